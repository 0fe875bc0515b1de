//! Which voxels are splatted: all that can have a part in a pixel that shows.
//!
//! A sheet's density is a mean of values, so it lies between the least and the largest of those that have a
//! part in it, and what is shown of several sheets not further outside than a part of their distance. Values
//! are coded by eight bits, rounded to the side on which more shows. If what may come of the voxels that
//! share a point with a voxel, or a point that a density or a gradient there is taken from, lies in no
//! visible range, then nothing shows in any of these points, with or without that voxel, and it is left out.
//! An exact picture is the same but for rounding, as a mean of values at the end of a visible range may come
//! to lie within it. By default it differs by what separable footprints and outer sheets have beyond what
//! `reach.rs` counts: less than can be seen.
//!
//! The least and the largest are found in boxes, axis by axis. Voxels at their corners are further away than
//! any voxel reaches. So there must also be, within an ellipsoid of half the volume, a value as large as the
//! largest is at least wherever anything shows, and one as small.

use super::bit_rows::BitRows;
use super::reach::Reach;
use rayon::prelude::*;
use slabsplat_core::{Cancelled, FrameHandle, IsoRange, Volume};
use slabsplat_traverse::{BRICK_SIDE, Brick, BrickGrid};

/// The voxels that are splatted, by brick.
#[derive(Debug)]
pub(super) struct Selection {
    /// Those that hold any, in memory order.
    pub(super) bricks: Vec<Brick>,
    /// Which voxels, a bit each; of all the bricks.
    masks: Vec<Mask>,
    pub(super) n_voxels: usize,
}

/// A brick's voxels: a bit each, by slot.
type Mask = [u64; BRICK_SIDE];

/// How far outside of densities those at nodes may lie, and between these, as a part of their distance (model
/// §8).
pub(super) const BEYOND_AT_NODES: f64 = 1.0 / 12.0;

/// The same of a peak among three nodes (model §12), half way from one to the next at most: there it is three
/// quarters of the one, three eighths of the other, and less an eighth of the third, so that it lies outside
/// of nodes by an eighth of their distance.
pub(super) const BEYOND_AT_PEAKS: f64 = BEYOND_AT_NODES + 0.125 * (1.0 + 2.0 * BEYOND_AT_NODES);

impl Selection {
    /// The voxels of `volume` that have a visible density between the values within `reach`, or `beyond`
    /// these by such a part of their distance. `finite` is the range of finite values, `ranges` are the
    /// visible ones. NaN voxels are never among them.
    pub(super) fn new(
        volume: &Volume,
        finite: Option<[f64; 2]>,
        (ranges, beyond): (&[IsoRange], f64),
        reach: &Reach,
        frame: &FrameHandle,
    ) -> Result<Self, Cancelled> {
        let coder = Coder::new(finite);
        let mut codes = Codes::new(volume, &coder, frame)?;
        let may_show = coder.visible_pairs((ranges, beyond), frame)?;
        let rows = reach.rows();
        let needed = if rows.is_empty() { [None, None] } else { codes.needed(&may_show) };
        let needed = needed.map(|bits| bits.map(|bits| bits.spread(&rows, frame)));
        for (axis, margin) in reach.margin.into_iter().enumerate() {
            codes.widen(axis, margin)?;
        }
        let grid = BrickGrid::new(volume.grid());
        let mask = |brick_idx: u32| {
            if frame.is_cancelled() {
                return None;
            }
            let mask = codes.mask(&grid, brick_idx, |idx, least, largest| {
                may_show[usize::from(least)][usize::from(largest)]
                    && needed.iter().flatten().all(|near| near.holds(idx))
                    && !volume.value(idx).is_nan()
            });
            mask.iter().any(|bits| *bits != 0).then_some((brick_idx, mask))
        };
        let n_bricks = grid.n_bricks() as u32;
        let selected: Vec<(u32, Mask)> = (0..n_bricks).into_par_iter().filter_map(mask).collect();
        frame.check()?;
        let brick = |(first, &(brick_idx, mask)): (usize, &(u32, Mask))| {
            let n_voxels = mask.iter().map(|bits| bits.count_ones() as u16).sum();
            Brick { brick_idx, first: first as u32, n_voxels }
        };
        let bricks: Vec<Brick> = selected.iter().enumerate().map(brick).collect();
        Ok(Self {
            n_voxels: bricks.iter().map(|brick| usize::from(brick.n_voxels)).sum(),
            bricks,
            masks: selected.into_iter().map(|(_, mask)| mask).collect(),
        })
    }

