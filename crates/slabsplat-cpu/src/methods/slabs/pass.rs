//! A layer on its way through the slabs of a frame.

use super::intake::{Intake, IntakeSummary, Scratch};
use super::occlusion::Occlusion;
use super::setup::Setup;
use super::stage::Stage;
use rayon::prelude::*;
use slabsplat_traverse::{Brick, TileGrid, Workspaces};
use std::ops::Range;

/// A layer, or a level of it, on its way through the slabs.
pub(super) struct Pass<'a> {
    pub(super) stage: Stage<'a>,
    pub(super) setup: Setup<'a>,
    /// The range in which each brick is yet to be taken in, and its key; sorted.
    bricks: &'a [(u32, u32)],
    /// The same of what a coarser level left; in any order.
    late: Vec<(u32, u32)>,
    /// The voxels of the last range.
    pub(super) intake: &'a mut Intake,
    /// To these go first all voxels that wait or were taken in.
    pub(super) first_slabs: Range<usize>,
}

impl<'a> Pass<'a> {
    pub(super) fn new(
        stage: Stage<'a>,
        setup: Setup<'a>,
        bricks: &'a mut Vec<(u32, u32)>,
        intake: &'a mut Intake,
    ) -> Self {
        stage.voxels.bricks(&|brick| range_of(&stage, &setup, brick), bricks);
        bricks.par_sort_unstable();
        Self { stage, setup, bricks, late: Vec::new(), intake, first_slabs: 0..0 }
    }

    /// The range whose bricks come next, if there are any.
    pub(super) fn next_range(&self) -> Option<u32> {
        let of_late = self.late.iter().map(|brick| brick.0).min();
        self.bricks.first().map(|brick| brick.0).into_iter().chain(of_late).min()
    }

    /// Adds bricks that a coarser level left, whose range is `range` or behind it.
    pub(super) fn add_late(&mut self, keys: impl Iterator<Item = u32>, range: u32) {
        let Self { stage, setup, late, .. } = self;
        late.extend(keys.map(|key| {
            let brick = stage.voxels.brick(key);
            (range_of(stage, setup, &brick).max(range), key)
        }));
    }

    /// Takes in the bricks of a range whose first slab is `start`.
    pub(super) fn take_in(
        &mut self,
        range: u32,
        start: usize,
        tiles: &TileGrid,
        occlusion: &Occlusion,
        scratches: &mut Workspaces<Scratch>,
    ) -> IntakeSummary {
        let n_here = self.bricks.partition_point(|brick| brick.0 == range);
        let (mut here, behind) = self.bricks.split_at(n_here);
        let mut all: Vec<(u32, u32)> = self.late.extract_if(.., |brick| brick.0 == range).collect();
        if !all.is_empty() {
            all.extend(here);
            all.sort_unstable();
            here = &all;
        }
        let taken = self.intake.take(&self.stage, &self.setup, tiles, occlusion, here, scratches);
        // What still waits went to some slab before, no longer ago than it is drawn.
        let end = self.first_slabs.end;
        let waited = start.saturating_sub(self.setup.slabs.n_before).min(end)..end;
        self.first_slabs = match taken.first_slabs.clone() {
            Some(new) if waited.is_empty() => new,
            Some(new) => new.start.min(waited.start)..new.end.max(waited.end),
            None => waited,
        };
        self.bricks = behind;
        taken
    }
}

/// The range of slabs in which the first section of a brick lies, or of what may be drawn instead.
fn range_of(stage: &Stage<'_>, setup: &Setup<'_>, brick: &Brick) -> u32 {
    let slabs = &setup.slabs;
    let bounds = stage.bounds_of_brick(brick);
    let first = slabs.meeting(bounds.center[2] - bounds.half_extents[2])[0];
    (first.saturating_sub(setup.most_slabs_before) / slabs.n_per_range) as u32
}
