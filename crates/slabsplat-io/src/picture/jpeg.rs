//! JPEG: 8 bits a channel, without opacity, and not exactly what was drawn.
//!
//! What a picture says of itself is in comments (marker `COM`, ITU-T T.81, B.2.4.5), of which there may be
//! any number, each of up to 64 KiB.

use std::io::{self, BufRead, Read, Write};

use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageError};
use slabsplat_core::Image;

use super::{Provenance, has_pixels};
use crate::IoError;

/// Nobody sees what is lost at this quality, and files are a tenth of a PNG.
const QUALITY: u8 = 95;

/// What comments of ours begin with.
const SCENE: &[u8] = b"slabsplat.scene\0";
const PROGRAM: &[u8] = b"slabsplat.program\0";

const MARKER: u8 = 0xff;
const START_OF_IMAGE: u8 = 0xd8;
const START_OF_SCAN: u8 = 0xda;
const COMMENT: u8 = 0xfe;

/// Bytes of a text in one comment, of which the format takes 65533.
const PIECE_BYTES: usize = 65_000;

/// What is read of a picture to find them.
const MAX_BYTES: u64 = 8 << 20;

/// A picture that is seen for a moment: JPEG of that quality, 1 … 100, without what it was made of.
///
/// ```
/// let image = slabsplat_core::Image::filled(64, 48, [0.2, 0.3, 0.4, 1.0]);
/// assert!(slabsplat_io::jpeg_bytes(&image, 80)?.starts_with(&[0xff, 0xd8]));
/// # Ok::<(), slabsplat_io::IoError>(())
/// ```
///
/// # Errors
/// If the picture has no pixels, or anything shines through it.
pub fn jpeg_bytes(image: &Image, quality: u8) -> Result<Vec<u8>, IoError> {
    encoded(image, quality).map_err(|source| IoError::Encode { source })
}

pub(super) fn encode(
    mut writer: impl Write,
    image: &Image,
    provenance: &Provenance,
) -> io::Result<()> {
    let bytes = encoded(image, QUALITY)?;
    let (start, rest) = bytes.split_at(2);
    writer.write_all(start)?;
    for (name, text) in [(PROGRAM, &provenance.program), (SCENE, &provenance.scene)] {
        write_comments(&mut writer, name, text.as_deref())?;
    }
    writer.write_all(rest)
}

fn encoded(image: &Image, quality: u8) -> io::Result<Vec<u8>> {
    has_pixels(image)?;
    let rgba = image.to_rgba8();
    let (pixels, _) = rgba.as_chunks::<4>();
    if pixels.iter().any(|pixel| pixel[3] != 255) {
        return Err(io::Error::other(super::format::NO_TRANSPARENCY));
    }
    let rgb: Vec<u8> = pixels.iter().flat_map(|&[r, g, b, _]| [r, g, b]).collect();
    let mut bytes = Vec::new();
    let (width, height) = (image.width(), image.height());
    JpegEncoder::new_with_quality(&mut bytes, quality)
        .encode(&rgb, width, height, ExtendedColorType::Rgb8)
        .map_err(to_io_error)?;
    Ok(bytes)
}

fn to_io_error(error: ImageError) -> io::Error {
    match error {
        ImageError::IoError(error) => error,
        other => io::Error::other(other),
    }
}

/// Writes a text in pieces, or an empty one in one.
fn write_comments(writer: &mut impl Write, name: &[u8], text: Option<&str>) -> io::Result<()> {
    let Some(text) = text else { return Ok(()) };
    let pieces = text.as_bytes().chunks(PIECE_BYTES);
    let empty: [&[u8]; 1] = [&[]];
    for piece in pieces.chain(empty.into_iter().filter(|_| text.is_empty())) {
        let length = 2 + name.len() + piece.len();
        let length = u16::try_from(length).map_err(io::Error::other)?;
        writer.write_all(&[MARKER, COMMENT])?;
        writer.write_all(&length.to_be_bytes())?;
        writer.write_all(name)?;
        writer.write_all(piece)?;
    }
    Ok(())
}

/// What comments before the pixels say.
pub(super) fn read_provenance(file: impl BufRead) -> Result<Provenance, String> {
    let mut file = file.take(MAX_BYTES);
    let mut start = [0; 2];
    let cut_off = |_| "it is cut off".to_owned();
    file.read_exact(&mut start).map_err(cut_off)?;
    if start != [MARKER, START_OF_IMAGE] {
        return Err("it does not begin as one".to_owned());
    }
    let (mut program, mut scene) = (None, None);
    loop {
        let mut head = [0; 4];
        file.read_exact(&mut head).map_err(cut_off)?;
        let [MARKER, kind, high, low] = head else {
            return Err("its segments do not follow each other".to_owned());
        };
        if kind == START_OF_SCAN {
            break;
        }
        let Some(length) = u16::from_be_bytes([high, low]).checked_sub(2) else {
            return Err("a segment has no length".to_owned());
        };
        let mut segment = vec![0; usize::from(length)];
        file.read_exact(&mut segment).map_err(cut_off)?;
        if kind == COMMENT {
            append(&mut program, segment.strip_prefix(PROGRAM));
            append(&mut scene, segment.strip_prefix(SCENE));
        }
    }
    let text = |bytes: Option<Vec<u8>>| bytes.and_then(|bytes| String::from_utf8(bytes).ok());
    Ok(Provenance { program: text(program), scene: text(scene) })
}

fn append(text: &mut Option<Vec<u8>>, piece: Option<&[u8]>) {
    if let Some(piece) = piece {
        text.get_or_insert_default().extend_from_slice(piece);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PictureFormat;

    #[test]
    fn jpeg_reads_back() {
        let mut image = Image::filled(40, 24, [0.2, 0.4, 0.6, 1.0]);
        image.pixels_mut()[..20 * 40].fill([0.9, 0.1, 0.0, 1.0]);
        let bytes = PictureFormat::Jpeg.bytes(&image, None).unwrap();
        let read = image::load_from_memory(&bytes).unwrap();
        assert_eq!(read.color(), image::ColorType::Rgb8);
        let read = read.into_rgb8();
        assert_eq!(read.dimensions(), (40, 24));
        for (x, y, expected) in [(3, 3, [230, 26, 0]), (30, 23, [51, 102, 153])] {
            for (channel, expected) in read.get_pixel(x, y).0.into_iter().zip(expected) {
                assert!(channel.abs_diff(expected) < 4, "{channel} {expected}");
            }
        }
    }

    #[test]
    fn jpeg_has_no_transparency() {
        let mut image = Image::filled(4, 4, [0.2, 0.4, 0.6, 1.0]);
        assert!(PictureFormat::Jpeg.bytes(&image, None).is_ok());
        image.pixels_mut()[7] = [0.2, 0.4, 0.6, 0.9];
        let error = PictureFormat::Jpeg.bytes(&image, None).unwrap_err().to_string();
        assert!(error.contains("JPEG has no transparency"), "{error}");
    }

    /// A comment takes 64 KiB.
    #[test]
    fn jpeg_comments_go_on_in_others() {
        let scene: String = (0..40_000).map(|n| format!("{n}ä ")).collect();
        let provenance = Provenance { program: None, scene: Some(scene) };
        let image = Image::filled(4, 4, [1.0; 4]);
        let bytes = PictureFormat::Jpeg.bytes(&image, Some(&provenance)).unwrap();
        assert!(image::load_from_memory(&bytes).is_ok());
        assert!(read_provenance(bytes.as_slice()).unwrap() == provenance);
    }
}
