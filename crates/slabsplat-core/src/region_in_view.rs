//! A region as a camera sees it: where rays enter and leave it (model §11).

use crate::{Plane, Region, View};
use glam::DVec3;

/// A region in view space.
#[derive(Clone, Debug, PartialEq)]
pub struct RegionInView {
    in_world: Region,
    planes: Vec<PlaneInView>,
}

/// A plane in view space; what lies behind it has `n·x ≤ d`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(clippy::exhaustive_structs, reason = "a plane is a normal and a distance")]
pub struct PlaneInView {
    /// `n`, of length 1.
    pub normal: DVec3,
    /// `d`, in world units.
    pub distance: f64,
}

/// The ray of a point of the image, in view space.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(clippy::exhaustive_structs, reason = "a ray is a point and a step")]
pub struct ViewRay {
    /// Where it is at depth 0.
    pub start: DVec3,
    /// How far it goes over one world unit of depth.
    pub step: DVec3,
}

impl RegionInView {
    /// By how many `unit`s a plane must be nearer than those before it to count as nearer
    /// ([model §11](crate::model)).
    pub const HAIR: f64 = 1.0 / 1024.0;

    /// How many `unit`s behind a lit face its normal counts for nothing; it counts in full up to one before
    /// that ([model §11](crate::model)).
    pub const DEEPEST_LIT: f64 = 1.75;

    /// The region as `view` sees it.
    pub fn new(region: &Region, view: &View) -> Self {
        let planes = region.planes().iter().map(|plane| PlaneInView::new(plane, view)).collect();
        Self { planes, in_world: region.clone() }
    }

    /// What was seen.
    pub fn in_world(&self) -> &Region {
        &self.in_world
    }

    /// The planes of the convex set.
    pub fn planes(&self) -> &[PlaneInView] {
        &self.planes
    }

    /// Whether the region is the complement of the convex set.
    pub fn is_inverted(&self) -> bool {
        self.in_world.is_inverted()
    }

    /// Whether its faces are lit as surfaces.
    pub fn is_lit(&self) -> bool {
        self.in_world.is_lit()
    }

    /// Whether the normal of a lit face may count at any point of a box, for voxel steps of that length.
    pub fn may_light(&self, center: DVec3, half_extents: DVec3, unit: f64) -> bool {
        let reach = (Self::DEEPEST_LIT + Self::HAIR) * unit + half_extents.length();
        self.is_lit() && self.face_near(center, 0.0).is_some_and(|(_, behind)| behind < reach)
    }

    /// The face nearest to a point: its normal, away from the region, and how far behind it the point lies in
    /// world units, negative outside of the region. Nothing, if there are no planes.
    ///
    /// A plane is nearer than those before it if it is by more than a hair's breadth: where a point is as far
    /// from two, rounding decides nothing.
    #[inline]
    pub fn face_near(&self, point: DVec3, hair: f64) -> Option<(DVec3, f64)> {
        let mut nearest: Option<(DVec3, f64)> = None;
        for PlaneInView { normal, distance } in &self.planes {
            let before = normal.dot(point) - distance;
            if nearest.is_none_or(|(_, most)| most + hair < before) {
                nearest = Some((*normal, before));
            }
        }
        let out = if self.is_inverted() { -1.0 } else { 1.0 };
        nearest.map(|(normal, before)| (normal * out, -before * out))
    }

    /// The depths at which a ray enters and leaves the convex set: infinite if it does not, and from +∞ to −∞
    /// if it never meets it.
    #[inline]
    pub fn interval(&self, ray: &ViewRay) -> [f64; 2] {
        let [mut first, mut last] = [f64::NEG_INFINITY, f64::INFINITY];
        for plane in &self.planes {
            let (approach, left) = plane.approached_by(ray);
            if 0.0 < approach {
                last = last.min(left / approach);
            } else if approach < 0.0 {
                first = first.max(left / approach);
            } else if left < 0.0 {
                return NEVER;
            }
        }
        if first <= last { [first, last] } else { NEVER }
    }