    /// The slots of a brick's voxels, rising.
    pub(super) fn slots_of(&self, brick: &Brick) -> impl Iterator<Item = u16> + '_ {
        let words = self.masks[brick.first as usize].iter().enumerate();
        words.flat_map(|(word, &bits)| {
            let first = (word * u64::BITS as usize) as u16;
            set_bits(bits).map(move |bit| first + bit)
        })
    }

    pub(super) fn resident_bytes(&self) -> usize {
        self.bricks.capacity() * size_of::<Brick>() + self.masks.capacity() * size_of::<Mask>()
    }
}

fn set_bits(mut bits: u64) -> impl Iterator<Item = u16> {
    std::iter::from_fn(move || {
        let bit = bits.trailing_zeros() as u16;
        bits &= bits.checked_sub(1)?;
        Some(bit)
    })
}

/// Takes values to codes: finite ones to `FIRST..=LAST`, infinities to what lies beside. The least and the
/// largest value have codes of their own, since what is around an object often has one value, and the object
/// is visible from the next one on.
#[derive(Clone, Copy, Debug)]
struct Coder {
    ends: [f64; 2],
    /// Half of the least value, and of the extent of all, so that no difference is infinite.
    half_least: f64,
    half_extent: f64,
}

const FIRST: u8 = 1;
const LAST: u8 = 253;

/// Codes between the least and the largest value's.
const N_BETWEEN: f64 = (LAST - FIRST - 1) as f64;

/// What a NaN voxel counts as: nothing.
const NOTHING: (u8, u8) = (u8::MAX, 0);

impl Coder {
    fn new(finite: Option<[f64; 2]>) -> Self {
        let [lo, hi] = finite.unwrap_or([0.0; 2]);
        Self { ends: [lo, hi], half_least: 0.5 * lo, half_extent: 0.5 * hi - 0.5 * lo }
    }

    fn code(&self, value: f64) -> u8 {
        if value.is_infinite() {
            return if value < 0.0 { FIRST - 1 } else { LAST + 1 };
        }
        if value <= self.ends[0] {
            return FIRST;
        }
        if self.ends[1] <= value {
            return LAST;
        }
        let between = (0.5 * value - self.half_least) / self.half_extent;
        FIRST + 1 + (between * N_BETWEEN).clamp(0.0, N_BETWEEN - 1.0) as u8
    }

    /// Half of what a code's values are at least, and of what they are at most. Between the ends a code's
    /// width is added on either side for rounding.
    fn half_ends(&self, code: u8) -> [f64; 2] {
        let step = self.half_extent / N_BETWEEN;
        let end = |steps: f64| self.half_least + steps * step;
        match code {
            ..FIRST => [f64::NEG_INFINITY, end(1.0)],
            FIRST => [0.5 * self.ends[0]; 2],
            LAST => [0.5 * self.ends[1]; 2],
            code if code < LAST => {
                let steps = f64::from(code - FIRST - 1);
                [end(steps - 1.0), end(steps + 2.0)]
            }
            _ => [end(N_BETWEEN - 1.0), f64::INFINITY],
        }
    }

