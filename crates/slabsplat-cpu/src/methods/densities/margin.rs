//! How far, in voxels along each axis, a voxel may be from another whose value it shares a pixel with.

use super::rays::Rays;
use crate::footprints::raster::Raster;
use slabsplat_backend::FramePlan;
use slabsplat_core::glam::DVec3;
use slabsplat_core::{Grid, SlabGrid};

/// The largest distance along each axis between a voxel and another, where the one adds to the density at a
/// place, and the other to the density at that place or to one of those that its gradient is taken from.
///
/// The way from one to the other leads from a voxel to a place within its kernel, along the slab, to the
/// next pixel and two slabs on, and to a voxel within whose kernel that is. What depends on the view is
/// bounded for all directions, so that turning the camera leaves the selection as it is.
pub(super) fn margin(plan: &FramePlan<'_>, raster: &Raster, slabs: &SlabGrid) -> [usize; 3] {
    let grid = plan.volume.grid();
    let farthest = slabs.middle(slabs.n_slabs() - 1).max(raster.near.into());
    let scale = plan.view.pixels_per_world(farthest);
    let stretch = plan.view.stretch(scale);
    let step = 2.0 * slabs.thickness() * slant(plan) + 1.0 / scale;
    let index_from_world = grid.index_from_world().matrix3;
    let of_axis = |axis: usize| {
        let index_per_world = index_from_world.row(axis).length();
        let stretched = (stretch - 1.0) * plan.radius * longest(grid) * index_per_world;
        let along = (slabs.thickness() + step) * index_per_world;
        // Kernels are tossed by rounded places; a hundredth is far more than the rounding.
        let margin = 2.0 * (plan.radius + stretched) + along + 0.01;
        (margin.ceil() as usize).min(grid.dims()[axis])
    };
    [0, 1, 2].map(of_axis)
}

/// Length of the ray through a corner of the image over one unit of depth.
fn slant(plan: &FramePlan<'_>) -> f64 {
    let per_depth = Rays::new(&plan.view, 0).right_per_depth;
    let [width, height] = plan.view.image_size().map(f64::from);
    DVec3::new(0.5 * width * per_depth, 0.5 * height * per_depth, 1.0).length()
}

/// How long a step of length 1 in index space may be in the world, at most.
fn longest(grid: &Grid) -> f64 {
    DVec3::from_array(grid.spacing()).length()
}
