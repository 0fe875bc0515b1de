//! A square of the image, rendered by one thread at a time.

use crate::blocks::{BLOCK_SIDE, Blocks};
use crate::composite::{OCTET, put_behind};
use crate::quad::{QUAD, Quad};
use crate::sheet::{Pixels, Sheet};
use crate::splat::PixelBox;
use crate::voxel::Voxel;
use fearless_simd::Simd;
use slabsplat_core::{Compositing, Image};
use std::ops::Range;

/// Pixels along the side of a tile. The sums of 32² pixels fill half of a first-level cache; smaller tiles would
/// share too many footprints.
pub(crate) const TILE_SIDE: usize = 32;

/// The composited pixels of a tile, and what waits to be splatted on it.
#[derive(Clone, Debug)]
pub(crate) struct Tile {
    /// The image pixel in the upper left corner.
    pub(crate) origin: [usize; 2],
    /// Columns and rows that are inside the image.
    inside: [usize; 2],
    /// The blocks that hold pixels which may still change.
    pub(crate) open: Blocks,
    /// Premultiplied colour and opacity. Pixels outside of the image are opaque from the start.
    pub(crate) pixels: Box<Pixels>,
    /// Voxels whose last sections are yet to come.
    pub(crate) pending: Vec<Voxel>,
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
    /// An empty tile of an image.
    pub(crate) fn new(origin: [usize; 2], image_size: [u32; 2]) -> Self {
        let mut tile = Self {
            origin,
            inside: [0, 1].map(|axis| TILE_SIDE.min(image_size[axis] as usize - origin[axis])),
            open: Blocks::NONE,
            pixels: Sheet::default().sums,
            pending: Vec::new(),
            stats: TileStats::default(),
        };
        tile.clear();
        tile
    }

    /// Makes it empty again.
    pub(crate) fn clear(&mut self) {
        let [n_columns, n_rows] = self.inside;
        for (row_idx, row) in self.pixels.iter_mut().enumerate() {
            for (quad_idx, quad) in row.iter_mut().enumerate() {
                *quad = Quad::ZERO;
                for pixel in 0..QUAD {
                    if n_rows <= row_idx || n_columns <= quad_idx * QUAD + pixel {
                        quad.0[4 * pixel + 3] = 1.0;
                    }
                }
            }
        }
        let columns = n_columns.div_ceil(BLOCK_SIDE);
        let rows = n_rows.div_ceil(BLOCK_SIDE);
        self.open = Blocks::first([columns, rows]);
        self.pending.clear();
        self.stats = TileStats::default();
    }

    /// Whether no pixel may change any more.
    pub(crate) fn is_full(&self) -> bool {
        self.open.is_empty()
    }

    /// Puts a sheet behind what is already there, empties it, and closes the blocks whose pixels are all at least
    /// as opaque as `cutoff`.
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
            let octets = column..column + 1;
            let least = self.put_octets_behind(simd, compositing, sheet, rows, octets);
            if cutoff <= least {
                self.open.remove([column, row]);
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
        let [columns, rows] = [0, 1].map(|axis| pixels.min[axis].into()..pixels.end[axis].into());
        let octets = columns.start / OCTET..usize::div_ceil(columns.end, OCTET);
        self.put_octets_behind(simd, compositing, sheet, rows, octets);
    }

    /// Closes the blocks whose pixels are all at least as opaque as `cutoff`.
    pub(crate) fn close_full_blocks(&mut self, cutoff: f32) {
        for [column, row] in self.open.iter() {
            let quads = column * BLOCK_SIDE / QUAD..(column + 1) * BLOCK_SIDE / QUAD;
            let mut rows = self.pixels[row * BLOCK_SIDE..(row + 1) * BLOCK_SIDE].iter();
            let is_full = |quad: &Quad| (0..QUAD).all(|pixel| cutoff <= quad.opacity(pixel));
            if rows.all(|row| row[quads.clone()].iter().all(is_full)) {
                self.open.remove([column, row]);
            }
        }
    }

    /// Returns the least opacity that any of the pixels has then.
    #[inline(always)]
    fn put_octets_behind<S: Simd>(
        &mut self,
        simd: S,
        compositing: Compositing,
        sheet: &mut Sheet,
        rows: Range<usize>,
        octets: Range<usize>,
    ) -> f32 {
        let mut least = f32::INFINITY;
        for (pixels, sums) in self.pixels[rows.clone()].iter_mut().zip(&mut sheet.sums[rows]) {
            let (pixels, sums) = (pixels.as_chunks_mut::<2>().0, sums.as_chunks_mut::<2>().0);
            for (pixels, sums) in pixels[octets.clone()].iter_mut().zip(&mut sums[octets.clone()]) {
                least = least.min(put_behind(simd, compositing, pixels, sums));
            }
        }
        least
    }

    /// Copies the part of the tile that is inside the image.
    pub(crate) fn copy_to(&self, image: &mut Image) {
        let width = image.width() as usize;
        let [x, y] = self.origin;
        let [n_columns, n_rows] = self.inside;
        for (row, quads) in self.pixels.iter().enumerate().take(n_rows) {
            let start = (y + row) * width + x;
            let pixels = &mut image.pixels_mut()[start..start + n_columns];
            for (column, pixel) in pixels.iter_mut().enumerate() {
                *pixel = quads[column / QUAD].pixel(column % QUAD);
            }
        }
    }
}
