//! Which 4×4 pixels of a tile are meant: a bit for each of its 64 blocks.

use super::rectangle::{PixelBox, TILE_SIDE};

/// Pixels along the side of a block.
pub(crate) const BLOCK_SIDE: usize = 4;

/// Blocks along the side of a tile.
pub(crate) const BLOCKS_ACROSS: usize = TILE_SIDE / BLOCK_SIDE;

/// A set of a tile's blocks; bit `8·row + column`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Blocks(u64);

const _: () = assert!(BLOCKS_ACROSS * BLOCKS_ACROSS == u64::BITS as usize, "a bit for each block");

impl Blocks {
    pub(crate) const NONE: Self = Self(0);
    pub(crate) const ALL: Self = Self(u64::MAX);

    /// The blocks that are not in it.
    pub(crate) fn others(self) -> Self {
        Self(!self.0)
    }

    pub(crate) fn has(self, [column, row]: [usize; 2]) -> bool {
        self.0 >> (row * BLOCKS_ACROSS + column) & 1 == 1
    }

    /// These blocks and those that share a side with one of them.
    pub(crate) fn with_neighbors(self) -> Self {
        let not_first_column = 0xfefe_fefe_fefe_fefe;
        let across = self.0 | self.0 << 1 & not_first_column | (self.0 & not_first_column) >> 1;
        Self(across | self.0 << BLOCKS_ACROSS | self.0 >> BLOCKS_ACROSS)
    }

    /// The blocks that are in both sets.
    pub(crate) fn and(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    /// The blocks that a box of pixels meets, which must not be empty.
    #[inline(always)]
    pub(crate) fn meeting(pixels: &PixelBox) -> Self {
        let block = |pixel: u8| u32::from(pixel) / BLOCK_SIDE as u32;
        let [first, last] = [pixels.min, pixels.end.map(|end| end - 1)].map(|p| p.map(block));
        let columns = (2_u64 << last[0]) - (1 << first[0]);
        // A bit for the first block of every row.
        let rows =
            0x0101_0101_0101_0101 & u64::MAX << (8 * first[1]) & u64::MAX >> (56 - 8 * last[1]);
        Self(rows * columns)
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
    pub(crate) fn add_one(&mut self, [column, row]: [usize; 2]) {
        self.0 |= 1 << (row * BLOCKS_ACROSS + column);
    }

    #[inline(always)]
    pub(crate) fn remove(&mut self, [column, row]: [usize; 2]) {
        self.0 &= !(1 << (row * BLOCKS_ACROSS + column));
    }

    /// The columns of one row of blocks, as bits.
    pub(crate) fn row(self, row: usize) -> u64 {
        self.0 >> (row * BLOCKS_ACROSS) & 0xff
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
        let side = TILE_SIDE as u8;
        for (first, end) in
            (0..side).flat_map(|first| (first + 1..=side).map(move |end| (first, end)))
        {
            for pixels in [
                PixelBox { min: [first, 3], end: [end, 9] },
                PixelBox { min: [31, first], end: [32, end] },
            ] {
                let met: Vec<[usize; 2]> = Blocks::meeting(&pixels).iter().collect();
                let [columns, rows] = [0, 1].map(|axis| {
                    usize::from(pixels.min[axis]) / BLOCK_SIDE
                        ..=usize::from(pixels.end[axis] - 1) / BLOCK_SIDE
                });
                let in_row = |row| columns.clone().map(move |column| [column, row]);
                assert_eq!(met, rows.flat_map(in_row).collect::<Vec<_>>(), "{pixels:?}");
            }
        }
    }

    #[test]
    fn neighbors_of_blocks_share_a_side() {
        for [column, row] in [[0, 0], [7, 0], [0, 7], [7, 7], [3, 4]] {
            let mut block = Blocks::NONE;
            block.add_one([column, row]);
            let with_neighbors: Vec<[usize; 2]> = block.with_neighbors().iter().collect();
            let is_near =
                |other: &[usize; 2]| other[0].abs_diff(column) + other[1].abs_diff(row) < 2;
            let all = (0..8).flat_map(|row| (0..8).map(move |column| [column, row]));
            assert_eq!(with_neighbors, all.filter(is_near).collect::<Vec<_>>());
            assert_eq!(block.with_neighbors().and(block), block);
        }
    }

    #[test]
    fn blocks_are_removed() {
        let end = [TILE_SIDE as u8; 2];
        let mut blocks = Blocks::meeting(&PixelBox { min: [0; 2], end });
        for row in 0..BLOCKS_ACROSS {
            for column in 0..BLOCKS_ACROSS {
                assert!(!blocks.is_empty());
                blocks.remove([column, row]);
            }
        }
        assert_eq!(blocks, Blocks::NONE);
    }
}
