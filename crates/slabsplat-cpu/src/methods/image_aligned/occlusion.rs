//! Which parts of the image are saturated: the occlusion map (Mueller, Shareef, Huang & Crawfis,
//! "High-Quality Splatting on Rectilinear Grids with Efficient Culling of Occluded Voxels", IEEE TVCG 5(2),
//! 1999), by blocks of 4×4 pixels.
//!
//! A block is saturated once all its pixels are as opaque as the plan's cut-off: what lies behind it is not
//! drawn. The map changes between ranges of depth only, so that all threads see the same one.
//!
//! It is stored as a table of sums (Crow, "Summed-Area Tables for Texture Mapping", SIGGRAPH '84): how many
//! blocks of a rectangle are open takes four of them, whatever its size.

use crate::pixels::blocks::{BLOCK_SIDE, BLOCKS_ACROSS};
use crate::pixels::rectangle::TILE_SIDE;
use crate::pixels::tile::Tile;
use slabsplat_traverse::PixelRect;

/// The blocks of an image that are not saturated. Made to be used again.
#[derive(Clone, Debug, Default)]
pub(super) struct Occlusion {
    /// How many blocks are open left of a column and above a row; one column and one row more than tiles have
    /// blocks.
    n_open: Vec<u32>,
    n_columns: usize,
}

/// What is to be seen of a part of the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Visibility {
    /// Nothing: all is saturated, or outside of the image.
    None,
    /// Some blocks are saturated or outside of the image, others are not.
    Partial,
    /// All blocks are open.
    Full,
}

impl Occlusion {
    /// Makes it that of an image, of whose `tiles`, row by row, none is as yet splatted on.
    pub(super) fn start(&mut self, image_size: [u32; 2], tiles: &[Tile]) {
        let n_across = |side: u32| (side as usize).div_ceil(TILE_SIDE) * BLOCKS_ACROSS;
        let [n_columns, n_rows] = image_size.map(|side| n_across(side) + 1);
        self.n_columns = n_columns;
        self.n_open.clear();
        self.n_open.resize(n_columns * n_rows, 0);
        self.note(tiles);
    }

    /// Notes which blocks are open, of all tiles.
    pub(super) fn note(&mut self, tiles: &[Tile]) {
        let n_columns = self.n_columns;
        let rows_of_tiles = tiles.chunks((n_columns - 1) / BLOCKS_ACROSS);
        for (tile_row, tiles) in rows_of_tiles.enumerate() {
            for block_row in 0..BLOCKS_ACROSS {
                let row = tile_row * BLOCKS_ACROSS + block_row;
                let (above, here) = self.n_open[row * n_columns..].split_at_mut(n_columns);
                let columns = here[1..n_columns].iter_mut().zip(&above[1..]);
                let are_open = tiles.iter().flat_map(|tile| {
                    let open = tile.open.row(block_row);
                    (0..BLOCKS_ACROSS).map(move |column| open >> column & 1)
                });
                let mut in_row = 0;
                for ((n_open, above), is_open) in columns.zip(are_open) {
                    in_row += is_open as u32;
                    *n_open = in_row + above;
                }
            }
        }
    }

    pub(super) fn resident_bytes(&self) -> usize {
        self.n_open.capacity() * size_of::<u32>()
    }

    /// How much is to be seen of a rectangle of pixels.
    #[inline(always)]
    pub(super) fn visibility(&self, pixels: &PixelRect) -> Visibility {
        let first = pixels.min.map(|pixel| pixel as usize / BLOCK_SIDE);
        let end = pixels.end.map(|pixel| (pixel as usize).div_ceil(BLOCK_SIDE));
        let above = &self.n_open[first[1] * self.n_columns..];
        let within = &self.n_open[end[1] * self.n_columns..];
        let n_open = within[end[0]] - within[first[0]] - (above[end[0]] - above[first[0]]);
        let n_all = (end[0] - first[0]) * (end[1] - first[1]);
        match n_open as usize {
            0 => Visibility::None,
            n_open if n_open == n_all => Visibility::Full,
            _ => Visibility::Partial,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn occlusion_is_block_by_block() {
        let size = [2100, 70];
        let origins = (0..70)
            .step_by(TILE_SIDE)
            .flat_map(|y| (0..2100).step_by(TILE_SIDE).map(move |x| [x, y]));
        let mut tiles: Vec<Tile> = origins.map(|origin| Tile::new(origin, size)).collect();
        let mut occlusion = Occlusion::default();
        occlusion
            .start([64; 2], &[[0, 0], [32, 0], [0, 32], [32, 32]].map(|o| Tile::new(o, [64; 2])));
        occlusion.start(size, &tiles);
        let visibility = |occlusion: &Occlusion, min: [u32; 2], end: [u32; 2]| {
            occlusion.visibility(&PixelRect { min, end })
        };
        assert_eq!(visibility(&occlusion, [0; 2], [2100, 70]), Visibility::Full);
        assert_eq!(
            visibility(&occlusion, [0; 2], [2112, 96]),
            Visibility::Partial,
            "beyond the image"
        );
        assert_eq!(visibility(&occlusion, [2100, 0], [2112, 96]), Visibility::None, "outside");
        for tile in &mut tiles {
            let [column, row] = tile.origin.map(|pixel| pixel / BLOCK_SIDE);
            for block in tile.open.iter().collect::<Vec<_>>() {
                if [column + block[0], row + block[1]] != [141, 6] {
                    tile.open.remove(block);
                }
            }
        }
        occlusion.note(&tiles);
        let [left, top] = [141, 6].map(|block| block * BLOCK_SIDE as u32);
        let [right, bottom] = [left, top].map(|start| start + BLOCK_SIDE as u32);
        assert_eq!(visibility(&occlusion, [0; 2], [2100, 70]), Visibility::Partial);
        assert_eq!(visibility(&occlusion, [left, top], [right, bottom]), Visibility::Full);
        assert_eq!(
            visibility(&occlusion, [left + 1, top + 3], [left + 2, top + 4]),
            Visibility::Full
        );
        assert_eq!(
            visibility(&occlusion, [left - 1, top + 3], [left + 2, top + 4]),
            Visibility::Partial
        );
        assert_eq!(visibility(&occlusion, [0; 2], [left, 70]), Visibility::None);
        assert_eq!(visibility(&occlusion, [right, 0], [2112, 70]), Visibility::None);
        assert_eq!(visibility(&occlusion, [0, bottom], [2112, 96]), Visibility::None);
        assert_eq!(visibility(&occlusion, [0; 2], [2112, top]), Visibility::None);
    }
}
