//! A film in memory, for programs that have no disk, as pages of browsers.

use crate::encode::{Encoder, Frames, encoder_to};
use crate::metadata::Metadata;
use crate::pixels::Pixels;
use crate::{FilmDesc, FilmError, FilmFormat};
use slabsplat_core::Image;
use std::io::{self, Cursor, Seek, SeekFrom, Write};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The bytes of a film, while its frames come.
///
/// They are those of the file that [`FilmWriter`](crate::FilmWriter) makes of the same frames: a GIF, a WebP
/// or an animated PNG. Each frame is encoded when it comes, so that no more than the film itself is in
/// memory; of a GIF all frames are, as PNGs, since it counts the colours of all before it writes the first.
pub struct FilmInMemory {
    encoder: Box<dyn Encoder>,
    file: SharedFile,
    name: PathBuf,
    desc: FilmDesc,
    n_added: u32,
    /// What the encoder looks at again, if it does.
    frames: Option<StoredFrames>,
}

impl std::fmt::Debug for FilmInMemory {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("FilmInMemory")
            .field("name", &self.name)
            .field("desc", &self.desc)
            .field("n_added", &self.n_added)
            .finish_non_exhaustive()
    }
}

impl FilmInMemory {
    /// A film that errors call `name`, and that says `metadata` of itself where the format has room for it.
    ///
    /// # Errors
    /// If the format needs a disk, or has no room for such frames.
    pub fn begin(
        name: impl Into<PathBuf>,
        format: FilmFormat,
        desc: FilmDesc,
        metadata: &Metadata,
    ) -> Result<Self, FilmError> {
        let (file, name) = (SharedFile::default(), name.into());
        format.check(&desc)?;
        let encoder = encoder_to(format, &desc, file.clone(), &name, metadata)?;
        let frames = (format == FilmFormat::Gif)
            .then(|| StoredFrames { size: [desc.width, desc.height], pngs: Vec::new() });
        Ok(Self { encoder, file, name, desc, n_added: 0, frames })
    }

    /// Takes the next frame.
    ///
    /// # Errors
    /// If it has another size than the film, or the film has all frames already.
    pub fn add(&mut self, image: &Image) -> Result<(), FilmError> {
        let found = [image.width(), image.height()];
        let expected = [self.desc.width, self.desc.height];
        if found != expected {
            return Err(FilmError::WrongSize { frame_idx: self.n_added, found, expected });
        }
        if self.n_added == self.desc.n_frames {
            return Err(self.wrong_count(self.n_added + 1));
        }
        let pixels = Pixels::of(image);
        self.encoder.add(&pixels)?;
        if let Some(frames) = &mut self.frames {
            frames.add(&pixels).map_err(FilmError::write(&self.name))?;
        }
        self.n_added += 1;
        Ok(())
    }

    /// The bytes of the film.
    ///
    /// # Errors
    /// If not all of its frames came, or they are more than the format has room for.
    pub fn finish(self) -> Result<Vec<u8>, FilmError> {
        if self.n_added < self.desc.n_frames {
            return Err(self.wrong_count(self.n_added));
        }
        let nothing = StoredFrames { size: [0; 2], pngs: Vec::new() };
        self.encoder.finish(&self.frames.unwrap_or(nothing))?;
        let bytes = std::mem::take(self.file.locked().get_mut());
        Ok(bytes)
    }

    fn wrong_count(&self, found: u32) -> FilmError {
        FilmError::WrongCount { found, expected: self.desc.n_frames }
    }
}

/// Frames that are looked at again, as PNGs: a second of a film would be 100 MB without.
struct StoredFrames {
    size: [u32; 2],
    pngs: Vec<Vec<u8>>,
}

impl StoredFrames {
    fn add(&mut self, pixels: &Pixels) -> io::Result<()> {
        let mut png = Vec::new();
        // Before black, as a GIF shows them.
        pixels.write_png(&mut png, false, &Metadata::default())?;
        self.pngs.push(png);
        Ok(())
    }
}

impl Frames for StoredFrames {
    fn read(&self, frame_idx: u32) -> Result<Pixels, FilmError> {
        let png = Cursor::new(&self.pngs[frame_idx as usize]);
        Ok(Pixels::read_png(png, self.size).expect("it was written so"))
    }
}

/// A file in memory, of which the encoder has a copy that it may not give back.
#[derive(Clone, Default)]
struct SharedFile(Arc<Mutex<Cursor<Vec<u8>>>>);

impl SharedFile {
    fn locked(&self) -> MutexGuard<'_, Cursor<Vec<u8>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Write for SharedFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.locked().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for SharedFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.locked().seek(to)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FilmWriter, FrameRate};

    /// Something moves, and something shines through.
    fn film(format: FilmFormat, has_opacity: bool) {
        let desc = FilmDesc::new(31, 17, 5, FrameRate::new(25.0).unwrap()).unwrap();
        let desc = desc.has_opacity(has_opacity);
        let frame = |frame_idx: u32| {
            let pixel = |idx: u32| {
                let [x, y] = [idx % 31, idx / 31].map(|at| at as f32 / 31.0);
                let a = if (3 * frame_idx..3 * frame_idx + 9).contains(&(idx % 31)) {
                    1.0
                } else {
                    0.4
                };
                [x * a, y * a, (0.2 * frame_idx as f32) * a, a]
            };
            Image::from_pixels(31, 17, (0..31 * 17).map(pixel).collect())
        };
        let metadata = Metadata::new([], Some("<x:xmpmeta/>".to_owned()));
        let mut film = FilmInMemory::begin("a", format, desc, &metadata).unwrap();
        (0..5).for_each(|idx| film.add(&frame(idx)).unwrap());
        let error = film.add(&frame(0)).unwrap_err();
        assert!(matches!(error, FilmError::WrongCount { found: 6, expected: 5 }), "{error}");
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a");
        let writer = FilmWriter::begin(&path, format, desc, "").unwrap().metadata(metadata);
        writer.make::<FilmError, _>(|idx| Ok(frame(idx)), |_| {}).unwrap();
        assert!(film.finish().unwrap() == std::fs::read(path).unwrap(), "{}", format.name());
    }

    #[test]
    fn films_in_memory_are_those_on_disk() {
        for format in [FilmFormat::Gif, FilmFormat::WebP, FilmFormat::Apng] {
            film(format, false);
            film(format, format.has_opacity());
        }
    }

    #[test]
    fn film_in_memory_is_refused_where_it_cannot_be() {
        let desc = FilmDesc::new(7, 5, 5, FrameRate::new(25.0).unwrap()).unwrap();
        let metadata = Metadata::default();
        for format in [FilmFormat::Mp4, FilmFormat::WebM, FilmFormat::PngSequence] {
            let error = FilmInMemory::begin("a", format, desc, &metadata).unwrap_err();
            assert!(error.to_string().contains("gif, webp or apng"), "{error}");
        }
        for format in [FilmFormat::Gif, FilmFormat::WebP, FilmFormat::Apng] {
            let mut film = FilmInMemory::begin("a", format, desc, &metadata).unwrap();
            let wrong = Image::filled(5, 7, [0.0; 4]);
            let error = film.add(&wrong).unwrap_err();
            assert!(matches!(error, FilmError::WrongSize { frame_idx: 0, .. }), "{error}");
            film.add(&Image::filled(7, 5, [0.0; 4])).unwrap();
            let error = film.finish().unwrap_err();
            assert!(matches!(error, FilmError::WrongCount { found: 1, expected: 5 }), "{error}");
        }
    }
}
