//! A tile advances through a range of slabs: splat the sections of a slab, composite the sheet, next.

use super::classes::{Classes, N_CLASSES};
use super::intake::Intake;
use super::setup::Setup;
use super::stage::{Sheets, Stage};
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
pub(super) struct Workspace<S> {
    sums: Sums,
    of_method: S,
}

/// What the sums of a slab are made with.
#[derive(Debug, Default)]
struct Sums {
    /// Voxels of a tile.
    voxels: BySheet<SpannedVoxel>,
    /// Empty between slabs, and so are the coefficients.
    sheet: Sheet,
    coefficients: Coefficients,
}

/// What a tile has from one range of slabs to the next.
#[derive(Debug, Default)]
pub(super) struct OfTile<R> {
    /// Voxels whose last sections are yet to come.
    waiting: Vec<SpannedVoxel>,
    /// What the method retains, and the first slab that it needs no more; 0 if it retains nothing.
    retained: R,
    needed_until: usize,
}

/// A range of slabs.
pub(super) struct Range {
    pub(super) slabs: std::ops::Range<usize>,
    /// To these go first all voxels that wait or were taken in.
    pub(super) first_slabs: std::ops::Range<usize>,
}

/// Takes all tiles through a range of slabs, in parallel.
pub(super) fn through<H: Sheets>(
    range: &Range,
    stage: &Stage<'_>,
    setup: &Setup<'_>,
    sheets: &H,
    (tiles, of_tiles): (&mut Tiles, &mut [OfTile<H::Retained>]),
    intake: &Intake,
    workspaces: &mut Workspaces<Workspace<H::Scratch>>,
) {
    tiles.for_each_with(of_tiles, workspaces, |tile_idx, tile, of_tile, workspace| {
        if tile.is_saturated() {
            return;
        }
        let runs = std::iter::once(of_tile.waiting.as_slice()).chain(intake.on_tile(tile_idx));
        workspace.sums.voxels.sort(N_CLASSES, range.first_slabs.clone(), runs, |voxel| {
            (setup.classes.of(voxel), voxel.sheets.first())
        });
        dispatch!(stage.level, simd => advance(simd, range, setup, sheets, tile, of_tile, workspace));
        of_tile.waiting.clear();
        if !tile.is_saturated() {
            of_tile.wait(&setup.classes, &workspace.sums.voxels, range.slabs.end);
        }
    });
}

#[inline(always)]
fn advance<S: Simd, H: Sheets>(
    simd: S,
    range: &Range,
    setup: &Setup<'_>,
    sheets: &H,
    tile: &mut Tile,
    OfTile { retained, needed_until, .. }: &mut OfTile<H::Retained>,
    Workspace { sums, of_method }: &mut Workspace<H::Scratch>,
) {
    let starts = sums.voxels.sheets();
    sums.coefficients.grow(setup.slabs.shapes.n_coefficients());
    let n_slabs = setup.slabs.grid.n_slabs();
    let start = range.slabs.start.max(setup.slabs.first_drawn);
    let end = if starts.is_empty() { 0 } else { starts.end + setup.slabs.n_before };
    let end = end.min(n_slabs) + H::N_BEHIND;
    let start = if range.slabs.start < *needed_until { start } else { start.max(starts.start) };
    let mut slab = start / H::AT_ONCE * H::AT_ONCE;
    while slab < range.slabs.end.min(end.max(*needed_until)) {
        if slab < n_slabs {
            match H::AT_ONCE {
                1 => add_slab(simd, slab, [1.0; 4], setup, tile, sums),
                _ => add_pair(simd, slab, setup, tile, sums),
            }
        }
        if !sums.sheet.touched.is_empty() {
            *needed_until = slab + H::AT_ONCE + H::N_BEHIND;
        }
        sheets.take(simd, slab, &mut sums.sheet, tile, retained, of_method);
        if tile.is_saturated() {
            *needed_until = 0;
            break;
        }
        slab += H::AT_ONCE;
    }
    if *needed_until <= range.slabs.end {
        *needed_until = 0;
        sheets.release(retained, of_method);
    }
}

/// The channels of a sheet that has the sums of two slabs, of the first and of the second.
const OF_PAIR: [[f32; 4]; 2] = [[1.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 1.0]];

