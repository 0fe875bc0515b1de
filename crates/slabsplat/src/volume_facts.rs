//! What is looked at of a volume before it is drawn, wherever its voxels are: in memory, or in boxes of a
//! file (`divided`), of which the same is found.

use crate::transfer::VolumeValues;
use slabsplat_core::{Grid, Volume};

/// A volume as far as its look and its transfer function follow from it.
#[derive(Clone, Copy)]
pub(crate) struct VolumeFacts<'a> {
    /// Of all voxels.
    pub(crate) grid: Grid,
    /// Of all voxels.
    pub(crate) values: &'a dyn VolumeValues,
}

impl<'a> From<&'a Volume> for VolumeFacts<'a> {
    /// Those of a volume in memory.
    fn from(volume: &'a Volume) -> Self {
        Self { grid: *volume.grid(), values: volume }
    }
}

impl<'a> VolumeFacts<'a> {
    /// What transfer functions are fitted to: values, and the length of a voxel step.
    pub(crate) fn scale(&self) -> (&'a dyn VolumeValues, f64) {
        (self.values, self.grid.unit())
    }
}
