//! Where a layer is seen (model §11).

use crate::Grid;
use crate::unit_vector::is_unit;
use glam::{DMat3, DVec3};
use thiserror::Error;

/// A convex set of points of the world, those that lie behind all of its planes, or the complement of one.
/// Without planes it is everywhere.
///
/// ```
/// use slabsplat_core::{Plane, Region};
///
/// let cut = Region::new(vec![Plane::new([1.0, 0.0, 0.0], 12.0)?]);
/// assert!(cut.contains([11.0, 5.0, 5.0]) && !cut.contains([13.0, 5.0, 5.0]));
/// let corner = Region::in_box([[0.0; 3], [9.0; 3]])?.inverted();
/// assert!(!corner.contains([4.0; 3]));
/// # Ok::<(), slabsplat_core::RegionError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize, serde::Serialize))]
#[cfg_attr(
    feature = "serde",
    serde(try_from = "crate::serialized::RegionKeys", into = "crate::serialized::RegionKeys")
)]
pub struct Region {
    planes: Vec<Plane>,
    is_inverted: bool,
    is_lit: bool,
}

/// A plane in world space; what lies behind it has `n·x ≤ d`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    normal: DVec3,
    distance: f64,
}

/// Why there is no such region.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum RegionError {
    /// The normal is zero, or not all numbers are finite.
    #[error(
        "a plane needs a finite normal other than zero and a finite distance, not {normal} and {distance}"
    )]
    BadPlane {
        /// The normal.
        normal: DVec3,
        /// The distance.
        distance: f64,
    },
    /// An end of the box is NaN or infinite, or lies before its start.
    #[error("a box goes from its least to its greatest corner, not from {min} to {max}")]
    BadBox {
        /// Where the box should start.
        min: DVec3,
        /// Where it should end.
        max: DVec3,
    },
}

impl Plane {
    /// The points of `n·x = d`, with a normal of any length.
    ///
    /// # Errors
    /// If the normal is zero, or a number is not finite.
    pub fn new(normal: impl Into<DVec3>, distance: f64) -> Result<Self, RegionError> {
        let normal = normal.into();
        let bad = RegionError::BadPlane { normal, distance };
        if is_unit(normal) && distance.is_finite() {
            return Ok(Self { normal, distance });
        }
        // Squares of very long or short normals would leave the range of numbers.
        let largest = normal.abs().max_element();
        let scaled = normal / largest;
        let length = scaled.length();
        let plane = Self { normal: scaled / length, distance: distance / largest / length };
        let is_finite = plane.normal.is_finite() && plane.distance.is_finite();
        if is_finite && 0.0 < largest { Ok(plane) } else { Err(bad) }
    }

    /// `n`, of length 1: away from what lies behind.
    pub fn normal(&self) -> DVec3 {
        self.normal
    }

    /// `d`, in world units.
    pub fn distance(&self) -> f64 {
        self.distance
    }

    /// The same plane seen from its other side, bit by bit.
    #[must_use]
    pub fn reversed(self) -> Self {
        Self { normal: -self.normal, distance: -self.distance }
    }

    /// How far a point lies before the plane, in world units; negative behind it.
    pub fn before(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.distance
    }
}

impl Region {
    /// What lies behind all of these planes.
    pub fn new(planes: Vec<Plane>) -> Self {
        Self { planes, ..Self::default() }
    }

    /// A box along the world's axes, from its least to its greatest corner.
    ///
    /// # Errors
    /// If a coordinate is not finite, or the box ends before it starts. It may have no volume: then nothing
    /// is seen.
    pub fn in_box(ends: [impl Into<DVec3>; 2]) -> Result<Self, RegionError> {
        let [min, max] = ends.map(Into::into);
        if !min.is_finite() || !max.is_finite() || !min.cmple(max).all() {
            return Err(RegionError::BadBox { min, max });
        }
        let sides =
            |axis: DVec3| [Plane::new(axis, axis.dot(max)), Plane::new(-axis, -axis.dot(min))];
        let sides = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(sides);
        Ok(Self::new(sides.collect::<Result<_, _>>()?))
    }

    /// A box along the axes of a grid, between two points of its index space.
    ///
    /// # Errors
    /// As [`in_box`](Self::in_box).
    pub fn in_index_box(grid: &Grid, ends: [impl Into<DVec3>; 2]) -> Result<Self, RegionError> {
        let in_index = Self::in_box(ends)?;
        // n·A⁻¹(x − o) ≤ d
        let index_from_world = grid.index_from_world();
        let to_world = |plane: &Plane| {
            let normal = DMat3::transpose(&index_from_world.matrix3) * plane.normal;
            Plane::new(normal, plane.distance - plane.normal.dot(index_from_world.translation))
        };
        let planes = in_index.planes.iter().map(to_world).collect::<Result<_, _>>()?;
        Ok(Self::new(planes))
    }

