//! A film, from its first frame to its last.

use crate::encode::{Encoder, encoder};
use crate::folder::{FrameFolder, check_sequence};
use crate::metadata::{FilmFrame, Metadata};
use crate::pixels::Pixels;
use crate::{FilmDesc, FilmError, FilmFormat};
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread;

/// Frames that wait between whoever renders and the encoder. More would only take memory: on average the
/// slower of the two decides.
const N_WAITING: usize = 2;

/// A film that has begun.
pub struct FilmWriter {
    target: PathBuf,
    format: FilmFormat,
    desc: FilmDesc,
    folder: FrameFolder,
    n_done: u32,
    metadata: Metadata,
}

impl std::fmt::Debug for FilmWriter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { target, format, desc, folder: _, n_done, metadata: _ } = self;
        f.debug_struct("FilmWriter")
            .field("target", target)
            .field("format", format)
            .field("desc", desc)
            .field("n_done", n_done)
            .finish_non_exhaustive()
    }
}

/// What has been done.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Step {
    /// A frame from before cannot be read, and is rendered again.
    Damaged {
        /// Which, from 0 on.
        frame_idx: u32,
        /// What is wrong with it.
        what: String,
    },
    /// One more frame is rendered; so many are there.
    Rendered(u32),
    /// All frames are rendered, and the file is being made of those that were not yet taken.
    Ending,
}

/// A film that was made.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct FilmReport {
    /// All of its frames.
    pub n_frames: u32,
    /// Those that were there before and are whole.
    pub n_continued: u32,
    /// How long it is.
    pub seconds: f64,
    /// How large it is on disk; of a folder, all of its files.
    pub n_bytes: u64,
}

impl FilmWriter {
    /// Begins the film `target`, or continues it if frames of it are in the folder `target.frames`.
    ///
    /// `identity` is a text that tells films apart, with all that decides about its pixels; lines of `key =
    /// value` are named in the error if they differ. Frames are retained in that folder until the film is
    /// done, and a film that is continued has the same bytes as one that is made in one go, as far as ffmpeg
    /// makes the same of the same frames.
    ///
    /// # Errors
    /// If the format has no room for such frames, there is no ffmpeg and it is needed, the folder has frames
    /// of another film or is in use, or files cannot be written.
    pub fn begin(
        target: impl Into<PathBuf>,
        format: FilmFormat,
        desc: FilmDesc,
        identity: &str,
    ) -> Result<Self, FilmError> {
        Self::open(target.into(), format, desc, identity, false)
    }

    /// The same from the first frame on, whatever is there.
    ///
    /// # Errors
    /// As [`begin`](Self::begin), but for frames of another film, which are removed.
    pub fn begin_anew(
        target: impl Into<PathBuf>,
        format: FilmFormat,
        desc: FilmDesc,
        identity: &str,
    ) -> Result<Self, FilmError> {
        Self::open(target.into(), format, desc, identity, true)
    }

    fn open(
        target: PathBuf,
        format: FilmFormat,
        desc: FilmDesc,
        identity: &str,
        anew: bool,
    ) -> Result<Self, FilmError> {
        format.check(&desc)?;
        format.check_program()?;
        if format == FilmFormat::PngSequence {
            check_sequence(&target)?;
        } else if target.symlink_metadata().is_ok_and(|metadata| !metadata.is_file()) {
            return Err(FilmError::InTheWay { path: target });
        }
        let size = [desc.width, desc.height, desc.n_frames];
        let about = format!("{identity}\nframes = {size:?}\nopacity = {}\n", desc.has_opacity);
        let (folder, n_done) = FrameFolder::open(&target, &desc, &about, anew)?;
        Ok(Self { target, format, desc, folder, n_done, metadata: Metadata::default() })
    }

    /// The same with what the film's file says of itself; MP4, WebM and GIF have no room for it, and in a
    /// folder of frames each says what it shows.
    #[must_use]
    pub fn metadata(self, metadata: Metadata) -> Self {
        Self { metadata, ..self }
    }

    /// How many frames are there already.
    pub fn n_done(&self) -> u32 {
        self.n_done
    }

