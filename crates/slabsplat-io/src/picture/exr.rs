//! OpenEXR: channels R, G, B, A in 32-bit floats, premultiplied, as OpenEXR means them.

use std::io::{Cursor, Write};
use std::path::Path;

use image::codecs::openexr::OpenExrEncoder;
use image::{ExtendedColorType, ImageEncoder};
use slabsplat_core::Image;

use super::atomic;
use crate::IoError;

/// Writes the picture as it is, bit for bit. If that fails, the file is as it was.
///
/// # Errors
/// If the file cannot be written.
pub fn write_exr(path: &Path, image: &Image) -> Result<(), IoError> {
    atomic::write(path, |file| {
        let bytes: Vec<u8> =
            image.pixels().iter().flatten().flat_map(|c| c.to_ne_bytes()).collect();
        let mut encoded = Cursor::new(Vec::new());
        OpenExrEncoder::new(&mut encoded)
            .write_image(&bytes, image.width(), image.height(), ExtendedColorType::Rgba32F)
            .map_err(std::io::Error::other)?;
        file.write_all(encoded.get_ref())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::ImageDecoder;
    use image::codecs::openexr::OpenExrDecoder;

    #[test]
    fn exr_keeps_every_bit() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.exr");
        let mut image = Image::filled(3, 2, [0.1, -2.5, 1e-30, 1.0]);
        image.pixels_mut()[4] = [1e30, 0.333_333_34, 0.0, 0.5];
        write_exr(&path, &image).unwrap();

        let file = std::io::BufReader::new(std::fs::File::open(&path).unwrap());
        let decoder = OpenExrDecoder::new(file).unwrap();
        assert_eq!(decoder.dimensions(), (3, 2));
        assert_eq!(decoder.original_color_type(), ExtendedColorType::Rgba32F);
        let mut bytes = vec![0; decoder.total_bytes() as usize];
        decoder.read_image(&mut bytes).unwrap();
        let read: Vec<f32> =
            bytes.chunks_exact(4).map(|b| f32::from_ne_bytes(b.try_into().unwrap())).collect();
        let written: Vec<f32> = image.pixels().iter().flatten().copied().collect();
        assert_eq!(read, written);
    }
}
