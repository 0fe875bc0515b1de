//! Files of frames. Each encoder takes frames in order, and needs no memory for those before. Where it
//! writes to is the caller's: a file, or memory.

mod apng;
mod ffmpeg;
mod gif;
mod palette;
mod webp;

use crate::metadata::Metadata;
use crate::pixels::Pixels;
use crate::{FilmDesc, FilmError, FilmFormat};
use std::fs::File;
use std::io::{self, BufWriter, Seek, Write};
use std::path::Path;

pub(crate) use ffmpeg::check as check_ffmpeg;

/// What makes a file of frames.
pub(crate) trait Encoder: Send {
    /// Takes the next frame.
    fn add(&mut self, frame: &Pixels) -> Result<(), FilmError>;

    /// Ends the file; `frames` has all frames, which some formats look at again.
    fn finish(self: Box<Self>, frames: &dyn Frames) -> Result<(), FilmError>;
}

/// Frames that can be looked at again.
pub(crate) trait Frames {
    /// A frame.
    fn read(&self, frame_idx: u32) -> Result<Pixels, FilmError>;
}

/// The encoder of a format, which writes to `path`; `metadata` is left out where it has no room. A
/// folder of frames has none.
pub(crate) fn encoder(
    format: FilmFormat,
    desc: &FilmDesc,
    path: &Path,
    metadata: &Metadata,
) -> Result<Option<Box<dyn Encoder>>, FilmError> {
    match format {
        FilmFormat::PngSequence => Ok(None),
        FilmFormat::Mp4 | FilmFormat::WebM => {
            Ok(Some(Box::new(ffmpeg::Ffmpeg::new(format, desc, path)?)))
        }
        FilmFormat::Apng | FilmFormat::WebP | FilmFormat::Gif => {
            let file = File::create(path).map_err(FilmError::write(path))?;
            encoder_to(format, desc, BufWriter::new(file), path, metadata).map(Some)
        }
    }
}

/// The same that writes to `file`, which errors call `path`.
///
/// # Errors
/// If the format has no encoder here.
pub(crate) fn encoder_to<W: Write + Seek + Send + 'static>(
    format: FilmFormat,
    desc: &FilmDesc,
    file: W,
    path: &Path,
    metadata: &Metadata,
) -> Result<Box<dyn Encoder>, FilmError> {
    Ok(match format {
        FilmFormat::Apng => Box::new(apng::ApngEncoder::new(desc, file, path, metadata)?),
        FilmFormat::WebP => Box::new(webp::WebPEncoder::new(desc, file, path, metadata)?),
        FilmFormat::Gif => Box::new(gif::GifEncoder::new(desc, file, path)),
        FilmFormat::PngSequence | FilmFormat::Mp4 | FilmFormat::WebM => {
            return Err(FilmError::NotInMemory { name: format.name() });
        }
    })
}

/// What is left of an error that says where it happened.
fn in_file<E>(path: &Path) -> impl FnOnce(E) -> FilmError
where
    E: Into<Box<dyn std::error::Error + Send + Sync>>,
{
    let path = path.to_owned();
    move |error| FilmError::Write { path, source: io::Error::other(error) }
}
