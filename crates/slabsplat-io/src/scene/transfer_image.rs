//! Two-dimensional transfer functions from pictures.

use std::path::{Path, PathBuf};

use image::{ImageReader, Limits};
use slabsplat_core::{TransferFunction2d, TransferImage};

use crate::IoError;

/// A picture of opacities and colours, as a scene file or a flag names it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct TransferImageFile {
    /// PNG, or EXR with the feature `exr`; what has no alpha channel is opaque.
    pub path: PathBuf,
    /// The values at its left and its right edge.
    pub values: [f64; 2],
    /// The gradients, per `unit`, at its lower and its upper edge.
    pub gradients: [f64; 2],
}

/// Formats of such pictures.
const FORMATS: &str = if cfg!(feature = "exr") { "PNG or EXR" } else { "PNG" };

/// More pixels along a side than any display of values has.
const MAX_SIDE: u32 = 4096;

impl TransferImageFile {
    /// That picture, over these values and gradients.
    pub fn new(path: impl Into<PathBuf>, values: [f64; 2], gradients: [f64; 2]) -> Self {
        Self { path: path.into(), values, gradients }
    }

    /// Reads the picture.
    ///
    /// # Errors
    /// If it cannot be read, has more than 4096 pixels a side, or a channel outside 0 … 1, or values or
    /// gradients do not rise.
    pub fn load(&self) -> Result<TransferFunction2d, IoError> {
        let (width, pixels) = read(&self.path)?;
        TransferImage::new(width, pixels, self.values, self.gradients)
            .map(TransferFunction2d::Image)
            .map_err(|error| IoError::malformed(&self.path, error.to_string()))
    }
}

/// Pixels in a row, and all pixels.
fn read(path: &Path) -> Result<(usize, Vec<[f32; 4]>), IoError> {
    let reader = ImageReader::open(path).map_err(IoError::read(path))?;
    let mut reader = reader.with_guessed_format().map_err(IoError::read(path))?;
    let mut limits = Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(MAX_SIDE), Some(MAX_SIDE));
    reader.limits(limits);
    let image = reader.decode().map_err(|error| {
        IoError::malformed(path, format!("not a picture ({FORMATS}) that can be read: {error}"))
    })?;
    let image = image.into_rgba32f();
    Ok((image.width() as usize, image.pixels().map(|pixel| pixel.0).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(path: PathBuf) -> TransferImageFile {
        TransferImageFile { path, values: [0.0, 2.0], gradients: [0.0, 10.0] }
    }

    #[test]
    fn transfer_image_is_read_upright() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.png");
        let pixels = [[255, 0, 0, 255], [0, 0, 0, 0], [0, 255, 0, 51], [0, 0, 255, 255_u8]];
        image::RgbaImage::from_raw(2, 2, pixels.concat()).unwrap().save(&path).unwrap();
        let transfer = file(path).load().unwrap();
        // The top row is that of steep gradients.
        assert_eq!(transfer.at(0.5, 9.0), (1.0, [1.0, 0.0, 0.0]));
        assert_eq!(transfer.opacity(1.5, 9.0), 0.0);
        assert_eq!(transfer.at(1.5, 1.0), (1.0, [0.0, 0.0, 1.0]));
        let (opacity, color) = transfer.at(0.5, 1.0);
        assert!((opacity - 0.2).abs() < 1e-6 && color == [0.0, 1.0, 0.0]);
    }

    #[test]
    fn transfer_image_errors_name_the_file() {
        let dir = tempfile::tempdir().unwrap();
        let check = |name: &str, bytes: &[u8], expected: &str| {
            let path = dir.path().join(name);
            std::fs::write(&path, bytes).unwrap();
            let error = file(path).load().unwrap_err().to_string();
            assert!(error.contains(name) && error.contains(expected), "{error}");
        };
        check("empty.png", b"", "not a picture");
        check("text.png", b"no picture at all", "not a picture");
        let missing = file(dir.path().join("missing.png")).load().unwrap_err().to_string();
        assert!(missing.contains("cannot read") && missing.contains("missing.png"), "{missing}");
        let path = dir.path().join("wide.png");
        image::GrayImage::new(5000, 1).save(&path).unwrap();
        let wide = file(path.clone()).load().unwrap_err().to_string();
        assert!(wide.contains("wide.png"), "{wide}");
        let turned = TransferImageFile { gradients: [1.0, 0.0], ..file(path.clone()) };
        image::GrayImage::new(5, 1).save(path).unwrap();
        let turned = turned.load().unwrap_err().to_string();
        assert!(turned.contains("the gradients of a picture need"), "{turned}");
    }
}
