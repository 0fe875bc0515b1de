//! Splatting without the blur (Mueller, Möller & Crawfis, IEEE Visualization '99): sheets hold densities, and
//! what lies between them is classified and shaded. Model §8.
//!
//! ```text
//! for each tile, in parallel:
//!     for each two sheets from the eye, half a slab thick:
//!         for each layer:
//!             add its sections: length += H, weighted value += H·v             (methods/slabs)
//!             put both sheets with the five before them                        (sheets.rs)
//!         for each of both:
//!             for each layer:
//!                 for each eight open pixels, between the two sheets in the middle:
//!                     densities in the middle of each                          (nodes.rs)
//!                     where anything shows between them: slopes on the way     (nodes.rs)
//!                         mean opacity and colour of all densities on the way  (integrals.rs)
//!                         light                                                (parts.rs)
//!             composite what came of all layers, as any sheet
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
//! `finite`, `reach`, `bit_rows`, `codes`, `selection`, `voxels`; `sheets`, `groups`, `rings`, `rays`,
//! `depths`, `nodes`, `normals`; `layer_to_draw`; `integrals`, `parts`, `classify`; `one_for_all`,
//! `saturation`, `extremes`, `means`, `grazed`, `joined`, `statistic`; `crossing`, `isosurfaces`, `passed`,
//! `surfaces`.

mod bit_rows;
mod codes;
mod finite;
mod reach;
mod selection;
mod voxels;

mod depths;
mod groups;
mod nodes;
mod normals;
mod rays;
mod rings;
mod sheets;

mod layer_to_draw;

mod integrals;
mod parts;

mod classify;

mod extremes;
mod grazed;
mod joined;
mod means;
mod one_for_all;
mod saturation;
mod statistic;

mod crossing;
mod isosurfaces;
mod passed;
mod surfaces;

#[cfg(test)]
mod tests;

use super::slabs;
use crate::footprints::raster::Raster;
use crate::pixels::tiles::Tiles;
use crate::stopwatch::Stopwatch;
use classify::{Classifier, LayerClassifier};
use fearless_simd::Level;
use finite::finite_range;
use integrals::Integrals;
use isosurfaces::Isosurfaces;
use joined::JoinedLayers;
use layer_to_draw::LayerToDraw;
use reach::Reach;
use rings::{Rings, Scratch};
use selection::{BEYOND_AT_NODES, BEYOND_AT_PEAKS, Selection};
use sheets::Limits;
use slabsplat_backend::densities::ValueScale;
use slabsplat_backend::{ByIdentity, Cached, FramePlan, LayerPlan, ShownDensities, Splats};
use slabsplat_core::{
    Cancelled, Compositing, FrameHandle, IsoRange, Statistic, TransferFunction, Volume,
};
use slabsplat_traverse::BrickView;
use statistic::OneByOne;
use surfaces::Surfaces;
use voxels::Selected;

/// Pixels on each side of a tile that are summed for gradients alone.
const BORDER: usize = 1;

/// How many there are.
pub(crate) fn border(shown: ShownDensities) -> usize {
    match shown {
        ShownDensities::Composited | ShownDensities::Isosurfaces => BORDER,
        ShownDensities::Statistic(_) => 0,
    }
}

/// What is cached from frame to frame.
#[derive(Debug, Default)]
pub(crate) struct Buffers {
    of_layers: Vec<OfLayer>,
    to_draw: BuffersToDraw,
}

/// What is cached of which voxels of a layer are drawn.
#[derive(Debug, Default)]
struct OfLayer {
    finite: Cached<ByIdentity<Volume>, Option<[f64; 2]>>,
    selection: Cached<SelectedBy, Selection>,
}

/// What is cached of how they are drawn.
#[derive(Debug, Default)]
struct BuffersToDraw {
    /// Of each layer.
    integrals: Vec<CachedIntegrals>,
    slabs: slabs::Buffers<Rings, Scratch>,
    joined: JoinedLayers,
}

type CachedIntegrals = Cached<(TransferFunction, Compositing, ValueScale), Integrals>;

/// What a selection of voxels depends on: the volume, the visible ranges, how far beyond values these count,
/// and how far voxels reach.
type SelectedBy = (ByIdentity<Volume>, (Vec<IsoRange>, f64), Reach);

/// Renders into empty tiles with borders; returns how many voxels may have a part in what is seen, and how
/// many of them were never tossed, being occluded.
pub(crate) fn render(
    plan: &FramePlan<'_>,
    shown: ShownDensities,
    level: Level,
    tiles: &mut Tiles,
    Buffers { of_layers, to_draw }: &mut Buffers,
    watch: &mut Stopwatch<'_>,
) -> Result<[u64; 2], Cancelled> {
    of_layers.resize_with(plan.layers.len(), OfLayer::default);
    let mut layers = Vec::with_capacity(plan.layers.len());
    for (of_layer, layer) in of_layers.iter_mut().zip(&plan.layers) {
        layers.extend(of_layer.prepare(layer, watch.frame())?);
    }
    watch.done("list")?;
    let n_voxels =
        layers.iter().map(|layer: &LayerToDraw<'_>| layer.voxels.n_voxels() as u64).sum();
    let n_occluded = draw(plan, shown, level, &layers, tiles, to_draw, watch)?;
    Ok([n_voxels, n_occluded])
}

impl OfLayer {
    /// `None` of a layer that splats no densities.
    fn prepare<'a>(
        &'a mut self,
        layer: &'a LayerPlan<'a>,
        frame: &'a FrameHandle,
    ) -> Result<Option<LayerToDraw<'a>>, Cancelled> {
        let Splats::Densities(splats) = &layer.splats else { return Ok(None) };
        let Self { finite, selection } = self;
        let identity = ByIdentity::of(layer.volume);
        let finite = *finite.try_made_of(identity, |_| finite_range(layer.volume, frame))?;
        let raster = Raster::new(layer, border(splats.shown));
        let is_exact = splats.separable.is_none();
        let reach = Reach::of(layer, &raster, &splats.slabs.grid, is_exact);
        let (scale, ranges) = shown_on_scale(layer, splats.shown, finite);
        let thickness = splats.slabs.grid.thickness() / layer.volume.grid().unit();
        let shown = (ranges, beyond(splats.shown));
        let selected_by = (ByIdentity::of(layer.volume), shown, reach);
        let selection = selection.try_made_of(selected_by, |(_, (ranges, beyond), reach)| {
            Selection::new(layer.volume, finite, (ranges, *beyond), reach, frame)
        })?;
        Ok(Some(LayerToDraw {
            layer,
            frame,
            splats,
            raster,
            bricks: BrickView::new(layer.volume.grid(), &layer.view),
            voxels: Selected::new(selection, layer.volume, scale),
            scale,
            extent: finite.map_or(0.0, |range| scale.extent(range)),
            limits: Limits::new(scale.ends(), thickness, is_exact),
        }))
    }

    fn resident_bytes(&self) -> usize {
        self.selection.value().map_or(0, Selection::resident_bytes)
    }
}

