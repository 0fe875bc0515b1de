//! Voxels to view space. What follows, the scale of the slab and the pixel, depends on the slab.

use crate::VoxelRecord;
use rayon::prelude::*;
use slabsplat_core::glam::DVec3;
use slabsplat_core::{Grid, View};

/// Writes where each voxel is in view space, `[right, up, depth]` in world units; depth counts from the
/// grid's centre. The sum is made in 64 bits and rounded once.
pub fn project(grid: &Grid, view: &View, records: &[VoxelRecord], points: &mut Vec<[f32; 3]>) {
    let view_from_index = view.from_index(grid);
    records
        .par_iter()
        .with_min_len(1 << 12)
        .map(|record| {
            let [i, j, k] = grid.voxel_coords(record.voxel_idx as usize);
            let in_index = DVec3::new(i as f64, j as f64, k as f64);
            view_from_index.transform(in_index).as_vec3().to_array()
        })
        .collect_into_vec(points);
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::{Camera, ImageDesc, Projection};

    #[test]
    fn project_measures_depth_from_grid_center() {
        let grid = Grid::with_spacing([3, 1, 1], [2.0, 1.0, 1.0]).unwrap();
        let eye = DVec3::new(-10.0, 0.0, 0.0);
        let projection = Projection::Orthographic { view_height: 5.0 };
        let camera = Camera::new(eye, DVec3::ZERO, DVec3::Z, projection).unwrap();
        let view = View::new(&grid, &camera, &ImageDesc::default());
        let records =
            [0, 1, 2].map(|voxel_idx| VoxelRecord { voxel_idx, normal_in_world: [0.0; 3] });
        let mut points = Vec::new();
        project(&grid, &view, &records, &mut points);
        assert_eq!(points, [[0.0, 0.0, -2.0], [0.0, 0.0, 0.0], [0.0, 0.0, 2.0]]);
    }
}