    /// Has all other frames rendered, in order, while a thread stores those before; then the film is there.
    ///
    /// `render` is given the number of a frame, from 0 on. `tell` hears of each step.
    ///
    /// # Errors
    /// As `render`; or if a frame has another size, or the film cannot be stored. What is rendered then stays
    /// in the folder of frames.
    pub fn make<E: From<FilmError>, F: Into<FilmFrame>>(
        self,
        mut render: impl FnMut(u32) -> Result<F, E>,
        mut tell: impl FnMut(Step),
    ) -> Result<FilmReport, E> {
        let Self { target, format, desc, folder, n_done, metadata } = self;
        let made = folder.beside("film.part");
        // An ffmpeg of a run that was killed may still be writing what it had, and continues with a file of
        // no name.
        if let Err(error) = fs::remove_file(&made)
            && error.kind() != ErrorKind::NotFound
        {
            return Err(FilmError::write(&made)(error).into());
        }
        let (sender, receiver) = sync_channel(N_WAITING);
        let mut n_there = n_done;
        let mut n_rendered = 0;
        thread::scope(|scope| {
            let (folder, made, metadata) = (&folder, &made, &metadata);
            let encoding = scope.spawn(move || {
                let encoder = encoder(format, &desc, made, metadata)?;
                store(folder, &desc, encoder, receiver)
            });
            for frame_idx in 0..desc.n_frames {
                let stored = folder.stored(frame_idx);
                if let Some(Err(error)) = &stored {
                    n_there = n_there.saturating_sub(1);
                    tell(Step::Damaged { frame_idx, what: error.to_string() });
                }
                let next = match stored {
                    Some(Ok(pixels)) => Next::Stored(pixels),
                    _ => Next::Rendered(render(frame_idx)?.into()),
                };
                let is_new = matches!(next, Next::Rendered(_));
                // An encoder that does not listen any more says why when it is joined.
                if sender.send(next).is_err() {
                    break;
                }
                if is_new {
                    n_rendered += 1;
                    n_there += 1;
                    tell(Step::Rendered(n_there));
                }
            }
            drop(sender);
            tell(Step::Ending);
            Ok::<_, E>(encoding.join().unwrap_or(Err(FilmError::Panicked))?)
        })?;
        match format {
            FilmFormat::PngSequence => folder.end_as_folder(&target)?,
            _ => folder.end_with_file(&made, &target)?,
        }
        let FilmDesc { n_frames, .. } = desc;
        let n_bytes = n_bytes_of(&target).map_err(FilmError::write(&target))?;
        Ok(FilmReport {
            n_frames,
            n_continued: n_frames - n_rendered,
            seconds: desc.seconds(),
            n_bytes,
        })
    }
}

/// The next frame of the film.
enum Next {
    /// It was there before.
    Stored(Pixels),
    Rendered(FilmFrame),
}

/// Stores those frames that are new, and gives the encoder all of them.
fn store(
    folder: &FrameFolder,
    desc: &FilmDesc,
    mut encoder: Option<Box<dyn Encoder>>,
    frames: Receiver<Next>,
) -> Result<(), FilmError> {
    let mut n_stored = 0;
    for next in frames {
        let pixels = match next {
            Next::Stored(pixels) => pixels,
            Next::Rendered(frame) => stored(folder, desc, n_stored, &frame)?,
        };
        if let Some(encoder) = &mut encoder {
            encoder.add(&pixels)?;
        }
        n_stored += 1;
    }
    // Whoever renders has failed: there is no film.
    if n_stored < desc.n_frames {
        return Ok(());
    }
    encoder.map_or(Ok(()), |encoder| encoder.finish(folder))
}

/// Stores a frame, whose pixels are returned.
fn stored(
    folder: &FrameFolder,
    desc: &FilmDesc,
    frame_idx: u32,
    frame: &FilmFrame,
) -> Result<Pixels, FilmError> {
    let found = [frame.image.width(), frame.image.height()];
    let expected = [desc.width, desc.height];
    if found != expected {
        return Err(FilmError::WrongSize { frame_idx, found, expected });
    }
    let pixels = Pixels::of(&frame.image);
    folder.write(frame_idx, &pixels, &frame.metadata)?;
    Ok(pixels)
}

fn n_bytes_of(path: &Path) -> std::io::Result<u64> {
    if path.is_file() {
        return Ok(path.metadata()?.len());
    }
    fs::read_dir(path)?.map(|entry| Ok(entry?.metadata()?.len())).sum()
}
