//! Files of frames. Each encoder takes frames in order, and needs no memory for those before.

mod apng;
mod ffmpeg;
mod gif;
mod palette;
mod webp;

use crate::folder::FrameFolder;
use crate::metadata::Metadata;
use crate::pixels::Pixels;
use crate::{FilmDesc, FilmError, FilmFormat};
use std::fs::File;
use std::io::{self, BufWriter};
use std::path::Path;

pub(crate) use ffmpeg::check as check_ffmpeg;
pub(crate) use webp::WebPEncoder;

/// What makes a file of frames.
pub(crate) trait Encoder: Send {
    /// Takes the next frame.
    fn add(&mut self, frame: &Pixels) -> Result<(), FilmError>;

    /// Ends the file. All frames are in the folder.
    fn finish(self: Box<Self>, frames: &FrameFolder) -> Result<(), FilmError>;
}

/// The encoder of a format, which writes to `path`; `metadata` is left out where it has no room. A
/// folder of frames has none.
pub(crate) fn encoder(
    format: FilmFormat,
    desc: &FilmDesc,
    path: &Path,
    metadata: &Metadata,
) -> Result<Option<Box<dyn Encoder>>, FilmError> {
    Ok(Some(match format {
        FilmFormat::PngSequence => return Ok(None),
        FilmFormat::Apng => Box::new(apng::ApngEncoder::new(desc, path, metadata)?),
        FilmFormat::WebP => {
            let file = File::create(path).map_err(FilmError::write(path))?;
            Box::new(WebPEncoder::new(desc, BufWriter::new(file), path, metadata)?)
        }
        FilmFormat::Gif => Box::new(gif::GifEncoder::new(desc, path)),
        FilmFormat::Mp4 | FilmFormat::WebM => Box::new(ffmpeg::Ffmpeg::new(format, desc, path)?),
    }))
}

/// What is left of an error that says where it happened.
fn in_file<E>(path: &Path) -> impl FnOnce(E) -> FilmError
where
    E: Into<Box<dyn std::error::Error + Send + Sync>>,
{
    let path = path.to_owned();
    move |error| FilmError::Write { path, source: io::Error::other(error) }
}
