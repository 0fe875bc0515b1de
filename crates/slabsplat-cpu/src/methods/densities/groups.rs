//! The pixels of a tile by eights of a row, as sheets of densities are looked at.

use super::sheets::{Eight, LANES};
use crate::pixels::blocks::{BLOCK_SIDE, BLOCKS_ACROSS, Blocks};
use crate::pixels::quad::QUAD;
use crate::pixels::rectangle::TILE_SIDE;
use crate::pixels::sheet::Sheet;
use crate::pixels::tile::Tile;

/// Blocks that eight pixels on end lie in.
pub(super) const BLOCKS_PER_GROUP: usize = LANES / BLOCK_SIDE;

/// Eight pixels of a row.
#[derive(Clone, Copy, Debug)]
pub(super) struct Group {
    pub(super) row: usize,
    /// The first of them.
    pub(super) column: usize,
    /// Which of the blocks that they lie in are meant, a bit each.
    blocks: u64,
}

/// Those of which some lie in these blocks.
#[inline(always)]
pub(super) fn groups_in(blocks: Blocks) -> impl Iterator<Item = Group> {
    let n_groups = BLOCKS_ACROSS * TILE_SIDE / LANES;
    (0..n_groups).flat_map(move |idx| {
        let (block_row, group) = (idx / (TILE_SIDE / LANES), idx % (TILE_SIDE / LANES));
        let of_group = blocks.row(block_row) >> (group * BLOCKS_PER_GROUP) & 0b11;
        let n_rows = if of_group == 0 { 0 } else { BLOCK_SIDE };
        (0..n_rows).map(move |row| Group {
            row: block_row * BLOCK_SIDE + row,
            column: group * LANES,
            blocks: of_group,
        })
    })
}

impl Group {
    /// Where it is on its tile: its row, and its first column.
    #[inline(always)]
    pub(super) fn position(&self) -> [usize; 2] {
        [self.row, self.column]
    }

    /// The first of its pixels, counted from the corner of the image's border.
    #[inline(always)]
    pub(super) fn first_pixel(&self, tile: &Tile) -> [usize; 2] {
        [tile.origin[0] + self.column, tile.origin[1] + self.row]
    }

    /// Which of its pixels are meant and not opaque, a bit each.
    #[inline(always)]
    pub(super) fn open(&self, tile: &Tile) -> u64 {
        let mut open = 0;
        for block in 0..BLOCKS_PER_GROUP {
            let opacities = tile.pixels[self.row][self.column / QUAD + block].opacities();
            let is_meant = self.blocks >> block & 1;
            for (lane, opacity) in opacities.into_iter().enumerate() {
                open |= (u64::from(opacity < 1.0) & is_meant) << (block * QUAD + lane);
            }
        }
        open
    }

    /// Writes what is `seen` of its pixels, a bit each, onto an empty sheet.
    #[inline(always)]
    pub(super) fn write(&self, sums: &[Eight; 4], seen: u64, sheet: &mut Sheet) {
        let quads = &mut sheet.sums[self.row][self.column / QUAD..][..BLOCKS_PER_GROUP];
        for (half, quad) in quads.iter_mut().enumerate() {
            // What is not touched must stay empty.
            if seen >> (half * QUAD) & 0b1111 == 0 {
                continue;
            }
            sheet.touched.add_one([self.column / QUAD + half, self.row / BLOCK_SIDE]);
            let (channels, _) = quad.0.as_chunks_mut::<QUAD>();
            for (channel, sums) in channels.iter_mut().zip(sums) {
                channel.copy_from_slice(&sums[half * QUAD..][..QUAD]);
            }
        }
    }
}
