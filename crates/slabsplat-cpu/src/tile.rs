//! A square of the image, rendered by one thread.

use crate::composite::Composite;
use crate::open_pixels::OpenPixels;
use crate::sheet::Sheet;
use slabsplat_core::Image;
use slabsplat_traverse::{SlabBuckets, TileGrid};

/// Pixels along the side of a tile. 16² sums and pixels take 8 KiB and leave a first-level cache to the
/// section table; with 32² everything is measured to take 1.7 times as long.
pub(crate) const TILE_SIDE: usize = 16;

/// The composited pixels of a tile.
#[derive(Clone, Debug)]
pub(crate) struct Tile {
    /// The image pixel in the upper left corner.
    pub(crate) origin: [usize; 2],
    pub(crate) side: usize,
    /// The pixels that may still change.
    pub(crate) open: OpenPixels,
    /// Premultiplied colour and opacity, row by row.
    pub(crate) pixels: Vec<[f32; 4]>,
}

/// What a tile took.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct TileStats {
    pub(crate) n_splats: u64,
    /// Splats that could touch no open pixel.
    pub(crate) n_culled: u64,
    pub(crate) is_full: bool,
}

/// What a thread keeps from tile to tile.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    /// The splats on the tile, in the order of the list.
    pub(crate) splats: Vec<u32>,
    pub(crate) buckets: SlabBuckets,
    pub(crate) sheet: Sheet,
    /// A section, ready to be splatted.
    pub(crate) row: Vec<f32>,
}

impl Tile {
    pub(crate) fn new(tiles: &TileGrid, tile_idx: usize, image_size: [u32; 2]) -> Self {
        let (side, origin) = (tiles.side, tiles.origin(tile_idx));
        let inside = [0, 1].map(|axis| side.min(image_size[axis] as usize - origin[axis]));
        let pixels = vec![[0.0; 4]; side * side];
        Self { origin, side, open: OpenPixels::all(inside), pixels }
    }

    /// Puts a sheet behind what is already there, and empties it.
    pub(crate) fn put_behind<C: Composite>(&mut self, sheet: &mut Sheet) {
        sheet.drain(|pixel_idx, sums| put_behind(&mut self.pixels[pixel_idx], C::resolve(sums)));
    }

    /// Closes pixels that are at least that opaque, and tells whether all are.
    pub(crate) fn close(&mut self, cutoff: f32) -> bool {
        self.open.close(&self.pixels, self.side, cutoff);
        self.open.is_empty()
    }

    /// Copies the part of the tile that is inside the image.
    pub(crate) fn copy_to(&self, image: &mut Image) {
        let [width, height] = [image.width() as usize, image.height() as usize];
        let [x0, y0] = self.origin;
        let n_columns = self.side.min(width - x0);
        let n_rows = self.side.min(height - y0);
        for row in 0..n_rows {
            let start = (y0 + row) * width + x0;
            let from = &self.pixels[row * self.side..][..n_columns];
            image.pixels_mut()[start..start + n_columns].copy_from_slice(from);
        }
    }
}

/// Front to back: `C ← C + (1 − A)·c`, `A ← A + (1 − A)·a`.
#[inline]
pub(crate) fn put_behind(pixel: &mut [f32; 4], behind: [f32; 4]) {
    let through = 1.0 - pixel[3];
    for (channel, behind) in pixel.iter_mut().zip(behind) {
        *channel += through * behind;
    }
}