/// Adds all sections that a slab or the next one cuts to their sheet. Where footprints are separable and of
/// one shape, one goes for both: their weights differ by a factor, which their channels have.
fn add_pair<S: Simd>(simd: S, first: usize, setup: &Setup<'_>, tile: &mut Tile, sums: &mut Sums) {
    if let Some(separable) = setup.pair_as_separable(first) {
        let cuts = [0, 1].map(|idx| setup.cut(first + idx, OF_PAIR[idx]));
        return add_cuts(simd, &cuts, [Some(separable); 2], &setup.classes, tile, sums);
    }
    let drawn = setup.slabs.first_drawn..setup.slabs.grid.n_slabs();
    for (slab, channels) in (first..).zip(OF_PAIR) {
        if drawn.contains(&slab) {
            add_slab(simd, slab, channels, setup, tile, sums);
        }
    }
}

/// Adds all sections that a slab cuts to those channels of its sheet.
fn add_slab<S: Simd>(
    simd: S,
    slab: usize,
    channels: [f32; 4],
    setup: &Setup<'_>,
    tile: &mut Tile,
    sums: &mut Sums,
) {
    let cuts = [setup.cut(slab, channels)];
    add_cuts(simd, &cuts, setup.as_separable(slab), &setup.classes, tile, sums);
}

/// Adds all sections that slabs which follow each other cut. A function of its own, as all methods share it
/// and it takes long to compile.
#[inline(never)]
fn add_cuts<S: Simd, const N: usize>(
    simd: S,
    cuts: &[SlabCut<'_>; N],
    separable: [Option<AsSeparable<'_>>; 2],
    classes: &Classes,
    tile: &mut Tile,
    sums: &mut Sums,
) {
    simd.vectorize(
        #[inline(always)]
        || add_cuts_inlined(simd, cuts, separable, classes, tile, sums),
    );
}

#[inline(always)]
fn add_cuts_inlined<S: Simd, const N: usize>(
    simd: S,
    cuts: &[SlabCut<'_>; N],
    [whole, cut_by_slab]: [Option<AsSeparable<'_>>; 2],
    classes: &Classes,
    tile: &mut Tile,
    Sums { voxels, sheet, coefficients }: &mut Sums,
) {
    let first = cuts[0].slab;
    // Coefficients are of footprints of one shape at a time.
    let mut pending: Option<AsSeparable<'_>> = None;
    for class in 0..N_CLASSES {
        let starts = first.saturating_sub(classes.n_before(class));
        let kind = classes.kind_of(class);
        match if kind == Kind::Whole { whole } else { cut_by_slab } {
            Some(separable) if Classes::may_be_separable(class) => {
                if let Some(other) = pending.replace(separable).filter(|p| !p.is_like(&separable)) {
                    other.slab.reconstruct(simd, tile, sheet, coefficients);
                }
                let voxels = voxels.starting_in(class, starts..first + N);
                separable.add_sections(simd, (cuts, kind), voxels, tile, (sheet, coefficients));
            }
            _ => {
                for cut in cuts {
                    let voxels = voxels.starting_in(class, starts..cut.slab + 1);
                    cut.add_sections(simd, kind, voxels, tile, sheet);
                }
            }
        }
    }
    if let Some(separable) = pending {
        separable.slab.reconstruct(simd, tile, sheet, coefficients);
    }
}

impl<S> Workspace<S> {
    pub(super) fn resident_bytes<H: Sheets<Scratch = S>>(&self) -> usize {
        let Sums { voxels, coefficients, .. } = &self.sums;
        voxels.resident_bytes()
            + Sheet::BYTES
            + coefficients.resident_bytes()
            + H::scratch_bytes(&self.of_method)
    }
}

impl<R> OfTile<R> {
    /// Makes it ready for another frame; the last one left nothing retained.
    pub(super) fn clear(&mut self) {
        self.waiting.clear();
        self.needed_until = 0;
    }

    /// Adds the voxels that are drawn at `slab` or behind it to those that wait.
    fn wait(&mut self, classes: &Classes, voxels: &BySheet<SpannedVoxel>, slab: usize) {
        for class in 0..N_CLASSES {
            let first = slab.saturating_sub(classes.n_before(class));
            self.waiting.extend(voxels.starting_in(class, first..usize::MAX).iter());
        }
    }

    pub(super) fn resident_bytes(&self) -> usize {
        self.waiting.capacity() * size_of::<SpannedVoxel>()
    }
}
