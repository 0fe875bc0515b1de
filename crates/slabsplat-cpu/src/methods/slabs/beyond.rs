//! Which bricks have nothing to do with a region, or with the part of a frame that is drawn.

use super::stage::Stage;
use slabsplat_backend::SceneInParts;
use slabsplat_core::glam::{DMat3, DVec3};
use slabsplat_core::{PartInView, RegionInView, SlabGrid};
use slabsplat_kernel::SplitLevels;
use slabsplat_traverse::BrickBounds;

/// How far voxels reach into a region, or a part, from outside.
pub(super) struct Beyond<'a> {
    region: Option<&'a RegionInView>,
    part: Option<&'a PartInView>,
    /// Takes steps in index space to steps in view space.
    view_from_index: DMat3,
    /// Of a footprint, in index space.
    radius: f64,
    /// Half the sides of the box around it, in view space, for separable ones.
    half_box: DVec3,
    /// How much further, sideways and in depth, a voxel may be drawn, in world units.
    aside: f64,
    behind: f64,
}

impl<'a> Beyond<'a> {
    /// `None` if the layer is seen everywhere, and all of the frame is drawn.
    pub(super) fn new(stage: &Stage<'a>, slabs: &SlabGrid) -> Option<Self> {
        let (layer, _) = stage.finest;
        let view = &layer.view;
        let (region, part) = (layer.region.as_ref(), stage.plan.part.as_ref());
        if region.is_none() && part.is_none() {
            return None;
        }
        let far = slabs.faces(slabs.n_slabs() - 1)[1].max(view.near_depth());
        // Rays count as parallel within a slab, and a whole voxel may be drawn in one further back.
        let n_slabs = SplitLevels::MOST_SLABS_BEFORE + 1;
        let view_from_index = view.from_index(&layer.grid()).matrix;
        let radius = layer.radius * view.stretch(view.pixels_per_world(far));
        let wider = SceneInParts::WIDER_WHERE_SEPARABLE;
        let wider = DVec3::new(wider, wider, 1.0);
        let along = |axis: usize| wider[axis] * radius * view_from_index.row(axis).length();
        Some(Self {
            region,
            part,
            view_from_index,
            radius,
            half_box: DVec3::from_array([0, 1, 2].map(along)),
            aside: 0.5 * slabs.thickness() * view.steepest_ray(),
            behind: n_slabs as f64 * slabs.thickness(),
        })
    }

    /// Whether none of a brick's voxels is seen.
    pub(super) fn hides(&self, BrickBounds { center, half_extents }: &BrickBounds) -> bool {
        let [center, half_extents] =
            [center, half_extents].map(|v| DVec3::from_array(v.map(f64::from)));
        let beside =
            |normal: DVec3| self.aside * normal.truncate().length() + self.behind * normal.z.abs();
        let of_region = |normal: DVec3| {
            self.radius * (self.view_from_index.transpose() * normal).length() + beside(normal)
        };
        // A part has to show what the whole does, where a footprint ends little by little.
        let of_part = |normal: DVec3| normal.abs().dot(self.half_box) + beside(normal);
        self.region.is_some_and(|region| region.is_beyond(center, half_extents, of_region))
            || self.part.is_some_and(|part| part.is_beyond(center, half_extents, of_part))
    }
}
