//! JPEG 2000 (ITU-T T.800, ISO/IEC 15444-1), lossless and lossy, by the crate `rust-j2k`.
//!
//! That crate has no unsafe code and nothing else below it, decodes all 23 streams of the conformance suite
//! (ISO/IEC 15444-4), keeps all 16 bits and their signs, and bounds what it takes of memory. `hayro-jpeg2000`
//! gives 8 bits alone up to 0.3 and needs a newer compiler after it; `openjp2` is OpenJPEG's C in another
//! language. HTJ2K is of neither.

use super::coded::CodedImage;
use super::frame::Layout;
use super::segments::FrameSize;

/// Start of codestream, and the segment of sizes that must be next (§A.4.1, §A.5.1).
const CODESTREAM: [u8; 4] = [0xff, 0x4f, 0xff, 0x51];

/// A box of JP2 files, which should not be in DICOM, but is met (§I.5.1).
const JP2: &[u8] = b"\0\0\0\x0cjP  ";

/// The header of a tile: no stream has more tiles than there is room for.
const TILE_HEADER_BYTES: u64 = 14;

/// The image of a frame, after the inverse of any colour transform.
pub(super) fn unpack(packed: &[u8], layout: &Layout) -> Result<CodedImage, String> {
    let stream = codestream(packed).ok_or("it does not begin as one")?;
    let sizes = Sizes::of(stream).ok_or("its header is cut off")?;
    layout.check_coded(&sizes.frame()?)?;
    if (stream.len() as u64) / TILE_HEADER_BYTES < sizes.n_tiles() {
        return Err(format!("there is no room for its {} tiles", sizes.n_tiles()));
    }
    let image = rust_j2k::decode(stream).map_err(|error| error.to_string())?;
    let [first, ..] = image.components.as_slice() else { return Err("it is empty".to_owned()) };
    let (precision, is_signed) = (u32::from(first.bit_depth), first.signed);
    let n_pixels = layout.n_pixels();
    if image.components.iter().any(|component| component.samples.len() != n_pixels) {
        return Err("its channels differ in size".to_owned());
    }
    let pixel = |at: usize| image.components.iter().map(move |component| component.samples[at]);
    Ok(CodedImage { samples: (0..n_pixels).flat_map(pixel).collect(), precision, is_signed })
}

/// The codestream, which may be in a box of a JP2 file.
fn codestream(packed: &[u8]) -> Option<&[u8]> {
    if packed.starts_with(&CODESTREAM) {
        return Some(packed);
    }
    let mut rest = packed.starts_with(JP2).then_some(packed)?;
    loop {
        let word = |at: usize| Some(u32::from_be_bytes(rest.get(at..at + 4)?.try_into().ok()?));
        let (n_bytes, kind) = (word(0)? as usize, rest.get(4..8)?);
        // To the end of the file, or of as many bytes as 64 bits count; boxes of these are codestreams alone.
        let (start, end) = match n_bytes {
            0 => (8, rest.len()),
            1 => (16, rest.len()),
            n_bytes => (8, n_bytes),
        };
        if kind == b"jp2c" {
            return rest.get(start..end.min(rest.len())).filter(|s| s.starts_with(&CODESTREAM));
        }
        rest = rest.get(end.max(8)..)?;
    }
}

/// What the segment of sizes says (§A.5.1).
struct Sizes<'p> {
    grid: [u32; 2],
    origin: [u32; 2],
    tile: [u32; 2],
    tile_origin: [u32; 2],
    /// Of each component its bits, and its steps along x and y.
    components: &'p [[u8; 3]],
}

impl<'p> Sizes<'p> {
    fn of(stream: &'p [u8]) -> Option<Self> {
        let word = |at: usize| Some(u32::from_be_bytes(stream.get(at..at + 4)?.try_into().ok()?));
        let pair = |at: usize| Some([word(at)?, word(at + 4)?]);
        let &[high, low] = stream.get(40..42)? else { return None };
        let n_components = usize::from(u16::from_be_bytes([high, low]));
        let (components, _) = stream.get(42..42 + 3 * n_components)?.as_chunks();
        let (grid, origin, tile, tile_origin) = (pair(8)?, pair(16)?, pair(24)?, pair(32)?);
        Some(Self { grid, origin, tile, tile_origin, components })
    }

    fn frame(&self) -> Result<FrameSize, String> {
        let [first, ..] = self.components else { return Err("it is empty".to_owned()) };
        if self.components.iter().any(|component| component != first) || first[1..] != [1, 1] {
            return Err("its channels differ in size or in bits".to_owned());
        }
        let size = |axis: usize| self.grid[axis].saturating_sub(self.origin[axis]) as usize;
        Ok(FrameSize {
            precision: u32::from(first[0] & 0x7f) + 1,
            rows: size(1),
            columns: size(0),
            n_components: self.components.len(),
        })
    }

    fn n_tiles(&self) -> u64 {
        let along = |axis: usize| {
            let size = self.grid[axis].saturating_sub(self.tile_origin[axis]);
            u64::from(size.div_ceil(self.tile[axis].max(1)))
        };
        along(0).saturating_mul(along(1))
    }
}
