//! The bucket toss (paper §7): a bucket for every image tile, and in it one for every slab, instead of a
//! sort.
//!
//! Both levels are counting sorts: linear, and stable, so that a bucket holds its voxels in the order
//! of the list whatever the number of threads. The first level works on chunks of the list whose size
//! depends on nothing but its length. A chunk's tosses stay where they are; a tile's bucket is the
//! chain of what each chunk holds for it. That costs no second pass, and no two threads ever write to
//! one place.

use rayon::prelude::*;

/// The image cut into square tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileGrid {
    /// Pixels along a tile's side.
    pub side: usize,
    /// Tiles in a row.
    pub n_x: usize,
    /// Rows of tiles.
    pub n_y: usize,
}

/// A rectangle of tiles, both ends included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileRect {
    /// First column and first row.
    pub min: [u16; 2],
    /// Last column and last row.
    pub max: [u16; 2],
}

/// Which splats fall on which tile.
#[derive(Debug, Default)]
pub struct TileBuckets {
    chunks: Vec<Chunk>,
}

/// What a run of the list tosses: `splats[starts[tile]..starts[tile + 1]]` falls on a tile.
#[derive(Debug, Default)]
struct Chunk {
    starts: Vec<u32>,
    splats: Vec<u32>,
}

impl TileGrid {
    /// Tiles of `side` pixels that cover an image.
    pub fn new([width, height]: [u32; 2], side: usize) -> Self {
        let across = |pixels: u32| (pixels as usize).div_ceil(side);
        Self { side, n_x: across(width), n_y: across(height) }
    }

    /// Number of tiles.
    pub fn n_tiles(&self) -> usize {
        self.n_x * self.n_y
    }

    /// The pixel in the upper left corner of a tile.
    pub fn origin(&self, tile_idx: usize) -> [usize; 2] {
        [tile_idx % self.n_x * self.side, tile_idx / self.n_x * self.side]
    }

    /// The tiles that have pixel centres within `min ..= max`, given in pixels; `None` if there are none.
    #[inline]
    pub fn touched(&self, min: [f32; 2], max: [f32; 2]) -> Option<TileRect> {
        let n_tiles = [self.n_x, self.n_y];
        let mut rect = TileRect { min: [0; 2], max: [0; 2] };
        for axis in 0..2 {
            // Pixel p has its centre at p + ½. Casts saturate, and turn NaN into 0.
            let first = (min[axis] - 0.5).ceil().max(0.0) as usize;
            let end = (max[axis] + 0.5).floor().max(0.0) as usize;
            let end = end.min(n_tiles[axis] * self.side);
            if end <= first {
                return None;
            }
            rect.min[axis] = (first / self.side) as u16;
            rect.max[axis] = ((end - 1) / self.side) as u16;
        }
        Some(rect)
    }

    fn tiles_in(&self, rect: TileRect) -> impl Iterator<Item = usize> + use<> {
        let n_x = self.n_x;
        let [columns, rows] =
            [0, 1].map(|axis| usize::from(rect.min[axis])..=usize::from(rect.max[axis]));
        rows.flat_map(move |row| columns.clone().map(move |column| row * n_x + column))
    }
}

impl TileBuckets {
    /// Tosses the splats `0..n_splats` onto the tiles that `rect_of` gives for each.
    pub fn toss(
        tiles: &TileGrid,
        n_splats: usize,
        rect_of: impl Fn(usize) -> Option<TileRect> + Sync,
    ) -> Self {
        // Many chunks to balance the load, but not so many that their starts outweigh the splats.
        // A chunk's tosses are counted in 32 bits, even if every splat falls on every tile.
        let countable = (u32::MAX as usize / tiles.n_tiles()).max(1);
        let chunk_len = (n_splats / 64).max(1 << 14).max(4 * tiles.n_tiles()).min(countable);
        let chunks = (0..n_splats.div_ceil(chunk_len))
            .into_par_iter()
            .map(|chunk_idx| {
                let first = chunk_idx * chunk_len;
                let end = (first + chunk_len).min(n_splats);
                let rects: Vec<_> = (first..end).map(&rect_of).collect();
                Chunk::toss(tiles, first, &rects)
            })
            .collect();
        Self { chunks }
    }

