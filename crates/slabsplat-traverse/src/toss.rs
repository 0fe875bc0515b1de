//! The bucket toss (paper §7), instead of a sort: its first level, a bucket for every image tile. The second,
//! a bucket for every slab, is the tile's own.
//!
//! A bucket holds its voxels in the order of the list whatever the number of threads, as the toss works on
//! runs of the list that do not depend on that number. What a run tosses stays where it is; a tile's bucket
//! is the chain of what each run holds for it. That costs no second pass, and no two threads ever write to
//! one place.

use crate::Buckets;
use rayon::prelude::*;
use slabsplat_core::{Cancelled, FrameHandle};

/// The image cut into square tiles.
///
/// Tiles may have a border, which is their neighbours' and holds what they need to know of them. Pixels are
/// then counted from the corner of the image's own border.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TileGrid {
    /// Pixels from a tile to the next.
    step: u32,
    /// Pixels of a tile on either side that are its neighbours'.
    border: u32,
    /// `2³²/step`, rounded up: a multiplication is cheaper than a division.
    per_step: u64,
    /// Across and down, with borders.
    n_pixels: [f32; 2],
    /// Tiles in a row.
    pub n_x: usize,
    /// Rows of tiles.
    pub n_y: usize,
}

/// A rectangle of pixels that holds at least one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PixelRect {
    /// First column and first row.
    pub min: [u32; 2],
    /// The column and the row behind the last.
    pub end: [u32; 2],
}

/// A rectangle of tiles, both ends included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileRect {
    /// First column and first row.
    pub min: [u16; 2],
    /// Last column and last row.
    pub max: [u16; 2],
}

impl TileRect {
    /// No tile.
    pub const EMPTY: Self = Self { min: [1; 2], max: [0; 2] };
}

/// A run of splats, or their names, by the tile on which they fall. Made to be used again.
#[derive(Debug)]
pub struct TileToss<T>(Buckets<T>);

impl<T> Default for TileToss<T> {
    fn default() -> Self {
        Self(Buckets::default())
    }
}

/// A splat that falls on a tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileEntry {
    /// The tile.
    pub tile: u32,
    /// The splat's name.
    pub name: u32,
}

/// Which splats fall on which tile: a [`TileToss`] for every run of them. Made to be used again.
#[derive(Debug, Default)]
pub struct TileBuckets {
    runs: Vec<Run>,
    n_runs: usize,
    run_len: usize,
}

#[derive(Debug, Default)]
struct Run {
    entries: Vec<TileEntry>,
    toss: TileToss<u32>,
}

impl TileGrid {
    /// Tiles of `side` pixels that cover an image, of which `border` on either side are their neighbours'.
    ///
    /// # Panics
    /// If a tile has no pixel of its own.
    pub fn new([width, height]: [u32; 2], side: usize, border: usize) -> Self {
        assert!(2 * border < side, "tiles of {side} pixels with borders of {border}");
        let step = (side - 2 * border) as u32;
        let [n_x, n_y] = [width, height].map(|pixels| pixels.div_ceil(step));
        Self {
            step,
            border: border as u32,
            per_step: (1_u64 << 32).div_ceil(step.into()),
            n_pixels: [n_x, n_y].map(|n_tiles| (n_tiles * step + 2 * border as u32) as f32),
            n_x: n_x as usize,
            n_y: n_y as usize,
        }
    }

    /// Pixels from a tile to the next.
    #[inline(always)]
    pub fn step(&self) -> u32 {
        self.step
    }

    /// Pixels of a tile on either side that are its neighbours'.
    pub fn border(&self) -> usize {
        self.border as usize
    }

    /// How many whole steps a number of pixels is, for less than 2²⁸ of them.
    #[inline(always)]
    fn steps(&self, pixels: u32) -> u32 {
        ((u64::from(pixels) * self.per_step) >> 32) as u32
    }

    /// Number of tiles.
    pub fn n_tiles(&self) -> usize {
        self.n_x * self.n_y
    }

    /// The pixel in the upper left corner of a tile.
    pub fn origin(&self, tile_idx: usize) -> [usize; 2] {
        [tile_idx % self.n_x, tile_idx / self.n_x].map(|tile| tile * self.step as usize)
    }

