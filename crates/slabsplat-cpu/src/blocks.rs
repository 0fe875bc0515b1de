//! Which 8×8 pixels of a tile are meant: a bit for each of its sixteen blocks.

use crate::splat::PixelBox;
use crate::tile::TILE_SIDE;

/// Pixels along the side of a block.
pub(crate) const BLOCK_SIDE: usize = 8;

/// Blocks along the side of a tile.
pub(crate) const BLOCKS_ACROSS: usize = TILE_SIDE / BLOCK_SIDE;

/// A set of a tile's blocks; bit `4·row + column`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Blocks(u16);

const _: () = assert!(BLOCKS_ACROSS * BLOCKS_ACROSS == u16::BITS as usize, "a bit for each block");

impl Blocks {
    pub(crate) const NONE: Self = Self(0);

    /// The first columns and rows of blocks.
    pub(crate) fn first([n_columns, n_rows]: [usize; 2]) -> Self {
        let end = [n_columns, n_rows].map(|n| (n * BLOCK_SIDE) as u8);
        Self::meeting(&PixelBox { min: [0; 2], end })
    }

    /// The blocks that a box of pixels meets, which must not be empty.
    #[inline(always)]
    pub(crate) fn meeting(pixels: &PixelBox) -> Self {
        let block = |pixel: u8| u32::from(pixel) / BLOCK_SIDE as u32;
        let [first, last] = [pixels.min, pixels.end.map(|end| end - 1)].map(|p| p.map(block));
        let columns = (2 << last[0]) - (1 << first[0]);
        // A bit for the first block of every row.
        let rows = ((16_u32 << (4 * last[1])) - (1 << (4 * first[1]))) & 0x1111;
        Self((rows * columns) as u16)
    }

    #[inline(always)]
    pub(crate) fn is_empty(self) -> bool {
        self.0 == 0
    }

    #[inline(always)]
    pub(crate) fn meets(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }

    #[inline(always)]
    pub(crate) fn add(&mut self, other: Self) {
        self.0 |= other.0;
    }

    #[inline(always)]
    pub(crate) fn remove(&mut self, [column, row]: [usize; 2]) {
        self.0 &= !(1 << (row * BLOCKS_ACROSS + column));
    }

    /// The columns of one row of blocks, as bits.
    pub(crate) fn row(self, row: usize) -> u64 {
        u64::from(self.0 >> (row * BLOCKS_ACROSS) & 0xf)
    }

    /// Column and row of every block.
    pub(crate) fn iter(self) -> impl Iterator<Item = [usize; 2]> {
        let mut left = self.0;
        std::iter::from_fn(move || {
            let bit = left.trailing_zeros() as usize;
            left &= left.checked_sub(1)?;
            Some([bit % BLOCKS_ACROSS, bit / BLOCKS_ACROSS])
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_meeting_a_box() {
        for first in 0..TILE_SIDE as u8 {
            for end in first + 1..=TILE_SIDE as u8 {
                let pixels = PixelBox { min: [first, 3], end: [end, 9] };
                let blocks = Blocks::meeting(&pixels);
                let met: Vec<[usize; 2]> = blocks.iter().collect();
                let columns = usize::from(first) / 8..=usize::from(end - 1) / 8;
                let expected: Vec<[usize; 2]> = (0..2)
                    .flat_map(|row| columns.clone().map(move |column| [column, row]))
                    .collect();
                assert_eq!(met, expected);
                assert_eq!(blocks.row(0), blocks.row(1));
            }
        }
    }

    #[test]
    fn blocks_are_removed() {
        let mut blocks = Blocks::first([4, 4]);
        for row in 0..4 {
            for column in 0..4 {
                assert!(!blocks.is_empty());
                blocks.remove([column, row]);
            }
        }
        assert_eq!(blocks, Blocks::NONE);
    }
}
