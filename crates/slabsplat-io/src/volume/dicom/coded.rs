//! An image as a codec gives it, and the bytes that it would have if it were not packed.

use super::frame::Layout;
use super::segments::FrameSize;

/// Samples, all those of a pixel together.
#[derive(Debug, PartialEq)]
pub(super) struct CodedImage {
    pub(super) samples: Vec<i32>,
    /// Bits of a sample.
    pub(super) precision: u32,
    /// Whether the codec says that samples have signs.
    pub(super) is_signed: bool,
}

impl CodedImage {
    /// As pixels are stored that are not packed, least significant byte first.
    pub(super) fn into_bytes(self, layout: &Layout) -> Vec<u8> {
        // Codecs without signs hold the bits of values that have them (PS3.5 §8.2).
        let has_bare_bits = layout.is_signed && !self.is_signed;
        let unused = if has_bare_bits { 32 - self.precision } else { 0 };
        let values = self.samples.iter().map(|&sample| sample << unused >> unused);
        match layout.bits_allocated {
            8 => values.map(|value| value as u8).collect(),
            16 => values.flat_map(|value| (value as u16).to_le_bytes()).collect(),
            _ => values.flat_map(i32::to_le_bytes).collect(),
        }
    }
}

impl Layout {
    /// That a codec's image is the one that the file says it has.
    pub(super) fn check_coded(&self, size: &FrameSize) -> Result<(), String> {
        let said = [self.rows, self.columns, self.n_channels];
        let found = [size.rows, size.columns, size.n_components];
        if said != found {
            let [rows, columns, n_channels] = found;
            return Err(format!(
                "it has {columns} x {rows} pixels of {n_channels} values, other than the file says"
            ));
        }
        if self.is_float || !(1..=self.bits_allocated).contains(&size.precision) {
            let allocated = self.bits_allocated;
            return Err(format!(
                "its samples have {} bits, and the file's {allocated}",
                size.precision
            ));
        }
        Ok(())
    }
}
