//! Where the rays of a tile's samples end at opaque surfaces (model §14).

use super::blocks::{BLOCK_SIDE, BLOCKS_ACROSS};
use super::rectangle::TILE_SIDE;
use slabsplat_mesh::{Hit, N_SAMPLES};

/// The hits of a tile's samples, and how many of them were come to. Made to be used again.
#[derive(Clone, Debug)]
pub(crate) struct Surfaces {
    /// Nearest first, pixel by pixel.
    hits: Vec<Hit>,
    /// Where those of each pixel start, row by row, and where the last ones end; nothing if there are none.
    starts: Vec<u32>,
    /// How many of each pixel's rays have ended.
    n_ended: Vec<u8>,
    /// The depth of the next hit, of each block and of all; infinite if there is none.
    next: [f32; BLOCKS_ACROSS * BLOCKS_ACROSS],
    next_of_all: f32,
}

impl Default for Surfaces {
    fn default() -> Self {
        Self {
            hits: Vec::new(),
            starts: Vec::new(),
            n_ended: Vec::new(),
            next: [f32::INFINITY; BLOCKS_ACROSS * BLOCKS_ACROSS],
            next_of_all: f32::INFINITY,
        }
    }
}

const N_PIXELS: usize = TILE_SIDE * TILE_SIDE;

impl Surfaces {
    /// Makes it empty.
    pub(crate) fn clear(&mut self) {
        self.hits.clear();
        self.starts.clear();
        self.n_ended.clear();
        self.next = [f32::INFINITY; BLOCKS_ACROSS * BLOCKS_ACROSS];
        self.next_of_all = f32::INFINITY;
    }

    /// Adds the hits of a pixel, nearest first, behind those of pixels in rows above or to the left.
    pub(crate) fn add(&mut self, [column, row]: [usize; 2], hits: &[Hit]) {
        let block = row / BLOCK_SIDE * BLOCKS_ACROSS + column / BLOCK_SIDE;
        let next = &mut self.next[block];
        *next = next.min(hits[0].depth);
        self.next_of_all = self.next_of_all.min(*next);
        self.starts.resize(row * TILE_SIDE + column + 1, self.hits.len() as u32);
        self.hits.extend_from_slice(hits);
    }

    /// Makes it ready, once all pixels are added.
    pub(crate) fn finish(&mut self) {
        if !self.hits.is_empty() {
            self.starts.resize(N_PIXELS + 1, self.hits.len() as u32);
            self.n_ended.resize(N_PIXELS, 0);
        }
    }

    /// Whether any ray ends before a depth that was not come to.
    #[inline(always)]
    pub(crate) fn any_before(&self, depth: f32) -> bool {
        self.next_of_all < depth
    }

    /// Whether any of a block does.
    pub(super) fn any_in_block_before(&self, [column, row]: [usize; 2], depth: f32) -> bool {
        self.next[row * BLOCKS_ACROSS + column] < depth
    }

    /// Comes to the hits of a pixel before a depth: how many rays were left, and where such end.
    pub(super) fn come_to(&mut self, [column, row]: [usize; 2], depth: f32) -> (usize, &[Hit]) {
        let pixel = row * TILE_SIDE + column;
        let [start, end] = [self.starts[pixel], self.starts[pixel + 1]].map(|at| at as usize);
        let n_ended = &mut self.n_ended[pixel];
        let n_before = usize::from(*n_ended);
        let left = &self.hits[start + n_before..end];
        let ended = &left[..left.iter().take_while(|hit| hit.depth < depth).count()];
        *n_ended += ended.len() as u8;
        (N_SAMPLES - n_before, ended)
    }

    /// Finds the next hit of a block.
    pub(super) fn note_next(&mut self, [column, row]: [usize; 2]) {
        let next_of = |pixel: usize| {
            let next = self.starts[pixel] as usize + usize::from(self.n_ended[pixel]);
            let is_left = next < self.starts[pixel + 1] as usize;
            if is_left { self.hits[next].depth } else { f32::INFINITY }
        };
        let rows = row * BLOCK_SIDE..(row + 1) * BLOCK_SIDE;
        let first = column * BLOCK_SIDE;
        let pixels =
            rows.flat_map(|row| (first..first + BLOCK_SIDE).map(move |c| row * TILE_SIDE + c));
        self.next[row * BLOCKS_ACROSS + column] = pixels.map(next_of).fold(f32::INFINITY, f32::min);
    }

    /// Finds the next hit of all blocks.
    pub(super) fn note_next_of_all(&mut self) {
        self.next_of_all = self.next.iter().copied().fold(f32::INFINITY, f32::min);
    }

    pub(crate) fn resident_bytes(&self) -> usize {
        self.hits.capacity() * size_of::<Hit>()
            + self.starts.capacity() * size_of::<u32>()
            + self.n_ended.capacity()
    }
}
