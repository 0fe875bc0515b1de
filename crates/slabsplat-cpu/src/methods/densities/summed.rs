//! Which pixels of a tile's sheet are summed: those that may still change, and their neighbours.

use crate::pixels::blocks::{BLOCK_SIDE, BLOCKS_ACROSS, Blocks};
use crate::pixels::rectangle::TILE_SIDE;
use std::ops::Range;

/// Pixels along the side of a sheet: the tile's, and a border of one, for gradients.
pub(super) const SHEET_SIDE: usize = TILE_SIDE + 2;

/// A run of pixels on every row of a sheet, which is the tile with a border of one pixel: row `y` of the tile
/// is row `y + 1` here.
#[derive(Clone, Debug)]
pub(super) struct Summed {
    of: Blocks,
    runs: [Range<usize>; SHEET_SIDE],
    /// Rows outside of which nothing is summed.
    rows: Range<usize>,
}

impl Default for Summed {
    fn default() -> Self {
        Self { of: Blocks::NONE, runs: std::array::from_fn(|_| 0..0), rows: 0..0 }
    }
}

impl Summed {
    /// Makes it what the open blocks of a tile need.
    pub(super) fn follow(&mut self, open: Blocks) {
        if self.of == open {
            return;
        }
        self.of = open;
        self.runs.fill(0..0);
        for block_row in 0..BLOCKS_ACROSS {
            let columns = open.row(block_row);
            if columns == 0 {
                continue;
            }
            let first = columns.trailing_zeros() as usize * BLOCK_SIDE;
            let end = (u64::BITS - columns.leading_zeros()) as usize * BLOCK_SIDE;
            // One more on either side, and the run itself above and below; a column of the tile is one
            // further right in the sheet.
            let rows = block_row * BLOCK_SIDE + 1..(block_row + 1) * BLOCK_SIDE + 1;
            join(&mut self.runs[rows.start - 1], first + 1..end + 1);
            join(&mut self.runs[rows.end], first + 1..end + 1);
            for row in rows {
                join(&mut self.runs[row], first..end + 2);
            }
        }
        let is_summed = |run: &Range<usize>| !run.is_empty();
        let first = self.runs.iter().position(is_summed);
        let last = self.runs.iter().rposition(is_summed);
        self.rows = first.zip(last).map_or(0..0, |(first, last)| first..last + 1);
    }

    /// Rows of the sheet that are summed.
    #[inline]
    pub(super) fn rows(&self) -> Range<usize> {
        self.rows.clone()
    }

    /// The run of a row of the sheet that is summed.
    #[inline]
    pub(super) fn run(&self, row: usize) -> Range<usize> {
        self.runs[row].clone()
    }
}

fn join(run: &mut Range<usize>, other: Range<usize>) {
    *run = if run.end <= run.start {
        other
    } else {
        run.start.min(other.start)..run.end.max(other.end)
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn summed_pixels_are_open_or_beside_open_ones() {
        let mut summed = Summed::default();
        let mut open = Blocks::first([3, 2]);
        summed.follow(open);
        assert_eq!((summed.rows(), summed.run(0), summed.run(1)), (0..10, 1..13, 0..14));
        open.remove([0, 1]);
        open.remove([2, 1]);
        summed.follow(open);
        assert_eq!((summed.run(4), summed.run(5), summed.run(9)), (0..14, 1..13, 5..9));
        assert_eq!((summed.run(6), summed.run(10)), (4..10, 0..0));
        summed.follow(Blocks::NONE);
        assert!(summed.rows().is_empty());
    }
}
