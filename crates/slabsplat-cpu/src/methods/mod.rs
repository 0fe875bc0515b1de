//! The methods, each a way from voxels to composited tiles: those that splat colours share a [`Stage`], and
//! `post-classified` splats densities.
//!
//! Reading order: `lit_faces`, `slabs`, `cells`, `image_aligned`; `whole_voxels`, `axis_aligned`,
//! `every_sample`; `densities`.

pub(crate) mod axis_aligned;
mod cells;
pub(crate) mod densities;
pub(crate) mod every_sample;
pub(crate) mod image_aligned;
mod lit_faces;
mod slabs;
mod whole_voxels;

use crate::footprints::raster::Raster;
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
    pub(crate) list: &'a RelevantList,
    pub(crate) bricks: &'a BrickView,
    pub(crate) lighting: VoxelLighting<'a>,
}
