//! GIF (<https://www.w3.org/Graphics/GIF/spec-gif89a.txt>), in two passes: colours are counted as frames
//! come, and when all are there the file is written of the frames, which are looked at again. A frame is no
//! more than the rectangle that changes, and what does not change within it is transparent.

use super::palette::{Histogram, Palette};
use super::{Encoder, Frames, in_file};
use crate::pixels::Pixels;
use crate::{FilmDesc, FilmError};
use std::borrow::Cow;
use std::io::Write;
use std::path::{Path, PathBuf};

pub(super) struct GifEncoder<W> {
    file: W,
    desc: FilmDesc,
    histogram: Histogram,
    path: PathBuf,
}

/// Index of what stays as it was.
const UNCHANGED: u8 = 255;

impl<W: Write> GifEncoder<W> {
    pub(super) fn new(desc: &FilmDesc, file: W, path: &Path) -> Self {
        Self { file, desc: *desc, histogram: Histogram::new(), path: path.to_owned() }
    }

    /// Width and height, which the format's limit leaves as they are.
    fn size(&self) -> [u16; 2] {
        [self.desc.width, self.desc.height].map(|side| side.try_into().unwrap_or(u16::MAX))
    }

    fn write(self, frames: &dyn Frames) -> Result<(), FilmError> {
        let [width, height] = self.size();
        let mut palette: Palette = self.histogram.palette();
        let mut colors = palette.bytes();
        colors.resize(3 * 256, 0);
        let mut encoder =
            gif::Encoder::new(self.file, width, height, &colors).map_err(in_file(&self.path))?;
        encoder.set_repeat(gif::Repeat::Infinite).map_err(in_file(&self.path))?;
        let mut before: Option<Vec<u8>> = None;
        for frame_idx in 0..self.desc.n_frames {
            let pixels = frames.read(frame_idx)?;
            let indices = palette.indices(&pixels.before_black(), width.into());
            let mut frame = changed(before.as_deref(), &indices, [width, height]);
            frame.delay = self.desc.rate.ticks(frame_idx, 100).try_into().unwrap_or(u16::MAX);
            encoder.write_frame(&frame).map_err(in_file(&self.path))?;
            before = Some(indices);
        }
        let mut file = encoder.into_inner().map_err(in_file(&self.path))?;
        file.flush().map_err(FilmError::write(&self.path))
    }
}

/// What changes from one picture to the next; of a picture that stays, one pixel.
fn changed(before: Option<&[u8]>, now: &[u8], [width, height]: [u16; 2]) -> gif::Frame<'static> {
    let Some(before) = before else {
        return gif::Frame {
            width,
            height,
            buffer: Cow::Owned(now.to_vec()),
            dispose: gif::DisposalMethod::Keep,
            ..gif::Frame::default()
        };
    };
    let row_len = usize::from(width);
    let (mut least, mut largest) = ([usize::MAX; 2], [0; 2]);
    for (idx, _) in before.iter().zip(now).enumerate().filter(|(_, (before, now))| before != now) {
        let at = [idx % row_len, idx / row_len];
        least = [0, 1].map(|axis| least[axis].min(at[axis]));
        largest = [0, 1].map(|axis| largest[axis].max(at[axis]));
    }
    if least[0] == usize::MAX {
        least = [0; 2];
    }
    let mut buffer = Vec::with_capacity((largest[0] - least[0] + 1) * (largest[1] - least[1] + 1));
    for y in least[1]..=largest[1] {
        let row = y * row_len + least[0]..=y * row_len + largest[0];
        let pixels = before[row.clone()].iter().zip(&now[row]);
        buffer.extend(pixels.map(|(before, now)| if before == now { UNCHANGED } else { *now }));
    }
    // They lie within the picture, whose sides are of 16 bits.
    gif::Frame {
        left: least[0] as u16,
        top: least[1] as u16,
        width: (largest[0] - least[0] + 1) as u16,
        height: (largest[1] - least[1] + 1) as u16,
        buffer: Cow::Owned(buffer),
        transparent: Some(UNCHANGED),
        dispose: gif::DisposalMethod::Keep,
        ..gif::Frame::default()
    }
}

impl<W: Write + Send> Encoder for GifEncoder<W> {
    fn add(&mut self, frame: &Pixels) -> Result<(), FilmError> {
        self.histogram.add(&frame.before_black());
        Ok(())
    }

    fn finish(self: Box<Self>, frames: &dyn Frames) -> Result<(), FilmError> {
        self.write(frames)
    }
}
