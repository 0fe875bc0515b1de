//! Animated PNG (<https://www.w3.org/TR/png-3/#apng-frame-based-animation>): whole frames, one after the
//! other.

use super::{Encoder, Frames};
use crate::metadata::Metadata;
use crate::pixels::{Pixels, png_encoder, to_io_error};
use crate::{FilmDesc, FilmError, FrameRate};
use std::io::Write;
use std::path::{Path, PathBuf};

pub(super) struct ApngEncoder<W: Write> {
    writer: png::Writer<W>,
    has_opacity: bool,
    path: PathBuf,
}

impl<W: Write> ApngEncoder<W> {
    pub(super) fn new(
        desc: &FilmDesc,
        file: W,
        path: &Path,
        metadata: &Metadata,
    ) -> Result<Self, FilmError> {
        let FilmDesc { width, height, n_frames, rate, has_opacity, .. } = *desc;
        let wrong = |error| FilmError::write(path)(to_io_error(error));
        let encoder = png_encoder(file, [width, height], has_opacity, metadata);
        let mut encoder = encoder.map_err(wrong)?;
        encoder.set_filter(png::Filter::Adaptive);
        encoder.set_animated(n_frames, 0).map_err(wrong)?;
        let [delay, of] = delay(rate);
        encoder.set_frame_delay(delay, of).map_err(wrong)?;
        let writer = encoder.write_header().map_err(wrong)?;
        Ok(Self { writer, has_opacity, path: path.to_owned() })
    }
}

/// How long a frame is seen, as a fraction of two 16-bit numbers of a second: exactly, where there is one.
fn delay(rate: FrameRate) -> [u16; 2] {
    let [frames, seconds] = rate.fraction();
    match (u16::try_from(seconds), u16::try_from(frames)) {
        (Ok(delay), Ok(of)) => [delay, of],
        // Only of more than 65 frames a second the thousandths do not fit.
        _ => [250, (rate.per_second() * 250.0).round() as u16],
    }
}

impl<W: Write + Send> Encoder for ApngEncoder<W> {
    fn add(&mut self, frame: &Pixels) -> Result<(), FilmError> {
        let written = self.writer.write_image_data(&frame.samples(self.has_opacity));
        written.map_err(|error| FilmError::write(&self.path)(to_io_error(error)))
    }

    fn finish(self: Box<Self>, _: &dyn Frames) -> Result<(), FilmError> {
        let path = self.path;
        self.writer.finish().map_err(|error| FilmError::write(&path)(to_io_error(error)))
    }
}
