//! The traditional sheets: slices of the grid along one axis (paper §3.1), which is what pops.

use crate::Grid;
use glam::DVec3;

/// Which slices of the grid are sheets, and in which order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct SliceOrder {
    /// The axis across the slices: 0, 1 or 2.
    pub axis: usize,
    /// Whether the slice with index 0 is the last, seen from the eye.
    pub is_reversed: bool,
    /// How many slices there are.
    pub n_slices: usize,
}

impl SliceOrder {
    /// The slices across the axis most parallel to `forward`, the first of equals.
    pub fn new(grid: &Grid, forward: DVec3) -> Self {
        let m = grid.world_from_index().matrix3;
        let cosines = [m.x_axis, m.y_axis, m.z_axis].map(|column| column.normalize().dot(forward));
        let mut axis = 0;
        for other in 1..3 {
            if cosines[axis].abs() < cosines[other].abs() {
                axis = other;
            }
        }
        Self { axis, is_reversed: cosines[axis] < 0.0, n_slices: grid.dims()[axis] }
    }

    /// The index of a voxel's slice among the sheets, front to back.
    #[inline]
    pub fn sheet_of(&self, voxel_coords: [usize; 3]) -> usize {
        let slice = voxel_coords[self.axis];
        if self.is_reversed { self.n_slices - 1 - slice } else { slice }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Figure 2: the sheets turn by 90° when the view passes 45°.
    #[test]
    fn slice_order_pops_at_45_degrees() {
        let grid = Grid::with_spacing([3, 4, 5], [1.0, 2.0, 0.5]).unwrap();
        let order = |degrees: f64| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            SliceOrder::new(&grid, DVec3::new(-sin, 0.0, cos))
        };
        assert_eq!(order(44.9), SliceOrder { axis: 2, is_reversed: false, n_slices: 5 });
        assert_eq!(order(45.1), SliceOrder { axis: 0, is_reversed: true, n_slices: 3 });
        assert_eq!([0, 1, 2].map(|x| order(45.1).sheet_of([x, 3, 4])), [2, 1, 0]);
        assert_eq!([0, 1, 4].map(|z| order(44.9).sheet_of([2, 3, z])), [0, 1, 4]);
    }
}
