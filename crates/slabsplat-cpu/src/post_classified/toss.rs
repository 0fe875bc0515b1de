//! The toss onto tiles that share their borders: a pixel beside a tile is summed with it, since gradients are
//! taken across.

use rayon::prelude::*;
use std::ops::Range;

/// The image cut into square tiles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tiles {
    pub(super) image_size: [usize; 2],
    pub(super) side: usize,
}

/// A range of columns and one of rows, of tiles.
pub(super) type TileRect = [Range<usize>; 2];

/// Which voxels fall on which tile.
pub(super) struct Toss {
    chunks: Vec<Chunk>,
}

/// What a run of the list tosses: `voxels[starts[tile]..starts[tile + 1]]` fall on a tile.
struct Chunk {
    starts: Vec<u32>,
    voxels: Vec<u32>,
}

impl Tiles {
    pub(super) fn n_along(&self) -> [usize; 2] {
        self.image_size.map(|pixels| pixels.div_ceil(self.side))
    }

    pub(super) fn n_tiles(&self) -> usize {
        self.n_along().into_iter().product()
    }

    /// The pixel in the upper left corner of a tile.
    pub(super) fn origin(&self, tile_idx: usize) -> [usize; 2] {
        let n_x = self.n_along()[0];
        [tile_idx % n_x * self.side, tile_idx / n_x * self.side]
    }

    /// The tiles with pixel centres within `min ..= max`, in pixels, in them or in their borders.
    pub(super) fn touched(&self, [min, max]: [[f32; 2]; 2]) -> Option<TileRect> {
        let along = |axis: usize| {
            // Pixel −1 and the one after the last belong to the borders. Casts saturate, and turn NaN into 0.
            let n_pixels = self.image_size[axis] as i64;
            let first = ((min[axis] - 0.5).ceil() as i64).max(-1);
            let last = ((max[axis] - 0.5).floor() as i64).min(n_pixels);
            if last < first {
                return None;
            }
            // Tile t sums the pixels t·side − 1 ..= (t + 1)·side.
            let side = self.side as i64;
            let start = (first + side - 1).div_euclid(side).max(1) - 1;
            let end = (last + 1).div_euclid(side) + 1;
            Some(start as usize..(end as usize).min(self.n_along()[axis]))
        };
        Some([along(0)?, along(1)?]).filter(|rect| rect.iter().all(|along| !along.is_empty()))
    }
}

impl Toss {
    /// Tosses the voxels `0..n_voxels` onto the tiles that `rect_of` gives for each.
    pub(super) fn new(
        tiles: &Tiles,
        n_voxels: usize,
        rect_of: impl Fn(usize) -> Option<TileRect> + Sync,
    ) -> Self {
        // A chunk's tosses are counted in 32 bits, even if every voxel falls on every tile.
        let countable = (u32::MAX as usize / tiles.n_tiles()).max(1);
        let chunk_len = (n_voxels / 64).max(1 << 14).max(4 * tiles.n_tiles()).min(countable);
        let chunk = |chunk_idx: usize| {
            let first = chunk_idx * chunk_len;
            let voxels = first..(first + chunk_len).min(n_voxels);
            let rects: Vec<_> = voxels.clone().map(&rect_of).collect();
            Chunk::new(tiles, first, &rects)
        };
        let n_chunks = n_voxels.div_ceil(chunk_len);
        Self { chunks: (0..n_chunks).into_par_iter().map(chunk).collect() }
    }

    /// The voxels on a tile, in the order of the list.
    pub(super) fn on_tile(&self, tile_idx: usize) -> impl Iterator<Item = u32> + '_ {
        self.chunks.iter().flat_map(move |chunk| chunk.on_tile(tile_idx)).copied()
    }

    /// How many voxels fall on a tile.
    pub(super) fn n_on_tile(&self, tile_idx: usize) -> usize {
        self.chunks.iter().map(|chunk| chunk.on_tile(tile_idx).len()).sum()
    }
}

impl Chunk {
    fn new(tiles: &Tiles, first: usize, rects: &[Option<TileRect>]) -> Self {
        let n_x = tiles.n_along()[0];
        let tiles_of = |[columns, rows]: &TileRect| {
            let columns = columns.clone();
            rows.clone().flat_map(move |row| columns.clone().map(move |column| row * n_x + column))
        };
        let mut starts = vec![0_u32; tiles.n_tiles() + 1];
        for tile_idx in rects.iter().flatten().flat_map(tiles_of) {
            starts[tile_idx + 1] += 1;
        }
        for tile_idx in 0..tiles.n_tiles() {
            starts[tile_idx + 1] += starts[tile_idx];
        }
        let mut next = starts.clone();
        let mut voxels = vec![0; starts[tiles.n_tiles()] as usize];
        for (offset, rect) in rects.iter().enumerate() {
            for tile_idx in rect.iter().flat_map(tiles_of) {
                voxels[next[tile_idx] as usize] = (first + offset) as u32;
                next[tile_idx] += 1;
            }
        }
        Self { starts, voxels }
    }

    fn on_tile(&self, tile_idx: usize) -> &[u32] {
        &self.voxels[self.starts[tile_idx] as usize..self.starts[tile_idx + 1] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tile is touched if any of its pixels is, or any that borders on it.
    #[test]
    fn toss_touches_borders() {
        let tiles = Tiles { image_size: [40, 20], side: 16 };
        let seed = fastrand::u64(..);
        println!("seed {seed}");
        let mut rng = fastrand::Rng::with_seed(seed);
        for _ in 0..2000 {
            let min = [rng.f32() * 60.0 - 10.0, rng.f32() * 40.0 - 10.0];
            let max = min.map(|c| c + rng.f32() * 20.0);
            let touches = |tile_idx: usize| {
                let origin = tiles.origin(tile_idx);
                (0..2).all(|axis| {
                    let summed = origin[axis] as i32 - 1..=(origin[axis] + tiles.side) as i32;
                    let in_image = -1..=tiles.image_size[axis] as i32;
                    summed.filter(|pixel| in_image.contains(pixel)).any(|pixel| {
                        let center = pixel as f32 + 0.5;
                        min[axis] <= center && center <= max[axis]
                    })
                })
            };
            let expected: Vec<usize> = (0..tiles.n_tiles()).filter(|&t| touches(t)).collect();
            let toss = Toss::new(&tiles, 1, |_| tiles.touched([min, max]));
            let actual: Vec<usize> =
                (0..tiles.n_tiles()).filter(|&t| toss.n_on_tile(t) == 1).collect();
            assert_eq!(actual, expected, "{min:?} {max:?}");
        }
    }
}
