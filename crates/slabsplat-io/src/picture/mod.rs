//! Writing pictures, and what they say of how they were made. What is written appears under its name only
//! when it is complete.

pub(crate) mod atomic;
#[cfg(feature = "exr")]
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
#[cfg(feature = "exr")]
pub use exr::{exr_bytes, write_exr};
pub use format::PictureFormat;
pub use jpeg::jpeg_bytes;
pub use png::{png_bytes, quick_png_bytes, write_png};
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
        let check = |name: &str, bytes: fn(&Image) -> Result<Vec<u8>, IoError>| {
            write_picture(dir.path().join(name), &image).unwrap();
            let written = std::fs::read(dir.path().join(name)).unwrap();
            assert_eq!(written, bytes(&image).unwrap(), "{name}");
            let error = bytes(&Image::filled(0, 3, [0.0; 4])).unwrap_err().to_string();
            assert_eq!(error, "cannot encode the picture: it has no pixels");
        };
        check("a.png", png_bytes);
        #[cfg(feature = "exr")]
        check("a.exr", exr_bytes);
    }

    #[test]
    fn picture_format_by_extension() {
        let dir = tempfile::tempdir().unwrap();
        let image = Image::filled(2, 1, [0.5; 4]);
        for (name, magic) in [
            ("a.PNG", &b"\x89PNG"[..]),
            ("b.tif", b"II"),
            #[cfg(feature = "exr")]
            ("c.exr", &[0x76, 0x2f, 0x31, 0x01]),
        ] {
            write_picture(dir.path().join(name), &image).unwrap();
            assert!(std::fs::read(dir.path().join(name)).unwrap().starts_with(magic), "{name}");
        }
        for name in ["a.gif", "a", "png"] {
            let err = write_picture(dir.path().join(name), &image).unwrap_err().to_string();
            assert!(err.contains(&format!("name it {}", PictureFormat::endings())), "{err}");
        }
    }

    /// Who writes or reads a format whose feature is off learns which it is.
    #[test]
    fn picture_formats_name_their_feature() {
        let dir = tempfile::tempdir().unwrap();
        let image = Image::filled(2, 1, [0.5; 4]);
        for (name, feature, is_on) in
            [("a.EXR", "exr", cfg!(feature = "exr")), ("a.webp", "webp", cfg!(feature = "webp"))]
        {
            let path = dir.path().join(name);
            let written = write_picture(&path, &image);
            assert_eq!(written.is_ok(), is_on, "{name}");
            let read = read_picture_scene(&path);
            assert_eq!(read.is_ok(), is_on, "{name}");
            for error in [written.err(), read.err()].into_iter().flatten() {
                let expected =
                    format!("{name}: it takes the feature `{feature}`, which is off here");
                assert!(error.to_string().contains(&expected), "{error}");
            }
        }
    }
}
