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
use crate::pixels::tile::Tile;
use slabsplat_traverse::{PixelRect, TileGrid};

/// The blocks of an image that are not saturated. Made to be used again.
#[derive(Clone, Debug, Default)]
pub(super) struct Occlusion {
    /// How many blocks are open left of a column and above a row; one column and one row more than tiles have
    /// blocks.
    n_open: Vec<u32>,
    n_columns: usize,
    /// The tiles, if they have borders.
    with_borders: Option<TileGrid>,
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
    pub(super) fn start(&mut self, grid: &TileGrid, tiles: &[Tile]) {
        let [n_columns, n_rows] = [grid.n_x, grid.n_y].map(|n| n * BLOCKS_ACROSS + 1);
        self.n_columns = n_columns;
        self.with_borders = (0 < grid.border()).then_some(*grid);
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
                    let open = tile.needed.row(block_row);
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
        let (mut first, mut last) = (pixels.min, pixels.end.map(|end| end - 1));
        // Pixels of borders are on two tiles, or four, and have a block on each.
        if let Some(grid) = &self.with_borders {
            let tiles = grid.tiles_of(pixels);
            let twice = 2 * grid.border() as u32;
            for axis in 0..2 {
                first[axis] += u32::from(tiles.min[axis]) * twice;
                last[axis] += u32::from(tiles.max[axis]) * twice;
            }
        }
        let first = first.map(|pixel| pixel as usize / BLOCK_SIDE);
        let end = last.map(|pixel| pixel as usize / BLOCK_SIDE + 1);
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
    use crate::pixels::tiles::Tiles;
    use slabsplat_core::FrameHandle;

    #[test]
    fn occlusion_is_block_by_block() {
        let [other, Tiles { grid, mut tiles, .. }] =
            [[64; 2], [2100, 70]].map(|size| Tiles::new(size, 0, &FrameHandle::new()).unwrap());
        let mut occlusion = Occlusion::default();
        occlusion.start(&other.grid, &other.tiles);
        occlusion.start(&grid, &tiles);
        let visibility = |occlusion: &Occlusion, min: [u32; 2], end: [u32; 2]| {
            let pixels = PixelRect { min, end };
            occlusion.visibility(&pixels)
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
                    tile.close(block);
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
