//! Splatting without the blur (Mueller, Möller & Crawfis, IEEE Visualization '99): sheets hold densities, and
//! what lies between them is classified and shaded. Model §8.
//!
//! ```text
//! for each tile, in parallel:
//!     for each two sheets from the eye, half a slab thick:
//!         add their sections: length += H, weighted value += H·v               (methods/slabs)
//!         for each of them:
//!             put it with the five before it                                   (sheets.rs)
//!             for each eight open pixels, between the two sheets in the middle:
//!                 densities in the middle of each                              (nodes.rs)
//!                 where anything shows between them: slopes on the way         (nodes.rs)
//!                     mean opacity and colour of all densities on the way      (integrals.rs)
//!                     light                                                    (parts.rs)
//!             composite what came of it, as any sheet
//! ```
//!
//! 1. A voxel is splatted only if it has a part in a pixel that may show (`selection.rs`), and if that is not
//!    occluded.
//! 2. A tile is summed with a border of one pixel, for the gradients. That is a seventh more at 32 pixels a
//!    side, and tiles need nothing of each other.
//! 3. Most pixels of a sheet show nothing, which eight densities at a time say.
//! 4. A sheet has four channels a pixel, and densities are sums of two: two sheets are summed at a time, by
//!    one footprint where both have it at one place.
//!
//! # Reading order
//!
//! `finite`, `reach`, `bit_rows`, `selection`, `voxels`; `sheets`, `groups`, `rays`, `depths`, `nodes`,
//! `normals`; `integrals`, `parts`, `classify`; `statistic`; `crossing`, `isosurfaces`.

mod bit_rows;
mod finite;
mod reach;
mod selection;
mod voxels;

mod depths;
mod groups;
mod nodes;
mod normals;
mod rays;
mod sheets;

mod integrals;
mod parts;

mod classify;
mod statistic;

mod crossing;
mod isosurfaces;

#[cfg(test)]
mod tests;

use super::slabs::{self, SectionsInSlabs, Stage};
use crate::footprints::raster::Raster;
use crate::pixels::tiles::Tiles;
use crate::stopwatch::Stopwatch;
use classify::Classifier;
use fearless_simd::Level;
use finite::finite_range;
use integrals::Integrals;
use isosurfaces::Isosurfaces;
use reach::Reach;
use selection::Selection;
use sheets::{Limits, Retained, Scratch};
use slabsplat_backend::densities::{FULL_PART, ValueScale};
use slabsplat_backend::{ByIdentity, Cached, DensitySplats, FramePlan, LayerPlan, ShownDensities};
use slabsplat_core::{Compositing, IsoRange, TransferFunction, Volume};
use slabsplat_traverse::BrickView;
use statistic::Gatherer;
use voxels::Selected;

/// Pixels on each side of a tile that are summed for gradients alone.
pub(crate) const BORDER: usize = 1;

/// What is cached from frame to frame.
#[derive(Debug, Default)]
pub(crate) struct Buffers {
    finite: Cached<ByIdentity<Volume>, Option<[f64; 2]>>,
    selection: Cached<SelectedBy, Selection>,
    integrals: CachedIntegrals,
    slabs: slabs::Buffers<Retained, Scratch>,
}

type CachedIntegrals = Cached<(TransferFunction, Compositing, ValueScale), Integrals>;

/// What a selection of voxels depends on: the volume, the visible ranges, and how far voxels reach.
type SelectedBy = (ByIdentity<Volume>, Vec<IsoRange>, Reach);

/// What the stages of a frame share.
struct Frame<'a> {
    plan: &'a FramePlan<'a>,
    layer: &'a LayerPlan<'a>,
    level: Level,
    splats: &'a DensitySplats,
    raster: Raster,
}

impl<'a> Frame<'a> {
    fn new(
        plan: &'a FramePlan<'_>,
        layer: &'a LayerPlan<'_>,
        level: Level,
        splats: &'a DensitySplats,
    ) -> Self {
        Self { plan, layer, level, splats, raster: Raster::new(layer, BORDER) }
    }
}

