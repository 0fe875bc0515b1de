//! Lines, which are seen as tubes with round ends, and points, which are balls: tubes of no length.
//!
//! A tube is a cylinder with a ball at either end. It is convex, so that a ray is in it from where it first
//! enters any of the three to where it last leaves one: at no joint can a hit be lost to rounding.

use crate::clip::bounds_of;
use crate::vertices::Corner;
use slabsplat_backend::MeshPlan;
use slabsplat_core::glam::DVec3;
use slabsplat_core::{MeshLayer, View, ViewRay};

/// A line or a point of a mesh, in view space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tube<'a> {
    pub(crate) of_mesh: &'a MeshPlan<'a>,
    /// Their numbers in the mesh.
    pub(crate) vertices: [u32; 2],
    pub(crate) shape: Shape,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Shape {
    pub(crate) ends: [DVec3; 2],
    pub(crate) radius: f64,
}

/// What of the image a tube lies in: discs of one size along a line, in pixels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Band {
    ends: [[f64; 2]; 2],
    radius: f64,
}

impl Tube<'_> {
    /// Its colour where a ray meets it.
    pub(crate) fn color(&self, ray: &ViewRay, depth: f64, view: &View) -> [f32; 3] {
        let point = ray.start + depth * ray.step;
        let share = self.shape.share(point);
        let normal = self.shape.normal(point, share);
        let axes = view.axes();
        let in_world = normal.x * axes.right + normal.y * axes.up + normal.z * axes.forward;
        let color = self.own_color(share);
        let light = self.of_mesh.light.as_ref();
        light.map_or(color, |light| light.lit(color, in_world)).as_vec3().to_array()
    }

    fn own_color(&self, share: f64) -> DVec3 {
        let MeshLayer { mesh, color, .. } = self.of_mesh.layer;
        if let Some(color) = color {
            return DVec3::from_array(*color);
        }
        let of_ends = self.vertices.map(|vertex| mesh.vertex_color(vertex as usize));
        let [Some(start), Some(end)] = of_ends else {
            return DVec3::from_array(MeshLayer::DEFAULT_COLOR);
        };
        let [start, end] = [start, end].map(|color| DVec3::from_array(color.map(f64::from)));
        (1.0 - share) * start + share * end
    }
}

impl Shape {
    /// The depths at which a ray enters and leaves it.
    pub(crate) fn met_by(&self, ray: &ViewRay) -> Option<[f64; 2]> {
        let [start, end] = self.ends.map(|end| self.ball_met_by(ray, end));
        let parts = [start, end, self.cylinder_met_by(ray)].into_iter().flatten();
        parts.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)])
    }

    fn ball_met_by(&self, ray: &ViewRay, center: DVec3) -> Option<[f64; 2]> {
        let from_center = ray.start + center.z * ray.step - center;
        self.near(from_center, ray.step).map(|depths| depths.map(|depth| center.z + depth))
    }

    /// Rays along the axis are left to the balls.
    fn cylinder_met_by(&self, ray: &ViewRay) -> Option<[f64; 2]> {
        let [start, end] = self.ends;
        let length = start.distance(end);
        let axis = (end - start).try_normalize()?;
        let from_start = ray.start + start.z * ray.step - start;
        let across = |way: DVec3| way - way.dot(axis) * axis;
        let [enter, leave] = self.near(across(from_start), across(ray.step))?;
        let (first, along) = (from_start.dot(axis), ray.step.dot(axis));
        // A ray across the axis passes its ends at infinity.
        let [a, b] = [0.0, length].map(|end| (end - first) / along);
        let [enter, leave] = [enter.max(a.min(b)), leave.min(a.max(b))];
        (enter <= leave).then(|| [enter, leave].map(|depth| start.z + depth))
    }

    /// From where to where a point that moves is no farther than the radius from the origin.
    fn near(&self, from_origin: DVec3, step: DVec3) -> Option<[f64; 2]> {
        let per_step = step.length_squared();
        let nearest = -from_origin.dot(step) / per_step;
        let distance = (from_origin + nearest * step).length();
        // Not of squares: rays that graze it would come out with half of their digits.
        let half = ((self.radius - distance) * (self.radius + distance) / per_step).sqrt();
        half.is_finite().then_some([nearest - half, nearest + half])
    }

    /// How far along it a point is, from 0 to 1.
    fn share(&self, point: DVec3) -> f64 {
        let [start, end] = self.ends;
        let squared_length = start.distance_squared(end);
        if squared_length <= 0.0 {
            return 0.0;
        }
        ((point - start).dot(end - start) / squared_length).clamp(0.0, 1.0)
    }

    fn normal(&self, point: DVec3, share: f64) -> DVec3 {
        let [start, end] = self.ends;
        (point - start.lerp(end, share)).normalize_or_zero()
    }

    /// The rectangle of the image around all of it that is not before the near depth, if there is any, and if
    /// numbers can hold it.
    pub(crate) fn bounds(&self, view: &View) -> Option<[[f64; 2]; 2]> {
        let [start, end] = self.ends;
        let is_there = 0.0 < self.radius && self.radius.is_finite();
        let [min, max] = [start.min(end) - self.radius, start.max(end) + self.radius];
        let near = min.z.max(view.near_depth());
        let is_before = near <= max.z;
        if !is_there || !is_before {
            return None;
        }
        let corner = |corner: DVec3, depth| Corner::of(corner.with_z(depth), view);
        let corners = [(min, near), (max, near), (min, max.z), (max, max.z)];
        let bounds = bounds_of(&corners.map(|(at, depth)| corner(at, depth)))?;
        bounds.as_flattened().iter().all(|it| it.is_finite()).then_some(bounds)
    }

    /// A tighter part of the image, unless some of it may lie before the near depth: it is the convex hull of
    /// its balls, and perspective keeps that.
    pub(crate) fn band(&self, view: &View) -> Option<Band> {
        if self.ends.iter().any(|end| end.z - self.radius < view.near_depth()) {
            return None;
        }
        let [start, end] = self.ends.map(|end| Self { ends: [end; 2], ..*self }.bounds(view));
        let boxes = [start?, end?];
        let radius = |[min, max]: [[f64; 2]; 2]| 0.5 * (max[0] - min[0]).hypot(max[1] - min[1]);
        let middle = |[min, max]: [[f64; 2]; 2]| [0, 1].map(|axis| 0.5 * (min[axis] + max[axis]));
        Some(Band { ends: boxes.map(middle), radius: radius(boxes[0]).max(radius(boxes[1])) })
    }
}

