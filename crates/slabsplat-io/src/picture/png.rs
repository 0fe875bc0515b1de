//! PNG: 8 bits a channel. PNG's colours are not premultiplied, so that ours are divided by their
//! opacity.

use std::path::Path;

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use slabsplat_core::Image;

use super::{atomic, to_io_error};
use crate::IoError;

/// Writes red, green, blue and opacity, rounded to 8 bits, as [`Image::to_rgba8`] does.
///
/// # Errors
/// If the file cannot be written.
pub fn write_png(path: &Path, image: &Image) -> Result<(), IoError> {
    let (width, height) = (image.width(), image.height());
    let bytes = image.to_rgba8();
    atomic::write(path, |writer| {
        PngEncoder::new(writer)
            .write_image(&bytes, width, height, ExtendedColorType::Rgba8)
            .map_err(to_io_error)
    })
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
