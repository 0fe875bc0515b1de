//! Gradients by differences in index space (model §6).

use slabsplat_core::Volume;
use slabsplat_core::glam::DVec3;

/// The gradient at a voxel in world space: per world unit, `A⁻ᵀ` times the differences; 0 next to an infinite
/// value, where there is no surface to speak of.
pub fn gradient_in_world(volume: &Volume, coords: [usize; 3]) -> DVec3 {
    finite_gradient(volume, coords).unwrap_or(DVec3::ZERO)
}

/// Its length, infinite next to an infinite value.
pub fn gradient_length(volume: &Volume, coords: [usize; 3]) -> f64 {
    finite_gradient(volume, coords).map_or(f64::INFINITY, DVec3::length)
}

fn finite_gradient(volume: &Volume, coords: [usize; 3]) -> Option<DVec3> {
    let in_index = DVec3::from_array([0, 1, 2].map(|axis| difference(volume, coords, axis)));
    let index_from_world = volume.grid().index_from_world().matrix3;
    in_index.is_finite().then(|| index_from_world.transpose() * in_index)
}

/// The change of the value along `axis` per voxel step: central where both neighbours have a
/// value, else one-sided, else 0.
fn difference(volume: &Volume, coords: [usize; 3], axis: usize) -> f64 {
    let before = neighbor(volume, coords, axis, -1);
    let after = neighbor(volume, coords, axis, 1);
    let here = neighbor(volume, coords, axis, 0);
    match (before, here, after) {
        (Some(before), _, Some(after)) => (after - before) / 2.0,
        (None, Some(here), Some(after)) => after - here,
        (Some(before), Some(here), None) => here - before,
        _ => 0.0,
    }
}

/// The value `step` voxels along `axis`, if there is one and it is not NaN.
fn neighbor(volume: &Volume, mut coords: [usize; 3], axis: usize, step: isize) -> Option<f64> {
    let grid = volume.grid();
    coords[axis] = coords[axis].checked_add_signed(step).filter(|c| *c < grid.dims()[axis])?;
    Some(volume.value(grid.voxel_idx(coords))).filter(|value| !value.is_nan())
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::glam::{DAffine3, DMat3};
    use slabsplat_core::{Grid, Samples, Scaling};

    const SLOPE: DVec3 = DVec3::new(0.7, -1.1, 0.4);

    /// A field that is linear in the world, on a sheared and mirrored grid.
    fn linear_field(break_at: Option<(usize, f64)>) -> Volume {
        let matrix = DMat3::from_cols(
            DVec3::new(1.2, 0.1, 0.0),
            DVec3::new(0.4, -0.8, 0.2),
            DVec3::new(0.0, 0.3, 2.0),
        );
        let world_from_index = DAffine3::from_mat3_translation(matrix, DVec3::new(3.0, 4.0, 5.0));
        let grid = Grid::new([4, 3, 5], world_from_index).unwrap();
        let value = |voxel_idx| {
            let coords = grid.voxel_coords(voxel_idx).map(|c| c as f64);
            SLOPE.dot(world_from_index.transform_point3(DVec3::from_array(coords)))
        };
        let mut samples: Vec<f64> = (0..grid.n_voxels()).map(value).collect();
        if let Some((voxel_idx, value)) = break_at {
            samples[voxel_idx] = value;
        }
        Volume::new(grid, Samples::F64(samples), Scaling::IDENTITY).unwrap()
    }

    #[test]
    fn gradient_of_linear_field_everywhere() {
        let volume = linear_field(None);
        for voxel_idx in 0..volume.grid().n_voxels() {
            let gradient = gradient_in_world(&volume, volume.grid().voxel_coords(voxel_idx));
            assert!(gradient.abs_diff_eq(SLOPE, 1e-12), "{voxel_idx}: {gradient}");
        }
    }

    /// A NaN voxel leaves its neighbours one-sided differences, which a linear field does not mind.
    #[test]
    fn gradient_passes_over_nan() {
        let grid = *linear_field(None).grid();
        let volume = linear_field(Some((grid.voxel_idx([1, 1, 2]), f64::NAN)));
        for coords in [[2, 1, 2], [1, 2, 1], [1, 1, 3], [1, 1, 2]] {
            let gradient = gradient_in_world(&volume, coords);
            assert!(gradient.abs_diff_eq(SLOPE, 1e-12), "{coords:?}: {gradient}");
        }
        let cut_off = gradient_in_world(&volume, [0, 1, 2]);
        let in_index = grid.world_from_index().matrix3.transpose() * cut_off;
        assert!(in_index.x.abs() < 1e-12, "no neighbour but NaN: {in_index}");
    }

    #[test]
    fn gradient_beside_infinity_is_zero() {
        for infinity in [f64::INFINITY, f64::NEG_INFINITY] {
            let voxel_idx = linear_field(None).grid().voxel_idx([1, 1, 2]);
            let volume = linear_field(Some((voxel_idx, infinity)));
            for coords in [[0, 1, 2], [2, 1, 2], [1, 2, 2], [1, 1, 3]] {
                assert_eq!(gradient_in_world(&volume, coords), DVec3::ZERO, "{coords:?}");
            }
            // Its own gradient is its neighbours' difference.
            assert!(gradient_in_world(&volume, [1, 1, 2]).abs_diff_eq(SLOPE, 1e-12));
        }
    }

    #[test]
    fn gradient_along_single_voxel_axis_is_zero() {
        let grid = Grid::with_spacing([3, 1, 1], [2.0, 1.0, 1.0]).unwrap();
        let volume = Volume::new(grid, Samples::U8(vec![0, 10, 40]), Scaling::IDENTITY).unwrap();
        assert_eq!(gradient_in_world(&volume, [1, 0, 0]), DVec3::new(10.0, 0.0, 0.0));
        assert_eq!(gradient_in_world(&volume, [2, 0, 0]), DVec3::new(15.0, 0.0, 0.0));
    }
}
