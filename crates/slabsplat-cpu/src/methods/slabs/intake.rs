//! Voxels into tiles, a range of depth at a time: cull, project, shade, toss.
//!
//! ```text
//! for every 32 bricks of the range, in parallel:
//!     for each brick that is not behind saturated blocks:
//!         project its voxels (project.rs of slabsplat-traverse)
//!         for each that is not behind saturated blocks: enter it for the tiles that it may touch
//!         colour those; find their slabs, eight at a time; make voxels of them
//!     toss the voxels onto tiles: a counting sort of the entries
//! ```
//!
//! 1. Neither a brick nor a voxel that is occluded is shaded or tossed, and a brick not even projected (the
//!    culling of Mueller et al. 1999).
//! 2. All buffers are as large as one range needs, and are used again.
//! 3. What 32 bricks toss stays with their task; a tile reads the chain of tasks, so that nothing is merged.

use super::occlusion::{Occlusion, Visibility};
use super::setup::Setup;
use super::stage::{ReadRoom, Stage};
use crate::sections::span::{Span, SpannedVoxel};
use crate::voxels::by_sheet::N_AT_ONCE;
use crate::voxels::voxel::Voxel;
use fearless_simd::{Simd, dispatch};
use rayon::prelude::*;
use slabsplat_traverse::{TileEntry, TileGrid, TileToss, VoxelRecord, Workspaces};
use std::cell::Cell;
use std::ops::Range;

/// Bricks that one task takes in. It depends on nothing, or the order of sums would.
const BRICKS_PER_TASK: usize = 32;

/// The voxels of a range, by tile.
#[derive(Debug, Default)]
pub(super) struct Intake {
    tasks: Vec<TileToss<SpannedVoxel>>,
    n_tasks: usize,
}

/// What came of a range.
pub(super) struct IntakeSummary {
    /// Relevant voxels that were not culled.
    pub(super) n_voxels: u64,
    /// The slabs to which the others go first, if there are any.
    pub(super) first_slabs: Option<Range<usize>>,
    /// The keys of bricks that are left to a finer level.
    pub(super) refused: Vec<u32>,
}

/// What a thread needs to take bricks in.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    /// Of one task.
    voxels: Vec<SpannedVoxel>,
    entries: Vec<TileEntry>,
    /// The least and the largest.
    spans: [Span; 2],
    /// The keys of bricks that are left to a finer level.
    refused: Vec<u32>,
    /// Of one brick: its voxels, where they are not listed; all its points.
    read: ReadRoom,
    points: Vec<[f32; 3]>,
    /// Those that are not culled, one after the other in `points`, and what they are made of.
    records: Vec<VoxelRecord>,
    colors: Vec<[f32; 4]>,
}

impl Intake {
    /// Takes in the voxels of `bricks`, whose second numbers are their keys.
    pub(super) fn take(
        &mut self,
        stage: &Stage<'_>,
        setup: &Setup<'_>,
        tiles: &TileGrid,
        occlusion: &Occlusion,
        bricks: &[(u32, u32)],
        scratches: &mut Workspaces<Scratch>,
    ) -> IntakeSummary {
        self.n_tasks = bricks.len().div_ceil(BRICKS_PER_TASK);
        if self.tasks.len() < self.n_tasks {
            self.tasks.resize_with(self.n_tasks, TileToss::default);
        }
        let scratches = scratches.for_all_threads();
        let tasks = self.tasks[..self.n_tasks].par_iter_mut();
        let work = tasks.zip(bricks.par_chunks(BRICKS_PER_TASK));
        let taken = work.map(|(toss, bricks)| {
            if stage.frame.is_cancelled() {
                return (0, NO_SPANS, Vec::new());
            }
            let scratch = &mut *scratches.of_this_thread();
            scratch.clear();
            let mut n_voxels = 0;
            dispatch!(stage.level, simd => {
                for &(_, key) in bricks {
                    n_voxels += scratch.take_brick(simd, stage, setup, tiles, occlusion, key);
                }
            });
            let voxel = |voxel: u32| scratch.voxels[voxel as usize];
            toss.toss(tiles, &scratch.entries, voxel, stage.frame);
            (n_voxels, scratch.spans, std::mem::take(&mut scratch.refused))
        });
        let (n_voxels, spans, refused) = taken.reduce(|| (0, NO_SPANS, Vec::new()), both);
        let [first, last] = spans.map(Span::first);
        let first_slabs = (spans != NO_SPANS).then_some(first..last + 1);
        IntakeSummary { n_voxels, first_slabs, refused }
    }

