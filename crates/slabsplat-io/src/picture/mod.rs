//! Writing pictures, and what they say of how they were made. What is written appears under its name only
//! when it is complete.

pub(crate) mod atomic;
mod exr;
mod format;
mod jpeg;
mod png;
mod provenance;
mod tiff;
#[cfg(feature = "webp")]
mod webp;

use std::io;
use std::path::Path;

use slabsplat_core::Image;

pub use atomic::write_whole;
pub use exr::{exr_bytes, write_exr};
pub use format::PictureFormat;
pub use png::{png_bytes, write_png};
pub use provenance::{PictureScene, Provenance, read_picture_scene};

use crate::IoError;

/// Writes a picture in the format that the name's extension says: one of [`PictureFormat::ALL`].
///
/// # Errors
/// If the extension is another, or the file cannot be written.
pub fn write_picture(path: impl AsRef<Path>, image: &Image) -> Result<(), IoError> {
    let path = path.as_ref();
    match PictureFormat::of_name(path) {
        Some(format) => format.write(path, image, None),
        None => Err(IoError::UnknownPicture { path: path.to_owned() }),
    }
}

/// No format has room for a picture of none, and one encoder panics.
fn has_pixels(image: &Image) -> io::Result<()> {
    match image.pixels() {
        [] => Err(io::Error::other("it has no pixels")),
        [..] => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn picture_bytes_are_those_of_the_file() {
        let dir = tempfile::tempdir().unwrap();
        let image = Image::filled(5, 3, [0.1, 0.2, 0.3, 0.7]);
        for (name, bytes) in [("a.png", png_bytes(&image)), ("a.exr", exr_bytes(&image))] {
            write_picture(dir.path().join(name), &image).unwrap();
            assert_eq!(std::fs::read(dir.path().join(name)).unwrap(), bytes.unwrap(), "{name}");
        }
        let empty = Image::filled(0, 3, [0.0; 4]);
        for error in [png_bytes(&empty), exr_bytes(&empty)].map(Result::unwrap_err) {
            assert_eq!(error.to_string(), "cannot encode the picture: it has no pixels");
        }
    }

    #[test]
    fn picture_format_by_extension() {
        let dir = tempfile::tempdir().unwrap();
        let image = Image::filled(2, 1, [0.5; 4]);
        for (name, magic) in [("a.PNG", &b"\x89PNG"[..]), ("b.exr", &[0x76, 0x2f, 0x31, 0x01])] {
            write_picture(dir.path().join(name), &image).unwrap();
            assert!(std::fs::read(dir.path().join(name)).unwrap().starts_with(magic), "{name}");
        }
        for name in ["a.gif", "a", "png"] {
            let err = write_picture(dir.path().join(name), &image).unwrap_err().to_string();
            assert!(err.contains(&format!("name it {}", PictureFormat::endings())), "{err}");
        }
    }
}
