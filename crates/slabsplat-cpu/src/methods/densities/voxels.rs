//! The selected voxels as slabs take them in: each adds its weight to a pixel's length, and its weight times
//! its value, in two channels for each of two sheets.

use super::selection::Selection;
use crate::methods::slabs::{BrickVoxels, ReadRoom, Voxels};
use slabsplat_backend::densities::ValueScale;
use slabsplat_core::{Sample, Volume, with_samples};
use slabsplat_traverse::{Brick, BrickGrid, VoxelRecord};

/// Selected voxels of a volume.
pub(super) struct Selected<'a> {
    selection: &'a Selection,
    volume: &'a Volume,
    scale: ValueScale,
    grid: BrickGrid,
}

impl<'a> Selected<'a> {
    pub(super) fn new(selection: &'a Selection, volume: &'a Volume, scale: ValueScale) -> Self {
        Self { selection, volume, scale, grid: BrickGrid::new(volume.grid()) }
    }

    pub(super) fn n_voxels(&self) -> usize {
        self.selection.n_voxels
    }

    fn values<T: Sample>(
        &self,
        samples: &[T],
        brick: &Brick,
        records: &[VoxelRecord],
        colors: &mut [[f32; 4]],
    ) {
        for (color, idx) in colors.iter_mut().zip(self.grid.voxel_indices(brick, records)) {
            let value = self.volume.scaling().apply(samples[idx].to_f64());
            let value = self.scale.scaled(value);
            *color = [value, 1.0, value, 1.0];
        }
    }
}

impl Voxels for Selected<'_> {
    fn n_voxels(&self) -> u64 {
        self.selection.n_voxels as u64
    }

    fn listed(&self) -> &[Brick] {
        &self.selection.bricks
    }

    fn read<'a>(&'a self, brick: &Brick, room: &'a mut ReadRoom) -> Option<BrickVoxels<'a>> {
        let ReadRoom { records, .. } = room;
        records.clear();
        records.extend(
            self.selection.slots_of(brick).map(|slot| VoxelRecord { slot, normal: [0; 3] }),
        );
        Some(BrickVoxels::new(records))
    }

    fn color(
        &self,
        brick: &Brick,
        _: &BrickVoxels<'_>,
        records: &[VoxelRecord],
        colors: &mut [[f32; 4]],
    ) {
        with_samples!(self.volume.samples(), |s| self.values(s, brick, records, colors));
    }
}
