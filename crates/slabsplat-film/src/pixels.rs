//! A frame as encoders take it, and as PNG.

use crate::metadata::Metadata;
use slabsplat_core::Image;
use std::io::{self, BufRead, Cursor, Seek, Write};

/// 8 bits of red, green, blue and opacity a pixel, not premultiplied.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Pixels {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) rgba: Vec<u8>,
}

/// The most memory that reading a frame may take beside its pixels.
const MAX_BYTES: usize = 1 << 26;

impl Pixels {
    pub(crate) fn of(image: &Image) -> Self {
        Self { width: image.width(), height: image.height(), rgba: image.to_rgba8() }
    }

    /// Red, green and blue before black.
    pub(crate) fn before_black(&self) -> Vec<u8> {
        let over = |pixel: &[u8; 4]| {
            let [r, g, b, a] = pixel.map(u32::from);
            // Rounded; of an opaque pixel nothing changes.
            [r, g, b].map(|channel| ((channel * a + 127) / 255) as u8)
        };
        let (pixels, _) = self.rgba.as_chunks::<4>();
        pixels.iter().flat_map(over).collect()
    }

    /// Without opacity where there is none to be seen.
    pub(crate) fn samples(&self, has_opacity: bool) -> Vec<u8> {
        if has_opacity { self.rgba.clone() } else { self.before_black() }
    }

    pub(crate) fn write_png(
        &self,
        writer: impl Write,
        has_opacity: bool,
        metadata: &Metadata,
    ) -> io::Result<()> {
        let size = [self.width, self.height];
        let mut encoder = png_encoder(writer, size, has_opacity, metadata).map_err(to_io_error)?;
        encoder.set_filter(png::Filter::Adaptive);
        let mut writer = encoder.write_header().map_err(to_io_error)?;
        writer.write_image_data(&self.samples(has_opacity)).map_err(to_io_error)?;
        writer.finish().map_err(to_io_error)
    }

    /// A frame that was written so.
    pub(crate) fn read_png(file: impl BufRead + Seek, size: [u32; 2]) -> Result<Self, String> {
        let limits = png::Limits { bytes: MAX_BYTES };
        let decoder = png::Decoder::new_with_limits(file, limits);
        let mut reader = decoder.read_info().map_err(|error| error.to_string())?;
        let info = reader.info();
        if [info.width, info.height] != size {
            return Err(format!("it has {} x {} pixels", info.width, info.height));
        }
        let n_channels = info.color_type.samples();
        if info.bit_depth != png::BitDepth::Eight || !(3..=4).contains(&n_channels) {
            return Err("it is not as slabsplat writes frames".to_owned());
        }
        let [width, height] = size;
        let mut samples = vec![0; width as usize * height as usize * n_channels];
        reader.next_frame(&mut samples).map_err(|error| error.to_string())?;
        let rgba = match n_channels {
            4 => samples,
            _ => samples.as_chunks::<3>().0.iter().flat_map(|&[r, g, b]| [r, g, b, 255]).collect(),
        };
        Ok(Self { width, height, rgba })
    }

    /// The VP8L chunk of a lossless WebP, with its header.
    pub(crate) fn vp8l(&self, has_opacity: bool) -> io::Result<Vec<u8>> {
        let mut file = Cursor::new(Vec::new());
        let color =
            if has_opacity { image_webp::ColorType::Rgba8 } else { image_webp::ColorType::Rgb8 };
        image_webp::WebPEncoder::new(&mut file)
            .encode(&self.samples(has_opacity), self.width, self.height, color)
            .map_err(io::Error::other)?;
        let file = file.into_inner();
        chunk(&file, b"VP8L")
            .ok_or_else(|| io::Error::other("the WebP encoder wrote no VP8L chunk"))
    }
}

/// A chunk of a RIFF file, with its name, its length and its padding.
fn chunk(file: &[u8], name: &[u8; 4]) -> Option<Vec<u8>> {
    let mut rest = file.get(12..)?;
    loop {
        let (header, data) = rest.split_first_chunk::<8>()?;
        let [.., a, b, c, d] = *header;
        let n_bytes = u32::from_le_bytes([a, b, c, d]) as usize;
        let n_padded = n_bytes.checked_add(n_bytes % 2)?;
        if header.starts_with(name) {
            return rest.get(..8 + n_padded).map(<[u8]>::to_vec);
        }
        rest = data.get(n_padded..)?;
    }
}

pub(crate) fn png_encoder<'a, W: Write>(
    writer: W,
    [width, height]: [u32; 2],
    has_opacity: bool,
    metadata: &Metadata,
) -> Result<png::Encoder<'a, W>, png::EncodingError> {
    let mut encoder = png::Encoder::new(writer, width, height);
    encoder.set_color(if has_opacity { png::ColorType::Rgba } else { png::ColorType::Rgb });
    encoder.set_depth(png::BitDepth::Eight);
    for (keyword, text) in &metadata.png_texts {
        encoder.add_itxt_chunk(keyword.clone(), text.clone())?;
    }
    Ok(encoder)
}

pub(crate) fn to_io_error(error: png::EncodingError) -> io::Error {
    match error {
        png::EncodingError::IoError(error) => error,
        other => io::Error::other(other),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_before_black() {
        let rgba = vec![255, 128, 0, 255, 200, 100, 50, 0, 255, 128, 2, 128];
        let pixels = Pixels { width: 3, height: 1, rgba };
        assert_eq!(pixels.before_black(), [255, 128, 0, 0, 0, 0, 128, 64, 1]);
    }

    #[test]
    fn pixels_come_back_from_png() {
        let rgba: Vec<u8> = (0..5 * 3 * 4).map(|n| (n * 37 % 256) as u8).collect();
        let pixels = Pixels { width: 5, height: 3, rgba };
        let mut bytes = Vec::new();
        pixels.write_png(&mut bytes, true, &Metadata::default()).unwrap();
        assert_eq!(Pixels::read_png(Cursor::new(&bytes), [5, 3]), Ok(pixels.clone()));
        let error = Pixels::read_png(Cursor::new(&bytes), [3, 5]).unwrap_err();
        assert_eq!(error, "it has 5 x 3 pixels");
        assert!(Pixels::read_png(Cursor::new(&bytes[..60]), [5, 3]).is_err());
    }
}
