//! A tile goes on through a range of slabs: splat the sections of a slab, composite the sheet, next.

use crate::by_sheet::BySheet;
use crate::frame::Stage;
use crate::image_aligned::Slabs;
use crate::image_aligned::intake::Intake;
use crate::image_aligned::sections::SlabCut;
use crate::image_aligned::span::{N_CLASSES, Span};
use crate::knots;
use crate::sheet::Sheet;
use crate::tile::Tile;
use crate::tiles::Tiles;
use crate::workspace::{Workspace, Workspaces};
use fearless_simd::{Simd, dispatch};
use std::ops::Range;

/// Takes all tiles through a range of slabs, in parallel. To `first_slabs` go first all voxels that wait or were taken
/// in.
pub(crate) fn through(
    range: Range<usize>,
    first_slabs: Range<usize>,
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
        let Workspace { voxels, sheet, .. } = workspace;
        let runs = std::iter::once(tile.pending.as_slice()).chain(intake.on_tile(tile_idx));
        voxels.sort(N_CLASSES, first_slabs.clone(), runs, |voxel| {
            (slabs.class_of(voxel), Span::from_bits(voxel.sheets).first())
        });
        dispatch!(stage.level, simd => advance(simd, stage, slabs, &range, tile, voxels, sheet));
        tile.keep_waiting(slabs, voxels, range.end);
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
    if starts.is_empty() {
        return;
    }
    knots::grow(&mut sheet.knots, slabs.shapes.n_knot_rows());
    let first = starts.start.max(range.start).max(slabs.first_drawn);
    for slab in first..range.end.min(starts.end + slabs.n_before) {
        let cut = SlabCut::new(slabs, slab);
        for class in 0..N_CLASSES {
            let first = slab.saturating_sub(slabs.n_before(class));
            cut.splat(simd, class, voxels.starting_in(class, first..slab + 1), tile, sheet);
        }
        cut.gather(simd, sheet);
        tile.put_behind(simd, stage.plan.compositing, sheet, stage.plan.opacity_cutoff);
        if tile.is_full() {
            break;
        }
    }
}

impl Tile {
    /// Keeps the voxels that are drawn at `slab` or behind it, unless nothing of them will be seen.
    fn keep_waiting(&mut self, slabs: &Slabs<'_>, voxels: &BySheet, slab: usize) {
        self.pending.clear();
        if self.is_full() {
            return;
        }
        for class in 0..N_CLASSES {
            let first = slab.saturating_sub(slabs.n_before(class));
            self.pending.extend(voxels.starting_in(class, first..usize::MAX).iter());
        }
    }
}