    /// The splats on a tile, in the order of the list.
    pub fn on_tile(&self, tile_idx: usize) -> impl Iterator<Item = u32> + '_ {
        self.chunks.iter().flat_map(move |chunk| chunk.on_tile(tile_idx)).copied()
    }

    /// How many splats fall on a tile.
    pub fn n_on_tile(&self, tile_idx: usize) -> usize {
        self.chunks.iter().map(|chunk| chunk.on_tile(tile_idx).len()).sum()
    }
}

impl Chunk {
    fn toss(tiles: &TileGrid, first_splat: usize, rects: &[Option<TileRect>]) -> Self {
        let mut starts = vec![0_u32; tiles.n_tiles() + 1];
        for tile_idx in rects.iter().flatten().flat_map(|&rect| tiles.tiles_in(rect)) {
            starts[tile_idx + 1] += 1;
        }
        accumulate(&mut starts);
        let mut next = starts.clone();
        let mut splats = vec![0; starts[tiles.n_tiles()] as usize];
        for (offset, rect) in rects.iter().enumerate() {
            let Some(rect) = *rect else { continue };
            for tile_idx in tiles.tiles_in(rect) {
                splats[next[tile_idx] as usize] = (first_splat + offset) as u32;
                next[tile_idx] += 1;
            }
        }
        Self { starts, splats }
    }

    fn on_tile(&self, tile_idx: usize) -> &[u32] {
        &self.splats[self.starts[tile_idx] as usize..self.starts[tile_idx + 1] as usize]
    }
}

/// Turns counts into the places where buckets start; `counts[0]` is 0.
fn accumulate(counts: &mut [u32]) {
    let mut sum = 0;
    for count in counts {
        sum += *count;
        *count = sum;
    }
}

/// The second level: the splats of one tile by the first slab that each meets. Made to be reused,
/// so that a tile allocates nothing once its thread has met the fullest one.
#[derive(Debug, Default)]
pub struct SlabBuckets {
    first_slab: usize,
    starts: Vec<u32>,
    splats: Vec<u32>,
}

impl SlabBuckets {
    /// Tosses `splats` by `slab_of`.
    pub fn toss(&mut self, splats: &[u32], slab_of: impl Fn(u32) -> usize) {
        self.starts.clear();
        self.splats.clear();
        let slabs = splats.iter().map(|&splat| slab_of(splat));
        let Some((first, last)) = slabs.fold(None, |range: Option<(usize, usize)>, slab| {
            Some(range.map_or((slab, slab), |(lo, hi)| (lo.min(slab), hi.max(slab))))
        }) else {
            return;
        };
        self.first_slab = first;
        // One entry more than counts need: while splats are placed, `starts[slab + 1]` is where the next
        // one of a slab goes, and ends up as where the slab after it starts.
        self.starts.resize(last - first + 3, 0);
        for &splat in splats {
            self.starts[slab_of(splat) - first + 2] += 1;
        }
        accumulate(&mut self.starts);
        self.splats.resize(splats.len(), 0);
        for &splat in splats {
            let next = &mut self.starts[slab_of(splat) - first + 1];
            self.splats[*next as usize] = splat;
            *next += 1;
        }
    }

    /// The first and the last slab in which a splat starts; `None` if there is no splat.
    pub fn slab_range(&self) -> Option<[usize; 2]> {
        let n_slabs = self.starts.len().checked_sub(2)?;
        Some([self.first_slab, self.first_slab + n_slabs - 1])
    }

