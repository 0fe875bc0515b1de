//! A square of the image, rendered by one thread at a time.

use super::blocks::{BLOCK_SIDE, Blocks};
use super::compositing::put_behind;
use super::quad::{QUAD, Quad};
use super::rectangle::{PixelBox, TILE_SIDE};
use super::sheet::{Pixels, Sheet};
use super::surfaces::Surfaces;
use fearless_simd::Simd;
use slabsplat_core::{Compositing, Image, over};
use std::ops::Range;

const _: () = assert!(BLOCK_SIDE == QUAD, "a block is a quad wide");

/// The composited pixels of a tile.
#[derive(Clone, Debug)]
pub(crate) struct Tile {
    /// The image pixel in the upper left corner, counted from the corner of the image's border.
    pub(crate) origin: [usize; 2],
    /// Columns and rows on each side that are other tiles'.
    border: usize,
    /// Columns and rows that are inside the image and this tile's own.
    inside: [Range<usize>; 2],
    /// The blocks that hold pixels which may still change.
    pub(crate) open: Blocks,
    /// The blocks whose sums are needed: those that are open, and of a tile with a border those beside them.
    pub(crate) needed: Blocks,
    /// Premultiplied colour and opacity. Pixels outside of the image are opaque from the start, and so are
    /// those of other tiles.
    pub(crate) pixels: Box<Pixels>,
    /// Where rays end.
    pub(crate) surfaces: Surfaces,
    pub(crate) stats: TileStats,
}

/// What a tile took.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct TileStats {
    pub(crate) n_splats: u64,
    /// Splats that could touch no open pixel.
    pub(crate) n_culled: u64,
}

impl Tile {
    /// An empty tile of an image, with `border` pixels on each side that are other tiles'.
    pub(crate) fn new(origin: [usize; 2], image_size: [u32; 2], border: usize) -> Self {
        let inside = |axis: usize| {
            let n_left = image_size[axis] as usize - origin[axis];
            border..border + n_left.min(TILE_SIDE - 2 * border)
        };
        let mut tile = Self {
            origin,
            border,
            inside: [inside(0), inside(1)],
            open: Blocks::NONE,
            needed: Blocks::NONE,
            pixels: Sheet::default().sums,
            surfaces: Surfaces::default(),
            stats: TileStats::default(),
        };
        tile.clear();
        tile
    }

    /// Makes it empty again, of which nothing is counted.
    pub(crate) fn clear(&mut self) {
        self.reopen();
        self.stats = TileStats::default();
    }

    /// Makes its pixels empty again.
    pub(crate) fn reopen(&mut self) {
        let [columns, rows] = &self.inside;
        for (row_idx, row) in self.pixels.iter_mut().enumerate() {
            for (quad_idx, quad) in row.iter_mut().enumerate() {
                *quad = Quad::ZERO;
                for pixel in 0..QUAD {
                    let is_inside =
                        rows.contains(&row_idx) && columns.contains(&(quad_idx * QUAD + pixel));
                    if !is_inside {
                        quad.set_pixel(pixel, [0.0, 0.0, 0.0, 1.0]);
                    }
                }
            }
        }
        let min = [columns.start, rows.start].map(|first| first as u8);
        let end = [columns.end, rows.end].map(|end| end as u8);
        self.open = Blocks::meeting(&PixelBox { min, end });
        self.needed = self.needed_for(self.open);
    }

    /// Puts what is in front of all into an empty tile, and closes what is saturated by that.
    pub(crate) fn begin_with(&mut self, in_front: &Image, cutoff: f32) {
        let [left, top] = self.origin;
        let [columns, rows] = self.inside.clone();
        let width = in_front.width() as usize;
        for (row, image_row) in rows.zip(top..) {
            for (column, image_column) in columns.clone().zip(left..) {
                let pixel = in_front.pixels()[image_row * width + image_column];
                self.pixels[row][column / QUAD].set_pixel(column % QUAD, pixel);
            }
        }
        self.close_saturated_blocks(cutoff);
    }

    /// The blocks whose sums are needed while those are open.
    fn needed_for(&self, open: Blocks) -> Blocks {
        if self.border == 0 { open } else { open.with_neighbors() }
    }

    /// Whether no pixel may change any more.
    pub(crate) fn is_saturated(&self) -> bool {
        self.open.is_empty()
    }

