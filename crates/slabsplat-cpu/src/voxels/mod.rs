//! Voxels on their way to tiles: which are relevant, what is stored of each, and the second level of the
//! toss.
//!
//! Reading order: `relevant`, `voxel`, `by_sheet`.

pub(crate) mod by_sheet;
pub(crate) mod relevant;
pub(crate) mod voxel;
