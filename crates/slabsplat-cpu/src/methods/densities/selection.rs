//! Which voxels are splatted: all that can have a part in a pixel that shows.
//!
//! A sheet's density is a mean of values, so it lies between the least and the largest of those that have a
//! part in it, and what is shown of several sheets not further outside than a part of their distance. Values
//! are coded by eight bits, rounded to the side on which more shows. If what may come of the voxels that
//! share a point with a voxel, or a point that a density or a gradient there is taken from, lies in no
//! visible range, then nothing shows in any of these points, with or without that voxel, and it is left out.
//! An exact picture is the same but for rounding, as a mean of values at the end of a visible range may come
//! to lie within it. By default it differs by what separable footprints and outer sheets have beyond what
//! `reach.rs` counts: 3·10⁻⁴ at most in 16,000 random frames, on a surface that is a plateau's.
//!
//! The least and the largest are found in boxes, axis by axis. Voxels at their corners are further away than
//! any voxel reaches. So there must also be, within an ellipsoid of half the volume, a value as large as the
//! largest is at least wherever anything shows, and one as small.

use super::bit_rows::BitRows;
use super::codes::{CodeBlock, Coder};
use super::reach::Reach;
use rayon::prelude::*;
use slabsplat_core::{Cancelled, FrameHandle, IsoRange, Volume};
use slabsplat_traverse::{BRICK_SIDE, Brick, BrickGrid};
use std::ops::Range;

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

/// Bricks that are looked at together, along each axis.
const BLOCK: [usize; 3] = [64, 8, 8];

impl Selection {
    /// The voxels of `volume` that have a visible density between the values within `reach`, or `beyond`
    /// these by such a part of their distance. `finite` is the range of finite values, `ranges` are the
    /// visible ones. NaN voxels are never among them.
    pub(super) fn new(
        volume: &Volume,
        finite: Option<[f64; 2]>,
        shown: (&[IsoRange], f64),
        reach: &Reach,
        frame: &FrameHandle,
    ) -> Result<Self, Cancelled> {
        Self::by_blocks(volume, finite, shown, reach, BLOCK, frame)
    }

    /// The same, so many bricks together.
    fn by_blocks(
        volume: &Volume,
        finite: Option<[f64; 2]>,
        shown: (&[IsoRange], f64),
        reach: &Reach,
        block: [usize; 3],
        frame: &FrameHandle,
    ) -> Result<Self, Cancelled> {
        let coder = Coder::new(finite);
        let may_show = coder.visible_pairs(shown, frame)?;
        let rows = reach.rows();
        let search = Search { volume, coder, grid: BrickGrid::new(volume.grid()), may_show, frame };
        let needed = if rows.is_empty() { [None, None] } else { search.needed() };
        let needed = needed.map(|bits| bits.map(|bits| bits.spread(&rows, frame)));
        let select = |codes: &mut CodeBlock, bricks| {
            // Of a frame that is cancelled it does not matter.
            search.select(codes, bricks, reach.margin, &needed).unwrap_or_default()
        };
        let blocks = blocks(search.grid.n_along(), block).into_par_iter();
        let selected = blocks.map_init(CodeBlock::default, select);
        let mut selected: Vec<(u32, Mask)> = selected.flatten_iter().collect();
        frame.check()?;
        selected.par_sort_unstable_by_key(|(brick_idx, _)| *brick_idx);
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

/// Bricks in blocks of so many along each axis.
fn blocks(n_along: [usize; 3], block: [usize; 3]) -> Vec<[Range<usize>; 3]> {
    let [xs, ys, zs] = [0, 1, 2].map(|axis: usize| {
        let starts = (0..n_along[axis]).step_by(block[axis]);
        starts.map(move |start| start..n_along[axis].min(start + block[axis]))
    });
    let rows = zs.flat_map(|z| ys.clone().map(move |y| (y, z.clone())));
    rows.flat_map(|(y, z)| xs.clone().map(move |x| [x, y.clone(), z.clone()])).collect()
}

/// What is selected from, and by what.
struct Search<'a> {
    volume: &'a Volume,
    coder: Coder,
    grid: BrickGrid,
    /// By the least and the largest code.
    may_show: Vec<[bool; 256]>,
    frame: &'a FrameHandle,
}

/// Voxels that a thread takes on at a time.
const CHUNK: usize = 1 << 16;

impl Search<'_> {
    /// The voxels one of which is near wherever anything shows: those with codes as large as the largest one
    /// there is at least, and those with codes as small; `None` where all voxels would be meant.
    fn needed(&self) -> [Option<BitRows>; 2] {
        let Self { volume, coder, may_show, frame, .. } = self;
        let [first, last] = self.ends();
        let largest =
            (first..=last).find(|&code| (first..=code).any(|least| may_show[least][code]));
        let least =
            (first..=last).rev().find(|&code| (code..=last).any(|largest| may_show[code][largest]));
        let rows = |is_meant: &(dyn Fn(usize) -> bool + Sync)| {
            let of_voxel = |idx| coder.code_of(volume, idx).map(usize::from);
            BitRows::of(volume.grid().dims(), frame, |idx| of_voxel(idx).is_some_and(is_meant))
        };
        let large = largest.filter(|&code| first < code).map(|code| rows(&|of| code <= of));
        let small = least.filter(|&code| code < last).map(|code| rows(&|of| of <= code));
        [large, small]
    }

