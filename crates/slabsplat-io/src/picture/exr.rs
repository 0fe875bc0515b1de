//! OpenEXR: the compositor's numbers as they are, 32-bit floats, premultiplied.

use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::Path;

use exr::error::Error;
use exr::image::write::WritableImage;
use exr::image::{Encoding, Image as ExrImage, Layer, SpecificChannels};
use exr::math::Vec2;
use exr::meta::MetaData;
use exr::meta::attribute::{AttributeValue, Text};
use exr::meta::header::LayerAttributes;
use slabsplat_core::Image;

use super::{PictureFormat, Provenance, has_pixels};
use crate::IoError;

/// The attribute that is the scene.
const SCENE: &str = "slabsplat.scene";

/// What is read of a picture to find it.
const MAX_HEADER_BYTES: u64 = 8 << 20;

/// Writes channels R, G, B and A of 32-bit floats, bit by bit what the picture holds.
///
/// # Errors
/// If the file cannot be written.
pub fn write_exr(path: impl AsRef<Path>, image: &Image) -> Result<(), IoError> {
    PictureFormat::Exr.write(path, image, None)
}

/// What [`write_exr`] would write.
///
/// # Errors
/// If the picture has no pixels.
pub fn exr_bytes(image: &Image) -> Result<Vec<u8>, IoError> {
    PictureFormat::Exr.bytes(image, None)
}

pub(super) fn encode(
    writer: impl Write + Seek,
    image: &Image,
    provenance: &Provenance,
) -> io::Result<()> {
    has_pixels(image)?;
    let (width, height) = (image.width() as usize, image.height() as usize);
    let pixels = image.pixels();
    let channels = SpecificChannels::rgba(|Vec2(x, y): Vec2<usize>| {
        let [r, g, b, a] = pixels[y * width + x];
        (r, g, b, a)
    });
    let attributes = attributes(provenance);
    let layer = Layer::new((width, height), attributes, Encoding::FAST_LOSSLESS, channels);
    let mut noting = Noting { writer, failed: None };
    let written = ExrImage::from_layer(layer).write().to_buffered(&mut noting);
    noting.failed.map_or(written.map_err(to_io_error), Err)
}

fn attributes(provenance: &Provenance) -> LayerAttributes {
    // Texts of the format are bytes; those of others are UTF-8, too.
    let text = |text: &String| Text::from_slice_unchecked(text.as_bytes());
    let software_name = provenance.program.as_ref().map(text);
    let mut attributes = LayerAttributes { software_name, ..LayerAttributes::default() };
    if let Some(scene) = &provenance.scene {
        attributes.other.insert(Text::from(SCENE), AttributeValue::Text(text(scene)));
    }
    attributes
}

fn to_io_error(error: Error) -> io::Error {
    match error {
        Error::Io(error) => error,
        other => io::Error::other(other),
    }
}

/// What the first header of a picture says.
pub(super) fn read_provenance(file: impl Read) -> Result<Provenance, String> {
    let file = file.take(MAX_HEADER_BYTES);
    let headers = MetaData::read_from_buffered(file, false).map_err(|error| error.to_string())?;
    let Some(header) = headers.headers.into_iter().next() else { return Ok(Provenance::NONE) };
    let attributes = header.own_attributes;
    let text = |text: &Text| String::from_utf8(text.as_slice().to_vec()).ok();
    let scene = match attributes.other.get(SCENE.as_bytes()) {
        Some(AttributeValue::Text(scene)) => text(scene),
        _ => None,
    };
    Ok(Provenance { program: attributes.software_name.as_ref().and_then(text), scene })
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
    use std::io::Cursor;

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
        let full = Full(Cursor::new(Vec::new()));
        let error = encode(full, &image, &Provenance::NONE).unwrap_err();
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
