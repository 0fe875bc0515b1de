//! TIFF: 16 bits a channel, not premultiplied, or the compositor's numbers as they are, 32-bit floats,
//! premultiplied. Which of the two opacities are is in the tag `ExtraSamples` (TIFF 6.0, section 18).

use std::borrow::Cow;
use std::io::{self, BufRead, Seek, Write};

use slabsplat_core::Image;
use tiff::TiffError;
use tiff::decoder::{Decoder, Limits};
use tiff::encoder::colortype::{ColorType, RGBA16, RGBA32Float};
use tiff::encoder::{Compression, DeflateLevel, Predictor, TiffEncoder, TiffValue};
use tiff::tags::{Tag, Type};

use super::{Provenance, has_pixels};

/// What a description that is a scene begins with: those of others are not.
const SCENE: &str = "slabsplat.scene\n";

/// What is read of a picture to find it.
const MAX_BYTES: usize = 8 << 20;

/// How a fourth sample of a pixel stands to the others.
const ASSOCIATED: u16 = 1;
const UNASSOCIATED: u16 = 2;

/// The picture rounded to 16 bits.
pub(super) fn encode_16_bits(
    writer: impl Write + Seek,
    image: &Image,
    provenance: &Provenance,
) -> io::Result<()> {
    let samples = image.to_rgba16();
    encode::<RGBA16>(writer, image, &samples, UNASSOCIATED, Predictor::Horizontal, provenance)
}

/// The picture bit by bit.
pub(super) fn encode_floats(
    writer: impl Write + Seek,
    image: &Image,
    provenance: &Provenance,
) -> io::Result<()> {
    let samples = image.pixels().as_flattened();
    encode::<RGBA32Float>(writer, image, samples, ASSOCIATED, Predictor::None, provenance)
}

fn encode<C: ColorType>(
    writer: impl Write + Seek,
    image: &Image,
    samples: &[C::Inner],
    opacity: u16,
    predictor: Predictor,
    provenance: &Provenance,
) -> io::Result<()>
where
    [C::Inner]: TiffValue,
{
    has_pixels(image)?;
    let write = || {
        let encoder = TiffEncoder::new(writer)?.with_predictor(predictor);
        let mut encoder = encoder.with_compression(Compression::Deflate(DeflateLevel::Balanced));
        let mut picture = encoder.new_image::<C>(image.width(), image.height())?;
        let tags = picture.encoder();
        tags.write_tag(Tag::ExtraSamples, opacity)?;
        if let Some(program) = &provenance.program {
            tags.write_tag(Tag::Software, Utf8(program.as_bytes()))?;
        }
        if let Some(scene) = &provenance.scene {
            tags.write_tag(Tag::ImageDescription, Utf8(format!("{SCENE}{scene}").as_bytes()))?;
        }
        picture.write_data(samples)
    };
    write().map_err(to_io_error)
}

/// A text. The format's own are ASCII; UTF-8, which others write there as well, the crate refuses.
struct Utf8<'a>(&'a [u8]);

impl TiffValue for Utf8<'_> {
    const BYTE_LEN: u8 = 1;
    const FIELD_TYPE: Type = Type::ASCII;

    fn count(&self) -> usize {
        self.0.len() + 1
    }

    fn data(&self) -> Cow<'_, [u8]> {
        Cow::Owned([self.0, &[0]].concat())
    }
}

fn to_io_error(error: TiffError) -> io::Error {
    match error {
        TiffError::IoError(error) => error,
        other => io::Error::other(other),
    }
}

/// What the first page says.
pub(super) fn read_provenance(mut file: impl BufRead + Seek) -> Result<Provenance, String> {
    let n_bytes = file.seek(io::SeekFrom::End(0)).map_err(|error| error.to_string())?;
    file.rewind().map_err(|error| error.to_string())?;
    let mut limits = Limits::default();
    limits.decoding_buffer_size = MAX_BYTES;
    limits.ifd_value_size = MAX_BYTES;
    let decoder = Decoder::new(file).map_err(|error| error.to_string())?;
    let mut decoder = decoder.with_limits(limits);
    let mut text = |tag: Tag| {
        // A longer one than the file is printed by the crate, where nobody asked.
        let entry = decoder.image_ifd().find_entry(tag)?;
        let is_backed = entry.count() <= n_bytes;
        let text = is_backed.then(|| decoder.get_tag_ascii_string(tag).ok())??;
        Some(text.trim_end_matches('\0').to_owned())
    };
    let description = text(Tag::ImageDescription);
    let scene = description.and_then(|text| text.strip_prefix(SCENE).map(str::to_owned));
    Ok(Provenance { program: text(Tag::Software), scene })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PictureFormat;
    use std::io::Cursor;

    fn image() -> Image {
        let mut image = Image::filled(37, 19, [0.2, 0.4, 0.6, 1.0]);
        image.pixels_mut()[4] = [0.0, 0.1, 0.2, 0.4];
        image.pixels_mut()[5] = [0.0; 4];
        image
    }

    fn tag(bytes: &[u8], tag: Tag) -> u32 {
        Decoder::new(Cursor::new(bytes)).unwrap().get_tag_u32(tag).unwrap()
    }

    #[test]
    fn tiff_of_16_bits_is_straight() {
        let bytes = PictureFormat::Tiff.bytes(&image(), None).unwrap();
        assert_eq!(tag(&bytes, Tag::ExtraSamples), 2);
        let read = Decoder::new(Cursor::new(&bytes)).unwrap().read_image().unwrap();
        let tiff::decoder::DecodingResult::U16(read) = read else { panic!("{read:?}") };
        assert_eq!(read.len(), 4 * 37 * 19);
        assert_eq!(read[..4], [13107, 26214, 39321, 65535]);
        assert_eq!(read[16..20], [0, 16384, 32768, 26214]);
        assert_eq!(read[20..24], [0; 4]);
    }

    #[test]
    fn tiff_of_floats_keeps_every_bit() {
        let mut image = image();
        image.pixels_mut()[7] = [f32::INFINITY, f32::MIN_POSITIVE / 2.0, -0.0, 1.5];
        let bytes = PictureFormat::TiffFloat.bytes(&image, None).unwrap();
        assert_eq!(tag(&bytes, Tag::ExtraSamples), 1);
        let read = Decoder::new(Cursor::new(&bytes)).unwrap().read_image().unwrap();
        let tiff::decoder::DecodingResult::F32(read) = read else { panic!("{read:?}") };
        let bits = |channels: &[f32]| channels.iter().map(|c| c.to_bits()).collect::<Vec<_>>();
        assert!(bits(&read) == bits(image.pixels().as_flattened()));
    }

    #[test]
    fn tiff_of_others_has_no_scene() {
        let mut bytes = Cursor::new(Vec::new());
        let provenance = Provenance { program: Some("ImageJ".to_owned()), scene: None };
        encode_16_bits(&mut bytes, &image(), &provenance).unwrap();
        bytes.rewind().unwrap();
        let read = read_provenance(bytes).unwrap();
        assert_eq!((read.program.as_deref(), read.scene), (Some("ImageJ"), None));
    }
}
