//! The list-based traversal of the paper (§4): which voxels are drawn, in which colour and order.
//!
//! The way of the data through this crate is its reading order:
//!
//! - `bricks`, `voxel`: how the volume is cut up, and what is stored of a voxel;
//! - `order`: iso-ranges of values as ranges of samples;
//! - `brick_ranges`: the least and the largest value of every brick, once a volume;
//! - `visible_labels`, `gradient_length`, `voxel_rules`: what decides beside its value whether a voxel is
//!   visible;
//! - `membership`, `gradient`: which voxels of a brick are relevant, and their normals;
//! - `relevant_list`, `relevant_update`: `L_r`, the voxels whose opacity is above 0, updated by
//!   difference;
//! - `classification`: samples to colour and opacity, once a transfer function;
//! - `blinn_phong`, `shade`: Blinn–Phong, once a voxel and frame;
//! - `brick_lister`, `cells`: cells of voxels, and bricks of either that are made when they are seen;
//! - `cell_light`: Blinn–Phong on cells, whose voxels face many ways;
//! - `project`: index space to view space, voxels and whole bricks;
//! - `depth_order`: what `every-sample` composites by (`axis-aligned` goes by slices, in core);
//! - `buckets`, `toss`: buckets instead of a sort (§7), by image tile and then by slab;
//! - `workspaces`: what threads work with.
//!
//! Every stage is parallel, and gives the same result for any number of threads. What takes long looks every
//! millisecond whether its frame was cancelled. Nothing here knows kernels' weights or draws a pixel.
//!
//! ```
//! use slabsplat_core::{Grid, IsoRange, Samples, Scaling, Volume};
//! use slabsplat_traverse::{BrickRanges, RelevantList};
//!
//! let grid = Grid::with_spacing([4, 1, 1], [1.0; 3])?;
//! let volume = Volume::new(grid, Samples::U8(vec![9, 3, 7, 5]), Scaling::IDENTITY)?;
//! let brick_ranges = BrickRanges::new(&volume);
//! let mut list = RelevantList::default();
//! list.update(&volume, &brick_ranges, &[IsoRange { lo: 5.0, hi: 8.0 }], None);
//! let brick = &list.bricks()[0];
//! let xs = list.voxels_of(brick).iter().map(|&record| list.voxel_coords(brick, record)[0]);
//! assert_eq!(xs.collect::<Vec<_>>(), [2, 3]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod bricks;
mod voxel;

mod in_pieces;

mod order;

mod brick_lister;
mod brick_ranges;
mod gradient;
mod gradient_length;
mod membership;
mod relevant_list;
mod relevant_update;
mod visible_labels;
mod voxel_rules;

mod blinn_phong;
mod classification;
mod project;
mod shade;

mod cells;

mod cell_light;

mod buckets;
mod depth_order;
mod toss;

mod workspaces;

#[cfg(test)]
mod naive_normals;
#[cfg(test)]
mod tests;

pub use blinn_phong::{BlinnPhong8, Light8};
pub use brick_lister::BrickLister;
pub use brick_ranges::BrickRanges;
pub use bricks::{BRICK_SIDE, Brick, BrickGrid};
pub use buckets::Buckets;
pub use cells::{
    BrickMaker, BrickRoom, BricksOnDemand, CELL_LEVELS, CellBrick, CellRecord, CellValues, Cells16,
    Moments,
};
pub use classification::Classification;
pub use depth_order::DepthOrder;
pub use in_pieces::{map_for_frame, resize_for_frame};
pub use project::{BrickBounds, BrickView};
pub use relevant_list::{ListChange, RelevantList};
pub use shade::VoxelLighting;
pub use toss::{PixelRect, TileBuckets, TileEntry, TileGrid, TileRect, TileToss};
pub use voxel::{NORMAL_STEPS, VoxelRecord};
pub use voxel_rules::{OwnVoxelRules, VoxelRules};
pub use workspaces::Workspaces;