    /// The voxels on a tile, in runs, in the order of the list.
    pub(super) fn on_tile(&self, tile_idx: usize) -> impl Iterator<Item = &[SpannedVoxel]> + Clone {
        self.tasks[..self.n_tasks].iter().map(move |toss| toss.on_tile(tile_idx))
    }

    pub(super) fn resident_bytes(&self) -> usize {
        self.tasks.iter().map(TileToss::resident_bytes).sum()
    }
}

/// What two tasks took, one after the other.
fn both(
    (n, [a, b], mut refused): (u64, [Span; 2], Vec<u32>),
    (m, [c, d], others): (u64, [Span; 2], Vec<u32>),
) -> (u64, [Span; 2], Vec<u32>) {
    refused.extend(others);
    (n + m, [a.min(c), b.max(d)], refused)
}

/// The least and the largest of no span at all.
const NO_SPANS: [Span; 2] = [Span(u32::MAX), Span(0)];

impl Scratch {
    /// Makes it ready for another task.
    fn clear(&mut self) {
        self.voxels.clear();
        self.entries.clear();
        self.refused.clear();
        self.spans = NO_SPANS;
    }

    /// Adds a brick's voxels, projected and shaded; returns how many relevant ones they are.
    #[inline(always)]
    fn take_brick<S: Simd>(
        &mut self,
        simd: S,
        stage: &Stage<'_>,
        setup: &Setup<'_>,
        tiles: &TileGrid,
        occlusion: &Occlusion,
        key: u32,
    ) -> u64 {
        let brick = &stage.voxels.brick(key);
        let in_view = stage.bounds_of_brick(brick);
        if setup.beyond.as_ref().is_some_and(|beyond| beyond.hides(&in_view)) {
            return 0;
        }
        let bounds = setup.slabs.bounds_of_brick(&in_view);
        let pixels = bounds.and_then(|[min, max]| tiles.pixels_within(min, max));
        let visibility = pixels.map_or(Visibility::None, |pixels| occlusion.visibility(&pixels));
        if visibility == Visibility::None {
            return 0;
        }
        let mut room = std::mem::take(&mut self.read);
        let mut n_voxels = 0;
        match stage.voxels.read(brick, &mut room) {
            None => self.refused.push(key),
            Some(read) => {
                let records = read.records;
                self.points.resize(records.len(), [0.0; 3]);
                stage.bricks.project_brick(brick, records, &mut self.points);
                let occlusion = (visibility == Visibility::Partial).then_some(occlusion);
                self.cull(simd, setup, tiles, occlusion, records);
                self.colors.resize(self.records.len(), [0.0; 4]);
                stage.voxels.color(brick, &read, &self.records, &mut self.colors);
                self.make_voxels(simd, setup);
                let n_kept = self.records.len() as u64;
                n_voxels = read.n_voxels * n_kept / (records.len() as u64).max(1);
            }
        }
        self.read = room;
        n_voxels
    }