    /// The least and the largest code that there is; any, if the frame is cancelled.
    fn ends(&self) -> [usize; 2] {
        let Self { volume, coder, frame, .. } = self;
        let n_voxels = volume.grid().n_voxels();
        let chunks = (0..n_voxels.div_ceil(CHUNK)).into_par_iter();
        let of_chunk = |chunk: usize| {
            let idxs = chunk * CHUNK..n_voxels.min((chunk + 1) * CHUNK);
            let codes = idxs.filter_map(|idx| coder.code_of(volume, idx));
            codes.fold(NO_CODES, |[least, largest], code| [least.min(code), largest.max(code)])
        };
        let ends = chunks.filter(|_| !frame.is_cancelled()).map(of_chunk);
        let ends = ends.reduce(|| NO_CODES, |[a, b], [c, d]| [a.min(c), b.max(d)]);
        ends.map(usize::from)
    }

    /// The bricks of a block that hold any voxels, and which.
    fn select(
        &self,
        codes: &mut CodeBlock,
        bricks: [Range<usize>; 3],
        margin: [usize; 3],
        needed: &[Option<BitRows>; 2],
    ) -> Result<Vec<(u32, Mask)>, Cancelled> {
        let dims = self.grid.dims();
        let voxels = [0, 1, 2].map(|axis: usize| {
            let Range { start, end } = bricks[axis];
            BRICK_SIDE * start..dims[axis].min(BRICK_SIDE * end)
        });
        codes.make((self.volume, &self.coder), &voxels, margin, self.frame)?;
        let [xs, ys, zs] = bricks;
        let mut selected = Vec::new();
        for (z, y) in zs.flat_map(|z| ys.clone().map(move |y| (z, y))) {
            self.frame.check()?;
            for x in xs.clone() {
                let brick_idx = self.grid.brick_idx([x, y, z]);
                let mask = self.mask(codes, brick_idx, needed);
                if mask.iter().any(|bits| *bits != 0) {
                    selected.push((brick_idx, mask));
                }
            }
        }
        Ok(selected)
    }

    /// The voxels of a brick that may have a part in what shows.
    fn mask(&self, codes: &CodeBlock, brick_idx: u32, needed: &[Option<BitRows>; 2]) -> Mask {
        let Self { volume, grid, may_show, .. } = self;
        let origin = grid.origin(brick_idx);
        let [n_x, n_y, n_z] = grid.size_at(origin);
        let mut mask = [0; BRICK_SIDE];
        for (z, y) in (0..n_z).flat_map(|z| (0..n_y).map(move |y| (z, y))) {
            let at = [origin[0], origin[1] + y, origin[2] + z];
            let first = grid.voxel_idx(at);
            let [least, largest] = codes.row(at[0]..at[0] + n_x, at[1], at[2]);
            for (x, (&least, &largest)) in least.iter().zip(largest).enumerate() {
                let idx = first + x;
                let is_selected = may_show[usize::from(least)][usize::from(largest)]
                    && needed.iter().flatten().all(|near| near.holds(idx))
                    && !volume.value(idx).is_nan();
                mask[z] |= u64::from(is_selected) << (y * BRICK_SIDE + x);
            }
        }
        mask
    }
}

/// The least and the largest code of no value at all.
const NO_CODES: [u8; 2] = [u8::MAX, 0];

fn set_bits(mut bits: u64) -> impl Iterator<Item = u16> {
    std::iter::from_fn(move || {
        let bit = bits.trailing_zeros() as u16;
        bits &= bits.checked_sub(1)?;
        Some(bit)
    })
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
                let block = [0; 3].map(|_| rng.usize(1..4));
                let selection = Selection::by_blocks(&volume, finite, shown, &reach, block, &frame);
                let selection = selection.expect("nobody cancels it");
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
