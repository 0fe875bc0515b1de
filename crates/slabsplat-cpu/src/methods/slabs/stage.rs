//! What a method says of a layer that goes through slabs: which voxels there are, and what a sheet sums of
//! each.

use crate::footprints::raster::Raster;
use fearless_simd::Level;
use rayon::prelude::*;
use slabsplat_backend::{FramePlan, LayerPlan};
use slabsplat_core::FrameHandle;
use slabsplat_traverse::{Brick, BrickBounds, BrickRoom, BrickView, CellBrick, VoxelRecord};

/// What the stages of a frame that goes through slabs share, for one layer or one level of detail of it.
#[derive(Clone, Copy)]
pub(in crate::methods) struct Stage<'a> {
    pub(in crate::methods) plan: &'a FramePlan<'a>,
    pub(in crate::methods) layer: &'a LayerPlan<'a>,
    pub(in crate::methods) frame: &'a FrameHandle,
    /// The instructions to be used.
    pub(in crate::methods) level: Level,
    pub(in crate::methods) raster: &'a Raster,
    /// The layer by voxels, by which bricks of cells may be drawn instead: of all levels they have the
    /// widest kernels.
    pub(in crate::methods) finest: (&'a LayerPlan<'a>, &'a Raster),
    pub(in crate::methods) bricks: &'a BrickView,
    pub(in crate::methods) voxels: &'a dyn Voxels,
}

/// The voxels that are splatted, and what a sheet sums of each. A brick has a key, which says more to those
/// who give it than to those who get it: keys rise in memory order.
pub(in crate::methods) trait Voxels: Sync {
    /// Relevant voxels in all, of a layer; 0 of its coarser levels.
    fn n_voxels(&self) -> u64;

    /// The bricks that hold any, in memory order, if they are listed; their keys are their indices.
    fn listed(&self) -> &[Brick] {
        &[]
    }

    /// Writes the keys of the bricks that hold any, each behind what `range_of` returns of it.
    fn bricks(&self, range_of: &(dyn Fn(&Brick) -> u32 + Sync), into: &mut Vec<(u32, u32)>) {
        let listed = self.listed().par_iter().enumerate();
        listed.map(|(idx, brick)| (range_of(brick), idx as u32)).collect_into_vec(into);
    }

    /// The brick of a key.
    fn brick(&self, key: u32) -> Brick {
        self.listed()[key as usize]
    }

    /// The voxels of one of the bricks; `None` if they are to be drawn by those of a finer level.
    fn read<'a>(&'a self, brick: &Brick, room: &'a mut ReadRoom) -> Option<BrickVoxels<'a>>;

    /// The keys of what the next finer level has of a brick that is not drawn by this one.
    fn finer<'a>(&'a self, key: u32) -> Box<dyn Iterator<Item = u32> + 'a> {
        unreachable!("brick {key} was not refused by those who have no finer level")
    }

    /// Writes what a sheet sums of some `records` of what was [read](Self::read), at weight 1.
    fn color(
        &self,
        brick: &Brick,
        read: &BrickVoxels<'_>,
        records: &[VoxelRecord],
        colors: &mut [[f32; 4]],
    );
}

impl Stage<'_> {
    /// The box in view space of all that a brick may be drawn by.
    pub(super) fn bounds_of_brick(&self, brick: &Brick) -> BrickBounds {
        self.bricks.bounds_of_all_levels(brick)
    }

    /// Whether its bricks may be drawn by others.
    pub(super) fn has_finer(&self) -> bool {
        0 < self.layer.level
    }
}

/// The voxels of a brick, in memory order.
#[derive(Clone, Copy)]
pub(in crate::methods) struct BrickVoxels<'a> {
    pub(in crate::methods) records: &'a [VoxelRecord],
    /// Relevant voxels, of which there may be more than records.
    pub(in crate::methods) n_voxels: u64,
    /// What else there is to know, if they are cells.
    pub(in crate::methods) cells: Option<&'a CellBrick>,
}

/// Where a thread reads bricks that are not stored as they are read.
#[derive(Debug, Default)]
pub(in crate::methods) struct ReadRoom {
    pub(in crate::methods) made: BrickRoom,
    pub(in crate::methods) records: Vec<VoxelRecord>,
}

impl<'a> BrickVoxels<'a> {
    /// Of voxels.
    pub(in crate::methods) fn new(records: &'a [VoxelRecord]) -> Self {
        Self { records, n_voxels: records.len() as u64, cells: None }
    }
}
