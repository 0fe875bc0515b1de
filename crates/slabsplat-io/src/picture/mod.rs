//! Writing pictures. What is written appears under its name only when it is complete.

mod atomic;
mod exr;
mod png;

use std::path::Path;

use slabsplat_core::Image;

pub use exr::write_exr;
pub use png::write_png;

use crate::IoError;

/// Writes a picture in the format that the name's extension says: `.exr` or `.png`.
///
/// # Errors
/// If the extension is another, or the file cannot be written.
pub fn write_picture(path: &Path, image: &Image) -> Result<(), IoError> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    match extension.as_deref() {
        Some("exr") => write_exr(path, image),
        Some("png") => write_png(path, image),
        _ => Err(IoError::UnknownPicture { path: path.to_owned() }),
    }
}

/// What the encoders' errors come down to.
fn to_io_error(error: image::ImageError) -> std::io::Error {
    match error {
        image::ImageError::IoError(error) => error,
        other => std::io::Error::other(other),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn picture_format_by_extension() {
        let dir = tempfile::tempdir().unwrap();
        let image = Image::filled(2, 1, [0.5; 4]);
        for (name, magic) in [("a.PNG", &b"\x89PNG"[..]), ("b.exr", &[0x76, 0x2f, 0x31, 0x01])] {
            write_picture(&dir.path().join(name), &image).unwrap();
            assert!(std::fs::read(dir.path().join(name)).unwrap().starts_with(magic), "{name}");
        }
        for name in ["a.jpg", "a", "png"] {
            let err = write_picture(&dir.path().join(name), &image).unwrap_err().to_string();
            assert!(err.contains(".exr or .png"), "{err}");
        }
    }
}
