//! Through the slabs of a frame, from the eye: what `image-aligned` and `post-classified` share.
//!
//! ```text
//! for each range of slabs, from the eye:
//!     take in the bricks whose first section lies in it, but for what is occluded (intake.rs):
//!         project, colour, toss their voxels onto tiles
//!     for each tile, in parallel (advance.rs):
//!         toss its voxels by slab
//!         for each slab of the range:
//!             splat its sections onto the sheet (sections/splat.rs, separable/sections.rs)
//!             hand the sheet to the method
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
//! What a voxel's *colour* is, four numbers that a sheet sums, or two for each of two slabs that are summed
//! at once, and what becomes of a sheet, a method says: [`Voxels`] and [`Sheets`].
//!
//! Reading order: `stage`; `slab_shapes`, `slab_view`, `span_finder`, `classes`, `setup`, `occlusion`,
//! `intake`, `advance`.

mod advance;
mod classes;
mod intake;
mod occlusion;
mod setup;
mod slab_shapes;
mod slab_view;
mod span_finder;
mod stage;

use crate::pixels::tiles::Tiles;
use crate::stopwatch::Stopwatch;
use crate::workspaces::Workspaces;
use advance::{OfTile, Workspace};
use intake::{Intake, Scratch};
use occlusion::Occlusion;
use rayon::prelude::*;
pub(super) use setup::SectionsInSlabs;
use setup::{Prepared, Setup};
use slabsplat_traverse::Brick;
pub(super) use stage::{Sheets, Stage, Voxels};

/// What is cached from frame to frame.
#[derive(Debug, Default)]
pub(super) struct Buffers<R, S> {
    prepared: Prepared,
    /// The range in which each brick is taken in, and its place in the list; sorted.
    bricks: Vec<(u32, u32)>,
    intake: Intake,
    scratches: Workspaces<Scratch>,
    occlusion: Occlusion,
    /// Of each tile, the voxels whose last sections are yet to come, and what the method retains.
    of_tiles: Vec<OfTile<R>>,
    workspaces: Workspaces<Workspace<S>>,
}

/// Renders into empty tiles; returns how many voxels were never tossed, being occluded.
pub(super) fn render<H: Sheets>(
    stage: &Stage<'_>,
    sections: &SectionsInSlabs<'_>,
    sheets: &H,
    tiles: &mut Tiles,
    buffers: &mut Buffers<H::Retained, H::Scratch>,
    watch: &mut Stopwatch,
) -> u64 {
    let Buffers { prepared, bricks, intake, scratches, occlusion, of_tiles, workspaces } = buffers;
    let setup = &Setup::new(stage, sections, prepared, H::AT_ONCE);
    sort_bricks(stage, setup, bricks);
    watch.done("bricks");
    occlusion.start(&tiles.grid, &tiles.tiles);
    of_tiles.resize_with(tiles.tiles.len(), OfTile::default);
    of_tiles.iter_mut().for_each(OfTile::clear);
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
        let end = behind.first().map_or(setup.slabs.grid.n_slabs() + H::N_BEHIND, |next| {
            next.0 as usize * setup.slabs.n_per_range
        });
        let range = advance::Range { slabs: start..end, first_slabs: first_slabs.clone() };
        advance::through(&range, stage, setup, sheets, (tiles, of_tiles), intake, workspaces);
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
    let listed = stage.voxels.bricks().par_iter().enumerate();
    listed.map(|(idx, brick)| (range_of(brick) as u32, idx as u32)).collect_into_vec(bricks);
    bricks.par_sort_unstable();
}

impl<R, S: Default> Buffers<R, S> {
    pub(super) fn resident_bytes<H: Sheets<Retained = R, Scratch = S>>(&self) -> usize {
        self.intake.resident_bytes()
            + self.scratches.sum_of(Scratch::resident_bytes)
            + self.occlusion.resident_bytes()
            + self.bricks.capacity() * size_of::<(u32, u32)>()
            + self.of_tiles.iter().map(OfTile::resident_bytes).sum::<usize>()
            + self.workspaces.sum_of(Workspace::resident_bytes::<H>)
    }
}