    /// Whether anything shows between values of a least and a largest code, and as far outside as densities
    /// may lie.
    fn visible_pairs(
        &self,
        (ranges, beyond): (&[IsoRange], f64),
        frame: &FrameHandle,
    ) -> Result<Vec<[bool; 256]>, Cancelled> {
        let is_visible = |least: usize, largest: usize| {
            // Half of the least number above 0 is 0: where all is of one value, it is that which counts.
            for (code, value) in [FIRST, LAST].into_iter().zip(self.ends) {
                if [least, largest] == [usize::from(code); 2] {
                    return ranges.iter().any(|range| (range.lo..=range.hi).contains(&value));
                }
            }
            let lo = self.half_ends(least as u8)[0];
            let hi = self.half_ends(largest as u8)[1];
            let over = beyond * (hi - lo);
            let (lo, hi) = (lo - over, hi + over);
            ranges.iter().any(|range| 0.5 * range.lo <= hi && lo <= 0.5 * range.hi)
        };
        let row = |least: usize| {
            frame.check()?;
            Ok(std::array::from_fn(|largest| least <= largest && is_visible(least, largest)))
        };
        (0..256).map(row).collect()
    }
}

/// Codes of voxels, or of neighbourhoods of them: the least and the largest.
struct Codes<'a> {
    frame: &'a FrameHandle,
    dims: [usize; 3],
    least: Vec<u8>,
    largest: Vec<u8>,
}

/// Voxels that a thread takes on at a time.
const CHUNK: usize = 1 << 16;

/// Bytes that are copied between two looks at whether anyone still wants them: half a millisecond.
const COPIED_AT_ONCE: usize = 1 << 20;

impl<'a> Codes<'a> {
    fn new(volume: &Volume, coder: &Coder, frame: &'a FrameHandle) -> Result<Self, Cancelled> {
        let n_voxels = volume.grid().n_voxels();
        let code = |value: f64| {
            if value.is_nan() { NOTHING } else { (coder.code(value), coder.code(value)) }
        };
        let (mut least, mut largest) = (vec![0; n_voxels], vec![0; n_voxels]);
        let chunks = least.par_chunks_mut(CHUNK).zip(largest.par_chunks_mut(CHUNK)).enumerate();
        chunks.filter(|_| !frame.is_cancelled()).for_each(|(chunk, (least, largest))| {
            for (idx, codes) in (chunk * CHUNK..).zip(least.iter_mut().zip(largest)) {
                (*codes.0, *codes.1) = code(volume.value(idx));
            }
        });
        frame.check()?;
        Ok(Self { frame, dims: volume.grid().dims(), least, largest })
    }

    /// The voxels one of which is near wherever anything shows: those with codes as large as the largest one
    /// there is at least, and those with codes as small; `None` where all voxels would be meant.
    fn needed(&self, may_show: &[[bool; 256]]) -> [Option<BitRows>; 2] {
        let [first, last] = self.ends();
        let largest =
            (first..=last).find(|&code| (first..=code).any(|least| may_show[least][code]));
        let least =
            (first..=last).rev().find(|&code| (code..=last).any(|largest| may_show[code][largest]));
        let large = largest
            .filter(|&code| first < code)
            .map(|code| self.rows(|idx| code <= usize::from(self.largest[idx])));
        let small = least
            .filter(|&code| code < last)
            .map(|code| self.rows(|idx| usize::from(self.least[idx]) <= code));
        [large, small]
    }

    /// The least and the largest code that there is; 0 if the frame is cancelled.
    fn ends(&self) -> [usize; 2] {
        let wanted = |_: &&[u8]| !self.frame.is_cancelled();
        let chunks = |codes| <[u8]>::par_chunks(codes, CHUNK).filter(wanted);
        let least = chunks(&self.least).map(|codes| codes.iter().fold(u8::MAX, |a, &b| a.min(b)));
        let largest = chunks(&self.largest).map(|codes| codes.iter().fold(0, |a, &b| a.max(b)));
        [least.min(), largest.max()].map(|end| end.map_or(0, usize::from))
    }

    fn rows(&self, is_meant: impl Fn(usize) -> bool + Sync) -> BitRows {
        BitRows::of(self.dims, self.frame, is_meant)
    }

