//! A sheet over one tile: the sums of model §3.

use super::blocks::{BLOCK_SIDE, Blocks};
use super::quad::{QUAD, Quad};
use super::rectangle::TILE_SIDE;
use std::ops::Range;

/// A row of a tile's pixels.
pub(crate) type Row = [Quad; TILE_SIDE / QUAD];

/// All pixels of a tile.
pub(crate) type Pixels = [Row; TILE_SIDE];

/// Four sums a pixel.
#[derive(Debug)]
pub(crate) struct Sheet {
    pub(crate) sums: Box<Pixels>,
    /// Where any of them may differ from 0.
    pub(crate) touched: Blocks,
}

impl Default for Sheet {
    fn default() -> Self {
        Self { sums: Box::new([[Quad::ZERO; TILE_SIDE / QUAD]; TILE_SIDE]), touched: Blocks::NONE }
    }
}

impl Sheet {
    pub(crate) const BYTES: usize = size_of::<Pixels>();

    /// Empties it.
    #[inline(always)]
    pub(crate) fn clear(&mut self) {
        for [column, row] in std::mem::take(&mut self.touched).iter() {
            for row in &mut self.sums[row * BLOCK_SIDE..(row + 1) * BLOCK_SIDE] {
                row[column] = Quad::ZERO;
            }
        }
    }

    /// Adds what another holds, and empties that.
    pub(crate) fn take_from(&mut self, other: &mut Self) {
        for [column, row] in std::mem::take(&mut other.touched).iter() {
            for row in row * BLOCK_SIDE..(row + 1) * BLOCK_SIDE {
                let taken = std::mem::replace(&mut other.sums[row][column], Quad::ZERO);
                for (sum, more) in self.sums[row][column].0.iter_mut().zip(taken.0) {
                    *sum += more;
                }
            }
            self.touched.add_one([column, row]);
        }
    }

    /// Rows, to be added to; what that touches must be added to `touched`.
    #[inline(always)]
    pub(crate) fn rows_mut(&mut self, rows: Range<usize>) -> &mut [Row] {
        &mut self.sums[rows]
    }
}