/// Renders into empty tiles with borders; returns how many voxels may have a part in what is seen, and how
/// many of them were never tossed, being occluded.
pub(crate) fn render(
    plan: &FramePlan<'_>,
    layer: &LayerPlan<'_>,
    level: Level,
    splats: &DensitySplats,
    tiles: &mut Tiles,
    buffers: &mut Buffers,
    watch: &mut Stopwatch,
) -> [u64; 2] {
    let Buffers { finite, selection, integrals, slabs } = buffers;
    let frame = Frame::new(plan, layer, level, splats);
    let finite = *finite.made_of(ByIdentity::of(layer.volume), |_| finite_range(layer.volume));
    let is_exact = splats.separable.is_none();
    let reach = Reach::of(layer, &frame.raster, &splats.slabs.grid, is_exact);
    let (scale, ranges) = shown_on_scale(layer, splats.shown, finite);
    let selected_by = (ByIdentity::of(layer.volume), ranges, reach);
    let selection = selection.made_of(selected_by, |(_, ranges, reach)| {
        Selection::new(layer.volume, finite, ranges, reach)
    });
    watch.done("list");
    let n_occluded = draw(&frame, (finite, scale), selection, tiles, (slabs, integrals), watch);
    [selection.n_voxels as u64, n_occluded]
}

/// What values are summed as, and which densities decide what is shown.
fn shown_on_scale(
    layer: &LayerPlan<'_>,
    shown: ShownDensities,
    finite: Option<[f64; 2]>,
) -> (ValueScale, Vec<IsoRange>) {
    let scale = ValueScale::of(layer, shown, finite);
    let ranges = match shown {
        ShownDensities::Composited | ShownDensities::Statistic(_) => layer.relevant.clone(),
        ShownDensities::Isosurfaces => isosurfaces::ranges(layer, &scale),
    };
    (scale, ranges)
}

/// Draws the selected voxels of a volume whose finite values are of that range, if there are any.
fn draw(
    Frame { plan, layer, level, splats, raster }: &Frame<'_>,
    (finite, scale): (Option<[f64; 2]>, ValueScale),
    selection: &Selection,
    tiles: &mut Tiles,
    (slabs, integrals): (&mut slabs::Buffers<Retained, Scratch>, &mut CachedIntegrals),
    watch: &mut Stopwatch,
) -> u64 {
    let extent = finite.map_or(0.0, |range| scale.extent(range));
    let voxels = &Selected::new(selection, layer.volume, scale);
    let bricks = &BrickView::new(layer.volume.grid(), &layer.view);
    let stage = Stage { plan, layer, level: *level, raster, bricks, voxels };
    let layers = [(stage, SectionsInSlabs::of_densities(splats))];
    let limits = Limits::new(scale.ends(), splats.separable.is_none());
    let of_sheets = &splats.slabs;
    match splats.shown {
        ShownDensities::Composited => {
            let key = (layer.transfer.clone(), plan.compositing, scale);
            let integrals = integrals.made_of(key, |(transfer, compositing, scale)| {
                Integrals::new(transfer, *compositing, scale)
            });
            let classifier =
                Classifier::new(plan, layer, of_sheets, integrals, extent, BORDER, limits);
            slabs::render(&layers, &classifier, tiles, slabs, watch)
        }
        ShownDensities::Statistic(statistic) => {
            let width = of_sheets.grid.thickness() / layer.volume.grid().unit();
            let per_full_length = (1.0 / (FULL_PART * width)) as f32;
            let gatherer = Gatherer { statistic, slabs: &of_sheets.grid, limits, per_full_length };
            let n_occluded = slabs::render(&layers, &gatherer, tiles, slabs, watch);
            statistic::classify(tiles, layer.transfer, &scale);
            n_occluded
        }
        ShownDensities::Isosurfaces => {
            let cutoff = plan.opacity_cutoff;
            let surfaces =
                Isosurfaces::new(layer, of_sheets, (&scale, extent), cutoff, BORDER, limits);
            slabs::render(&layers, &surfaces, tiles, slabs, watch)
        }
    }
}

impl Buffers {
    pub(crate) fn resident_bytes(&self) -> usize {
        self.selection.value().map_or(0, Selection::resident_bytes)
            + self.integrals.value().map_or(0, Integrals::resident_bytes)
            + self.slabs.resident_bytes::<Classifier<'_>>()
    }
}
