//! Voxels by depth, for `every-sample` (paper §4: "with respect to their distance from the viewing
//! plane").
//!
//! Whole planes of voxels are equally deep in many views, up to rounding, and the order among them shows.
//! So depths are rounded to a grid that is coarser than the rounding errors, and equals are sorted
//! by their place in the picture: the result does not depend on how voxels are stored.

use crate::VoxelRecord;
use rayon::prelude::*;
use slabsplat_core::glam::DVec3;
use slabsplat_core::{Grid, View};

/// Steps of the rounding grid per `unit`.
const STEPS_PER_UNIT: f64 = (1 << 20) as f64;

/// The places of `records` in the order of depth, front to back; then bottom to top, left to right.
pub fn depth_order(grid: &Grid, view: &View, records: &[VoxelRecord]) -> Vec<u32> {
    let view_from_index = view.from_index(grid);
    let steps_per_world = STEPS_PER_UNIT / grid.unit();
    let mut keys: Vec<([i64; 3], u32)> = records
        .par_iter()
        .enumerate()
        .map(|(record_idx, record)| {
            let [i, j, k] = grid.voxel_coords(record.voxel_idx as usize);
            let at = view_from_index.transform(DVec3::new(i as f64, j as f64, k as f64));
            let steps = [at.z, at.y, at.x].map(|c| (c * steps_per_world).round() as i64);
            (steps, record_idx as u32)
        })
        .collect();
    keys.par_sort_unstable();
    keys.into_iter().map(|(_, record_idx)| record_idx).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::{Camera, ImageDesc, Projection};

    #[test]
    fn depth_order_breaks_ties_by_place() {
        let grid = Grid::with_spacing([2, 2, 2], [1.0; 3]).unwrap();
        let target = grid.center_in_world();
        // 45°: voxels 1 and 4 (and 3 and 6) are equally deep but for rounding.
        let eye = target + DVec3::new(10.0, 0.0, 10.0);
        let projection = Projection::Orthographic { view_height: 4.0 };
        let camera = Camera::new(eye, target, DVec3::Y, projection).unwrap();
        let view = View::new(&grid, &camera, &ImageDesc::default());
        let records: Vec<VoxelRecord> =
            (0..8).map(|voxel_idx| VoxelRecord { voxel_idx, normal_in_world: [0.0; 3] }).collect();
        assert_eq!(depth_order(&grid, &view, &records), [5, 7, 4, 1, 6, 3, 0, 2]);
    }
}