    /// The voxels of a brick of which `is_meant`, given their indices in memory and their codes.
    fn mask(
        &self,
        grid: &BrickGrid,
        brick_idx: u32,
        is_meant: impl Fn(usize, u8, u8) -> bool,
    ) -> Mask {
        let origin = grid.origin(brick_idx);
        let [n_x, n_y, n_z] = grid.size_at(origin);
        let mut mask = [0; BRICK_SIDE];
        for (z, y) in (0..n_z).flat_map(|z| (0..n_y).map(move |y| (z, y))) {
            let first = grid.voxel_idx([origin[0], origin[1] + y, origin[2] + z]);
            for x in 0..n_x {
                let idx = first + x;
                let bit = u64::from(is_meant(idx, self.least[idx], self.largest[idx]));
                mask[z] |= bit << (y * BRICK_SIDE + x);
            }
        }
        mask
    }

    /// Makes every code that of all voxels within `margin` steps along `axis`.
    fn widen(&mut self, axis: usize, margin: usize) -> Result<(), Cancelled> {
        let mut reached = 0;
        while reached < margin {
            // Three windows side by side, or overlapping, make one.
            let step = (2 * reached + 1).min(margin - reached);
            self.least = self.joined(&self.least, axis, step, u8::min)?;
            self.largest = self.joined(&self.largest, axis, step, u8::max)?;
            reached += step;
        }
        Ok(())
    }

