//! What a method says of a frame that goes through slabs: which voxels there are, what a sheet sums of each,
//! and what becomes of a sheet.

use crate::footprints::raster::Raster;
use crate::pixels::sheet::Sheet;
use crate::pixels::tile::Tile;
use crate::pixels::tile_region::TileRegion;
use fearless_simd::{Level, Simd};
use slabsplat_backend::{FramePlan, LayerPlan};
use slabsplat_traverse::{Brick, BrickView, VoxelRecord};

/// What the stages of a frame that goes through slabs share, for one layer.
pub(in crate::methods) struct Stage<'a> {
    pub(in crate::methods) plan: &'a FramePlan<'a>,
    pub(in crate::methods) layer: &'a LayerPlan<'a>,
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

    /// The voxels of one of the bricks, in memory order; `room` may hold them.
    fn records_of<'a>(&'a self, brick: &Brick, room: &'a mut Vec<VoxelRecord>)
    -> &'a [VoxelRecord];

    /// Writes what a sheet sums of some of them, at weight 1.
    fn color(&self, brick: &Brick, records: &[VoxelRecord], colors: &mut [[f32; 4]]);
}

/// What becomes of the sheets of a tile.
pub(in crate::methods) trait Sheets: Sync {
    /// What a tile retains from slab to slab.
    type Retained: Default + Send;
    /// What a thread needs beside.
    type Scratch: Default + Send;

    /// The slabs that a sheet has the sums of: one, or two that follow each other, with two channels each.
    const AT_ONCE: usize;

    /// For how many slabs behind one its sheet is needed.
    const N_BEHIND: usize;

    /// Whether regions cut what sections sum to. If not, they cut what the method makes of it.
    const CUTS_SUMS: bool;

    /// The depth before which nothing is left to be composited, once all slabs before one were taken.
    fn front(&self, slab: usize) -> f32;

    /// Whether a slab has a part in a region; if not, it is in it or not by its middle.
    fn splits_slabs(&self) -> bool;

    /// Takes what the sections of a slab, or of it and the next, sum to, and leaves the sheet empty. There
    /// is a region, of the only layer, if there is something to be cut.
    fn take<S: Simd>(
        &self,
        simd: S,
        slab: usize,
        sheet: &mut Sheet,
        tile: (&mut Tile, Option<&TileRegion>),
        retained: &mut Self::Retained,
        scratch: &mut Self::Scratch,
    );

    /// Frees what a tile retains, if it needs it no more.
    fn release(&self, retained: &mut Self::Retained, scratch: &mut Self::Scratch);

    /// Bytes that a thread's scratch holds.
    fn scratch_bytes(scratch: &Self::Scratch) -> usize;
}