    /// Whether all points of a box are so far outside of the region that a ball around each of them, of
    /// which a plane with normal `n` cuts `reach(n)`, is too.
    pub fn is_beyond(
        &self,
        center: DVec3,
        half_extents: DVec3,
        reach: impl Fn(DVec3) -> f64,
    ) -> bool {
        if self.is_inverted() {
            let extent = |plane: &PlaneInView| plane.extent(half_extents, &reach);
            self.planes.iter().all(|plane| plane.before(center) < -extent(plane))
        } else {
            is_beyond_any(self.planes.iter(), center, half_extents, reach)
        }
    }
}

impl PlaneInView {
    /// A plane of the world as `view` sees it.
    pub(crate) fn new(plane: &Plane, view: &View) -> Self {
        let axes = view.axes();
        let normal = plane.normal();
        let along = |axis: DVec3| normal.dot(axis);
        Self {
            normal: DVec3::new(along(axes.right), along(axes.up), along(axes.forward)),
            distance: -plane.before(view.origin_in_world()),
        }
    }

    /// `(a, l)`: at depths `z` of a ray with `a·z ≤ l` it is behind the plane.
    #[inline]
    pub(crate) fn approached_by(&self, ray: &ViewRay) -> (f64, f64) {
        (self.normal.dot(ray.step), self.distance - self.normal.dot(ray.start))
    }

    /// How far a point lies before it, in world units.
    fn before(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.distance
    }

    /// How far a box and what a ball around each of its points adds reach along the normal.
    fn extent(&self, half_extents: DVec3, reach: impl Fn(DVec3) -> f64) -> f64 {
        self.normal.abs().dot(half_extents) + reach(self.normal)
    }
}

/// Whether a box, and a ball around each of its points, lie before any of these planes.
pub(crate) fn is_beyond_any<'a>(
    mut planes: impl Iterator<Item = &'a PlaneInView>,
    center: DVec3,
    half_extents: DVec3,
    reach: impl Fn(DVec3) -> f64,
) -> bool {
    planes.any(|plane| plane.extent(half_extents, &reach) < plane.before(center))
}

