//! Frames of a film, each drawn whole by one rank, where a volume fits the memory of each.
//!
//! ```text
//! rank 0 asks each other rank for one of the frames that come next, draws its own, and takes them in order
//! the others draw what they are asked for, until there is no more
//! ```
//!
//! A rank has one frame to draw at a time, so that no more pictures wait than there are ranks.

use crate::communicator::{receive, while_beating};
use crate::piece::{Extent, decode, encode};
use crate::{Communicator, MpiError, Tag};
use slabsplat::Image;
use std::collections::BTreeMap;

/// A frame that a rank has drawn.
#[derive(Clone, Debug, PartialEq)]
#[expect(clippy::exhaustive_structs, reason = "who draws one fills it in")]
pub struct DrawnFrame {
    /// The picture.
    pub image: Image,
    /// Why it shows nothing, if it does not.
    pub why_blank: Option<String>,
    /// What is to be said of it, a line each.
    pub notes: Vec<String>,
}

/// The ranks that draw a film, as rank 0 has them.
#[derive(Debug)]
pub struct FrameTeam<'a> {
    comm: &'a dyn Communicator,
    n_frames: u32,
    /// Who draws which frame.
    asked: BTreeMap<u32, usize>,
}

/// What stands for no frame.
const NO_MORE: u32 = u32::MAX;

impl<'a> FrameTeam<'a> {
    /// For a film of so many frames. Rank 0 alone calls it; all others [draw what they are
    /// asked](draw_frames).
    pub fn new(comm: &'a dyn Communicator, n_frames: u32) -> Self {
        Self { comm, n_frames, asked: BTreeMap::new() }
    }

    /// A frame, by whoever draws it: this rank by `draw`. Frames that are not asked for here, as they are
    /// there from before, are drawn in vain where others are asked ahead.
    ///
    /// # Errors
    /// If the network fails, a rank is silent for too long, or it or this one could not draw the frame.
    pub fn frame<E: std::fmt::Display>(
        &mut self,
        frame_idx: u32,
        draw: impl FnOnce(u32) -> Result<DrawnFrame, E> + Send,
    ) -> Result<DrawnFrame, MpiError> {
        self.ask_ahead(frame_idx)?;
        let Some(rank) = self.asked.remove(&frame_idx) else {
            let drawn = while_beating(self.comm, || draw(frame_idx).map_err(|e| e.to_string()))?;
            return drawn.map_err(|cause| MpiError::Rank { rank: 0, cause });
        };
        self.take(rank)
    }

    /// Has each rank that is free draw a frame that comes soon.
    fn ask_ahead(&mut self, frame_idx: u32) -> Result<(), MpiError> {
        // What was asked for and is not wanted any more still comes.
        while let Some((&earlier, &rank)) = self.asked.first_key_value()
            && earlier < frame_idx
        {
            self.asked.remove(&earlier);
            self.take(rank)?;
        }
        let mut next = frame_idx + 1;
        for rank in 1..self.comm.n_ranks() {
            if self.asked.values().any(|busy| *busy == rank) {
                continue;
            }
            while self.asked.contains_key(&next) {
                next += 1;
            }
            if self.n_frames <= next {
                break;
            }
            self.comm.send(rank, Tag::FrameAsked, next.to_le_bytes().to_vec())?;
            self.asked.insert(next, rank);
        }
        Ok(())
    }

    fn take(&self, rank: usize) -> Result<DrawnFrame, MpiError> {
        let bytes = receive(self.comm, rank, Tag::Frame)?;
        match from_bytes(&bytes).ok_or(MpiError::Malformed { rank, what: "frame" })? {
            Ok(frame) => Ok(frame),
            Err(cause) => Err(MpiError::Rank { rank, cause }),
        }
    }

    /// Tells all that there is no more to draw, and waits for what is being drawn. It has to be called,
    /// whatever failed.
    ///
    /// # Errors
    /// If the network fails, or a rank is silent for too long.
    pub fn end(self) -> Result<(), MpiError> {
        for rank in 1..self.comm.n_ranks() {
            self.comm.send(rank, Tag::FrameAsked, NO_MORE.to_le_bytes().to_vec())?;
        }
        self.asked.values().try_for_each(|rank| receive(self.comm, *rank, Tag::Frame).map(|_| ()))
    }
}

/// Draws the frames that rank 0 asks for, until there is no more; on all ranks but that.
///
/// # Errors
/// If the network fails, or rank 0 is silent for too long. What `draw` fails by goes to rank 0.
pub fn draw_frames<E: std::fmt::Display>(
    comm: &dyn Communicator,
    mut draw: impl FnMut(u32) -> Result<DrawnFrame, E> + Send,
) -> Result<(), MpiError> {
    loop {
        let asked = receive(comm, 0, Tag::FrameAsked)?;
        let asked =
            asked.try_into().map_err(|_| MpiError::Malformed { rank: 0, what: "number" })?;
        let frame_idx = u32::from_le_bytes(asked);
        if frame_idx == NO_MORE {
            return Ok(());
        }
        let drawn = while_beating(comm, || draw(frame_idx).map_err(|error| error.to_string()))?;
        comm.send(0, Tag::Frame, to_bytes(drawn))?;
    }
}

