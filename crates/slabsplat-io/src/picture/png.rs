//! PNG: 8 bits a channel. PNG's colours are not premultiplied, so that ours are divided by their
//! opacity.

use std::io::{self, Write};
use std::path::Path;

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use slabsplat_core::Image;

use super::{atomic, has_pixels, to_io_error};
use crate::IoError;

/// Writes red, green, blue and opacity, rounded to 8 bits, as [`Image::to_rgba8`] does.
///
/// # Errors
/// If the file cannot be written.
pub fn write_png(path: impl AsRef<Path>, image: &Image) -> Result<(), IoError> {
    atomic::write(path.as_ref(), |writer| encode(writer, image))
}

/// What [`write_png`] would write.
///
/// # Errors
/// If the picture has no pixels.
pub fn png_bytes(image: &Image) -> Result<Vec<u8>, IoError> {
    let mut bytes = Vec::new();
    encode(&mut bytes, image).map_err(|source| IoError::Encode { source })?;
    Ok(bytes)
}

fn encode(writer: impl Write, image: &Image) -> io::Result<()> {
    has_pixels(image)?;
    PngEncoder::new(writer)
        .write_image(&image.to_rgba8(), image.width(), image.height(), ExtendedColorType::Rgba8)
        .map_err(to_io_error)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn png_reads_back() {
        let mut image = Image::filled(3, 2, [0.2, 0.4, 0.6, 1.0]);
        image.pixels_mut()[4] = [0.0, 0.0, 0.2, 0.4];
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.png");
        write_png(&path, &image).unwrap();
        let read = image::open(&path).unwrap();
        assert_eq!(read.color(), image::ColorType::Rgba8);
        let read = read.into_rgba8();
        assert_eq!(read.dimensions(), (3, 2));
        assert_eq!(read.get_pixel(0, 0).0, [51, 102, 153, 255]);
        assert_eq!(read.get_pixel(1, 1).0, [0, 0, 128, 102]);
    }
}
