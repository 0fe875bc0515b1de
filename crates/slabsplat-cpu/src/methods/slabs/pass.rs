//! A layer on its way through the slabs of a frame.

use super::intake::{Intake, Scratch};
use super::occlusion::Occlusion;
use super::setup::Setup;
use super::stage::Stage;
use rayon::prelude::*;
use slabsplat_traverse::{Brick, TileGrid, Workspaces};
use std::ops::Range;

/// A layer on its way through the slabs.
pub(super) struct Pass<'a> {
    pub(super) stage: Stage<'a>,
    pub(super) setup: Setup<'a>,
    /// The bricks that are yet to be taken in.
    pub(super) bricks: &'a [(u32, u32)],
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
        sort_bricks(&stage, &setup, bricks);
        Self { stage, setup, bricks, intake, first_slabs: 0..0 }
    }

    /// Takes in the bricks of a range whose first slab is `start`; returns how many voxels were occluded.
    pub(super) fn take_in(
        &mut self,
        range: u32,
        start: usize,
        tiles: &TileGrid,
        occlusion: &Occlusion,
        scratches: &mut Workspaces<Scratch>,
    ) -> u64 {
        let n_here = self.bricks.partition_point(|brick| brick.0 == range);
        let (here, behind) = self.bricks.split_at(n_here);
        let taken = self.intake.take(&self.stage, &self.setup, tiles, occlusion, here, scratches);
        // What still waits went to some slab before, no longer ago than it is drawn.
        let end = self.first_slabs.end;
        let waited = start.saturating_sub(self.setup.slabs.n_before).min(end)..end;
        self.first_slabs = match taken.first_slabs {
            Some(new) if waited.is_empty() => new,
            Some(new) => new.start.min(waited.start)..new.end.max(waited.end),
            None => waited,
        };
        self.bricks = behind;
        taken.n_occluded
    }
}

/// Sorts the bricks by the range of slabs in which their first section lies, and then by memory order.
fn sort_bricks(stage: &Stage<'_>, setup: &Setup<'_>, bricks: &mut Vec<(u32, u32)>) {
    let slabs = &setup.slabs;
    let n_early = setup.spans.most_slabs_before();
    let range_of = |brick: &Brick| {
        let bounds = stage.bricks.bounds(brick);
        let first = slabs.meeting(bounds.center[2] - bounds.half_extents[2])[0];
        first.saturating_sub(n_early) / slabs.n_per_range
    };
    let listed = stage.voxels.bricks().par_iter().enumerate();
    listed.map(|(idx, brick)| (range_of(brick) as u32, idx as u32)).collect_into_vec(bricks);
    bricks.par_sort_unstable();
}
