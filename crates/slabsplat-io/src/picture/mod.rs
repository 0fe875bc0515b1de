//! Writing pictures: OpenEXR for numbers, PNG for eyes.

mod atomic;
mod exr;
mod png;

use std::path::Path;

use slabsplat_core::Image;

pub use exr::write_exr;
pub use png::write_png;

use crate::IoError;

/// What a picture can be written as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureFormat {
    /// 32-bit floats, premultiplied, just as they were composited.
    Exr,
    /// 8 bits, not premultiplied.
    Png,
}

impl PictureFormat {
    /// The format that a file's name ends with.
    ///
    /// # Errors
    /// If it is neither `.exr` nor `.png`.
    pub fn of(path: &Path) -> Result<Self, IoError> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        match extension.as_deref() {
            Some("exr") => Ok(Self::Exr),
            Some("png") => Ok(Self::Png),
            _ => Err(IoError::UnknownPicture { path: path.to_owned() }),
        }
    }
}

/// Writes a picture in the format that the file's name ends with. If that fails, the file is as it was.
///
/// # Errors
/// If the name ends neither in `.exr` nor in `.png`, or the file cannot be written.
pub fn write_picture(path: &Path, image: &Image) -> Result<(), IoError> {
    match PictureFormat::of(path)? {
        PictureFormat::Exr => write_exr(path, image),
        PictureFormat::Png => write_png(path, image),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn picture_format_is_told_by_the_name() {
        assert_eq!(PictureFormat::of(Path::new("a.b/c.EXR")).unwrap(), PictureFormat::Exr);
        assert_eq!(PictureFormat::of(Path::new("c.png")).unwrap(), PictureFormat::Png);
        for name in ["c.jpg", "c", "png"] {
            let err = PictureFormat::of(Path::new(name)).unwrap_err().to_string();
            assert!(err.contains(".exr or .png"), "{err}");
        }
    }
}
