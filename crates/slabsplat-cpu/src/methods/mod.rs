//! The methods, each a way from voxels to composited tiles: those that splat colours share a [`Stage`], and
//! `post-classified` splats densities.
//!
//! Reading order: `shade`, `lit_faces`, `slabs`, `on_demand`, `image_aligned`; `whole_voxels`,
//! `axis_aligned`, `every_sample`; `densities`.

pub(crate) mod axis_aligned;
pub(crate) mod densities;
pub(crate) mod every_sample;
pub(crate) mod image_aligned;
mod lit_faces;
mod on_demand;
mod shade;
mod slabs;
mod whole_voxels;

use crate::footprints::raster::Raster;
use crate::voxels::relevant::RelevantVoxels;
use fearless_simd::Level;
use slabsplat_backend::{FramePlan, LayerPlan};
use slabsplat_core::FrameHandle;
use slabsplat_traverse::{BrickView, RelevantList, VoxelLighting};

/// What the stages of a frame of coloured splats share, for one layer.
pub(crate) struct Stage<'a> {
    pub(crate) plan: &'a FramePlan<'a>,
    pub(crate) layer: &'a LayerPlan<'a>,
    pub(crate) frame: &'a FrameHandle,
    /// The instructions to be used.
    pub(crate) level: Level,
    pub(crate) raster: Raster,
    pub(crate) relevant: RelevantVoxels<'a>,
    pub(crate) bricks: &'a BrickView,
    pub(crate) lighting: VoxelLighting<'a>,
}

impl Stage<'_> {
    /// The list, of methods that have no levels of detail.
    fn list(&self) -> &RelevantList {
        match &self.relevant {
            RelevantVoxels::Listed(list) => list,
            RelevantVoxels::OnDemand(_) => unreachable!("only image-aligned has plans with cells"),
        }
    }
}
