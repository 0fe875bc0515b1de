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
use crate::voxels::relevant::OnDemand;
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

/// How the relevant voxels of a layer are had.
#[derive(Debug)]
pub(crate) enum RelevantVoxels<'a> {
    /// All of them, listed.
    Listed(&'a RelevantList),
    /// Brick by brick, where cells may be drawn instead.
    OnDemand(OnDemand<'a>),
}

impl RelevantVoxels<'_> {
    /// How many they are.
    pub(crate) fn n_voxels(&self) -> u64 {
        match self {
            Self::Listed(list) => list.len() as u64,
            Self::OnDemand(on_demand) => on_demand.bricks.n_voxels(),
        }
    }
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
