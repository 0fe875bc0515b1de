//! Which bricks have nothing to do with a region.

use super::stage::Stage;
use slabsplat_core::glam::{DMat3, DVec3};
use slabsplat_core::{RegionInView, SlabGrid};
use slabsplat_kernel::SplitLevels;
use slabsplat_traverse::BrickBounds;

/// How far voxels reach into a region from outside.
pub(super) struct Beyond<'a> {
    region: &'a RegionInView,
    /// Takes steps in index space to steps in view space.
    view_from_index: DMat3,
    /// Of a footprint, in index space.
    radius: f64,
    /// How much further, sideways and in depth, a voxel may be drawn, in world units.
    aside: f64,
    behind: f64,
}

impl<'a> Beyond<'a> {
    /// `None` if the layer is seen everywhere.
    pub(super) fn new(stage: &Stage<'a>, slabs: &SlabGrid) -> Option<Self> {
        let layer = stage.layer;
        let view = &layer.view;
        let region = layer.region.as_ref()?;
        let far = slabs.faces(slabs.n_slabs() - 1)[1].max(view.near_depth());
        // Rays count as parallel within a slab, and a whole voxel may be drawn in one further back.
        let n_slabs = SplitLevels::MOST_SLABS_BEFORE + 1;
        Some(Self {
            region,
            view_from_index: view.from_index(&layer.grid()).matrix,
            radius: layer.radius * view.stretch(view.pixels_per_world(far)),
            aside: 0.5 * slabs.thickness() * view.steepest_ray(),
            behind: n_slabs as f64 * slabs.thickness(),
        })
    }

    /// Whether none of a brick's voxels is seen.
    pub(super) fn hides(&self, BrickBounds { center, half_extents }: &BrickBounds) -> bool {
        let [center, half_extents] =
            [center, half_extents].map(|v| DVec3::from_array(v.map(f64::from)));
        self.region.is_beyond(center, half_extents, |normal| {
            self.radius * (self.view_from_index.transpose() * normal).length()
                + self.aside * normal.truncate().length()
                + self.behind * normal.z.abs()
        })
    }
}