    /// Joins every code with those `step` voxels before and after it along `axis`.
    fn joined(
        &self,
        codes: &[u8],
        axis: usize,
        step: usize,
        join: fn(u8, u8) -> u8,
    ) -> Result<Vec<u8>, Cancelled> {
        let stride: usize = self.dims[..axis].iter().product();
        let (offset, block) = (step * stride, stride * self.dims[axis]);
        let mut out = Vec::with_capacity(codes.len());
        for codes in codes.chunks(COPIED_AT_ONCE) {
            self.frame.check()?;
            out.extend_from_slice(codes);
        }
        // A block is a run of memory within which a step along the axis never leaves the grid.
        let blocks = out.par_chunks_mut(block).zip(codes.par_chunks(block));
        blocks.with_min_len(CHUNK.div_ceil(block)).for_each(|(out, codes)| {
            let fold = |out: &mut [u8], codes: &[u8]| {
                let chunks = out.chunks_mut(CHUNK).zip(codes.chunks(CHUNK));
                for (out, codes) in chunks.take_while(|_| !self.frame.is_cancelled()) {
                    out.iter_mut().zip(codes).for_each(|(out, &code)| *out = join(*out, code));
                }
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
        self.frame.check()?;
        Ok(out)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::glam::{DMat3, DVec3};
    use slabsplat_core::{Grid, Scaling};
    use slabsplat_seeds::for_each_seed;
    use slabsplat_traverse::VoxelRecord;

    /// Against the definition, one voxel after the other: all that may show, and nothing that is farther from
    /// it than codes are wide.
    #[test]
    fn selection_is_a_search_of_every_box() {
        for_each_seed(1, |mut rng| {
            for _ in 0..40 {
                let dims = [0; 3].map(|_| rng.usize(1..19));
                let grid = Grid::with_spacing(dims, [1.0; 3]).unwrap();
                let common = rng.u8(..4);
                let value = |rng: &mut fastrand::Rng| match rng.u8(..60) {
                    0 => f32::NAN,
                    1 => [f32::INFINITY, f32::NEG_INFINITY][rng.usize(..2)],
                    2..6 => f32::from(rng.u8(..9)),
                    _ => f32::from(common),
                };
                let samples: Vec<f32> = (0..grid.n_voxels()).map(|_| value(&mut rng)).collect();
                let volume = Volume::new(grid, samples.into(), Scaling::IDENTITY).unwrap();
                let ranges =
                    [IsoRange { lo: 0.5, hi: 1.5 }, IsoRange { lo: 5.0, hi: f64::INFINITY }];
                let ranges = &ranges[rng.usize(..2)..];
                // What lies between something and −∞ may be anything.
                let has_no_least =
                    (0..grid.n_voxels()).any(|idx| volume.value(idx) == f64::NEG_INFINITY);
                let margin = [0; 3].map(|_| rng.usize(..6));
                let margin = [0, 1, 2].map(|axis| margin[axis].min(dims[axis]));
                let reach = ellipsoid(margin);
                let finite = Some([0.0, 8.0]);
                let (shown, frame) = ((ranges, BEYOND_AT_NODES), FrameHandle::new());
                let selection = Selection::new(&volume, finite, shown, &reach, &frame).unwrap();
                let bricks = BrickGrid::new(&grid);
                let mut selected = vec![false; grid.n_voxels()];
                for brick in &selection.bricks {
                    assert_eq!(selection.slots_of(brick).count(), brick.n_voxels.into());
                    for slot in selection.slots_of(brick) {
                        let record = VoxelRecord { slot, normal: [0; 3] };
                        selected[bricks.voxel_idx(bricks.voxel_coords(brick, record))] = true;
                    }
                }
                assert_eq!(selected.iter().filter(|is| **is).count(), selection.n_voxels);
                for (idx, is_selected) in selected.into_iter().enumerate() {
                    let may_show = |is_near: &dyn Fn([isize; 3]) -> bool, room| {
                        may_show(&volume, ranges, is_near, room, idx)
                    };
                    let in_ellipsoid = |step: [isize; 3]| holds(&reach, step);
                    let in_box = |step: [isize; 3]| {
                        (0..3).all(|axis| step[axis].unsigned_abs() <= margin[axis])
                    };
                    assert!(
                        is_selected || !may_show(&in_ellipsoid, 0.0),
                        "{idx} {dims:?} {margin:?}"
                    );
                    assert!(!is_selected || may_show(&in_box, 0.2), "{idx} {dims:?} {margin:?}");
                    // Where all that shows is large, what is large must be near.
                    let is_sought = ranges.len() == 1 && !has_no_least;
                    assert!(
                        !is_selected || !is_sought || is_near_large(&volume, &in_ellipsoid, idx),
                        "{idx} {dims:?} {margin:?}"
                    );
                }
            }
        });
    }

    /// Steps within an ellipsoid of that extent.
    fn ellipsoid(margin: [usize; 3]) -> Reach {
        let form = margin.map(|steps| (steps as f64 + 0.01).powi(-2));
        Reach { margin, form: DMat3::from_diagonal(DVec3::from_array(form)) }
    }

    fn holds(reach: &Reach, step: [isize; 3]) -> bool {
        let step = DVec3::from_array(step.map(|steps| steps as f64));
        step.dot(reach.form * step) <= 1.0
    }

    /// The values of voxels that are near.
    fn values_near(volume: &Volume, is_near: &dyn Fn([isize; 3]) -> bool, idx: usize) -> Vec<f64> {
        let grid = volume.grid();
        let coords = |idx: usize| grid.voxel_coords(idx).map(|c| c as isize);
        let at = coords(idx);
        let step = |other: usize| [0, 1, 2].map(|axis| coords(other)[axis] - at[axis]);
        let values = (0..grid.n_voxels()).filter(|&other| is_near(step(other)));
        values.map(|other| volume.value(other)).filter(|value| !value.is_nan()).collect()
    }

    /// Whether a value is near without which nothing would show from 5 on.
    fn is_near_large(volume: &Volume, is_near: &dyn Fn([isize; 3]) -> bool, idx: usize) -> bool {
        let least = (5.0 - 0.2) / (1.0 + BEYOND_AT_NODES);
        values_near(volume, is_near, idx).iter().any(|&value| least <= value)
    }

    fn may_show(
        volume: &Volume,
        ranges: &[IsoRange],
        is_near: &dyn Fn([isize; 3]) -> bool,
        room: f64,
        idx: usize,
    ) -> bool {
        let values = values_near(volume, is_near, idx);
        let lo = values.iter().copied().fold(f64::INFINITY, f64::min);
        let hi = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let over = if lo < hi { BEYOND_AT_NODES * (hi - lo) } else { 0.0 } + room;
        // Codes do not tell an infinity from what lies next to it.
        let is_blurred = lo.is_infinite() && 0.0 < room;
        let shows = |range: &IsoRange| range.lo <= hi + over && lo - over <= range.hi;
        !volume.value(idx).is_nan() && (is_blurred || ranges.iter().any(shows))
    }
}
