//! The list-based traversal of the paper (§4): which voxels are drawn, in which colour and order.
//!
//! The way of the data through this crate is its reading order:
//!
//! - `voxel`: what is kept of a voxel;
//! - `value_order`: all voxels sorted by value, once a volume;
//! - `gradient`: the normal of a voxel;
//! - `relevant_list`: `L_r`, the voxels whose opacity is above 0, kept up to date by difference;
//! - `shade`: classification and Blinn–Phong, once a voxel and frame;
//! - `project`: index space to view space;
//! - `depth_order`: what `every-sample` composites by (`axis-aligned` goes by slices, in core);
//! - `toss`: buckets instead of a sort (§7), by image tile and then by slab.
//!
//! Every stage is parallel, and gives the same result for any number of threads. Nothing here knows
//! kernels' weights or draws a pixel.
//!
//! ```
//! use slabsplat_core::{Grid, IsoRange, Samples, Scaling, Volume};
//! use slabsplat_traverse::{RelevantList, ValueOrder};
//!
//! let grid = Grid::with_spacing([4, 1, 1], [1.0; 3])?;
//! let volume = Volume::new(grid, Samples::U8(vec![9, 3, 7, 5]), Scaling::IDENTITY)?;
//! let order = ValueOrder::new(&volume);
//! let mut list = RelevantList::default();
//! list.update(&volume, &order, &[IsoRange { lo: 5.0, hi: 8.0 }]);
//! let voxels: Vec<u32> = list.records().iter().map(|r| r.voxel_idx).collect();
//! assert_eq!(voxels, [2, 3]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod gradient;
mod relevant_list;
mod value_order;
mod voxel;

mod project;
mod shade;

mod depth_order;
mod toss;

pub use depth_order::depth_order;
pub use gradient::Normals;
pub use project::project;
pub use relevant_list::{ListChange, RelevantList};
pub use shade::{ShadeDesc, shade};
pub use toss::{SlabBuckets, TileBuckets, TileGrid, TileRect};
pub use value_order::ValueOrder;
pub use voxel::VoxelRecord;
