//! A tile advances through a range of slabs: splat the sections of a slab, composite the sheet, next.

use super::classes::{Classes, N_CLASSES};
use super::pass::Pass;
use super::regions::{Regions, RegionsOnTile};
use super::setup::Setup;
use super::sheets::{Sheets, SlabOnTile, SlabSums};
use crate::pixels::sheet::Sheet;
use crate::pixels::tile::Tile;
use crate::pixels::tiles::Tiles;
use crate::progress::Progress;
use crate::sections::cut::SlabCut;
use crate::sections::shared::Kind;
use crate::sections::span::SpannedVoxel;
use crate::separable::b_spline::Coefficients;
use crate::separable::sections::AsSeparable;
use crate::voxels::by_sheet::BySheet;
use fearless_simd::{Simd, dispatch};
use slabsplat_core::FrameHandle;
use slabsplat_traverse::Workspaces;
use std::ops::Range;

/// What a thread needs.
#[derive(Debug, Default)]
pub(super) struct Workspace<S> {
    sums: Sums,
    of_method: S,
}

/// What the sums of a slab are made with.
#[derive(Debug, Default)]
struct Sums {
    /// Voxels of a tile, of each layer.
    voxels: Vec<BySheet<SpannedVoxel>>,
    sheet: SheetInWork,
    /// Room for the sum of all layers. Empty between slabs.
    joined: Sheet,
}

/// A sheet that is being summed.
#[derive(Debug, Default)]
struct SheetInWork {
    /// Empty between slabs, and so are the coefficients.
    sheet: Sheet,
    coefficients: Coefficients,
}

/// What a tile has from one range of slabs to the next.
#[derive(Debug, Default)]
pub(super) struct OfTile<R> {
    /// Voxels whose last sections are yet to come, of each layer.
    waiting: Vec<Vec<SpannedVoxel>>,
    /// What the method retains, and the first slab that it needs no more; 0 if it retains nothing, as it does
    /// after a frame that was not cancelled.
    retained: R,
    needed_until: usize,
}

