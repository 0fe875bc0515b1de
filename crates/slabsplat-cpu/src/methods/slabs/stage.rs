//! What a method says of a layer that goes through slabs: which voxels there are, and what a sheet sums of
//! each.

use crate::footprints::raster::Raster;
use fearless_simd::Level;
use slabsplat_backend::{FramePlan, LayerPlan};
use slabsplat_core::FrameHandle;
use slabsplat_traverse::{Brick, BrickView, VoxelRecord};

/// What the stages of a frame that goes through slabs share, for one layer.
#[derive(Clone, Copy)]
pub(in crate::methods) struct Stage<'a> {
    pub(in crate::methods) plan: &'a FramePlan<'a>,
    pub(in crate::methods) layer: &'a LayerPlan<'a>,
    pub(in crate::methods) frame: &'a FrameHandle,
    /// The instructions to be used.
    pub(in crate::methods) level: Level,
    pub(in crate::methods) raster: &'a Raster,
    pub(in crate::methods) bricks: &'a BrickView,
    pub(in crate::methods) voxels: &'a dyn Voxels,
}

/// The voxels that are splatted, and what a sheet sums of each.
pub(in crate::methods) trait Voxels: Sync {
    /// The bricks that hold any, in memory order.
    fn bricks(&self) -> &[Brick];

    /// How many relevant voxels are drawn by one of them.
    fn n_voxels(&self, brick: &Brick) -> u64 {
        brick.n_voxels.into()
    }

    /// The voxels of one of the bricks, in memory order; `room` may hold them.
    fn records_of<'a>(&'a self, brick: &Brick, room: &'a mut Vec<VoxelRecord>)
    -> &'a [VoxelRecord];

    /// Writes what a sheet sums of some of them, at weight 1.
    fn color(&self, brick: &Brick, records: &[VoxelRecord], colors: &mut [[f32; 4]]);
}
