//! Several layers as one picture, each shown by one density (model §12).

use crate::pixels::quad::QUAD;
use crate::pixels::rectangle::TILE_SIDE;
use crate::pixels::tiles::Tiles;
use rayon::prelude::*;
use slabsplat_core::Compositing;

/// What layers show together.
#[derive(Debug, Default)]
pub(super) struct JoinedLayers {
    /// Those of each tile, row by row.
    pixels: Vec<JoinedPixel>,
}

/// Of a tile.
const N_PIXELS: usize = TILE_SIDE * TILE_SIDE;

#[derive(Clone, Copy, Debug)]
struct JoinedPixel {
    /// Colours, weighted with extinctions.
    color: [f32; 3],
    extinction: f32,
    /// What goes through all layers.
    through: f32,
}

impl JoinedPixel {
    const EMPTY: Self = Self { color: [0.0; 3], extinction: 0.0, through: 1.0 };

    fn add(&mut self, [r, g, b, opacity]: [f32; 4]) {
        if opacity <= 0.0 {
            return;
        }
        let extinction = Compositing::Extinction.weight(f64::from(opacity)) as f32;
        for (sum, channel) in self.color.iter_mut().zip([r, g, b]) {
            *sum += extinction * (channel / opacity);
        }
        self.extinction += extinction;
        self.through *= 1.0 - opacity;
    }

    /// Premultiplied colour and opacity.
    fn shown(&self) -> [f32; 4] {
        if self.extinction <= 0.0 {
            return [0.0; 4];
        }
        let opacity = 1.0 - self.through;
        let [r, g, b] = self.color.map(|sum| opacity * (sum / self.extinction));
        [r, g, b, opacity]
    }
}

impl JoinedLayers {
    /// Makes it nothing, of so many tiles.
    pub(super) fn clear(&mut self, tiles: &Tiles) {
        self.pixels.clear();
        self.pixels.resize(tiles.tiles.len() * N_PIXELS, JoinedPixel::EMPTY);
    }

    /// Adds what tiles show of a layer.
    pub(super) fn add(&mut self, tiles: &Tiles) {
        let of_tiles = self.pixels.par_chunks_mut(N_PIXELS).zip(&tiles.tiles);
        of_tiles.for_each(|(joined, tile)| {
            for (joined, quad) in joined.chunks_mut(QUAD).zip(tile.pixels.iter().flatten()) {
                for (pixel, joined) in joined.iter_mut().enumerate() {
                    joined.add(quad.pixel(pixel));
                }
            }
        });
    }

    /// Makes tiles show all of them.
    pub(super) fn put(&self, tiles: &mut Tiles) {
        let of_tiles = self.pixels.par_chunks(N_PIXELS).zip(&mut tiles.tiles);
        of_tiles.for_each(|(joined, tile)| {
            let quads = tile.pixels.iter_mut().flatten();
            for (joined, quad) in joined.chunks(QUAD).zip(quads) {
                for (pixel, joined) in joined.iter().enumerate() {
                    quad.set_pixel(pixel, joined.shown());
                }
            }
        });
    }

    pub(super) fn resident_bytes(&self) -> usize {
        self.pixels.capacity() * size_of::<JoinedPixel>()
    }
}
