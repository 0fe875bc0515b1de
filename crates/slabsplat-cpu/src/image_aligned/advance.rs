//! A tile goes on through a range of slabs: splat the sections of a slab, composite the sheet, next.

use crate::by_sheet::BySheet;
use crate::frame::Stage;
use crate::image_aligned::intake::Intake;
use crate::image_aligned::sections::SlabCut;
use crate::image_aligned::Slabs;
use crate::sheet::Sheet;
use crate::tile::Tile;
use crate::tiles::Tiles;
use crate::voxel::Voxel;
use crate::workspace::{Workspace, Workspaces};
use fearless_simd::{Simd, dispatch};
use std::ops::Range;

/// Takes all tiles through a range of slabs, in parallel.
pub(crate) fn through(
    range: Range<usize>,
    stage: &Stage<'_>,
    slabs: &Slabs<'_>,
    tiles: &mut Tiles,
    intake: &Intake,
    workspaces: &mut Workspaces,
) {
    tiles.for_each(workspaces, |tile_idx, tile, workspace| {
        if tile.is_full() {
            return;
        }
        let Workspace { voxels, sheet } = workspace;
        let waiting = tile.pending.iter().chain(intake.on_tile(tile_idx));
        voxels.sort(waiting, |voxel| slabs.meeting(voxel.point[2])[0]);
        dispatch!(stage.level, simd => advance(simd, stage, slabs, &range, tile, voxels, sheet));
        tile.keep_waiting(voxels.starting_in(range.end.saturating_sub(slabs.n_before)..usize::MAX));
    });
}

#[inline(always)]
fn advance<S: Simd>(
    simd: S,
    stage: &Stage<'_>,
    slabs: &Slabs<'_>,
    range: &Range<usize>,
    tile: &mut Tile,
    voxels: &BySheet,
    sheet: &mut Sheet,
) {
    let starts = voxels.sheets();
    let first = starts.start.max(range.start).max(slabs.first_drawn);
    for slab in first..range.end.min(starts.end + slabs.n_before) {
        let cut = SlabCut {
            slabs,
            shape: slabs.shape(slab),
            faces: slabs.grid.faces(slab).map(|face| face as f32),
        };
        let met = voxels.starting_in(slab.saturating_sub(slabs.n_before)..slab + 1);
        cut.splat(simd, met, tile, sheet);
        tile.put_behind(simd, stage.plan.compositing, sheet, stage.plan.opacity_cutoff);
        if tile.is_full() {
            break;
        }
    }
}

impl Tile {
    /// Keeps voxels for the next range, unless nothing of them will be seen.
    fn keep_waiting(&mut self, voxels: &[Voxel]) {
        self.pending.clear();
        if !self.is_full() {
            self.pending.extend_from_slice(voxels);
        }
    }
}
