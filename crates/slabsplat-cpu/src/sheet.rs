//! A sheet over one tile: the sums of SPEC §3.

use crate::blocks::Blocks;
use crate::quad::{QUAD, Quad};
use crate::tile::TILE_SIDE;
use std::ops::Range;

/// A row of a tile's pixels.
pub(crate) type Row = [Quad; TILE_SIDE / QUAD];

/// All pixels of a tile.
pub(crate) type Pixels = [Row; TILE_SIDE];

/// Four sums a pixel.
#[derive(Debug)]
pub(crate) struct Sheet {
    pub(crate) sums: Box<Pixels>,
    /// Where any of them may differ from 0, once knots are gathered.
    pub(crate) touched: Blocks,
    /// Sums of products that are yet to be gathered (`knots.rs`); 0 between slabs.
    pub(crate) knots: Vec<Row>,
}

impl Default for Sheet {
    fn default() -> Self {
        Self {
            sums: Box::new([[Quad::ZERO; TILE_SIDE / QUAD]; TILE_SIDE]),
            touched: Blocks::NONE,
            knots: Vec::new(),
        }
    }
}

impl Sheet {
    pub(crate) fn resident_bytes(&self) -> usize {
        size_of::<Pixels>() + self.knots.capacity() * size_of::<Row>()
    }

    /// Rows, to be added to; what that touches must be told to `touched`.
    #[inline(always)]
    pub(crate) fn rows_mut(&mut self, rows: Range<usize>) -> &mut [Row] {
        &mut self.sums[rows]
    }
}
