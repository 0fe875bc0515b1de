//! A region as it is edited: a box along the axes of a layer's grid, and planes beside.

use slabsplat::glam::{DMat3, DVec3};
use slabsplat::{Grid, Plane, Region};

/// What is left of a layer.
#[derive(Clone, Debug, PartialEq)]
pub struct Cut {
    /// Where the box begins and ends along each axis of the grid, in voxels: a voxel is from half before its
    /// middle to half behind it.
    pub ends: [[f64; 2]; 3],
    /// All that is behind these is left.
    pub planes: Vec<Plane>,
    /// Whether what would be left is what is cut off.
    pub is_inverted: bool,
    /// Whether faces are lit as surfaces.
    pub is_lit: bool,
}

/// Ends of a grid: of an axis of `n` voxels.
fn all_of(n: usize) -> [f64; 2] {
    [-0.5, n as f64 - 0.5]
}

impl Cut {
    /// What a region leaves of a grid. Faces along its axes are of the box, one on each side.
    pub fn of(region: &Region, grid: &Grid) -> Self {
        let dims = grid.dims();
        let mut ends = dims.map(all_of);
        let mut planes = Vec::new();
        for &plane in region.planes() {
            match face(plane, grid) {
                Some((axis, 0, at)) => ends[axis][0] = ends[axis][0].max(at),
                Some((axis, _, at)) => ends[axis][1] = ends[axis][1].min(at),
                None => planes.push(plane),
            }
        }
        for (ends, n) in ends.iter_mut().zip(dims) {
            ends[0] = ends[0].min(all_of(n)[1]);
            ends[1] = ends[1].max(ends[0]);
        }
        Self { ends, planes, is_inverted: region.is_inverted(), is_lit: region.is_lit() }
    }

    /// The region that leaves this. Faces of the grid itself cut nothing.
    pub fn region(&self, grid: &Grid) -> Region {
        let of_box = |ends: [DVec3; 2]| Region::in_index_box(grid, ends);
        let corners = [0, 1].map(|side| DVec3::from_array(self.ends.map(|ends| ends[side])));
        let whole = [0, 1].map(|side| DVec3::from_array(grid.dims().map(|n| all_of(n)[side])));
        let mut planes = Vec::new();
        if let Ok(region) = of_box(corners) {
            // They are in the order of axes, the far side of each before the near one.
            for (idx, plane) in region.planes().iter().enumerate() {
                let (axis, side) = (idx / 2, 1 - idx % 2);
                if corners[side][axis] != whole[side][axis] {
                    planes.push(*plane);
                }
            }
        }
        planes.extend_from_slice(&self.planes);
        let region = Region::new(planes);
        let region = if self.is_lit { region.lit() } else { region };
        if self.is_inverted && !region.is_everywhere() { region.inverted() } else { region }
    }
}

/// The axis, the side and the place of a plane that is a face of a box along the grid's axes.
fn face(plane: Plane, grid: &Grid) -> Option<(usize, usize, f64)> {
    let to_world = grid.world_from_index();
    let in_index = DMat3::transpose(&to_world.matrix3) * plane.normal();
    let axis = (0..3).max_by(|&a, &b| in_index[a].abs().total_cmp(&in_index[b].abs()))?;
    let beside = (0..3).filter(|&other| other != axis).map(|other| in_index[other].abs());
    let along = in_index[axis];
    if 1e-9 * along.abs() < beside.sum() {
        return None;
    }
    let distance = plane.distance() - plane.normal().dot(to_world.translation);
    Some((axis, usize::from(0.0 < along), distance / along))
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat::glam::DAffine3;

    fn sheared() -> Grid {
        let matrix = DMat3::from_cols(
            DVec3::new(0.5, 0.0, 0.1),
            DVec3::new(0.2, -2.0, 0.0),
            DVec3::new(0.0, 0.3, 1.5),
        );
        let affine = DAffine3 { matrix3: matrix, translation: DVec3::new(40.0, -7.0, 3.0) };
        Grid::new([10, 20, 30], affine).unwrap()
    }

    #[test]
    fn a_cut_is_the_region_that_it_makes() {
        for grid in [sheared(), Grid::with_spacing([10, 20, 30], [1.0, 2.0, 0.25]).unwrap()] {
            let mut cut = Cut::of(&Region::default(), &grid);
            assert!(cut.region(&grid).is_everywhere());
            cut.ends[1] = [3.0, 12.5];
            cut.ends[2][1] = 4.0;
            cut.is_lit = true;
            cut.planes.push(Plane::new(DVec3::new(1.0, 1.0, 1.0), 5.0).unwrap());
            let region = cut.region(&grid);
            assert_eq!(region.planes().len(), 4);
            let again = Cut::of(&region, &grid);
            assert_eq!((&again.planes, again.is_lit), (&cut.planes, true));
            for (ends, expected) in again.ends.iter().flatten().zip(cut.ends.iter().flatten()) {
                assert!((ends - expected).abs() < 1e-9, "{again:?}");
            }
            let inverted = Cut { is_inverted: true, ..cut }.region(&grid);
            assert!(inverted.is_inverted());
        }
    }

    #[test]
    fn points_are_inside_as_their_voxels_are() {
        let grid = sheared();
        let mut cut = Cut::of(&Region::default(), &grid);
        cut.ends[0] = [2.0, 5.0];
        let region = cut.region(&grid);
        for i in 0..10 {
            let point =
                grid.world_from_index().transform_point3(DVec3::new(f64::from(i), 3.0, 4.0));
            // At its very ends anything goes.
            if i != 2 && i != 5 {
                assert_eq!(region.contains(point), (2..=5).contains(&i), "{i}");
            }
        }
    }
}
