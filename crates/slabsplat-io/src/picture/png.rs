//! PNG: 8 bits a channel. The format stores straight colour, so what is premultiplied is divided.

use std::path::Path;

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use slabsplat_core::Image;

use super::atomic;
use crate::IoError;

/// Writes the picture rounded to 8 bits. If that fails, the file is as it was.
///
/// # Errors
/// If the file cannot be written.
pub fn write_png(path: &Path, image: &Image) -> Result<(), IoError> {
    let bytes: Vec<u8> = image.pixels().iter().flat_map(|&pixel| straight_bytes(pixel)).collect();
    atomic::write(path, |file| {
        PngEncoder::new(file)
            .write_image(&bytes, image.width(), image.height(), ExtendedColorType::Rgba8)
            .map_err(std::io::Error::other)
    })
}

/// Colour divided by opacity, both rounded. Where there is nothing there is no colour either.
fn straight_bytes([r, g, b, a]: [f32; 4]) -> [u8; 4] {
    let byte = |channel: f32| (channel.clamp(0.0, 1.0) * 255.0).round() as u8;
    match byte(a) {
        0 => [0; 4],
        alpha => [byte(r / a), byte(g / a), byte(b / a), alpha],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn png_divides_by_opacity() {
        assert_eq!(straight_bytes([0.25, 0.5, 0.0, 0.5]), [128, 255, 0, 128]);
        assert_eq!(straight_bytes([0.2, 0.4, 1.0, 1.0]), [51, 102, 255, 255]);
        assert_eq!(straight_bytes([0.9, 0.1, 0.1, 0.0]), [0; 4]);
        assert_eq!(straight_bytes([f32::NAN, 2.0, -1.0, 1.0]), [0, 255, 0, 255]);
    }

    #[test]
    fn png_can_be_read_back() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.png");
        write_png(&path, &Image::filled(4, 3, [0.5, 0.25, 0.0, 0.5])).unwrap();
        let read = image::open(&path).unwrap().into_rgba8();
        assert_eq!(read.dimensions(), (4, 3));
        assert!(read.pixels().all(|p| p.0 == [255, 128, 0, 128]));
    }
}
