//! OpenEXR: the compositor's numbers as they are, 32-bit floats, premultiplied.

use std::io::{self, Cursor, Seek, SeekFrom, Write};
use std::path::Path;

use image::codecs::openexr::OpenExrEncoder;
use image::{ExtendedColorType, ImageEncoder};
use slabsplat_core::Image;

use super::{atomic, has_pixels, to_io_error};
use crate::IoError;

/// Writes channels R, G, B and A of 32-bit floats, bit by bit what the picture holds.
///
/// # Errors
/// If the file cannot be written.
pub fn write_exr(path: impl AsRef<Path>, image: &Image) -> Result<(), IoError> {
    atomic::write(path.as_ref(), |writer| encode(writer, image))
}

/// What [`write_exr`] would write.
///
/// # Errors
/// If the picture has no pixels.
pub fn exr_bytes(image: &Image) -> Result<Vec<u8>, IoError> {
    let mut bytes = Cursor::new(Vec::new());
    encode(&mut bytes, image).map_err(|source| IoError::Encode { source })?;
    Ok(bytes.into_inner())
}

fn encode(writer: impl Write + Seek, image: &Image) -> io::Result<()> {
    has_pixels(image)?;
    let bytes = bytemuck::cast_slice(image.pixels());
    let mut noting = Noting { writer, failed: None };
    let encoded = OpenExrEncoder::new(&mut noting)
        .write_image(bytes, image.width(), image.height(), ExtendedColorType::Rgba32F)
        .map_err(to_io_error);
    noting.failed.map_or(encoded, Err)
}

/// Keeps why writing failed: of that the encoder says no more than that it did.
struct Noting<W> {
    writer: W,
    failed: Option<io::Error>,
}

impl<W> Noting<W> {
    fn note<T>(&mut self, result: io::Result<T>) -> io::Result<T> {
        let interrupted = |error: &io::Error| error.kind() == io::ErrorKind::Interrupted;
        match result {
            Err(error) if !interrupted(&error) => {
                let kind = error.kind();
                self.failed.get_or_insert(error);
                Err(kind.into())
            }
            other => other,
        }
    }
}

impl<W: Write> Write for Noting<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.writer.write(bytes);
        self.note(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        let flushed = self.writer.flush();
        self.note(flushed)
    }
}

impl<W: Seek> Seek for Noting<W> {
    fn seek(&mut self, position: SeekFrom) -> io::Result<u64> {
        let sought = self.writer.seek(position);
        self.note(sought)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exr_keeps_every_bit() {
        let mut image = Image::filled(33, 17, [0.0; 4]);
        let mut rng = fastrand::Rng::with_seed(8);
        for channel in image.pixels_mut().as_flattened_mut() {
            *channel = rng.f32() * 3.0 - 1.0;
        }
        image.pixels_mut()[5] = [f32::INFINITY, f32::MIN_POSITIVE / 2.0, -0.0, f32::MAX];
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.exr");
        write_exr(&path, &image).unwrap();
        let read = image::open(&path).unwrap();
        assert_eq!(read.color(), image::ColorType::Rgba32F);
        let read = read.into_rgba32f();
        assert_eq!(read.dimensions(), (33, 17));
        let bits = |channels: &[f32]| channels.iter().map(|c| c.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(read.as_raw()), bits(image.pixels().as_flattened()));
    }

    /// The encoder's own word for it was "Format error decoding".
    #[test]
    fn exr_on_a_full_disk() {
        struct Full(Cursor<Vec<u8>>);
        impl Write for Full {
            fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
                match self.0.position() + bytes.len() as u64 {
                    ..1000 => self.0.write(bytes),
                    _ => Err(io::Error::new(io::ErrorKind::StorageFull, "the disk is full")),
                }
            }
            fn flush(&mut self) -> io::Result<()> {
                Ok(())
            }
        }
        impl Seek for Full {
            fn seek(&mut self, position: SeekFrom) -> io::Result<u64> {
                self.0.seek(position)
            }
        }
        let image = Image::filled(64, 64, [0.1, 0.2, 0.3, 0.4]);
        let error = encode(Full(Cursor::new(Vec::new())), &image).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::StorageFull);
        assert_eq!(error.to_string(), "the disk is full");
    }

    /// The channels' types as they stand in the file: name, zero, then 2 for 32-bit floats.
    #[test]
    fn exr_channels_are_32_bit_floats() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.exr");
        write_exr(&path, &Image::filled(2, 2, [0.1, 0.2, 0.3, 0.4])).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        for channel in [b'R', b'G', b'B', b'A'] {
            let entry = [channel, 0, 2, 0, 0, 0];
            assert!(bytes.windows(6).any(|w| w == entry), "channel {}", char::from(channel));
        }
    }
}