/// What the first byte of a frame says of it.
const SEEN: u8 = 0;
const BLANK: u8 = 1;
const FAILED: u8 = 2;

/// Whether it is blank or failed; its size, and lines of text, of which the first says why it is blank, or
/// why it failed; then its pixels.
fn to_bytes(drawn: Result<DrawnFrame, String>) -> Vec<u8> {
    let DrawnFrame { image, why_blank, notes } = match drawn {
        Ok(drawn) => drawn,
        Err(cause) => return [&[FAILED], cause.as_bytes()].concat(),
    };
    let kind = if why_blank.is_some() { BLANK } else { SEEN };
    let notes = why_blank.into_iter().chain(notes).collect::<Vec<_>>().join("\n");
    let numbers = [image.width(), image.height(), notes.len() as u32];
    let extent = Extent::of(&image);
    let mut bytes = vec![kind];
    bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
    bytes.extend(notes.as_bytes());
    bytes.extend(extent.to_bytes());
    bytes.extend(encode(&image, &extent, &(0..image.height())));
    bytes
}

/// The frame, or why there is none; nothing if it is neither.
fn from_bytes(bytes: &[u8]) -> Option<Result<DrawnFrame, String>> {
    let (kind, bytes) = bytes.split_first()?;
    if *kind == FAILED {
        return Some(Err(String::from_utf8_lossy(bytes).into_owned()));
    }
    let (numbers, bytes) = bytes.split_at_checked(12)?;
    let number = |idx: usize| u32::from_le_bytes(numbers.as_chunks().0[idx]);
    let [width, height] = [number(0), number(1)];
    slabsplat::ImageDesc::new(width, height).checked().ok()?;
    let (notes, bytes) = bytes.split_at_checked(number(2) as usize)?;
    let (extent, bytes) = bytes.split_at_checked(16)?;
    let extent = Extent::from_bytes(extent, [width, height])?;
    let mut image = Image::filled(width, height, [0.0; 4]);
    decode(bytes, &extent, &(0..height), |[x, y], run| {
        let start = y as usize * width as usize + x as usize;
        image.pixels_mut()[start..start + run.len()].copy_from_slice(run);
    })?;
    let notes = String::from_utf8_lossy(notes).into_owned();
    let mut notes = notes.lines().map(str::to_owned);
    let why_blank = if *kind == BLANK { Some(notes.next().unwrap_or_default()) } else { None };
    Some(Ok(DrawnFrame { image, why_blank, notes: notes.collect() }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ThreadRank, agree};
    use std::time::Duration;

    const LIMIT: Duration = Duration::from_secs(20);

    fn frame(frame_idx: u32) -> DrawnFrame {
        let image = Image::filled(3, 2, [0.1 * frame_idx as f32, 0.0, 0.0, 1.0]);
        let why_blank = (frame_idx == 4).then(|| "it is far away".to_owned());
        DrawnFrame { image, why_blank, notes: vec![format!("note {frame_idx}")] }
    }

    #[test]
    fn frames_come_in_order_whoever_draws_them() {
        for n_ranks in [1, 2, 3, 7] {
            // Some are there from before.
            for wanted in [(0..10).collect::<Vec<u32>>(), vec![2, 3, 7, 9], vec![]] {
                let ranks = ThreadRank::run(n_ranks, LIMIT, |comm| {
                    if comm.rank() != 0 {
                        return draw_frames(comm, |idx| Ok::<_, String>(frame(idx)))
                            .map(|()| vec![]);
                    }
                    let mut team = FrameTeam::new(comm, 10);
                    let draw = |idx| Ok::<_, String>(frame(idx));
                    let frames = wanted.iter().map(|idx| team.frame(*idx, draw));
                    let frames = frames.collect::<Result<Vec<_>, _>>();
                    team.end()?;
                    frames
                });
                let expected: Vec<_> = wanted.iter().map(|idx| frame(*idx)).collect();
                assert!(ranks[0] == Ok(expected), "{n_ranks} ranks, {wanted:?}");
                assert!(ranks.iter().all(Result::is_ok));
            }
        }
    }

    #[test]
    fn frames_that_fail_name_their_rank() {
        let ranks = ThreadRank::run(3, LIMIT, |comm| {
            let draw = |idx: u32| match idx {
                5 => Err("no memory"),
                idx => Ok(frame(idx)),
            };
            let done = if comm.rank() == 0 {
                let mut team = FrameTeam::new(comm, 10);
                let done = (0..10).try_for_each(|idx| team.frame(idx, draw).map(|_| ()));
                team.end()?;
                done
            } else {
                draw_frames(comm, draw)
            };
            agree(comm, done)
        });
        let said: Vec<String> = ranks.into_iter().map(|of| of.unwrap_err().to_string()).collect();
        assert!(said.iter().all(|line| *line == said[0] && line.contains("no memory")), "{said:?}");
    }

    #[test]
    fn hostile_frames_are_refused() {
        let bytes = to_bytes(Ok(frame(3)));
        assert_eq!(from_bytes(&bytes), Some(Ok(frame(3))));
        assert!((0..bytes.len()).all(|n| from_bytes(&bytes[..n]).is_none()));
        assert_eq!(from_bytes(&to_bytes(Err("why".to_owned()))), Some(Err("why".to_owned())));
    }
}
