//! Which voxels of a brick have values in the iso-ranges, as bits.
//!
//! ```text
//! for each row of eight voxels:
//!     bits = 0
//!     for each iso-range [lo, hi], as samples of the volume's own type:
//!         bits |= lo ≤ sample and sample ≤ hi, eight at once
//! ```
//!
//! 1. Samples are compared as they are, in their own type: no value is computed, and a range's ends are
//!    exact.
//! 2. A brick is only asked about the ranges that its least and largest value leave open (`brick_ranges.rs`).
//! 3. A row is a byte: how many there are, and where, takes single instructions.

use crate::bricks::N_ROWS;
use crate::order::{Ordered, samples_in};
use crate::voxel_rules::{VisibleVoxels, VoxelRules};
use crate::{BRICK_SIDE, BrickGrid, VoxelRecord};
use slabsplat_core::{IsoRange, Volume};
use std::ops::Range;

/// Decides which voxels are inside of iso-ranges.
pub(crate) struct Membership<'a, T> {
    samples: &'a [T],
    grid: BrickGrid,
    /// The iso-ranges among samples.
    ranges: Vec<[T; 2]>,
    /// What else decides.
    visible: Option<VisibleVoxels<'a, T>>,
}

/// A bit a voxel of a brick, row by row, the first voxel in the lowest bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct BrickMask {
    pub(crate) rows: [u8; N_ROWS],
}

impl<'a, T: Ordered> Membership<'a, T> {
    /// `samples` are those of `volume`.
    pub(crate) fn new(
        volume: &Volume,
        samples: &'a [T],
        grid: BrickGrid,
        ranges: &[IsoRange],
        rules: Option<&VoxelRules<'a>>,
    ) -> Self {
        let in_samples = |ranges: &[IsoRange]| -> Vec<[T; 2]> {
            ranges.iter().map(|&range| samples_in(volume.scaling(), range)).collect()
        };
        let visible = |rules| VisibleVoxels::new(rules, volume, samples, in_samples);
        Self { samples, grid, ranges: in_samples(ranges), visible: rules.map(visible) }
    }

    /// The voxels of a brick whose values are in the iso-ranges with those numbers.
    pub(crate) fn of_brick(&self, brick_idx: u32, ranges: Range<usize>) -> BrickMask {
        let ranges = &self.ranges[ranges];
        let mut mask = BrickMask { rows: [0; N_ROWS] };
        if ranges.is_empty() {
            return mask;
        }
        let [n_x, n_y, _] = self.grid.dims();
        let origin = self.grid.origin(brick_idx);
        let [x_size, y_size, z_size] = self.grid.size_at(origin);
        let start = self.grid.voxel_idx(origin);
        for z in 0..z_size {
            for y in 0..y_size {
                let row = &self.samples[start + (z * n_y + y) * n_x..][..x_size];
                mask.rows[z * BRICK_SIDE + y] = match row.first_chunk() {
                    Some(row) => row_mask(row, ranges),
                    None => short_row_mask(row, ranges),
                };
            }
        }
        if let Some(visible) = &self.visible {
            self.leave_visible(visible, origin, &mut mask);
        }
        mask
    }

    /// Takes out the voxels of a brick that are not visible. A pass of its own, which the common one is
    /// quicker without (14 % of a new transfer function's instructions).
    #[cold]
    fn leave_visible(
        &self,
        visible: &VisibleVoxels<'_, T>,
        [x, y, z]: [usize; 3],
        mask: &mut BrickMask,
    ) {
        let [n_x, ..] = self.grid.dims();
        for (row, bits) in mask.rows.iter_mut().enumerate().filter(|(_, bits)| **bits != 0) {
            let coords = [x, y + row % BRICK_SIDE, z + row / BRICK_SIDE];
            let start = self.grid.voxel_idx(coords);
            let samples = &self.samples[start..][..BRICK_SIDE.min(n_x - x)];
            *bits = visible.among(*bits, coords, start, samples);
        }
    }
}

/// A bit a voxel, without a branch. Eight truths, a byte each, are gathered by a multiplication: it moves the
/// i-th byte's bit to the i-th bit of the highest byte, and no two others meet there.
#[inline]
fn row_mask<T: Ordered>(row: &[T; BRICK_SIDE], ranges: &[[T; 2]]) -> u8 {
    let mut is_inside = [0_u8; BRICK_SIDE];
    for &[first, last] in ranges {
        for (is_inside, &sample) in is_inside.iter_mut().zip(row) {
            *is_inside |= u8::from((first <= sample) & (sample <= last));
        }
    }
    (u64::from_le_bytes(is_inside).wrapping_mul(0x0102_0408_1020_4080) >> 56) as u8
}

#[cold]
fn short_row_mask<T: Ordered>(row: &[T], ranges: &[[T; 2]]) -> u8 {
    let is_inside = |sample: T| ranges.iter().any(|&[a, b]| a <= sample && sample <= b);
    row.iter().rev().fold(0, |mask, &sample| mask << 1 | u8::from(is_inside(sample)))
}

impl BrickMask {
    /// All voxels.
    pub(crate) const ALL: Self = Self { rows: [u8::MAX; N_ROWS] };

    /// The voxels of the records.
    pub(crate) fn of_records(records: &[VoxelRecord]) -> Self {
        let mut rows = [0; N_ROWS];
        for record in records {
            let slot = usize::from(record.slot);
            rows[slot / BRICK_SIDE] |= 1 << (slot % BRICK_SIDE);
        }
        Self { rows }
    }

    /// Whether the voxel in that slot is among them.
    #[inline]
    pub(crate) fn has(&self, slot: u16) -> bool {
        let slot = usize::from(slot);
        self.rows[slot / BRICK_SIDE % N_ROWS] >> (slot % BRICK_SIDE) & 1 == 1
    }

    pub(crate) fn count(&self) -> usize {
        let words = self.rows.as_chunks().0.iter();
        words.map(|&word| u64::from_le_bytes(word).count_ones() as usize).sum()
    }
}

#[cfg(test)]
mod tests;