impl Band {
    /// From where to where it may lie in a row of pixels, from whose upper edge it is asked.
    pub(crate) fn in_row(&self, top: f64) -> Option<[f64; 2]> {
        let [[x0, y0], [x1, y1]] = self.ends;
        let edges = [top - self.radius, top + 1.0 + self.radius];
        // A level band passes them at infinity.
        let [a, b] = edges.map(|y| (y - y0) / (y1 - y0));
        let [first, last] = [a.min(b).max(0.0), a.max(b).min(1.0)];
        let [a, b] = [first, last].map(|share| x0 + share * (x1 - x0));
        (first <= last).then(|| [a.min(b) - self.radius, a.max(b) + self.radius])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_seeds::for_each_seed;

    fn point(rng: &mut fastrand::Rng, extent: f64) -> DVec3 {
        DVec3::from_array([0; 3].map(|_| extent * (2.0 * rng.f64() - 1.0)))
    }

    #[test]
    fn tube_is_met_by_hand() {
        let check = |end: DVec3, x: f64, y: f64, expected: Option<[f64; 2]>| {
            let tube = Shape { ends: [DVec3::ZERO, end], radius: 1.25 };
            let ray = ViewRay { start: DVec3::new(x, y, 0.0), step: DVec3::Z };
            assert_eq!(tube.met_by(&ray), expected, "{end} {x} {y}");
        };
        let across = 4.0 * DVec3::X;
        check(across, 2.0, 0.0, Some([-1.25, 1.25]));
        check(across, 2.0, 0.75, Some([-1.0, 1.0]));
        check(across, 4.75, 0.0, Some([-1.0, 1.0]));
        check(across, 0.0, 0.0, Some([-1.25, 1.25]));
        check(across, 2.0, 1.5, None);
        check(across, 5.5, 0.0, None);
        check(4.0 * DVec3::Z, 0.75, 0.0, Some([-1.0, 5.0]));
        check(DVec3::ZERO, 0.75, 0.0, Some([-1.0, 1.0]));
        check(DVec3::ZERO, 1.5, 0.0, None);
    }

    /// Where a ray enters and leaves, points are as far from the axis as it is thick, and nearer between.
    #[test]
    fn tube_is_all_that_is_near_its_axis() {
        for_each_seed(200, |mut rng| {
            let (mut ends, radius) = ([0; 2].map(|_| point(&mut rng, 3.0)), 0.1 + rng.f64());
            if rng.u32(..4) == 0 {
                ends[1] = ends[0];
            }
            let tube = Shape { ends, radius };
            let step = point(&mut rng, 1.0).with_z(1.0);
            let ray = ViewRay { start: point(&mut rng, 3.0).with_z(0.0), step };
            let distance = |depth: f64| {
                let point = ray.start + depth * step;
                point.distance(ends[0].lerp(ends[1], tube.share(point)))
            };
            let least = (-800..800).map(|depth| distance(f64::from(depth) / 100.0));
            let least = least.fold(f64::INFINITY, f64::min);
            let Some([enter, leave]) = tube.met_by(&ray) else {
                return assert!(radius - 1e-3 < least, "{least} {radius}");
            };
            for depth in [enter, leave] {
                assert!((distance(depth) - radius).abs() < 1e-9, "{depth}");
                let point = ray.start + depth * step;
                let normal = tube.normal(point, tube.share(point));
                assert!((normal.length() - 1.0).abs() < 1e-12);
            }
            assert!(distance(0.5 * (enter + leave)) < radius + 1e-9);
            assert!(
                radius - 1e-9 < distance(enter - 0.01) && radius - 1e-9 < distance(leave + 0.01)
            );
        });
    }

    #[test]
    fn band_holds_the_discs() {
        for_each_seed(200, |mut rng| {
            let ends = [0; 2].map(|_| [0; 2].map(|_| f64::from(rng.u32(..20))));
            let band = Band { ends, radius: 3.0 * rng.f64() };
            let (share, turn) = (rng.f64(), rng.f64() * std::f64::consts::TAU);
            let [x, y] = [0, 1].map(|axis| ends[0][axis] + share * (ends[1][axis] - ends[0][axis]));
            let reach = 0.99 * band.radius;
            let [x, y] = [x + reach * turn.cos(), y + reach * turn.sin()];
            let [first, last] = band.in_row(y.floor()).expect("a point of it is in this row");
            assert!(first <= x && x <= last, "{x} {first} {last} {band:?}");
            assert_eq!(band.in_row(40.0), None);
        });
    }
}
