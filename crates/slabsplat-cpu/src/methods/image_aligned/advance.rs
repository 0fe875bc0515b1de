//! A tile advances through a range of slabs: splat the sections of a slab, composite the sheet, next.

use super::classes::{Classes, N_CLASSES};
use super::intake::Intake;
use super::setup::Setup;
use crate::methods::Stage;
use crate::pixels::sheet::Sheet;
use crate::pixels::tile::Tile;
use crate::pixels::tiles::Tiles;
use crate::sections::cut::SlabCut;
use crate::sections::shared::Kind;
use crate::sections::span::SpannedVoxel;
use crate::separable::b_spline::Coefficients;
use crate::separable::sections::AsSeparable;
use crate::voxels::by_sheet::BySheet;
use crate::workspaces::Workspaces;
use fearless_simd::{Simd, dispatch};

/// What a thread needs.
#[derive(Debug, Default)]
pub(super) struct Workspace {
    /// Voxels of a tile.
    voxels: BySheet<SpannedVoxel>,
    /// Empty between slabs, and so are the coefficients.
    sheet: Sheet,
    coefficients: Coefficients,
}

/// Voxels of a tile whose last sections are yet to come.
#[derive(Debug, Default)]
pub(super) struct Waiting(Vec<SpannedVoxel>);

/// A range of slabs.
pub(super) struct Range {
    pub(super) slabs: std::ops::Range<usize>,
    /// To these go first all voxels that wait or were taken in.
    pub(super) first_slabs: std::ops::Range<usize>,
}

/// Takes all tiles through a range of slabs, in parallel.
pub(super) fn through(
    range: &Range,
    stage: &Stage<'_>,
    setup: &Setup<'_>,
    (tiles, waiting): (&mut Tiles, &mut [Waiting]),
    intake: &Intake,
    workspaces: &mut Workspaces<Workspace>,
) {
    tiles.for_each_with(waiting, workspaces, |tile_idx, tile, waiting, workspace| {
        if tile.is_saturated() {
            return;
        }
        let runs = std::iter::once(waiting.0.as_slice()).chain(intake.on_tile(tile_idx));
        workspace.voxels.sort(N_CLASSES, range.first_slabs.clone(), runs, |voxel| {
            (setup.classes.of(voxel), voxel.sheets.first())
        });
        dispatch!(stage.level, simd => advance(simd, range, stage, setup, tile, workspace));
        waiting.clear();
        if !tile.is_saturated() {
            waiting.keep(&setup.classes, &workspace.voxels, range.slabs.end);
        }
    });
}

#[inline(always)]
fn advance<S: Simd>(
    simd: S,
    range: &Range,
    stage: &Stage<'_>,
    setup: &Setup<'_>,
    tile: &mut Tile,
    workspace: &mut Workspace,
) {
    let starts = workspace.voxels.sheets();
    if starts.is_empty() {
        return;
    }
    workspace.coefficients.grow(setup.slabs.shapes.n_coefficients());
    let first = starts.start.max(range.slabs.start).max(setup.slabs.first_drawn);
    for slab in first..range.slabs.end.min(starts.end + setup.slabs.n_before) {
        add_slab(simd, slab, setup, tile, workspace);
        let sheet = &mut workspace.sheet;
        tile.put_behind(simd, stage.plan.compositing, sheet, stage.plan.opacity_cutoff);
        if tile.is_saturated() {
            break;
        }
    }
}

/// Adds all sections that a slab cuts to its sheet.
#[inline(always)]
fn add_slab<S: Simd>(
    simd: S,
    slab: usize,
    setup: &Setup<'_>,
    tile: &mut Tile,
    Workspace { voxels, sheet, coefficients }: &mut Workspace,
) {
    let Setup { slabs, classes, sections, .. } = setup;
    let faces = slabs.grid.faces(slab).map(|face| face as f32);
    let cut = SlabCut { sections, slab, shape: slabs.shape(slab), faces };
    let [whole, cut_by_slab] = setup.as_separable(slab);
    // Coefficients are of footprints of one shape at a time.
    let mut pending: Option<AsSeparable<'_>> = None;
    for class in 0..N_CLASSES {
        let first = slab.saturating_sub(classes.n_before(class));
        let (voxels, kind) = (voxels.starting_in(class, first..slab + 1), classes.kind_of(class));
        let separable = if kind == Kind::Whole { whole } else { cut_by_slab };
        match separable {
            Some(separable) if Classes::may_be_separable(class) => {
                if let Some(other) = pending.replace(separable).filter(|p| !p.is_like(&separable)) {
                    other.slab.reconstruct(simd, tile, sheet, coefficients);
                }
                separable.add_sections(simd, (&cut, kind), voxels, tile, (sheet, coefficients));
            }
            _ => cut.add_sections(simd, kind, voxels, tile, sheet),
        }
    }
    if let Some(separable) = pending {
        separable.slab.reconstruct(simd, tile, sheet, coefficients);
    }
}

impl Workspace {
    pub(super) fn resident_bytes(&self) -> usize {
        self.voxels.resident_bytes() + Sheet::BYTES + self.coefficients.resident_bytes()
    }
}

impl Waiting {
    pub(super) fn clear(&mut self) {
        self.0.clear();
    }

    /// Adds the voxels that are drawn at `slab` or behind it.
    fn keep(&mut self, classes: &Classes, voxels: &BySheet<SpannedVoxel>, slab: usize) {
        for class in 0..N_CLASSES {
            let first = slab.saturating_sub(classes.n_before(class));
            self.0.extend(voxels.starting_in(class, first..usize::MAX).iter());
        }
    }

    pub(super) fn resident_bytes(&self) -> usize {
        self.0.capacity() * size_of::<SpannedVoxel>()
    }
}