/// Of rays that never meet a set.
pub(crate) const NEVER: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Camera, Grid, ImageDesc, Projection};

    fn view(projection: Projection) -> View {
        let grid = Grid::with_spacing([5; 3], [1.0; 3]).unwrap();
        let target = DVec3::new(2.0, 3.0, 4.0);
        let eye = target + DVec3::new(3.0, -2.0, 9.0);
        let camera = Camera::new(eye, target, DVec3::Y, projection).unwrap();
        View::new(&grid, &camera, &ImageDesc::new(30, 20)).unwrap()
    }

    /// Points along rays are in the region just where the interval says.
    #[test]
    fn region_in_view_is_the_region() {
        let planes = [(DVec3::X, 3.0), (DVec3::new(1.0, -2.0, 0.5), 1.0), (-DVec3::Z, 1.0)];
        let planes = planes.map(|(normal, distance)| Plane::new(normal, distance).unwrap());
        let region = Region::new(planes.to_vec());
        for projection in [
            Projection::Orthographic { view_height: 8.0 },
            Projection::Perspective { fov_y_radians: 0.8 },
        ] {
            let view = view(projection);
            let seen = RegionInView::new(&region, &view);
            let (mut n_inside, mut n_outside) = (0, 0);
            for (x, y) in (0..30).flat_map(|x| (0..20).map(move |y| (x, y))) {
                let ray = view.ray([f64::from(x) + 0.5, f64::from(y) + 0.5]);
                let [first, last] = seen.interval(&ray);
                for depth in [-7.03, -3.31, -0.4, 0.9, 3.7, 8.8] {
                    let at = view.world_from_view(ray.start + ray.step * depth);
                    let is_inside = first <= depth && depth <= last;
                    assert_eq!(region.contains(at), is_inside, "{projection:?} {x} {y} {depth}");
                    if is_inside { n_inside += 1 } else { n_outside += 1 }
                }
            }
            assert!(200 < n_inside && 200 < n_outside, "{n_inside} {n_outside}");
        }
    }

    #[test]
    fn region_in_view_of_rays_along_a_plane() {
        let view = view(Projection::Orthographic { view_height: 8.0 });
        let right = view.axes().right;
        let at = view.origin_in_world().dot(right);
        let cut = Region::new(vec![Plane::new(right, at).unwrap()]);
        let seen = RegionInView::new(&cut, &view);
        let interval = |x: f64| seen.interval(&view.ray([x, 10.0]));
        let left_of_axis = interval(14.0);
        assert!(left_of_axis[0] < -1e9 && 1e9 < left_of_axis[1], "{left_of_axis:?}");
        let [first, last] = interval(16.0);
        assert!(last < first, "{first} {last}");
    }

    #[test]
    fn region_in_view_has_faces() {
        let view = view(Projection::Orthographic { view_height: 8.0 });
        let planes = [(view.axes().right, 0.0), (view.axes().forward, 0.0)];
        let planes = planes.map(|(normal, distance)| Plane::new(normal, distance).unwrap());
        let region = Region::new(planes.to_vec()).lit();
        let seen = RegionInView::new(&region, &view);
        assert!(seen.is_lit());
        let corner = DVec3::new(seen.planes()[0].distance, 5.0, seen.planes()[1].distance);
        let inverted = RegionInView::new(&region.inverted(), &view);
        for (from_corner, normal, behind) in [
            (DVec3::new(-3.0, 0.0, -1.0), DVec3::Z, 1.0),
            (DVec3::new(-1.0, 0.0, -4.0), DVec3::X, 1.0),
            (DVec3::new(2.0, 0.0, 0.5), DVec3::X, -2.0),
        ] {
            let (found, depth) = seen.face_near(corner + from_corner, 1e-9).unwrap();
            assert!(found.abs_diff_eq(normal, 1e-12) && (depth - behind).abs() < 1e-12, "{found}");
            let (found, depth) = inverted.face_near(corner + from_corner, 1e-9).unwrap();
            assert!(found.abs_diff_eq(-normal, 1e-12) && (depth + behind).abs() < 1e-12, "{found}");
        }
        assert_eq!(RegionInView::new(&Region::default(), &view).face_near(corner, 0.0), None);
        // As far from both: the first is taken, until the second is nearer by more than a hair.
        for (nearer, normal) in [(0.0, DVec3::X), (9e-4, DVec3::X), (1.1e-3, DVec3::Z)] {
            let point = corner - DVec3::new(1.0, 0.0, 1.0 - nearer);
            let (found, _) = seen.face_near(point, 1e-3).unwrap();
            assert!(found.abs_diff_eq(normal, 1e-12), "{nearer}: {found}");
        }
    }

    #[test]
    fn region_in_view_is_beyond_boxes() {
        let view = view(Projection::Orthographic { view_height: 8.0 });
        let cut = Region::new(vec![Plane::new(view.axes().forward, 0.0).unwrap()]);
        let seen = RegionInView::new(&cut, &view);
        let [plane] = seen.planes() else { panic!("{seen:?}") };
        let inverted = RegionInView::new(&cut.inverted(), &view);
        let (face, half) = (plane.distance, DVec3::splat(0.5));
        let reach = |normal: DVec3| 2.0 * normal.length();
        for (before, expected, expected_of_inverted) in
            [(2.6, true, false), (2.4, false, false), (-2.4, false, false), (-2.6, false, true)]
        {
            let center = DVec3::new(30.0, -20.0, face + before);
            assert_eq!(seen.is_beyond(center, half, reach), expected, "{before}");
            assert_eq!(inverted.is_beyond(center, half, reach), expected_of_inverted, "{before}");
        }
        assert!(!RegionInView::new(&Region::default(), &view).is_beyond(half, half, reach));
        assert!(
            RegionInView::new(&Region::default().inverted(), &view).is_beyond(half, half, reach)
        );
    }
}
