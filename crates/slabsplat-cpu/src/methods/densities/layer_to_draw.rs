//! A layer of densities that is about to be drawn.

use super::sheets::Limits;
use super::voxels::Selected;
use crate::footprints::raster::Raster;
use crate::methods::slabs::{SectionsInSlabs, Stage};
use fearless_simd::Level;
use slabsplat_backend::densities::{FULL_PART, ValueScale};
use slabsplat_backend::{DensitySplats, FramePlan, LayerPlan};
use slabsplat_core::FrameHandle;
use slabsplat_traverse::BrickView;

pub(super) struct LayerToDraw<'a> {
    pub(super) layer: &'a LayerPlan<'a>,
    pub(super) frame: &'a FrameHandle,
    pub(super) splats: &'a DensitySplats,
    pub(super) raster: Raster,
    pub(super) bricks: BrickView,
    pub(super) voxels: Selected<'a>,
    pub(super) scale: ValueScale,
    /// Of all finite values, scaled.
    pub(super) extent: f64,
    pub(super) limits: Limits,
}

impl LayerToDraw<'_> {
    /// As sections.
    pub(super) fn in_slabs<'a>(
        &'a self,
        plan: &'a FramePlan<'a>,
        level: Level,
    ) -> (Stage<'a>, SectionsInSlabs<'a>) {
        let Self { layer, frame, splats, raster, bricks, voxels, .. } = self;
        let stage =
            Stage { plan, layer, frame, level, raster, finest: (layer, raster), bricks, voxels };
        (stage, SectionsInSlabs::of_densities(splats))
    }

    /// As whole footprints, if rays are parallel and not cut.
    pub(super) fn whole_in_slabs<'a>(
        &'a self,
        plan: &'a FramePlan<'a>,
        level: Level,
    ) -> Option<(Stage<'a>, SectionsInSlabs<'a>)> {
        let are_whole = !self.layer.view.is_perspective() && self.layer.region.is_none();
        let sections = SectionsInSlabs::of_whole_densities(self.splats).filter(|_| are_whole)?;
        let (stage, _) = self.in_slabs(plan, level);
        Some((stage, sections))
    }

    /// One over the length of a ray, in `unit`s, with which a sheet counts in full (model §12).
    pub(super) fn per_full_length(&self) -> f32 {
        let width = self.splats.slabs.grid.thickness() / self.layer.volume.grid().unit();
        (1.0 / (FULL_PART * width)) as f32
    }
}
