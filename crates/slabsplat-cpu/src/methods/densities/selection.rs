//! Which voxels are splatted: all that can have a part in a pixel that shows.
//!
//! A density is a mean of values, so it lies between the least and the largest of those that have a part in
//! it. Values are coded by where they lie among the visible ranges: `2·n` in the gap below range `n`, `2·n +
//! 1` inside of it. If all voxels that share a place with a voxel, or a place that a gradient there is taken
//! from, have one and the same gap for their code, then nothing shows in any of these places, with or without
//! that voxel, and it is left out. The picture is the same to the last bit.

use rayon::prelude::*;
use slabsplat_core::{IsoRange, Volume};

/// Codes of voxels, or of neighbourhoods of them: the least and the largest.
struct Codes {
    dims: [usize; 3],
    least: Vec<u8>,
    largest: Vec<u8>,
}

/// The voxels of `volume` that have a visible density between the values within `margin` steps along every
/// axis, in memory order. `ranges` are the visible ones. NaN voxels are never among them.
pub(super) fn select(volume: &Volume, ranges: &[IsoRange], margin: [usize; 3]) -> Vec<u32> {
    let mut codes = Codes::new(volume, ranges);
    for (axis, margin) in margin.into_iter().enumerate() {
        codes.widen(axis, margin);
    }
    let may_show = |voxel_idx: usize| {
        let (least, largest) = (codes.least[voxel_idx], codes.largest[voxel_idx]);
        least < largest || (least == largest && is_inside(least))
    };
    let chunk = |chunk_idx: usize| {
        let first = chunk_idx * CHUNK;
        let end = (first + CHUNK).min(codes.least.len());
        (first..end)
            .filter(|&idx| may_show(idx) && !volume.value(idx).is_nan())
            .map(|idx| idx as u32)
            .collect::<Vec<_>>()
    };
    let n_chunks = codes.least.len().div_ceil(CHUNK);
    (0..n_chunks).into_par_iter().flat_map_iter(chunk).collect()
}

/// Voxels that a thread takes on at a time.
const CHUNK: usize = 1 << 16;

/// What a NaN voxel counts as: nothing.
const NOTHING: (u8, u8) = (u8::MAX, 0);

fn is_inside(code: u8) -> bool {
    code % 2 == 1
}

/// Where `value` lies among `ranges`. More than 127 ranges are one from the last on, which only keeps more
/// voxels.
fn code(value: f64, ranges: &[IsoRange]) -> (u8, u8) {
    if value.is_nan() {
        return NOTHING;
    }
    let n_below = ranges.partition_point(|range| range.hi < value);
    let is_inside = ranges.get(n_below).is_some_and(|range| range.lo <= value);
    let code = (2 * n_below + usize::from(is_inside)).min(u8::MAX.into()) as u8;
    (code, code)
}

impl Codes {
    fn new(volume: &Volume, ranges: &[IsoRange]) -> Self {
        let n_voxels = volume.grid().n_voxels();
        let codes = (0..n_voxels).into_par_iter().with_min_len(CHUNK);
        let (least, largest) = codes.map(|idx| code(volume.value(idx), ranges)).unzip();
        Self { dims: volume.grid().dims(), least, largest }
    }

    /// Makes every code that of all voxels within `margin` steps along `axis`.
    fn widen(&mut self, axis: usize, margin: usize) {
        let mut reached = 0;
        while reached < margin {
            // Three windows side by side, or overlapping, make one.
            let step = (2 * reached + 1).min(margin - reached);
            self.least = self.joined(&self.least, axis, step, u8::min);
            self.largest = self.joined(&self.largest, axis, step, u8::max);
            reached += step;
        }
    }

    /// Joins every code with those `step` voxels before and after it along `axis`.
    fn joined(&self, codes: &[u8], axis: usize, step: usize, join: fn(u8, u8) -> u8) -> Vec<u8> {
        let stride: usize = self.dims[..axis].iter().product();
        let (offset, block) = (step * stride, stride * self.dims[axis]);
        let mut out = codes.to_vec();
        // A block is a run of memory within which a step along the axis never leaves the grid.
        let blocks = out.par_chunks_mut(block).zip(codes.par_chunks(block));
        blocks.with_min_len(CHUNK.div_ceil(block)).for_each(|(out, codes)| {
            let fold = |out: &mut [u8], codes: &[u8]| {
                out.iter_mut().zip(codes).for_each(|(out, &code)| *out = join(*out, code));
            };
            let n_moved = codes.len().saturating_sub(offset);
            if 0 < n_moved {
                fold(&mut out[..n_moved], &codes[offset..]);
                fold(&mut out[offset..], &codes[..n_moved]);
            }
            // The window of a voxel outside of the grid reaches into it no further than that of the last one
            // inside.
            let last = codes.len() - stride;
            for out in out[n_moved..].chunks_mut(stride) {
                fold(out, &codes[last..]);
            }
            for out in out[..codes.len() - n_moved].chunks_mut(stride) {
                fold(out, &codes[..stride]);
            }
        });
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::{Grid, Scaling};
    use slabsplat_seeds::for_each_seed;

    /// Against the definition, one voxel after the other.
    #[test]
    fn selection_is_a_search_of_every_box() {
        for_each_seed(1, |mut rng| {
            for _ in 0..40 {
                let dims = [0; 3].map(|_| rng.usize(1..9));
                let grid = Grid::with_spacing(dims, [1.0; 3]).unwrap();
                let common = rng.u8(..4);
                let value = |rng: &mut fastrand::Rng| match rng.u8(..60) {
                    0 => f32::NAN,
                    1..6 => f32::from(rng.u8(..9)),
                    _ => f32::from(common),
                };
                let samples: Vec<f32> = (0..grid.n_voxels()).map(|_| value(&mut rng)).collect();
                let volume = Volume::new(grid, samples.into(), Scaling::IDENTITY).unwrap();
                let ranges =
                    [IsoRange { lo: 0.5, hi: 1.5 }, IsoRange { lo: 5.0, hi: f64::INFINITY }];
                let margin = [0; 3].map(|_| rng.usize(..6));
                let margin = [0, 1, 2].map(|axis| margin[axis].min(dims[axis]));
                let expected: Vec<u32> = (0..grid.n_voxels())
                    .filter(|&idx| may_show(&volume, &ranges, margin, idx))
                    .map(|idx| idx as u32)
                    .collect();
                assert_eq!(select(&volume, &ranges, margin), expected, "{dims:?} {margin:?}");
            }
        });
    }

    fn may_show(volume: &Volume, ranges: &[IsoRange], margin: [usize; 3], idx: usize) -> bool {
        let grid = volume.grid();
        let at = grid.voxel_coords(idx);
        let is_near = |other: &usize| {
            let other = grid.voxel_coords(*other);
            (0..3).all(|axis| at[axis].abs_diff(other[axis]) <= margin[axis])
        };
        let values: Vec<f64> = (0..grid.n_voxels())
            .filter(is_near)
            .map(|other| volume.value(other))
            .filter(|value| !value.is_nan())
            .collect();
        let lo = values.iter().copied().fold(f64::INFINITY, f64::min);
        let hi = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        !volume.value(idx).is_nan() && ranges.iter().any(|r| r.lo <= hi && lo <= r.hi)
    }
}
