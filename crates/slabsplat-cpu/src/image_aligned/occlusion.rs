//! Which parts of the image are full: the occlusion map (Mueller, Shareef, Huang & Crawfis, "High-Quality Splatting on
//! Rectilinear Grids with Efficient Culling of Occluded Voxels", IEEE TVCG 5(2), 1999), a bit for every block of
//! 8×8 pixels.
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
            self.full[(row + block_row) * self.words_per_row + column / 64] |= full << (column % 64);
        }
    }

    /// Whether there is nothing to be seen between two corners, in pixels: because all is full, or
    /// because it is outside of the image.
    #[inline]
    pub(crate) fn hides(&self, min: [f32; 2], max: [f32; 2]) -> bool {
        let first = min.map(|pixel| (pixel.max(0.0) as usize) / BLOCK_SIDE);
        let outside = max[0] < 0.0 || max[1] < 0.0;
        if outside || self.n_blocks[0] <= first[0] || self.n_blocks[1] <= first[1] {
            return true;
        }
        let last = |axis: usize| ((max[axis] as usize) / BLOCK_SIDE).min(self.n_blocks[axis] - 1);
        (first[1]..=last(1)).all(|row| self.is_full(row, first[0], last(0)))
    }

    #[inline]
    fn is_full(&self, row: usize, first: usize, last: usize) -> bool {
        let words = &self.full[row * self.words_per_row..];
        (first / 64..=last / 64).all(|word| {
            let from = u64::MAX << if word == first / 64 { first % 64 } else { 0 };
            let to = u64::MAX >> if word == last / 64 { 63 - last % 64 } else { 0 };
            let asked = from & to;
            words[word] & asked == asked
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn occlusion_is_block_by_block() {
        let size = [2100, 70];
        let mut occlusion = Occlusion::new(size);
        let everything = ([-5.0, -5.0], [3000.0, 3000.0]);
        assert!(!occlusion.hides(everything.0, everything.1));
        for y in (0..70).step_by(TILE_SIDE) {
            for x in (0..2100).step_by(TILE_SIDE) {
                let mut tile = Tile::new([x, y], size);
                for block in tile.open.iter().collect::<Vec<_>>() {
                    if [x / 8 + block[0], y / 8 + block[1]] != [70, 3] {
                        tile.open.remove(block);
                    }
                }
                occlusion.note(&tile);
            }
        }
        assert!(!occlusion.hides(everything.0, everything.1));
        assert!(!occlusion.hides([560.1, 24.1], [560.2, 24.2]));
        assert!(occlusion.hides([0.0, 0.0], [559.9, 69.0]), "left of the open block");
        assert!(occlusion.hides([568.0, 0.0], [9999.0, 69.0]), "right of it");
        assert!(occlusion.hides([0.0, 32.0], [9999.0, 9999.0]), "below it");
        assert!(occlusion.hides([-9.0, -9.0], [-1.0, 50.0]), "outside of the image");
        assert!(occlusion.hides([2105.0, 0.0], [2106.0, 50.0]), "outside of the image");
    }
}