    /// The complement.
    #[must_use]
    pub fn inverted(self) -> Self {
        Self { is_inverted: !self.is_inverted, ..self }
    }

    /// The same with faces that are lit as surfaces, instead of by what is inside.
    #[must_use]
    pub fn lit(self) -> Self {
        Self { is_lit: true, ..self }
    }

    /// What lies behind one more plane, before anything is inverted.
    #[must_use]
    pub fn behind(mut self, plane: Plane) -> Self {
        self.planes.push(plane);
        self
    }

    /// The planes of the convex set.
    pub fn planes(&self) -> &[Plane] {
        &self.planes
    }

    /// Whether it is the complement of the convex set.
    pub fn is_inverted(&self) -> bool {
        self.is_inverted
    }

    /// Whether its faces are lit as surfaces.
    pub fn is_lit(&self) -> bool {
        self.is_lit
    }

    /// Whether every point is in it.
    pub fn is_everywhere(&self) -> bool {
        self.planes.is_empty() && !self.is_inverted
    }

    /// Whether a point of the world is in it.
    pub fn contains(&self, point: impl Into<DVec3>) -> bool {
        let point = point.into();
        self.planes.iter().all(|plane| plane.before(point) <= 0.0) != self.is_inverted
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DAffine3;

    #[test]
    fn plane_has_a_normal_of_length_one() {
        for length in [1e-300, 0.2, 5.0, 1e300] {
            let plane = Plane::new(DVec3::X * length, 3.0 * length).unwrap();
            assert_eq!(plane.normal(), DVec3::X, "{length}");
            assert!((plane.distance() - 3.0).abs() < 1e-12, "{length}");
        }
        assert_eq!(Plane::new(DVec3::Y, 2.0).unwrap().before(DVec3::new(9.0, 5.0, 9.0)), 3.0);
        for (normal, distance) in [
            (DVec3::ZERO, 1.0),
            (DVec3::NAN, 1.0),
            (DVec3::INFINITY, 1.0),
            (DVec3::X, f64::NAN),
            (DVec3::X, f64::INFINITY),
            (DVec3::X * 1e-300, 1e300),
        ] {
            assert!(Plane::new(normal, distance).is_err(), "{normal} {distance}");
        }
    }

    #[test]
    fn region_of_nothing_is_everywhere() {
        let everywhere = Region::default();
        assert!(everywhere.is_everywhere() && everywhere.contains(DVec3::splat(1e9)));
        let nowhere = everywhere.inverted();
        assert!(!nowhere.is_everywhere() && !nowhere.contains(DVec3::ZERO));
    }

    #[test]
    fn region_in_a_box() {
        let (min, max) = (DVec3::new(-1.0, 2.0, 3.0), DVec3::new(4.0, 5.0, 6.0));
        let inside = Region::in_box([min, max]).unwrap();
        for (point, expected) in [
            (min, true),
            (max, true),
            (min.midpoint(max), true),
            (min - DVec3::X * 1e-9, false),
            (max + DVec3::Z * 1e-9, false),
        ] {
            assert_eq!(inside.contains(point), expected, "{point}");
            assert_eq!(inside.clone().inverted().contains(point), !expected, "{point}");
        }
        for ends in [[max, min], [DVec3::NAN, max], [min, DVec3::INFINITY]] {
            assert!(Region::in_box(ends).is_err(), "{ends:?}");
        }
    }

    #[test]
    fn region_in_a_box_of_a_sheared_grid() {
        let steps = DMat3::from_cols(
            DVec3::new(2.0, 0.0, 0.3),
            DVec3::new(0.7, -1.0, 0.0),
            DVec3::new(0.0, 0.4, 3.0),
        );
        let world_from_index =
            DAffine3::from_mat3_translation(steps, DVec3::new(30.0, -20.0, 10.0));
        let grid = Grid::new([9, 9, 9], world_from_index).unwrap();
        let (min, max) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(4.5, 5.5, 6.5));
        let region = Region::in_index_box(&grid, [min, max]).unwrap();
        for at in (0..512).map(|n| [n % 8, n / 8 % 8, n / 64]) {
            let at = DVec3::from_array(at.map(f64::from)) + 0.25;
            let expected = at.cmpge(min).all() && at.cmple(max).all();
            assert_eq!(region.contains(world_from_index.transform_point3(at)), expected, "{at}");
        }
    }
}
