//! Which parts of the image are full: the occlusion map (Mueller, Shareef, Huang & Crawfis, "High-Quality Splatting on
//! Rectilinear Grids with Efficient Culling of Occluded Voxels", IEEE TVCG 5(2), 1999), a bit for every block of
//! 4×4 pixels.
//!
//! A block is full once all its pixels are as opaque as the plan's cut-off: what lies behind it is not
//! drawn. The map changes between ranges of depth only, so that all threads see the same one.

use crate::blocks::{BLOCK_SIDE, BLOCKS_ACROSS};
use crate::tile::{TILE_SIDE, Tile};

/// The full blocks of an image.
#[derive(Clone, Debug)]
pub(crate) struct Occlusion {
    n_blocks: [usize; 2],
    words_per_row: usize,
    full: Vec<u64>,
}

/// What is to be seen of a part of the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Seen {
    /// Nothing: all is full, or outside of the image.
    Not,
    /// Some blocks are full, others are not.
    Partly,
    /// No block is full.
    All,
}

impl Occlusion {
    /// The map of an empty image.
    pub(crate) fn new(image_size: [u32; 2]) -> Self {
        let n_blocks = image_size.map(|side| (side as usize).div_ceil(BLOCK_SIDE));
        // Tiles note all their blocks, also those beyond the image's edge.
        let n_padded = n_blocks.map(|n| n.next_multiple_of(BLOCKS_ACROSS));
        let words_per_row = n_padded[0].div_ceil(64);
        Self { n_blocks, words_per_row, full: vec![0; words_per_row * n_padded[1]] }
    }

    /// Notes which blocks of a tile are full.
    pub(crate) fn note(&mut self, tile: &Tile) {
        let [column, row] = tile.origin.map(|pixel| pixel / TILE_SIDE * BLOCKS_ACROSS);
        for block_row in 0..BLOCKS_ACROSS {
            let full = !tile.open.row(block_row) & ((1 << BLOCKS_ACROSS) - 1);
            // 64 is a multiple of a tile's blocks, so a tile's row lies in one word.
            self.full[(row + block_row) * self.words_per_row + column / 64] |=
                full << (column % 64);
        }
    }

    /// How much is to be seen between two corners, in pixels.
    #[inline]
    pub(crate) fn shows(&self, min: [f32; 2], max: [f32; 2]) -> Seen {
        let first = min.map(|pixel| (pixel.max(0.0) as usize) / BLOCK_SIDE);
        let outside = max[0] < 0.0 || max[1] < 0.0;
        if outside || self.n_blocks[0] <= first[0] || self.n_blocks[1] <= first[1] {
            return Seen::Not;
        }
        let last = |axis: usize| ((max[axis] as usize) / BLOCK_SIDE).min(self.n_blocks[axis] - 1);
        let (mut some_full, mut some_open) = (false, false);
        for row in first[1]..=last(1) {
            let [full, open] = self.of_row(row, first[0], last(0));
            some_full |= full;
            some_open |= open;
        }
        match (some_full, some_open) {
            (_, false) => Seen::Not,
            (true, true) => Seen::Partly,
            (false, true) => Seen::All,
        }
    }

    /// Whether any of a row's blocks are full, and whether any are not.
    #[inline]
    fn of_row(&self, row: usize, first: usize, last: usize) -> [bool; 2] {
        let words = &self.full[row * self.words_per_row..];
        let (mut some_full, mut some_open) = (false, false);
        let [first_word, last_word] = [first / 64, last / 64];
        for (word, bits) in words.iter().enumerate().take(last_word + 1).skip(first_word) {
            let from = u64::MAX << if word == first_word { first % 64 } else { 0 };
            let to = u64::MAX >> if word == last_word { 63 - last % 64 } else { 0 };
            let full = bits & from & to;
            some_full |= full != 0;
            some_open |= full != from & to;
        }
        [some_full, some_open]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn occlusion_is_block_by_block() {
        let size = [2100, 70];
        let mut occlusion = Occlusion::new(size);
        let everything = |occlusion: &Occlusion| occlusion.shows([-5.0; 2], [3000.0; 2]);
        assert_eq!(everything(&occlusion), Seen::All);
        for y in (0..70).step_by(TILE_SIDE) {
            for x in (0..2100).step_by(TILE_SIDE) {
                let mut tile = Tile::new([x, y], size);
                for block in tile.open.iter().collect::<Vec<_>>() {
                    if [x / BLOCK_SIDE + block[0], y / BLOCK_SIDE + block[1]] != [141, 6] {
                        tile.open.remove(block);
                    }
                }
                occlusion.note(&tile);
            }
        }
        let [left, top] = [141, 6].map(|block| (block * BLOCK_SIDE) as f32);
        let [right, bottom] = [left, top].map(|start| start + BLOCK_SIDE as f32);
        assert_eq!(everything(&occlusion), Seen::Partly);
        assert_eq!(occlusion.shows([left + 0.1, top + 0.1], [left + 0.2, top + 0.2]), Seen::All);
        assert_eq!(occlusion.shows([0.0; 2], [left - 0.1, 69.0]), Seen::Not);
        assert_eq!(occlusion.shows([right, 0.0], [9999.0, 69.0]), Seen::Not);
        assert_eq!(occlusion.shows([0.0, bottom], [9999.0, 9999.0]), Seen::Not);
        assert_eq!(occlusion.shows([-9.0, -9.0], [-1.0, 50.0]), Seen::Not, "outside");
        assert_eq!(occlusion.shows([2105.0, 0.0], [2106.0, 50.0]), Seen::Not, "outside");
    }
}
