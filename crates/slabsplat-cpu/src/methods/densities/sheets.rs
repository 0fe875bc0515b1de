//! Sheets of densities over one tile, the last six of them.

use crate::pixels::blocks::{BLOCK_SIDE, Blocks};
use crate::pixels::quad::QUAD;
use crate::pixels::rectangle::TILE_SIDE;
use crate::pixels::sheet::Sheet;
use fearless_simd::{Simd, f32x4, f32x8, prelude::*};

/// Pixels that are classified at once.
pub(super) const LANES: usize = 8;

/// A number for each of them.
pub(super) type Eight = [f32; LANES];

/// Sheets that are summed at once, in two channels each: weighted values, and lengths.
pub(super) const AT_ONCE: usize = 2;

/// How many sheets what lies between the two in the middle is taken from.
pub(super) const N_SHEETS: usize = 6;

/// Sheets behind the two in the middle, and before them.
pub(super) const N_BESIDE: usize = N_SHEETS / 2 - 1;

/// A number for each pixel of a tile, with a column of zeros on either side.
type Plane = [[f32; TILE_SIDE + 2]; TILE_SIDE];

/// What a slab's sections sum to on a tile.
#[derive(Debug)]
pub(super) struct DensitySheet {
    /// `V`, scaled; 0 where there is no length.
    weighted: Plane,
    /// `L`.
    length: Plane,
    /// Where there may be any.
    held: Blocks,
}

/// Sheets are retained until those behind them have come, which they do two at a time.
const N_RETAINED: usize = N_SHEETS + AT_ONCE - 1;

/// Sheets on end.
#[derive(Debug)]
pub(super) struct Ring {
    /// That of slab `n` is at `n` modulo their number.
    sheets: [DensitySheet; N_RETAINED],
}

/// What sums are worth.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// Less of a ray is nothing.
    pub(super) least_length: f32,
    /// Between these all values lie, and so does each density.
    pub(super) values: [f32; 2],
}

/// Less of a ray, in `unit`s, may be what separable footprints miss.
const LEAST_LENGTH: f64 = 1e-3;

/// But no less than this part of a sheet, which may be ever so thin to a layer beside one of finer voxels.
const LEAST_PART: f64 = 1.0 / 64.0;

impl Limits {
    /// For values between those ends, in sheets of that thickness, in `unit`s.
    pub(super) fn new(values: [f32; 2], thickness: f64, are_exact: bool) -> Self {
        let least = if are_exact { 0.0 } else { LEAST_LENGTH.min(LEAST_PART * thickness) };
        Self { least_length: least as f32, values }
    }
}

impl Default for Ring {
    fn default() -> Self {
        let plane = [[0.0; TILE_SIDE + 2]; TILE_SIDE];
        let sheet = || DensitySheet { weighted: plane, length: plane, held: Blocks::NONE };
        Self { sheets: std::array::from_fn(|_| sheet()) }
    }
}

impl Ring {
    pub(super) const BYTES: usize = size_of::<Self>();

    /// Makes it empty.
    pub(super) fn clear(&mut self) {
        for sheet in &mut self.sheets {
            for [column, row] in std::mem::take(&mut sheet.held).iter() {
                for row in row * BLOCK_SIDE..(row + 1) * BLOCK_SIDE {
                    let columns = 1 + column * BLOCK_SIDE..1 + (column + 1) * BLOCK_SIDE;
                    sheet.weighted[row][columns.clone()].fill(0.0);
                    sheet.length[row][columns].fill(0.0);
                }
            }
        }
    }

    /// Takes the sums of a slab and the next in the place of the oldest, and empties them.
    #[inline(never)]
    pub(super) fn push<S: Simd>(
        &mut self,
        simd: S,
        slab: usize,
        sums: &mut Sheet,
        limits: &Limits,
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                for channels in 0..AT_ONCE {
                    self.sheets[(slab + channels) % N_RETAINED].fill(simd, sums, channels, limits);
                }
                sums.clear();
            },
        );
    }

    /// Six of them, from front to back, of which the last is that of `slab`.
    #[inline(always)]
    pub(super) fn up_to(&self, slab: usize) -> [&DensitySheet; N_SHEETS] {
        let first = slab + N_RETAINED + 1 - N_SHEETS;
        std::array::from_fn(|idx| &self.sheets[(first + idx) % N_RETAINED])
    }
}

impl DensitySheet {
    pub(super) fn held(&self) -> Blocks {
        self.held
    }

    /// Makes it what the first or the second two channels of sums hold.
    #[inline(always)]
    fn fill<S: Simd>(&mut self, simd: S, sums: &Sheet, channels: usize, limits: &Limits) {
        let mut changed = self.held;
        changed.add(sums.touched);
        self.held = sums.touched;
        let least = f32x4::splat(simd, limits.least_length);
        let [lo, hi] = limits.values.map(|end| f32x4::splat(simd, end));
        let zero = f32x4::splat(simd, 0.0);
        for [column, block_row] in changed.iter() {
            for row in block_row * BLOCK_SIDE..(block_row + 1) * BLOCK_SIDE {
                let (of_quad, _) = sums.sums[row][column].0.as_chunks::<QUAD>();
                let weighted = f32x4::from_slice(simd, &of_quad[2 * channels]);
                let length = f32x4::from_slice(simd, &of_quad[2 * channels + 1]);
                let is_there = length.simd_gt(least);
                let columns = 1 + column * BLOCK_SIDE..1 + (column + 1) * BLOCK_SIDE;
                let weighted = weighted.max(lo * length).min(hi * length);
                let weighted = is_there.select(weighted, zero);
                weighted.store_slice(&mut self.weighted[row][columns.clone()]);
                is_there.select(length, zero).store_slice(&mut self.length[row][columns]);
            }
        }
    }

    /// `L` and `V` of eight pixels of a row, from one `by` columns to the right of `column` on.
    #[inline(always)]
    pub(super) fn eight<S: Simd>(
        &self,
        simd: S,
        row: usize,
        column: usize,
        by: isize,
    ) -> [f32x8<S>; 2] {
        let first = (column + 1).wrapping_add_signed(by);
        let columns = first..first + LANES;
        [
            f32x8::from_slice(simd, &self.length[row][columns.clone()]),
            f32x8::from_slice(simd, &self.weighted[row][columns]),
        ]
    }
}