    /// The blocks that a splat on a box of pixels meets, if any of them is needed; counts it either way.
    #[inline(always)]
    pub(crate) fn accept(&mut self, pixels: &PixelBox) -> Option<Blocks> {
        let blocks = Blocks::meeting(pixels);
        let is_needed = self.needed.meets(blocks);
        let count = if is_needed { &mut self.stats.n_splats } else { &mut self.stats.n_culled };
        *count += 1;
        is_needed.then_some(blocks)
    }

    /// Puts a sheet behind what is already there, empties it, and closes the blocks whose pixels are all at
    /// least as opaque as `cutoff`.
    #[inline(always)]
    pub(crate) fn put_behind<S: Simd>(
        &mut self,
        simd: S,
        compositing: Compositing,
        sheet: &mut Sheet,
        cutoff: f32,
    ) {
        for [column, row] in std::mem::take(&mut sheet.touched).iter() {
            let rows = row * BLOCK_SIDE..(row + 1) * BLOCK_SIDE;
            let least = self.put_column_behind(simd, compositing, sheet, rows, column);
            if cutoff <= least {
                self.close([column, row]);
            }
        }
    }

    /// Puts what a sheet holds in a box behind what is already there, and empties it. Closes nothing.
    #[inline(always)]
    pub(crate) fn put_box_behind<S: Simd>(
        &mut self,
        simd: S,
        compositing: Compositing,
        sheet: &mut Sheet,
        pixels: &PixelBox,
    ) {
        sheet.touched = Blocks::NONE;
        let [columns, rows] =
            [0, 1].map(|axis| usize::from(pixels.min[axis])..usize::from(pixels.end[axis]));
        let rows = rows.start & !1..rows.end.next_multiple_of(2);
        for quad in columns.start / QUAD..usize::div_ceil(columns.end, QUAD) {
            self.put_column_behind(simd, compositing, sheet, rows.clone(), quad);
        }
    }

    /// Closes the blocks whose pixels are all at least as opaque as `cutoff`.
    pub(crate) fn close_saturated_blocks(&mut self, cutoff: f32) {
        self.open.iter().for_each(|block| self.close_if_saturated(block, cutoff));
    }

    /// Closes a block if all its pixels are at least as opaque as `cutoff`.
    pub(super) fn close_if_saturated(&mut self, [column, row]: [usize; 2], cutoff: f32) {
        let mut rows = self.pixels[row * BLOCK_SIDE..(row + 1) * BLOCK_SIDE].iter();
        if rows.all(|row| row[column].opacities().iter().all(|opacity| cutoff <= *opacity)) {
            self.close([column, row]);
        }
    }

    /// Closes blocks of which nothing more is to be seen.
    pub(crate) fn close_all(&mut self, blocks: Blocks) {
        self.open.and(blocks).iter().for_each(|block| self.close(block));
    }

    pub(crate) fn close(&mut self, block: [usize; 2]) {
        self.open.remove(block);
        self.needed = self.needed_for(self.open);
    }

    /// An even number of rows of one quad; returns the least opacity that any of their pixels has then.
    #[inline(always)]
    fn put_column_behind<S: Simd>(
        &mut self,
        simd: S,
        compositing: Compositing,
        sheet: &mut Sheet,
        rows: Range<usize>,
        quad: usize,
    ) -> f32 {
        let mut least = f32::INFINITY;
        let pixels = self.pixels[rows.clone()].as_chunks_mut::<2>().0;
        for ([p, q], [s, t]) in pixels.iter_mut().zip(sheet.sums[rows].as_chunks_mut::<2>().0) {
            let pixels = [&mut p[quad], &mut q[quad]];
            let opacity = put_behind(simd, compositing, pixels, [&mut s[quad], &mut t[quad]]);
            least = if opacity < least { opacity } else { least };
        }
        least
    }

    /// Copies the part of the tile that is inside the image, before what is `behind`, to the image's rows
    /// from the tile's first on.
    pub(crate) fn copy_to(&self, rows: &mut [[f32; 4]], width: usize, behind: [f32; 4]) {
        let left = self.origin[0];
        let [columns, all_rows] = &self.inside;
        let own = &self.pixels[all_rows.clone()];
        for (row, quads) in rows.chunks_mut(width).zip(own) {
            let pixels = &mut row[left..left + columns.len()];
            for (column, pixel) in columns.clone().zip(pixels) {
                *pixel = over(quads[column / QUAD].pixel(column % QUAD), behind);
            }
        }
    }
}