/// Takes all tiles through a range of slabs, in parallel, until the frame is cancelled.
pub(super) fn through<H: Sheets>(
    slabs: Range<usize>,
    passes: &[Pass<'_>],
    (sheets, regions, progress): (&H, &Regions, Progress<'_>),
    (tiles, of_tiles): (&mut Tiles, &mut [OfTile<H::Retained>]),
    workspaces: &mut Workspaces<Workspace<H::Scratch>>,
) {
    let frame = progress.frame;
    tiles.for_each_with(progress, of_tiles, workspaces, |tile_idx, tile, of_tile, workspace| {
        if tile.is_saturated() {
            return;
        }
        workspace.sums.sort(passes, tile_idx, &of_tile.waiting, frame);
        if frame.is_cancelled() {
            return;
        }
        let level = passes[0].stage.level;
        let slabs = &slabs;
        let how = (sheets, regions.on_tile(tile_idx), frame);
        dispatch!(level, simd => {
            advance(simd, slabs, passes, how, tile, of_tile, workspace);
        });
        tile.end_rays_before(sheets.front(slabs.end), passes[0].stage.plan.opacity_cutoff);
        for ((waiting, pass), voxels) in
            of_tile.waiting.iter_mut().zip(passes).zip(&workspace.sums.voxels)
        {
            waiting.clear();
            if !tile.is_saturated() {
                wait(waiting, &pass.setup.classes, voxels, slabs.end);
            }
        }
    });
}

/// Adds the voxels that are drawn at `slab` or behind it to those that wait.
fn wait(
    waiting: &mut Vec<SpannedVoxel>,
    classes: &Classes,
    voxels: &BySheet<SpannedVoxel>,
    slab: usize,
) {
    for class in 0..N_CLASSES {
        let first = slab.saturating_sub(classes.n_before(class));
        waiting.extend(voxels.starting_in(class, first..usize::MAX).iter());
    }
}

impl Sums {
    /// Makes them those of a tile: what waits there, and what was taken in.
    fn sort(
        &mut self,
        passes: &[Pass<'_>],
        tile_idx: usize,
        waiting: &[Vec<SpannedVoxel>],
        frame: &FrameHandle,
    ) {
        self.voxels.resize_with(passes.len(), BySheet::default);
        for ((voxels, pass), waiting) in self.voxels.iter_mut().zip(passes).zip(waiting) {
            let runs = std::iter::once(waiting.as_slice()).chain(pass.intake.on_tile(tile_idx));
            let key_of =
                |voxel: &SpannedVoxel| (pass.setup.classes.of(voxel), voxel.sheets.first());
            voxels.sort(N_CLASSES, pass.first_slabs.clone(), runs, key_of, frame);
            self.sheet.coefficients.grow(pass.setup.slabs.shapes.n_coefficients());
        }
    }

    /// The slabs that may hold anything, behind which `n_behind` more are needed.
    fn slabs(&self, passes: &[Pass<'_>], n_behind: usize) -> Range<usize> {
        let (mut start, mut end) = (usize::MAX, 0);
        for (voxels, Pass { setup, .. }) in self.voxels.iter().zip(passes) {
            let starts = voxels.sheets();
            if !starts.is_empty() {
                start = start.min(starts.start.max(setup.slabs.first_drawn));
                end = end.max((starts.end + setup.slabs.n_before).min(setup.slabs.grid.n_slabs()));
            }
        }
        start..end + n_behind
    }
}

#[inline(always)]
fn advance<S: Simd, H: Sheets>(
    simd: S,
    slabs: &Range<usize>,
    passes: &[Pass<'_>],
    (sheets, regions, frame): (&H, RegionsOnTile<'_>, &FrameHandle),
    tile: &mut Tile,
    OfTile { retained, needed_until, .. }: &mut OfTile<H::Retained>,
    Workspace { sums, of_method }: &mut Workspace<H::Scratch>,
) {
    let held = sums.slabs(passes, H::N_BEHIND);
    let is_retained = slabs.start < *needed_until;
    let start = if is_retained { slabs.start } else { slabs.start.max(held.start) };
    let mut slab = start / H::AT_ONCE * H::AT_ONCE;
    let Sums { voxels, sheet, joined } = sums;
    while slab < slabs.end.min(held.end.max(*needed_until)) && !frame.is_cancelled() {
        let here = SlabOnTile { slab, regions };
        for (layer, (voxels, Pass { setup, .. })) in voxels.iter().zip(passes).enumerate() {
            let needed = tile.needed;
            tile.needed = needed.and(sheets.needed(here, layer));
            if !tile.needed.is_empty() && !voxels.sheets().is_empty() {
                match H::AT_ONCE {
                    1 => add_slab(simd, slab, [1.0; 4], setup, tile, voxels, sheet),
                    _ => add_pair(simd, slab, setup, tile, voxels, sheet),
                }
            }
            tile.needed = needed;
            if !sheet.sheet.touched.is_empty() {
                let end = (slab + H::AT_ONCE).min(setup.slabs.grid.n_slabs());
                *needed_until = end + H::N_BEHIND;
            }
            let sums = SlabSums { of_layer: &mut sheet.sheet, joined };
            sheets.take(simd, here, layer, sums, retained, of_method);
        }
        let sums = SlabSums { of_layer: &mut sheet.sheet, joined };
        sheets.show(simd, here, sums, tile, retained, of_method);
        slab += H::AT_ONCE;
        tile.close_all(regions.over_from(sheets.front(slab)));
        if tile.is_saturated() {
            *needed_until = 0;
            break;
        }
    }
    if *needed_until <= slabs.end {
        *needed_until = 0;
        sheets.release(retained, of_method);
    }
}

/// Voxels of one slab between two looks at whether anyone still wants them: a picture may be so small that
/// there are 10⁵ on a tile. A multiple of those that are prepared at once.
const LOOK_EVERY: usize = 1 << 14;

/// The channels of a sheet that has the sums of two slabs, of the first and of the second.
const OF_PAIR: [[f32; 4]; 2] = [[1.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 1.0]];

/// Adds all sections that a slab or the next one cuts to their sheet. Where footprints are separable and of
/// one shape, one goes for both: their weights differ by a factor, which their channels have.
fn add_pair<S: Simd>(
    simd: S,
    first: usize,
    setup: &Setup<'_>,
    tile: &mut Tile,
    voxels: &BySheet<SpannedVoxel>,
    sheet: &mut SheetInWork,
) {
    if let Some(separable) = setup.pair_as_separable(first) {
        let cuts = [0, 1].map(|idx| setup.cut(first + idx, OF_PAIR[idx]));
        let how = (&setup.classes, setup.frame);
        return add_cuts(simd, &cuts, [Some(separable); 2], how, tile, voxels, sheet);
    }
    for (slab, channels) in (first..).zip(OF_PAIR) {
        add_slab(simd, slab, channels, setup, tile, voxels, sheet);
    }
}

/// Adds all sections that a slab cuts to those channels of its sheet, if it is drawn.
fn add_slab<S: Simd>(
    simd: S,
    slab: usize,
    channels: [f32; 4],
    setup: &Setup<'_>,
    tile: &mut Tile,
    voxels: &BySheet<SpannedVoxel>,
    sheet: &mut SheetInWork,
) {
    if (setup.slabs.first_drawn..setup.slabs.grid.n_slabs()).contains(&slab) {
        let cuts = [setup.cut(slab, channels)];
        let separable = setup.as_separable(slab);
        add_cuts(simd, &cuts, separable, (&setup.classes, setup.frame), tile, voxels, sheet);
    }
}

/// Adds all sections that slabs which follow each other cut. A function of its own, as all methods share it
/// and it takes long to compile. If the frame is cancelled some may be missing.
#[inline(never)]
fn add_cuts<S: Simd, const N: usize>(
    simd: S,
    cuts: &[SlabCut<'_>; N],
    separable: [Option<AsSeparable<'_>>; 2],
    how: (&Classes, &FrameHandle),
    tile: &mut Tile,
    voxels: &BySheet<SpannedVoxel>,
    sheet: &mut SheetInWork,
) {
    simd.vectorize(
        #[inline(always)]
        || add_cuts_inlined(simd, cuts, separable, how, tile, voxels, sheet),
    );
}

#[inline(always)]
fn add_cuts_inlined<S: Simd, const N: usize>(
    simd: S,
    cuts: &[SlabCut<'_>; N],
    [whole, cut_by_slab]: [Option<AsSeparable<'_>>; 2],
    (classes, frame): (&Classes, &FrameHandle),
    tile: &mut Tile,
    voxels: &BySheet<SpannedVoxel>,
    SheetInWork { sheet, coefficients }: &mut SheetInWork,
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
                for voxels in voxels.pieces(LOOK_EVERY).take_while(|_| !frame.is_cancelled()) {
                    separable.add_sections(simd, (cuts, kind), voxels, tile, (sheet, coefficients));
                }
            }
            _ => {
                for cut in cuts {
                    let voxels = voxels.starting_in(class, starts..cut.slab + 1);
                    for voxels in voxels.pieces(LOOK_EVERY).take_while(|_| !frame.is_cancelled()) {
                        cut.add_sections(simd, kind, voxels, tile, sheet);
                    }
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
        let Sums { voxels, sheet, .. } = &self.sums;
        voxels.iter().map(BySheet::resident_bytes).sum::<usize>()
            + 2 * Sheet::BYTES
            + sheet.coefficients.resident_bytes()
            + H::scratch_bytes(&self.of_method)
    }
}

impl<R: Default> OfTile<R> {
    /// Makes it ready for another frame, of so many layers.
    pub(super) fn clear(&mut self, n_layers: usize) {
        self.waiting.resize_with(n_layers, Vec::new);
        self.waiting.iter_mut().for_each(Vec::clear);
        if self.needed_until != 0 {
            (self.retained, self.needed_until) = (R::default(), 0);
        }
    }
}

impl<R> OfTile<R> {
    pub(super) fn resident_bytes(&self) -> usize {
        let n_waiting: usize = self.waiting.iter().map(Vec::capacity).sum();
        n_waiting * size_of::<SpannedVoxel>()
    }
}