    /// The pixels that have their centres within `min ..= max`, given in pixels, or hardly outside; `None` if
    /// there are none on any tile.
    #[inline(always)]
    pub fn pixels_within(&self, min: [f32; 2], max: [f32; 2]) -> Option<PixelRect> {
        // All four as one vector.
        let edges = [min[0] - MARGIN, min[1] - MARGIN, max[0] + MARGIN, max[1] + MARGIN];
        let mut pixels = [0; 4];
        for (side, pixel) in pixels.iter_mut().enumerate() {
            *pixel = nearest(edges[side], self.n_pixels[side % 2]);
        }
        let [left, top, right, bottom] = pixels;
        let holds_any = left < right && top < bottom;
        holds_any.then_some(PixelRect { min: [left, top], end: [right, bottom] })
    }

    /// The tiles that hold pixels of a rectangle.
    #[inline(always)]
    pub fn tiles_of(&self, pixels: &PixelRect) -> TileRect {
        let last = [self.n_x, self.n_y].map(|n_tiles| n_tiles as u32 - 1);
        let of_last = |axis: usize| self.steps(pixels.end[axis] - 1).min(last[axis]) as u16;
        TileRect {
            min: pixels.min.map(|first| self.steps(first.saturating_sub(2 * self.border)) as u16),
            max: [of_last(0), of_last(1)],
        }
    }

    /// Appends every tile of a rectangle, which must hold one, with a splat's name, to what is to be tossed.
    ///
    /// Nearly all splats fall on one tile, two or four, and nobody can guess on how many: they take no
    /// branch.
    #[inline(always)]
    pub fn push(&self, rect: TileRect, name: u32, onto: &mut Vec<TileEntry>) {
        let [left, top] = rect.min.map(u32::from);
        let [width, height] =
            [0, 1].map(|axis| 1 + u32::from(rect.max[axis]) - u32::from(rect.min[axis]));
        let n_x = self.n_x as u32;
        let first = top * n_x + left;
        if width <= 2 && height <= 2 {
            let second = if width == 2 { first + 1 } else { first + n_x };
            let four =
                [first, second, first + n_x, first + n_x + 1].map(|tile| TileEntry { tile, name });
            let end = onto.len() + (width * height) as usize;
            onto.extend_from_slice(&four);
            onto.truncate(end);
            return;
        }
        for row in 0..height {
            let start = first + row * n_x;
            onto.extend((start..start + width).map(|tile| TileEntry { tile, name }));
        }
    }
}

impl<T: Copy + Default> TileToss<T> {
    /// Tosses splats, of which `splat` gives one by its name.
    ///
    /// If the frame is cancelled they may be any of them, or none.
    pub fn toss(
        &mut self,
        tiles: &TileGrid,
        entries: &[TileEntry],
        splat: impl Fn(u32) -> T,
        frame: &FrameHandle,
    ) {
        let (runs, splat) = (std::iter::once(entries), |entry: &TileEntry| splat(entry.name));
        self.0.sort(tiles.n_tiles(), runs, |entry| entry.tile as usize, splat, frame);
    }

    /// The splats on a tile, in the order of the run.
    #[inline]
    pub fn on_tile(&self, tile_idx: usize) -> &[T] {
        self.0.items_of(tile_idx..tile_idx + 1)
    }

    /// Bytes held.
    pub fn resident_bytes(&self) -> usize {
        self.0.resident_bytes()
    }
}

impl TileBuckets {
    /// Tosses the splats `0..n_splats` onto the tiles that `rect_of` gives for each, for a frame.
    ///
    /// # Errors
    /// If that is cancelled; what falls on which tile is then of no meaning.
    pub fn toss(
        &mut self,
        tiles: &TileGrid,
        n_splats: usize,
        rect_of: impl Fn(usize) -> TileRect + Sync,
        frame: &FrameHandle,
    ) -> Result<(), Cancelled> {
        // Many runs to balance the load, but not so many that their starts outweigh the splats.
        // A run's tosses are counted in 32 bits, even if every splat falls on every tile.
        let countable = (u32::MAX as usize / tiles.n_tiles()).max(1);
        let run_len = (n_splats / 64).max(1 << 14).max(4 * tiles.n_tiles()).min(countable);
        self.run_len = run_len;
        self.n_runs = n_splats.div_ceil(run_len);
        if self.runs.len() < self.n_runs {
            self.runs.resize_with(self.n_runs, Run::default);
        }
        let runs = self.runs[..self.n_runs].par_iter_mut().enumerate();
        runs.for_each(|(run_idx, Run { entries, toss })| {
            let first = run_idx * run_len;
            entries.clear();
            let end = (first + run_len).min(n_splats);
            for start in (first..end).step_by(LOOK_EVERY) {
                if frame.is_cancelled() {
                    entries.clear();
                    break;
                }
                for splat in start..end.min(start + LOOK_EVERY) {
                    let rect = rect_of(splat);
                    if rect != TileRect::EMPTY {
                        tiles.push(rect, (splat - first) as u32, entries);
                    }
                }
            }
            toss.toss(tiles, entries, |name| name, frame);
        });
        frame.check()
    }

