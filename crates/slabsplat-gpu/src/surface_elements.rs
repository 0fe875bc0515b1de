//! Surfaces as the shaders read them: `shaders/shared/surfaces.wgsl`.

use crate::params::TILE_SIDE;
use crate::surfaces::Sheets;
use slabsplat_mesh::Hit;

/// An element of the shaders' `table`.
pub(crate) type Element = [u32; WORDS];

const WORDS: usize = 4;

/// Tiles along the side of a square, and pixels.
const TILES_ACROSS: usize = 4;
pub(crate) const SQUARE_SIDE: usize = TILES_ACROSS * TILE_SIDE as usize;

const TILE_PIXELS: usize = (TILE_SIDE * TILE_SIDE) as usize;

/// The surfaces of a square, pixel by pixel.
#[derive(Debug, Default)]
pub(crate) struct SquareOfPixels {
    surfaces: Vec<Element>,
    /// Where those of each pixel begin, and how many they are; empty if there are none.
    of_pixels: Vec<[usize; 2]>,
}

/// The surfaces of a square, tile by tile.
#[derive(Debug, Default)]
pub(crate) struct Square {
    elements: Vec<Element>,
    /// Where each tile begins, row by row, if anything is hit on it.
    starts: [Option<usize>; TILES_ACROSS * TILES_ACROSS],
}

impl SquareOfPixels {
    /// Adds the hits of a pixel, nearest first. Those before which as much lies are one surface, of the mean
    /// of their colours.
    pub(crate) fn push(&mut self, [column, row]: [usize; 2], hits: &[Hit], sheets: &Sheets) {
        let Self { surfaces, of_pixels } = self;
        of_pixels.resize(SQUARE_SIDE * SQUARE_SIDE, [0; 2]);
        let first = surfaces.len();
        for alike in hits.chunk_by(|a, b| sheets.at(a.depth) == sheets.at(b.depth)) {
            let (sheet, share) = sheets.at(alike[0].depth);
            let sum = |channel: usize| alike.iter().map(|hit| hit.color[channel]).sum::<f32>();
            let [r, g, b] = [0, 1, 2].map(|channel| unorm16(sum(channel) / alike.len() as f32));
            let n_rays = alike.len() as u32;
            surfaces.push([sheet, share.to_bits(), r | (g << 16), b | (n_rays << 16)]);
        }
        of_pixels[row * SQUARE_SIDE + column] = [first, surfaces.len() - first];
    }

    /// The same, tile by tile.
    pub(crate) fn by_tile(&self) -> Square {
        let mut tiles = Square::default();
        if self.surfaces.is_empty() {
            return tiles;
        }
        let side = TILE_SIDE as usize;
        for tile in 0..TILES_ACROSS * TILES_ACROSS {
            let [left, top] = [tile % TILES_ACROSS, tile / TILES_ACROSS].map(|at| at * side);
            let pixels: [[usize; 2]; TILE_PIXELS] = std::array::from_fn(|pixel| {
                self.of_pixels[(top + pixel / side) * SQUARE_SIDE + left + pixel % side]
            });
            if pixels.iter().any(|[_, n]| 0 < *n) {
                tiles.starts[tile] = Some(tiles.elements.len());
                self.push_tile(&pixels, &mut tiles.elements);
            }
        }
        tiles
    }

    fn push_tile(&self, pixels: &[[usize; 2]; TILE_PIXELS], elements: &mut Vec<Element>) {
        let mut start = TILE_PIXELS / WORDS;
        let words = pixels.map(|[_, n]| {
            let word = ((start << 16) | n) as u32;
            start += n;
            word
        });
        elements.extend_from_slice(words.as_chunks().0);
        for [first, n] in pixels {
            elements.extend_from_slice(&self.surfaces[*first..first + n]);
        }
    }
}

fn unorm16(channel: f32) -> u32 {
    (channel.clamp(0.0, 1.0) * f32::from(u16::MAX)).round() as u32
}

/// The squares of a picture, row by row, behind where each tile begins.
pub(crate) fn put_together([width, height]: [u32; 2], squares: &[Square]) -> Vec<Element> {
    let [n_x, n_y] = [width, height].map(|side| side.div_ceil(TILE_SIDE) as usize);
    let mut starts = vec![0; (n_x * n_y).next_multiple_of(WORDS)];
    let mut first = starts.len() / WORDS;
    let squares_across = n_x.div_ceil(TILES_ACROSS);
    for (square_idx, square) in squares.iter().enumerate() {
        let corner = [square_idx % squares_across, square_idx / squares_across];
        for (tile, start) in square.starts.iter().enumerate() {
            let within = [tile % TILES_ACROSS, tile / TILES_ACROSS];
            let [x, y] = [0, 1].map(|axis| corner[axis] * TILES_ACROSS + within[axis]);
            if let Some(start) = start {
                starts[y * n_x + x] = (first + start) as u32;
            }
        }
        first += square.elements.len();
    }
    let mut elements = Vec::with_capacity(first);
    elements.extend_from_slice(starts.as_chunks().0);
    squares.iter().for_each(|square| elements.extend_from_slice(&square.elements));
    elements
}
