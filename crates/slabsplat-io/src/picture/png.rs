//! PNG: 8 bits a channel. PNG's colours are not premultiplied, so that ours are divided by their
//! opacity.

use std::io::{self, BufRead, Seek, Write};
use std::path::Path;

use png::text_metadata::ITXtChunk;
use png::{
    BitDepth, ColorType, Compression, Decoder, Encoder, EncodingError, Filter, Info, Limits,
};
use slabsplat_core::Image;

use super::{PictureFormat, Provenance, has_pixels};
use crate::IoError;

/// The keyword of the text that is the scene; others of the kind have a program's name before them, too.
const SCENE: &str = "slabsplat.scene";

/// PNG's own keyword.
const SOFTWARE: &str = "Software";

/// What reading a picture's texts may take: they are packed, and their lengths are a stranger's word.
const MAX_BYTES: usize = 8 << 20;

/// Writes red, green, blue and opacity, rounded to 8 bits, as [`Image::to_rgba8`] does.
///
/// # Errors
/// If the file cannot be written.
pub fn write_png(path: impl AsRef<Path>, image: &Image) -> Result<(), IoError> {
    PictureFormat::Png.write(path, image, None)
}

/// What [`write_png`] would write.
///
/// # Errors
/// If the picture has no pixels.
pub fn png_bytes(image: &Image) -> Result<Vec<u8>, IoError> {
    PictureFormat::Png.bytes(image, None)
}

/// A picture that is seen for a moment: as [`png_bytes`], packed in a fraction of the time, and less.
///
/// # Errors
/// If the picture has no pixels.
pub fn quick_png_bytes(image: &Image) -> Result<Vec<u8>, IoError> {
    let mut bytes = Vec::new();
    let encoded = encode_by(&mut bytes, image, &Provenance::NONE, Compression::Fast);
    encoded.map_err(|source| IoError::Encode { source })?;
    Ok(bytes)
}

pub(super) fn encode(writer: impl Write, image: &Image, provenance: &Provenance) -> io::Result<()> {
    encode_by(writer, image, provenance, Compression::default())
}

fn encode_by(
    writer: impl Write,
    image: &Image,
    provenance: &Provenance,
    compression: Compression,
) -> io::Result<()> {
    has_pixels(image)?;
    let mut info = Info::with_size(image.width(), image.height());
    info.color_type = ColorType::Rgba;
    info.bit_depth = BitDepth::Eight;
    info.utf8_text.extend(texts(provenance).map(|(keyword, text)| chunk(keyword, text)));
    let mut encoder = Encoder::with_info(writer, info).map_err(to_io_error)?;
    encoder.set_compression(compression);
    encoder.set_filter(Filter::Adaptive);
    let mut writer = encoder.write_header().map_err(to_io_error)?;
    writer.write_image_data(&image.to_rgba8()).map_err(to_io_error)?;
    writer.finish().map_err(to_io_error)
}

/// Keywords and texts.
pub(super) fn texts(provenance: &Provenance) -> impl Iterator<Item = (&'static str, &str)> {
    let Provenance { program, scene } = provenance;
    let texts = [(SOFTWARE, program), (SCENE, scene)];
    texts.into_iter().filter_map(|(keyword, text)| Some((keyword, text.as_deref()?)))
}

fn chunk(keyword: &str, text: &str) -> ITXtChunk {
    let mut chunk = ITXtChunk::new(keyword, text);
    chunk.compressed = keyword == SCENE;
    chunk
}

fn to_io_error(error: EncodingError) -> io::Error {
    match error {
        EncodingError::IoError(error) => error,
        other => io::Error::other(other),
    }
}

/// What stands before the pixels.
pub(super) fn read_provenance(file: impl BufRead + Seek) -> Result<Provenance, String> {
    let decoder = Decoder::new_with_limits(file, Limits { bytes: MAX_BYTES });
    let reader = decoder.read_info().map_err(|error| error.to_string())?;
    let info = reader.info();
    let text = |keyword: &str| {
        let mut chunk = info.utf8_text.iter().find(|chunk| chunk.keyword == keyword)?.clone();
        chunk.decompress_text_with_limit(MAX_BYTES).ok()?;
        chunk.get_text().ok()
    };
    Ok(Provenance { program: text(SOFTWARE), scene: text(SCENE) })
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
        let quick = image::load_from_memory(&quick_png_bytes(&image).unwrap()).unwrap();
        assert_eq!(quick.into_rgba8(), read);
    }
}