    /// The splats on a tile, rising.
    pub fn on_tile(&self, tile_idx: usize) -> impl Iterator<Item = usize> + Clone + '_ {
        self.runs[..self.n_runs].iter().enumerate().flat_map(move |(run_idx, run)| {
            let first = run_idx * self.run_len;
            run.toss.on_tile(tile_idx).iter().map(move |&splat| first + splat as usize)
        })
    }

    /// How many splats fall on a tile.
    pub fn n_on_tile(&self, tile_idx: usize) -> usize {
        self.runs[..self.n_runs].iter().map(|run| run.toss.on_tile(tile_idx).len()).sum()
    }

    /// Bytes held.
    pub fn resident_bytes(&self) -> usize {
        let bytes =
            |run: &Run| run.entries.capacity() * size_of::<TileEntry>() + run.toss.resident_bytes();
        self.runs.iter().map(bytes).sum()
    }
}

/// Splats between two looks at whether anyone still wants them.
const LOOK_EVERY: usize = 1 << 12;

/// What lies exactly on a pixel's centre must count on both sides alike, or pictures would not be symmetric.
const MARGIN: f32 = 1.0 / 1024.0;

/// The whole number nearest to `at`, 0 … `most`; pixel `p` has its centre at `p + ½`, so this is the first
/// pixel whose centre lies behind `at`. NaN gives 0.
///
/// Adding 2²³ rounds to whole numbers and leaves them in the low bits, at a fraction of what a cast costs.
#[inline(always)]
fn nearest(at: f32, most: f32) -> u32 {
    let inside = if 0.0 < at { at } else { 0.0 };
    let inside = if inside < most { inside } else { most };
    (inside + 8_388_608.0).to_bits() & 0x7f_ffff
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_seeds::for_each_seed;

    fn random_rect(rng: &mut fastrand::Rng, tiles: &TileGrid) -> TileRect {
        let min = [rng.f32() * 99.0, rng.f32() * 69.0];
        let max = min.map(|start| start + 1.0 + rng.f32() * 40.0);
        tiles.tiles_of(&tiles.pixels_within(min, max).unwrap())
    }

    /// Against the definition, for any number of threads.
    #[test]
    fn toss_is_a_stable_sort_by_tile() {
        for_each_seed(1, |mut rng| {
            let tiles = TileGrid::new([100, 70], 16, 0);
            let rects: Vec<_> = (0..40_000).map(|_| random_rect(&mut rng, &tiles)).collect();
            let expected = |tile_idx: usize, n_splats: usize| {
                let (x, y) = ((tile_idx % tiles.n_x) as u16, (tile_idx / tiles.n_x) as u16);
                let holds = move |r: &TileRect| {
                    (r.min[0]..=r.max[0]).contains(&x) && (r.min[1]..=r.max[1]).contains(&y)
                };
                rects[..n_splats].iter().enumerate().filter(move |(_, r)| holds(r))
            };
            let mut buckets = TileBuckets::default();
            for (n_threads, n_splats) in [(1, 40_000), (3, 20_000), (8, 40_000), (2, 0)] {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
                let frame = FrameHandle::new();
                pool.install(|| buckets.toss(&tiles, n_splats, |i| rects[i], &frame)).unwrap();
                for tile_idx in 0..tiles.n_tiles() {
                    let expected: Vec<usize> =
                        expected(tile_idx, n_splats).map(|(i, _)| i).collect();
                    assert_eq!(buckets.on_tile(tile_idx).collect::<Vec<_>>(), expected);
                    assert_eq!(buckets.n_on_tile(tile_idx), expected.len());
                }
            }
        });
    }

    /// Enough runs to balance the load, but none whose starts outweigh its splats or whose entries leave 32
    /// bits.
    #[test]
    fn toss_takes_runs_of_middle_length() {
        let check = |n_splats: usize, size: [u32; 2], n_runs: usize| {
            let mut buckets = TileBuckets::default();
            let (tiles, frame) = (TileGrid::new(size, 1, 0), FrameHandle::new());
            buckets.toss(&tiles, n_splats, |_| TileRect::EMPTY, &frame).unwrap();
            assert_eq!(buckets.n_runs, n_runs, "{n_splats} splats on {size:?} tiles");
        };
        check(1 << 14, [5, 7], 1);
        check(40_000, [5, 7], 3);
        check(1 << 22, [5, 7], 64);
        check(300_000, [150, 150], 4);
        check(10_000, [1024, 1024], 3);
    }

    #[test]
    fn toss_holds_entries_and_names() {
        let tiles = TileGrid::new([5, 7], 1, 0);
        let mut buckets = TileBuckets::default();
        let rect = |splat| {
            let tile = [splat as u16 % 5, splat as u16 % 7];
            TileRect { min: tile, max: tile }
        };
        buckets.toss(&tiles, 16_000, rect, &FrameHandle::new()).unwrap();
        let least = 16_000 * (size_of::<TileEntry>() + size_of::<u32>());
        assert!((least..3 * least).contains(&buckets.resident_bytes()));
        let run = &buckets.runs[0];
        assert!(run.toss.resident_bytes() < buckets.resident_bytes());
    }

    #[test]
    fn tiles_stand_row_by_row() {
        let tiles = TileGrid::new([100, 70], 16, 0);
        assert_eq!((tiles.n_x, tiles.n_y, tiles.n_tiles()), (7, 5, 35));
        assert_eq!(
            [0, 6, 7, 34].map(|tile| tiles.origin(tile)),
            [[0, 0], [96, 0], [0, 16], [96, 64]]
        );
    }

    /// Every pixel is on the tiles whose sides hold it, borders too.
    #[test]
    fn tiles_with_borders_overlap() {
        for (side, border) in [(32, 1), (32, 0), (7, 3), (1, 0), (5, 1)] {
            let size = [70, 9];
            let tiles = TileGrid::new(size, side, border);
            assert_eq!(tiles.border(), border);
            let end = size.map(|n| n + 2 * border as u32);
            for (x, y) in (0..end[0]).flat_map(|x| (0..end[1]).map(move |y| (x, y))) {
                let pixel = PixelRect { min: [x, y], end: [x + 1, y + 1] };
                let TileRect { min, max } = tiles.tiles_of(&pixel);
                for tile in 0..tiles.n_tiles() {
                    let origin = tiles.origin(tile);
                    let position = [tile % tiles.n_x, tile / tiles.n_x];
                    let holds = |axis: usize| {
                        let at = [x, y][axis] as usize;
                        (origin[axis]..origin[axis] + side).contains(&at)
                    };
                    let is_in = |axis: usize| {
                        (usize::from(min[axis])..=usize::from(max[axis])).contains(&position[axis])
                    };
                    let expected = holds(0) && holds(1);
                    assert_eq!(is_in(0) && is_in(1), expected, "{side} {border} {x} {y} {tile}");
                }
            }
        }
    }

    #[test]
    fn toss_touches_pixels_with_centers_inside() {
        let tiles = TileGrid::new([64, 32], 16, 0);
        let check = |min, max, pixels: [[u32; 2]; 2], on: [[u16; 2]; 2]| {
            let rect = PixelRect { min: pixels[0], end: pixels[1] };
            assert_eq!(tiles.pixels_within(min, max), Some(rect));
            assert_eq!(tiles.tiles_of(&rect), TileRect { min: on[0], max: on[1] });
        };
        check([0.5, 0.5], [0.5, 0.5], [[0, 0], [1, 1]], [[0, 0], [0, 0]]);
        check([15.6, 0.0], [16.5, 20.0], [[16, 0], [17, 20]], [[1, 0], [1, 1]]);
        check([-50.0, -50.0], [500.0, 500.0], [[0, 0], [64, 32]], [[0, 0], [3, 1]]);
        let none = |min, max| assert_eq!(tiles.pixels_within(min, max), None);
        none([0.0, 0.0], [0.4, 0.4]);
        none([64.0, 0.0], [70.0, 5.0]);
        none([-9.0, 0.0], [-1.0, 5.0]);
        none([0.0, -9.0], [5.0, -1.0]);
        none([f32::NAN; 2], [f32::NAN; 2]);
    }
}