    /// The splats that start in the slabs `first ..= last`, by slab and then in the order of the list.
    pub fn starting_in(&self, first: usize, last: usize) -> &[u32] {
        let n_slabs = self.starts.len().saturating_sub(2);
        let place = |slab: usize| slab.saturating_sub(self.first_slab).min(n_slabs);
        let [start, end] = [first, last + 1].map(|slab| self.starts.get(place(slab)));
        match (start, end) {
            (Some(&start), Some(&end)) => &self.splats[start as usize..end as usize],
            _ => &[],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn random_rect(rng: &mut fastrand::Rng, tiles: &TileGrid) -> Option<TileRect> {
        let min = [rng.f32() * 150.0 - 20.0, rng.f32() * 150.0 - 20.0];
        tiles.touched(min, [min[0] + rng.f32() * 40.0, min[1] + rng.f32() * 40.0])
    }

    /// Against the definition, for any number of threads.
    #[test]
    fn toss_is_a_stable_sort_by_tile() {
        let seed = fastrand::u64(..);
        println!("seed {seed}");
        let mut rng = fastrand::Rng::with_seed(seed);
        let tiles = TileGrid::new([100, 70], 16);
        let rects: Vec<_> = (0..40_000).map(|_| random_rect(&mut rng, &tiles)).collect();
        let expected = |tile_idx: usize| {
            let (x, y) = ((tile_idx % tiles.n_x) as u16, (tile_idx / tiles.n_x) as u16);
            let holds = move |r: &TileRect| {
                (r.min[0]..=r.max[0]).contains(&x) && (r.min[1]..=r.max[1]).contains(&y)
            };
            rects.iter().enumerate().filter(move |(_, r)| r.as_ref().is_some_and(holds))
        };
        for n_threads in [1, 3, 8] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
            let buckets = pool.install(|| TileBuckets::toss(&tiles, rects.len(), |i| rects[i]));
            for tile_idx in 0..tiles.n_tiles() {
                let expected: Vec<u32> = expected(tile_idx).map(|(i, _)| i as u32).collect();
                assert_eq!(buckets.on_tile(tile_idx).collect::<Vec<_>>(), expected);
                assert_eq!(buckets.n_on_tile(tile_idx), expected.len());
            }
        }
    }

    #[test]
    fn toss_touches_tiles_with_pixel_centers_inside() {
        let tiles = TileGrid::new([64, 32], 16);
        let rect = |min, max| Some(TileRect { min, max });
        assert_eq!(tiles.touched([0.0, 0.0], [0.4, 0.4]), None, "no centre inside");
        assert_eq!(tiles.touched([0.5, 0.5], [0.5, 0.5]), rect([0, 0], [0, 0]));
        assert_eq!(tiles.touched([15.6, 0.0], [16.5, 20.0]), rect([1, 0], [1, 1]));
        assert_eq!(tiles.touched([-50.0, -50.0], [500.0, 500.0]), rect([0, 0], [3, 1]));
        assert_eq!(tiles.touched([64.0, 0.0], [70.0, 5.0]), None, "right of the image");
        assert_eq!(tiles.touched([-9.0, 0.0], [-1.0, 5.0]), None, "left of the image");
        assert_eq!(tiles.touched([f32::NAN; 2], [f32::NAN; 2]), None);
    }

    #[test]
    fn toss_slabs_is_a_stable_sort() {
        let seed = fastrand::u64(..);
        println!("seed {seed}");
        let mut rng = fastrand::Rng::with_seed(seed);
        let mut buckets = SlabBuckets::default();
        for n_splats in [0, 1, 7, 500, 20] {
            let slabs: Vec<usize> = (0..n_splats).map(|_| rng.usize(5..25)).collect();
            let splats: Vec<u32> = (0..n_splats as u32).collect();
            buckets.toss(&splats, |splat| slabs[splat as usize]);
            let ends = slabs.iter().min().zip(slabs.iter().max()).map(|(&a, &b)| [a, b]);
            assert_eq!(buckets.slab_range(), ends);
            for first in 0..30 {
                for last in first..30 {
                    let starts = |&splat: &u32| (first..=last).contains(&slabs[splat as usize]);
                    let mut expected: Vec<u32> = splats.iter().copied().filter(starts).collect();
                    expected.sort_by_key(|&splat| slabs[splat as usize]);
                    assert_eq!(buckets.starting_in(first, last), expected, "{first}..={last}");
                }
            }
        }
    }
}
