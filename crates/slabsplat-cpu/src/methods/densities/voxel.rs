//! The voxels of a frame that are splatted, where they are, and what value each has.

use super::values::ValueScale;
use rayon::prelude::*;
use slabsplat_backend::FramePlan;
use slabsplat_core::glam::DVec3;

/// A voxel in view space, with what its sections weigh.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct DensityVoxel {
    /// Right, up, and depth from the grid's centre.
    pub(super) point: [f32; 3],
    /// Its value, scaled.
    pub(super) value: f32,
}

/// Voxels that a thread takes on at a time.
const MIN_LEN: usize = 1 << 12;

/// Projects voxels, given by their places in memory.
pub(super) fn project(
    plan: &FramePlan<'_>,
    scale: &ValueScale,
    selected: &[u32],
    voxels: &mut Vec<DensityVoxel>,
) {
    let grid = plan.volume.grid();
    let view_from_index = plan.view.from_index(grid);
    let voxel = |&voxel_idx: &u32| {
        let [i, j, k] = grid.voxel_coords(voxel_idx as usize).map(|c| c as f64);
        let point = view_from_index.transform(DVec3::new(i, j, k)).as_vec3().to_array();
        DensityVoxel { point, value: scale.scaled(plan.volume.value(voxel_idx as usize)) }
    };
    selected.par_iter().with_min_len(MIN_LEN).map(voxel).collect_into_vec(voxels);
}
