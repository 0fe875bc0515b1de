//! JPEG (ITU-T T.81): of 8 bits and lossless by the crate `jpeg-decoder`, of 12 bits by [`twelve_bits`].
//!
//! `jpeg-decoder` refuses 12 bits, and so does `zune-jpeg`; DICOM has them in one form (PS3.5 §8.2.1,
//! process 4): sequential, Huffman codes, one component.

mod huffman;
mod idct;
mod twelve_bits;

use std::io::Cursor;

use jpeg_decoder::{ColorTransform, Decoder};

use super::coded::CodedImage;
use super::frame::{Colors, Layout};
use super::segments::{Broken, END_OF_IMAGE, FrameSize, START_OF_SCAN, Segments};
use crate::volume::images::MAX_JPEG_ROWS;

/// What says in front of a scan how it is to be read.
struct Outline {
    size: FrameSize,
    /// Of the frame header, which says how the image is coded.
    marker: u8,
    /// What the file's own marks say of its colours: whether they are luminance and differences.
    has_ybr: bool,
}

/// The samples of a frame, of the colours that the layout has.
pub(super) fn unpack(packed: &[u8], layout: &Layout) -> Result<CodedImage, String> {
    let outline = Outline::of(packed)?;
    let size = outline.size;
    layout.check_coded(&size)?;
    let is_lossless = outline.marker == 0xc3;
    if size.precision == 12 && !is_lossless {
        return Ok(twelve_bits::unpack(packed, layout)?);
    }
    if MAX_JPEG_ROWS < size.rows {
        return Err(format!("it has more than {MAX_JPEG_ROWS} rows"));
    }
    let mut decoder = Decoder::new(Cursor::new(packed));
    decoder.set_max_decoding_buffer_size(2 * layout.frame_bytes() as usize);
    if 1 < size.n_components {
        let is_converted = layout.colors == Colors::Rgb && outline.has_ybr;
        // `None` would not interleave what it decodes.
        let transform = if is_converted { ColorTransform::YCbCr } else { ColorTransform::RGB };
        decoder.set_color_transform(transform);
    }
    let bytes = decoder.decode().map_err(|error| error.to_string())?;
    let n_samples = layout.n_pixels() * layout.n_channels;
    let samples = if bytes.len() == n_samples {
        bytes.into_iter().map(i32::from).collect()
    } else if bytes.len() == 2 * n_samples {
        let pair = |pair: &[u8]| i32::from(u16::from_ne_bytes([pair[0], pair[1]]));
        bytes.chunks_exact(2).map(pair).collect()
    } else {
        return Err("it is of another size than it says".to_owned());
    };
    Ok(CodedImage { samples, precision: size.precision, is_signed: false })
}

impl Outline {
    fn of(packed: &[u8]) -> Result<Self, Broken> {
        let mut segments = Segments::of(packed)?;
        let mut frame = None;
        let (mut is_jfif, mut adobe) = (false, None);
        loop {
            let segment = segments.next()?;
            match segment.marker {
                // Frame headers, but for the tables among them.
                0xc0..=0xcf if !matches!(segment.marker, 0xc4 | 0xc8 | 0xcc) => {
                    frame = Some((FrameSize::of(segment.data)?, segment.marker));
                }
                0xe0 => is_jfif |= segment.data.starts_with(b"JFIF\0"),
                0xee if segment.data.starts_with(b"Adobe") => {
                    adobe = segment.data.get(11).copied();
                }
                START_OF_SCAN | END_OF_IMAGE => break,
                _ => {}
            }
        }
        let (size, marker) = frame.ok_or("it has no frame")?;
        let has_ybr = marker != 0xc3 && adobe.map_or(is_jfif, |transform| transform == 1);
        Ok(Self { size, marker, has_ybr })
    }
}
