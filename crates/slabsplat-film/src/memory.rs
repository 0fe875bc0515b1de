//! A film in memory, for programs that have no disk, as pages of browsers.

use crate::encode::WebPEncoder;
use crate::metadata::Metadata;
use crate::pixels::Pixels;
use crate::{FilmDesc, FilmError, FilmFormat};
use slabsplat_core::Image;
use std::io::Cursor;
use std::path::PathBuf;

/// The bytes of a film, while its frames come.
///
/// They are those of the file that [`FilmWriter`](crate::FilmWriter) makes of the same frames. A film is a
/// WebP: each frame is encoded when it comes, so that no more than the film itself is in memory. GIF counts
/// the colours of all frames before it writes the first.
pub struct FilmInMemory {
    encoder: WebPEncoder<Cursor<Vec<u8>>>,
    desc: FilmDesc,
    n_added: u32,
}

impl std::fmt::Debug for FilmInMemory {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { encoder: _, desc, n_added } = self;
        f.debug_struct("FilmInMemory")
            .field("desc", desc)
            .field("n_added", n_added)
            .finish_non_exhaustive()
    }
}

impl FilmInMemory {
    /// A film that errors call `name`, and that says `metadata` of itself.
    ///
    /// # Errors
    /// If the format is not WebP, or has no room for such frames.
    pub fn begin(
        name: impl Into<PathBuf>,
        format: FilmFormat,
        desc: FilmDesc,
        metadata: &Metadata,
    ) -> Result<Self, FilmError> {
        if format != FilmFormat::WebP {
            return Err(FilmError::NotInMemory { name: format.name() });
        }
        format.check(&desc)?;
        let file = Cursor::new(Vec::new());
        let encoder = WebPEncoder::new(&desc, file, &name.into(), metadata)?;
        Ok(Self { encoder, desc, n_added: 0 })
    }

    /// Takes the next frame.
    ///
    /// # Errors
    /// If it has another size than the film.
    pub fn add(&mut self, image: &Image) -> Result<(), FilmError> {
        let found = [image.width(), image.height()];
        let expected = [self.desc.width, self.desc.height];
        if found != expected {
            return Err(FilmError::WrongSize { frame_idx: self.n_added, found, expected });
        }
        self.encoder.take(&Pixels::of(image))?;
        self.n_added += 1;
        Ok(())
    }

    /// The bytes of the film of those frames that came.
    ///
    /// # Errors
    /// If they are more than a WebP has room for.
    pub fn finish(self) -> Result<Vec<u8>, FilmError> {
        Ok(self.encoder.end()?.into_inner())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FilmWriter, FrameRate};

    fn frame(frame_idx: u32) -> Image {
        let value = frame_idx as f32 / 5.0;
        Image::filled(7, 5, [value, 0.5 * value, 0.0, 1.0])
    }

    #[test]
    fn film_in_memory_is_the_one_on_disk() {
        let desc = FilmDesc::new(7, 5, 5, FrameRate::new(25.0).unwrap()).unwrap();
        let metadata = Metadata::new([], Some("<x:xmpmeta/>".to_owned()));
        let mut film = FilmInMemory::begin("a.webp", FilmFormat::WebP, desc, &metadata).unwrap();
        (0..5).for_each(|idx| film.add(&frame(idx)).unwrap());
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.webp");
        let writer = FilmWriter::begin(&path, FilmFormat::WebP, desc, "").unwrap();
        let writer = writer.metadata(metadata);
        writer.make::<FilmError, _>(|idx| Ok(frame(idx)), |_| {}).unwrap();
        assert_eq!(film.finish().unwrap(), std::fs::read(path).unwrap());
    }

    #[test]
    fn film_in_memory_is_refused_where_it_cannot_be() {
        let desc = FilmDesc::new(7, 5, 5, FrameRate::new(25.0).unwrap()).unwrap();
        let metadata = Metadata::default();
        for format in [FilmFormat::Gif, FilmFormat::Mp4, FilmFormat::Apng, FilmFormat::PngSequence]
        {
            let error = FilmInMemory::begin("a", format, desc, &metadata).unwrap_err();
            assert!(error.to_string().contains("webp"), "{error}");
        }
        let mut film = FilmInMemory::begin("a", FilmFormat::WebP, desc, &metadata).unwrap();
        let wrong = Image::filled(5, 7, [0.0; 4]);
        assert!(matches!(film.add(&wrong), Err(FilmError::WrongSize { frame_idx: 0, .. })));
    }
}
