//! PNG: 8 bits a channel. PNG's colours are not premultiplied, so that ours are divided by their
//! opacity.

use std::path::Path;

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use slabsplat_core::Image;

use super::{atomic, to_io_error};
use crate::IoError;

/// Writes red, green, blue and opacity, rounded to 8 bits; what is outside 0 … 1 is clamped.
///
/// # Errors
/// If the file cannot be written.
pub fn write_png(path: &Path, image: &Image) -> Result<(), IoError> {
    let (width, height) = (image.width(), image.height());
    let bytes: Vec<u8> = image.pixels().iter().flat_map(|&pixel| straight(pixel)).collect();
    atomic::write(path, |writer| {
        PngEncoder::new(writer)
            .write_image(&bytes, width, height, ExtendedColorType::Rgba8)
            .map_err(to_io_error)
    })
}

/// A premultiplied pixel as 8 bits of straight colour and opacity; all 0 where the opacity rounds
/// to 0, as the colour is then nobody's.
fn straight([r, g, b, a]: [f32; 4]) -> [u8; 4] {
    // NaN becomes 0 in the cast.
    let to_byte = |value: f32| (value.clamp(0.0, 1.0) * 255.0).round() as u8;
    match to_byte(a) {
        0 => [0; 4],
        alpha => [to_byte(r / a), to_byte(g / a), to_byte(b / a), alpha],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn png_pixels_are_straight() {
        let check = |pixel, expected| assert_eq!(straight(pixel), expected, "{pixel:?}");
        check([0.0; 4], [0; 4]);
        check([1.0; 4], [255; 4]);
        check([0.25, 0.1, 0.0, 0.5], [128, 51, 0, 128]);
        check([0.001, 0.0, 0.0, 0.001], [0; 4]);
        check([2.0, -1.0, 0.5, 1.5], [255, 0, 85, 255]);
        check([f32::NAN, 0.5, 0.5, 1.0], [0, 128, 128, 255]);
        check([0.5, 0.5, 0.5, f32::NAN], [0; 4]);
    }

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
