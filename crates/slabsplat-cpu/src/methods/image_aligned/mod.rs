//! The paper's method (§3.2): kernel sections summed in slabs parallel to the image, slab by slab from
//! the eye.
//!
//! ```text
//! for each range of slabs, from the eye:
//!     take in the bricks whose first section lies in it, but for what is occluded (intake.rs):
//!         project, shade, toss their voxels onto tiles
//!     for each tile, in parallel (advance.rs):
//!         toss its voxels by slab
//!         for each slab of the range:
//!             splat its sections onto the sheet (sections/splat.rs, separable/sections.rs)
//!             composite the sheet
//!     note which blocks of pixels are saturated (occlusion.rs)
//! ```
//!
//! So what is occluded is never looked at, buffers hold one range instead of the volume, and what they hold
//! is still in the caches when the tiles read it.
//!
//! A voxel waits with its tile in the bucket of the first slab that its kernel meets. A slab takes its
//! sections from that bucket and from those of the few slabs before it, as many as a kernel is thick; so the
//! work is linear in sections, and a voxel is stored once a tile instead of once a section.
//!
//! Reading order: `slab_shapes`, `slab_view`, `span_finder`, `classes`, `setup`, `occlusion`, `intake`,
//! `advance`.

mod advance;
mod classes;
mod intake;
mod occlusion;
mod setup;
mod slab_shapes;
mod slab_view;
mod span_finder;

use super::Stage;
use crate::pixels::tiles::Tiles;
use crate::stopwatch::Stopwatch;
use crate::workspaces::Workspaces;
use advance::{Waiting, Workspace};
use intake::{Intake, Scratch};
use occlusion::Occlusion;
use rayon::prelude::*;
use setup::{Prepared, Setup};
use slabsplat_backend::SectionSplats;
use slabsplat_traverse::Brick;

/// What is cached from frame to frame.
#[derive(Debug, Default)]
pub(crate) struct Buffers {
    prepared: Prepared,
    /// The range in which each brick is taken in, and its place in the list; sorted.
    bricks: Vec<(u32, u32)>,
    intake: Intake,
    scratches: Workspaces<Scratch>,
    occlusion: Occlusion,
    /// Of each tile, the voxels whose last sections are yet to come.
    waiting: Vec<Waiting>,
    workspaces: Workspaces<Workspace>,
}

/// Renders into empty tiles; returns how many voxels were never tossed, being occluded.
pub(crate) fn render(
    stage: &Stage<'_>,
    splats: &SectionSplats,
    tiles: &mut Tiles,
    buffers: &mut Buffers,
    watch: &mut Stopwatch,
) -> u64 {
    let Buffers { prepared, bricks, intake, scratches, occlusion, waiting, workspaces } = buffers;
    let setup = &Setup::new(stage, splats, prepared);
    sort_bricks(stage, setup, bricks);
    watch.done("bricks");
    occlusion.start(stage.plan.view.image_size(), &tiles.tiles);
    waiting.resize_with(tiles.tiles.len(), Waiting::default);
    waiting.iter_mut().for_each(Waiting::clear);
    let (mut n_occluded, mut start, mut rest) = (0, 0_usize, bricks.as_slice());
    let mut first_slabs = 0..0;
    while let Some(&(range, _)) = rest.first() {
        let (here, behind) = rest.split_at(rest.partition_point(|brick| brick.0 == range));
        let taken = intake.take(stage, setup, &tiles.grid, occlusion, here, scratches);
        n_occluded += taken.n_occluded;
        // What still waits went to some slab before, no longer ago than it is drawn.
        let waited = start.saturating_sub(setup.slabs.n_before).min(first_slabs.end);
        let waited = waited..first_slabs.end;
        first_slabs = match taken.first_slabs {
            Some(new) if waited.is_empty() => new,
            Some(new) => new.start.min(waited.start)..new.end.max(waited.end),
            None => waited,
        };
        watch.done("intake");
        // The last range continues until no voxel is left that was taken in.
        let end = behind
            .first()
            .map_or(setup.slabs.grid.n_slabs(), |next| next.0 as usize * setup.slabs.n_per_range);
        let range = advance::Range { slabs: start..end, first_slabs: first_slabs.clone() };
        advance::through(&range, stage, setup, (tiles, waiting), intake, workspaces);
        occlusion.note(&tiles.tiles);
        watch.done("splat");
        (start, rest) = (end, behind);
    }
    n_occluded
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
    let listed = stage.list.bricks().par_iter().enumerate();
    listed.map(|(idx, brick)| (range_of(brick) as u32, idx as u32)).collect_into_vec(bricks);
    bricks.par_sort_unstable();
}

impl Buffers {
    pub(crate) fn resident_bytes(&self) -> usize {
        self.intake.resident_bytes()
            + self.scratches.sum_of(Scratch::resident_bytes)
            + self.occlusion.resident_bytes()
            + self.bricks.capacity() * size_of::<(u32, u32)>()
            + self.waiting.iter().map(Waiting::resident_bytes).sum::<usize>()
            + self.workspaces.sum_of(Workspace::resident_bytes)
    }
}
