//! A part of the world, of several that are drawn one by one and are all of it together (model §17).

use crate::region_in_view::{NEVER, PlaneInView, is_beyond_any};
use crate::{Plane, View, ViewRay};
use glam::DVec3;

/// A convex part of the world, half-open: of parts that were [split](Self::split) from a whole every point
/// is in just one. Not a [`Region`](crate::Region), which cuts a layer: a part shows what it holds as the
/// whole does, and pictures of all parts, laid over each other as the eye has them, are the picture of the
/// whole.
///
/// ```
/// use slabsplat_core::{Part, Plane};
///
/// let whole = Part::whole([0.0; 3]);
/// let [left, right] = whole.split(Plane::new([1.0, 0.0, 0.0], 2.0)?);
/// assert!(left.contains([1.9, 5.0, 5.0]) && !left.contains([2.0, 5.0, 5.0]));
/// assert!(right.contains([2.0, 5.0, 5.0]) && !right.contains([1.9, 5.0, 5.0]));
/// # Ok::<(), slabsplat_core::RegionError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    center: DVec3,
    faces: Vec<Face>,
}

/// A plane behind which a part lies.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Face {
    plane: Plane,
    /// Whether the plane itself belongs to it.
    is_held: bool,
}

/// A part in view space.
#[derive(Clone, Debug, PartialEq)]
pub struct PartInView {
    faces: Vec<(PlaneInView, bool)>,
    /// The depth of the eye, if rays leave it.
    eye_depth: Option<f64>,
}

impl Part {
    /// All of a world of which that is the centre: the middle of the only grid, or of all grids
    /// ([`Grid::center_of_all`](crate::Grid::center_of_all)). Slabs are counted from there, whatever grids
    /// a part has.
    pub fn whole(center: impl Into<DVec3>) -> Self {
        Self { center: center.into(), faces: Vec::new() }
    }

    /// What lies behind a plane, without the plane, and all else.
    #[must_use]
    pub fn split(&self, plane: Plane) -> [Self; 2] {
        let with = |face: Face| {
            let mut part = self.clone();
            part.faces.push(face);
            part
        };
        [
            with(Face { plane, is_held: false }),
            with(Face { plane: plane.reversed(), is_held: true }),
        ]
    }

    /// The centre of the whole.
    pub fn center(&self) -> DVec3 {
        self.center
    }

    /// Whether a point of the world is in it.
    pub fn contains(&self, point: impl Into<DVec3>) -> bool {
        let point = point.into();
        self.faces.iter().all(|Face { plane, is_held }| {
            let before = plane.before(point);
            before < 0.0 || *is_held && before == 0.0
        })
    }
}

impl PartInView {
    /// The part as `view` sees it.
    pub fn new(part: &Part, view: &View) -> Self {
        let faces = part.faces.iter();
        Self {
            faces: faces.map(|face| (PlaneInView::new(&face.plane, view), face.is_held)).collect(),
            eye_depth: view.is_perspective().then(|| view.eye_depth()),
        }
    }

    /// The planes behind which it lies, each with whether it belongs to the part.
    pub fn faces(&self) -> &[(PlaneInView, bool)] {
        &self.faces
    }

    /// The depths at which a ray enters and leaves it, as [`RegionInView::interval`] has them, of which the
    /// first belongs to it and the last does not: of all parts, one alone has any depth.
    ///
    /// Rays meet in the eye. What a slab has before it belongs to the part that the ray is in at the eye:
    /// that slab is one sheet, and no order of parts would be right there for all rays.
    ///
    /// [`RegionInView::interval`]: crate::RegionInView::interval
    #[inline]
    pub fn interval(&self, ray: &ViewRay) -> [f64; 2] {
        let [mut first, mut last] = [f64::NEG_INFINITY, f64::INFINITY];
        for (plane, is_held) in &self.faces {
            let (approach, left) = plane.approached_by(ray);
            if 0.0 < approach {
                last = last.min(left / approach);
            } else if approach < 0.0 {
                first = first.max(left / approach);
            } else if left < 0.0 || left == 0.0 && !is_held {
                return NEVER;
            }
        }
        if let Some(eye) = self.eye_depth {
            if last <= eye {
                return NEVER;
            }
            if first <= eye {
                first = f64::NEG_INFINITY;
            }
        }
        if first < last { [first, last] } else { NEVER }
    }

