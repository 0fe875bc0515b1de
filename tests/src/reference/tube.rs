//! Lines and points of meshes (model §14): all that is no farther than a radius from a line's ends, or from
//! what lies between them.

use slabsplat_core::glam::{DMat3, DVec3};
use slabsplat_core::{Light, MeshLayer, Region, Shading, ViewAxes};

use super::shaded_by_normals;

/// A line, or a point, whose ends are one.
pub(super) struct Tube<'a> {
    pub(super) ends: [DVec3; 2],
    pub(super) radius: f64,
    pub(super) colors: [[f64; 3]; 2],
    pub(super) light: (&'a Shading, &'a [Light]),
    pub(super) region: &'a Region,
}

/// How much nearer than its radius a point may be to the axis and count as on the surface.
const ROUNDING: f64 = 1e-9;

impl Tube<'_> {
    /// The depths at which a ray passes its surface, rising: those at which it passes one of two spheres or a
    /// cylinder, and is not within the tube.
    pub(super) fn met_by(&self, start: DVec3, step: DVec3) -> Vec<f64> {
        let [a, b] = self.ends;
        let axis = (b - a).normalize_or_zero();
        let along = DMat3::from_cols(axis * axis.x, axis * axis.y, axis * axis.z);
        let across = DMat3::IDENTITY - along;
        let mut depths = Vec::new();
        for (from, step) in
            [(start - a, step), (start - b, step), (across * (start - a), across * step)]
        {
            depths.extend(self.passes(from, step));
        }
        depths.retain(|depth| {
            let distance = self.distance(start + *depth * step);
            (distance - self.radius).abs() < ROUNDING * self.radius.max(1.0)
        });
        depths.sort_by(f64::total_cmp);
        depths
    }

    /// The roots of `|from + depth·step|² = radius²`.
    fn passes(&self, from: DVec3, step: DVec3) -> Vec<f64> {
        let (a, b) = (step.length_squared(), from.dot(step));
        let c = from.length_squared() - self.radius * self.radius;
        let root = (b * b - a * c).sqrt();
        let roots = [(-b - root) / a, (-b + root) / a];
        roots.into_iter().filter(|root| root.is_finite()).collect()
    }

    /// How far along the axis the point of it is that is nearest, from 0 to 1.
    fn share(&self, point: DVec3) -> f64 {
        let [a, b] = self.ends;
        if a == b {
            return 0.0;
        }
        ((point - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0)
    }

    fn on_axis(&self, point: DVec3) -> DVec3 {
        let [a, b] = self.ends;
        a + self.share(point) * (b - a)
    }

    fn distance(&self, point: DVec3) -> f64 {
        point.distance(self.on_axis(point))
    }

    pub(super) fn color(&self, point: DVec3, axes: &ViewAxes) -> [f64; 3] {
        let share = self.share(point);
        let [start, end] = self.colors;
        let color = [0, 1, 2].map(|it| (1.0 - share) * start[it] + share * end[it]);
        let normal = (point - self.on_axis(point)).normalize();
        shaded_by_normals(self.light, color, &[(normal, 1.0)], axes.forward)
    }
}

/// The lines and points of a layer.
pub(super) fn tubes<'a>(layer: &'a MeshLayer, lights: &'a [Light]) -> Vec<Tube<'a>> {
    let MeshLayer { mesh, color, line_width, point_size, shading, region, .. } = layer;
    let place = layer.world_from_mesh();
    let size = if mesh.size() == 0.0 { 1.0 } else { mesh.size() };
    let size = size * place.matrix3.determinant().abs().cbrt();
    let (line_width, point_size) =
        (line_width.unwrap_or(size / 400.0), point_size.unwrap_or(size / 100.0));
    let tube = |(vertices, width): ([u32; 2], f64)| {
        let own = |vertex: u32| {
            let of_vertex = mesh.vertex_color(vertex as usize).map(|it| it.map(f64::from));
            color.or(of_vertex).unwrap_or(MeshLayer::DEFAULT_COLOR)
        };
        let end = |vertex: u32| place.transform_point3(mesh.positions()[vertex as usize]);
        Tube {
            ends: vertices.map(end),
            radius: 0.5 * width,
            colors: vertices.map(own),
            light: (shading, lights),
            region,
        }
    };
    let lines = mesh.lines().iter().map(|line| (*line, line_width));
    lines.chain(mesh.points().iter().map(|point| ([*point; 2], point_size))).map(tube).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tube_is_met_by_hand() {
        let (shading, region) = (Shading::None, Region::default());
        let tube = Tube {
            ends: [DVec3::ZERO, 4.0 * DVec3::X],
            radius: 1.25,
            colors: [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
            light: (&shading, &[]),
            region: &region,
        };
        let check = |x: f64, y: f64, expected: &[f64]| {
            let mut depths = tube.met_by(DVec3::new(x, y, -10.0), DVec3::Z);
            depths.dedup();
            assert_eq!(depths, expected, "{x} {y}");
        };
        check(2.0, 0.0, &[8.75, 11.25]);
        check(2.0, 0.75, &[9.0, 11.0]);
        check(4.75, 0.0, &[9.0, 11.0]);
        check(-0.75, 0.0, &[9.0, 11.0]);
        check(2.0, 1.5, &[]);
        check(5.5, 0.0, &[]);
        let axes = ViewAxes { right: DVec3::X, up: DVec3::Y, forward: DVec3::NEG_Z };
        let middle = tube.color(DVec3::new(2.0, 0.0, 1.25), &axes);
        assert_eq!(middle, [0.5, 0.0, 0.5]);
        assert_eq!(tube.color(DVec3::new(-1.25, 0.0, 0.0), &axes), [1.0, 0.0, 0.0]);
    }
}
