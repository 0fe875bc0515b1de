//! Surface normals from central differences (SPEC §6).

use slabsplat_core::glam::{DMat3, DVec3};
use slabsplat_core::{Sample, Scaling, Volume, with_samples};

/// Finds the normals of a volume's voxels.
///
/// Differences are central, one-sided where a neighbour is outside the grid or NaN, and 0 where both
/// are. The gradient goes to world space by `A⁻ᵀ`. Where it is zero, or infinite because a
/// neighbour is, there is no surface to speak of and the normal is zero.
#[derive(Clone, Copy, Debug)]
pub struct Normals<'a> {
    volume: &'a Volume,
    world_gradient_from_index: DMat3,
}

impl<'a> Normals<'a> {
    /// The normals of `volume`.
    pub fn new(volume: &'a Volume) -> Self {
        let index_from_world = volume.grid().index_from_world().matrix3;
        Self { volume, world_gradient_from_index: index_from_world.transpose() }
    }

    /// `−∇v/|∇v|` in world space, or zero.
    pub fn at(&self, voxel_idx: usize) -> DVec3 {
        let dims = self.volume.grid().dims();
        let coords = self.volume.grid().voxel_coords(voxel_idx);
        let scaling = self.volume.scaling();
        let in_index = with_samples!(self.volume.samples(), |s| {
            gradient(s, scaling, dims, coords, voxel_idx)
        });
        let in_world = self.world_gradient_from_index * in_index;
        // Scaled before the length is taken: squares of tiny differences would underflow.
        let largest = in_world.abs().max_element();
        let normal = -(in_world / largest).normalize_or_zero();
        if normal.is_finite() { normal } else { DVec3::ZERO }
    }
}

fn gradient<T: Sample>(
    samples: &[T],
    scaling: Scaling,
    [nx, ny, nz]: [usize; 3],
    [i, j, k]: [usize; 3],
    voxel_idx: usize,
) -> DVec3 {
    let value = |idx: usize| scaling.apply(samples[idx].to_f64());
    let here = value(voxel_idx);
    let along = |coord: usize, n: usize, stride: usize| {
        let before = (0 < coord).then(|| value(voxel_idx - stride)).filter(|v| !v.is_nan());
        let after = (coord + 1 < n).then(|| value(voxel_idx + stride)).filter(|v| !v.is_nan());
        match (before, after) {
            (Some(before), Some(after)) => 0.5 * (after - before),
            (None, Some(after)) => after - here,
            (Some(before), None) => here - before,
            (None, None) => 0.0,
        }
    };
    DVec3::new(along(i, nx, 1), along(j, ny, nx), along(k, nz, nx * ny))
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::glam::DAffine3;
    use slabsplat_core::{Grid, Samples};

    fn sheared(dims: [usize; 3]) -> Grid {
        let columns = DMat3::from_cols(
            DVec3::new(1.0, 0.2, 0.0),
            DVec3::new(0.0, -1.5, 0.3),
            DVec3::new(0.4, 0.0, 2.0),
        );
        Grid::new(dims, DAffine3::from_mat3(columns)).unwrap()
    }

    /// A linear field in world space has the same normal at every voxel, borders too.
    #[test]
    fn normal_of_linear_field() {
        let slope = DVec3::new(0.3, -1.0, 0.5);
        let grid = sheared([4, 3, 5]);
        let field = |idx: usize| {
            let [i, j, k] = grid.voxel_coords(idx).map(|c| c as f64);
            grid.world_from_index().transform_point3(DVec3::new(i, j, k)).dot(slope)
        };
        let samples: Vec<f64> = (0..grid.n_voxels()).map(field).collect();
        for sign in [1.0, -1.0] {
            let scaling = Scaling { slope: sign * 3.0, intercept: 1.0 };
            let volume = Volume::new(grid, samples.clone().into(), scaling).unwrap();
            for voxel_idx in 0..grid.n_voxels() {
                let normal = Normals::new(&volume).at(voxel_idx);
                assert!(normal.abs_diff_eq(-slope.normalize() * sign, 1e-12), "{normal}");
            }
        }
    }

    #[test]
    fn normal_is_one_sided_beside_nan() {
        let row = |samples: Vec<f32>| {
            let grid = Grid::with_spacing([samples.len(), 1, 1], [1.0; 3]).unwrap();
            let volume = Volume::new(grid, Samples::F32(samples), Scaling::IDENTITY).unwrap();
            Normals::new(&volume).at(1)
        };
        assert_eq!(row(vec![f32::NAN, 1.0, 3.0]), -DVec3::X);
        assert_eq!(row(vec![9.0, 1.0, f32::NAN]), DVec3::X);
        assert_eq!(row(vec![f32::NAN, 1.0, f32::NAN]), DVec3::ZERO);
        assert_eq!(row(vec![4.0, 1.0, 4.0]), DVec3::ZERO);
        assert_eq!(row(vec![0.0, 1.0, f32::INFINITY]), DVec3::ZERO);
        assert_eq!(row(vec![0.0, 0.0, 1e-38]), -DVec3::X, "a faint gradient is still one");
    }
}
