//! A frame that is packed in fragments, as plain bytes.

use std::path::Path;

use super::frame::Layout;
use super::pixels::{MAX_RATIO, too_short};
use super::syntax::Packing;
use super::{jpeg, jpeg_2000, jpeg_ls, rle};
use crate::IoError;

/// JPEG-LS and JPEG 2000 have a bit for a row of one value, or for many rows, and what is around an image is
/// often that. A frame of 2048 × 2048 empty pixels of 16 bits takes 286 bytes as JPEG-LS.
const MAX_BLANK_RATIO: u64 = 1 << 16;

/// A frame of that many bytes may be blank.
const MAX_BLANK_BYTES: u64 = 64 << 20;

/// A frame's bytes, least significant first, and all values of a pixel together.
pub(super) fn unpack(
    path: &Path,
    layout: &Layout,
    packing: Packing,
    packed: &[u8],
) -> Result<Vec<u8>, IoError> {
    let n_bytes = layout.frame_bytes();
    if !is_backed(packing, packed.len() as u64, n_bytes) {
        return Err(too_short(path, n_bytes, packed.len() as u64));
    }
    let (name, unpacked) = match packing {
        Packing::None => return Ok(packed.to_vec()),
        Packing::Rle => return unpack_runs(path, layout, packed),
        Packing::Jpeg => ("JPEG", jpeg::unpack(packed, layout)),
        Packing::JpegLs => ("JPEG-LS", jpeg_ls::unpack(packed, layout)),
        Packing::Jpeg2000 => ("JPEG 2000", jpeg_2000::unpack(packed, layout)),
    };
    let unpacked = unpacked
        .map_err(|what| IoError::malformed(path, format!("its {name} is broken: {what}")))?;
    Ok(unpacked.into_bytes(layout))
}

/// Whether so many packed bytes may be a frame.
fn is_backed(packing: Packing, n_packed: u64, n_bytes: u64) -> bool {
    let may_be_blank = matches!(packing, Packing::JpegLs | Packing::Jpeg2000);
    n_bytes <= n_packed.saturating_mul(MAX_RATIO)
        || (may_be_blank
            && n_bytes <= MAX_BLANK_BYTES.min(n_packed.saturating_mul(MAX_BLANK_RATIO)))
}

fn unpack_runs(path: &Path, layout: &Layout, packed: &[u8]) -> Result<Vec<u8>, IoError> {
    let pixel_bytes = layout.bits_allocated as usize / 8 * layout.n_channels;
    rle::unpack(packed, layout.n_pixels(), pixel_bytes)
        .map(|bytes| if layout.n_channels == 1 { bytes } else { un_rle(layout, &bytes) })
        .ok_or_else(|| IoError::malformed(path, "its run lengths are broken or cut off"))
}

/// Segments of several channels come the first channel first, though bytes are counted from the last.
fn un_rle(layout: &Layout, bytes: &[u8]) -> Vec<u8> {
    let value_bytes = layout.bits_allocated as usize / 8;
    let pixels = bytes.chunks_exact(value_bytes * layout.n_channels);
    pixels.flat_map(|pixel| pixel.rchunks_exact(value_bytes).flatten().copied()).collect()
}