    /// Keeps the records and points of voxels that may be seen, and enters them for their tiles. None is
    /// occluded where there is no `occlusion`.
    #[inline(always)]
    fn cull<S: Simd>(
        &mut self,
        simd: S,
        setup: &Setup<'_>,
        tiles: &TileGrid,
        occlusion: Option<&Occlusion>,
        records: &[VoxelRecord],
    ) {
        let Self { voxels, entries, points, records: kept, .. } = self;
        kept.clear();
        let all = Cell::from_mut(points.as_mut_slice()).as_slice_of_cells();
        let first = voxels.len();
        // A copy, as nobody can tell that what is written to buffers is not these.
        let mut keeper = Keeper { tiles: *tiles, occlusion, first, entries, records: kept, all };
        if let Some(bounds) = setup.slabs.bounds_in_all() {
            for (record, point) in records.iter().zip(all) {
                keeper.keep_if_seen(record, point.get(), bounds.at(point.get()));
            }
            return;
        }
        for (records, points) in records.chunks(N_AT_ONCE).zip(all.chunks(N_AT_ONCE)) {
            let [first, last] = setup.spans.met(simd, &eight(points, |point| point.get()[2]));
            for (idx, (record, point)) in records.iter().zip(points).enumerate() {
                let slabs = [first[idx] as usize, last[idx] as usize];
                if let Some(bounds) = setup.slabs.bounds_between(slabs, point.get()) {
                    keeper.keep_if_seen(record, point.get(), bounds);
                }
            }
        }
    }

    /// Makes voxels of what is left of a brick.
    #[inline(always)]
    fn make_voxels<S: Simd>(&mut self, simd: S, setup: &Setup<'_>) {
        let points = self.points[..self.records.len()].chunks(N_AT_ONCE);
        for (points, colors) in points.zip(self.colors.chunks(N_AT_ONCE)) {
            let depths = eight(points, |point| point[2]);
            let extinctions = eight(colors, |color| color[3]);
            let spans = setup.spans.spans(simd, &depths, &extinctions);
            let parts = points.iter().zip(colors).zip(spans);
            let voxel = |((&point, &color), sheets)| Voxel { point, sheets, color };
            self.voxels.extend(parts.map(voxel));
            let [least, largest] = &mut self.spans;
            least.0 = spans.iter().fold(least.0, |least, span| least.min(span.0));
            largest.0 = spans.iter().fold(largest.0, |largest, span| largest.max(span.0));
        }
    }

    pub(super) fn resident_bytes(&self) -> usize {
        self.voxels.capacity() * size_of::<SpannedVoxel>()
            + self.entries.capacity() * size_of::<TileEntry>()
    }
}

/// What keeps voxels of a brick, moving their points to the front.
struct Keeper<'a> {
    tiles: TileGrid,
    occlusion: Option<&'a Occlusion>,
    /// The voxel that the first to be kept becomes.
    first: usize,
    entries: &'a mut Vec<TileEntry>,
    records: &'a mut Vec<VoxelRecord>,
    all: &'a [Cell<[f32; 3]>],
}

impl Keeper<'_> {
    /// Keeps a voxel with these bounds, and enters it for its tiles, if it is in the picture and not
    /// occluded.
    #[inline(always)]
    fn keep_if_seen(&mut self, record: &VoxelRecord, point: [f32; 3], [min, max]: [[f32; 2]; 2]) {
        let Some(pixels) = self.tiles.pixels_within(min, max) else { return };
        if self.occlusion.is_some_and(|map| map.visibility(&pixels) == Visibility::None) {
            return;
        }
        let n_kept = self.records.len();
        let voxel = (self.first + n_kept) as u32;
        self.tiles.push(self.tiles.tiles_of(&pixels), voxel, self.entries);
        self.all[n_kept].set(point);
        self.records.push(*record);
    }
}

/// A number of each of up to eight items; where there are fewer, the first stands for the others.
#[inline(always)]
fn eight<T>(items: &[T], number_of: impl Fn(&T) -> f32) -> [f32; N_AT_ONCE] {
    let mut numbers = [number_of(&items[0]); N_AT_ONCE];
    numbers.iter_mut().zip(items).for_each(|(number, item)| *number = number_of(item));
    numbers
}