    /// Whether all points of a box are so far outside that a ball around each of them, of which a plane with
    /// normal `n` cuts `reach(n)`, is too.
    pub fn is_beyond(
        &self,
        center: DVec3,
        half_extents: DVec3,
        reach: impl Fn(DVec3) -> f64,
    ) -> bool {
        let planes = self.faces.iter().map(|(plane, _)| plane);
        is_beyond_any(planes, center, half_extents, reach)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Camera, Grid, ImageDesc, Projection};

    fn plane(normal: [f64; 3], distance: f64) -> Plane {
        Plane::new(normal, distance).unwrap()
    }

    /// Eight parts, by planes of which some go through the eye and some along rays.
    fn parts() -> Vec<Part> {
        let planes = [
            plane([1.0, 0.0, 0.0], 2.0),
            plane([0.3, -2.0, 0.5], -3.0),
            plane([0.0, 0.0, 1.0], 4.0),
        ];
        planes.into_iter().fold(vec![Part::whole([2.0, 3.0, 4.0])], |parts, plane| {
            parts.iter().flat_map(|part| part.split(plane)).collect()
        })
    }

    #[test]
    fn part_holds_what_no_other_holds() {
        let parts = parts();
        for idx in 0..1000 {
            let point = [idx % 10, idx / 10 % 10, idx / 100].map(|c| 0.5 * f64::from(c));
            let n_holding = parts.iter().filter(|part| part.contains(point)).count();
            assert_eq!(n_holding, 1, "{point:?}");
        }
    }

    /// Every depth of every ray is in one part, up to where rounding decides; also where a ray lies in a
    /// plane, and where the eye is in one.
    #[test]
    fn part_in_view_has_its_own_depths_of_rays() {
        let grid = Grid::with_spacing([5, 7, 9], [1.0; 3]).unwrap();
        let target = DVec3::new(2.0, 3.0, 4.0);
        let projections = [
            Projection::Orthographic { view_height: 8.0 },
            Projection::Perspective { fov_y_radians: 0.8 },
        ];
        for (projection, eye) in projections.into_iter().flat_map(|projection| {
            let eyes = [[2.0, 3.0, 14.0], [5.0, 1.0, 13.0], [2.5, 3.5, 5.0], [2.0, 3.0, 4.0]];
            eyes.map(|eye| (projection, DVec3::from(eye)))
        }) {
            let target = if eye == target { target - DVec3::Z } else { target };
            let camera = Camera::new(eye, target, DVec3::Y, projection).unwrap();
            let view = View::about(grid.center_in_world(), &grid, &camera, &ImageDesc::new(15, 9));
            let view = view.unwrap();
            let seen: Vec<_> = parts().iter().map(|part| PartInView::new(part, &view)).collect();
            for pixel in (0..135).map(|idx| [idx % 15, idx / 15].map(|p| f64::from(p) + 0.5)) {
                let ray = view.ray(pixel);
                let mut intervals: Vec<_> = seen.iter().map(|part| part.interval(&ray)).collect();
                intervals.retain(|[first, last]| first < last);
                intervals.sort_by(|a, b| a[0].total_cmp(&b[0]));
                let is_whole = intervals[0][0] == f64::NEG_INFINITY
                    && intervals.last().unwrap()[1] == f64::INFINITY
                    && intervals.windows(2).all(|pair| pair[0][1] == pair[1][0]);
                assert!(is_whole, "{projection:?} {eye} {pixel:?}: {intervals:?}");
            }
        }
    }
}