/// How far beyond values lies what is shown of them, as a part of their distance.
fn beyond(shown: ShownDensities) -> f64 {
    match shown {
        ShownDensities::Composited | ShownDensities::Isosurfaces => BEYOND_AT_NODES,
        ShownDensities::Statistic(_) => BEYOND_AT_PEAKS,
    }
}

/// What values are summed as, and which densities decide what is shown.
fn shown_on_scale(
    layer: &LayerPlan<'_>,
    shown: ShownDensities,
    finite: Option<[f64; 2]>,
) -> (ValueScale, Vec<IsoRange>) {
    let scale = ValueScale::of(layer, shown, finite);
    let ranges = match shown {
        ShownDensities::Composited => layer.relevant.clone(),
        ShownDensities::Statistic(statistic) => {
            let worst = scale.value(scale.worst(statistic, &layer.relevant).into());
            let all = IsoRange { lo: f64::NEG_INFINITY, hi: f64::INFINITY };
            let deciding = match statistic {
                Statistic::Maximum => IsoRange { lo: worst, ..all },
                Statistic::Minimum => IsoRange { hi: worst, ..all },
                Statistic::Average => all,
            };
            // Of nothing that is visible nothing decides.
            layer.relevant.iter().take(1).map(|_| deciding).collect()
        }
        ShownDensities::Isosurfaces => isosurfaces::ranges(layer, &scale),
    };
    (scale, ranges)
}

fn draw(
    plan: &FramePlan<'_>,
    shown: ShownDensities,
    level: Level,
    layers: &[LayerToDraw<'_>],
    tiles: &mut Tiles,
    buffers: &mut BuffersToDraw,
    watch: &mut Stopwatch<'_>,
) -> Result<u64, Cancelled> {
    let BuffersToDraw { integrals, slabs, joined } = buffers;
    let (compositing, cutoff) = (plan.compositing, plan.opacity_cutoff);
    let in_slabs = layers.iter().map(|layer| layer.in_slabs(plan, level));
    match shown {
        ShownDensities::Composited => {
            integrals.resize_with(layers.len(), CachedIntegrals::default);
            let layers = layers.iter().zip(integrals);
            let layers = layers.map(|(layer, integrals)| layer.classifier(plan, integrals));
            let classifier = Classifier { layers: layers.collect(), compositing, cutoff };
            slabs::render(in_slabs, &classifier, tiles, slabs, watch)
        }
        ShownDensities::Isosurfaces => {
            let layers = layers.iter().map(LayerToDraw::isosurfaces).collect();
            slabs::render(in_slabs, &Surfaces { layers, cutoff }, tiles, slabs, watch)
        }
        ShownDensities::Statistic(statistic) => {
            OneByOne { plan, level, statistic }.draw(layers, tiles, (slabs, joined), watch)
        }
    }
}

impl LayerToDraw<'_> {
    fn classifier<'a>(
        &'a self,
        plan: &FramePlan<'_>,
        integrals: &'a mut CachedIntegrals,
    ) -> LayerClassifier<'a> {
        let Self { layer, splats, scale, extent, limits, .. } = self;
        // A transfer function is copied only if it is new.
        let (transfer, compositing) = (layer.transfer, plan.compositing);
        let is_key = |(of, by, on): &(TransferFunction, Compositing, ValueScale)| {
            of == transfer && *by == compositing && on == scale
        };
        let integrals = integrals.made_unless(is_key, || {
            let key = (transfer.clone(), compositing, *scale);
            (key, Integrals::new(transfer, compositing, scale))
        });
        LayerClassifier::new(plan, layer, &splats.slabs, integrals, *extent, BORDER, *limits)
    }

    fn isosurfaces(&self) -> Isosurfaces<'_> {
        let values = (&self.scale, self.extent);
        Isosurfaces::new(self.layer, &self.splats.slabs, values, BORDER, self.limits)
    }
}

impl Buffers {
    pub(crate) fn resident_bytes(&self) -> usize {
        let BuffersToDraw { integrals, slabs, joined } = &self.to_draw;
        let of_integrals =
            |integrals: &CachedIntegrals| integrals.value().map_or(0, Integrals::resident_bytes);
        self.of_layers.iter().map(OfLayer::resident_bytes).sum::<usize>()
            + integrals.iter().map(of_integrals).sum::<usize>()
            + slabs.resident_bytes::<Classifier<'_>>()
            + joined.resident_bytes()
    }
}
