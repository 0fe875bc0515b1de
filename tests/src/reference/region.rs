//! How much of a slab a region leaves of a layer, at one pixel (model §11).

use super::density;
use super::frame::Frame;
use super::mesh;
use super::sheet::{share_of_slab, splitting};
use super::view::View;
use rayon::prelude::*;
use slabsplat_core::glam::DVec3;
use slabsplat_core::{Compositing, Method, Mode, Region, Scene};

/// What a pixel's ray has in common with a region.
#[derive(Clone, Copy, Debug)]
pub(super) struct RegionOnRay {
    /// `z₀` and `z₁`: the depths at which the convex set begins and ends. It is empty if it ends first.
    ends: [f64; 2],
    is_inverted: bool,
}

impl RegionOnRay {
    /// The true ray of the pixel, through its middle; in a perspective view it is one through the eye.
    pub(super) fn new(region: &Region, view: &View, at: [i64; 2]) -> Self {
        Self::moved(region, view, at, 0.0)
    }

    /// The same of planes that let so much more in, in world units.
    pub(super) fn moved(region: &Region, view: &View, at: [i64; 2], outwards: f64) -> Self {
        let [near, far] = [0.0, 1.0].map(|depth| view.ray_in_world(at, depth));
        let mut ends = [f64::NEG_INFINITY, f64::INFINITY];
        for plane in region.planes() {
            // n·(near + z·(far − near)) ≤ d
            let slope = plane.normal().dot(far - near);
            let room = plane.distance() + outwards - plane.normal().dot(near);
            if 0.0 < slope {
                ends[1] = ends[1].min(room / slope);
            } else if slope < 0.0 {
                ends[0] = ends[0].max(room / slope);
            } else if room < 0.0 {
                ends = [f64::INFINITY, f64::NEG_INFINITY];
            }
        }
        Self { ends, is_inverted: region.is_inverted() }
    }

    /// Whether a depth is in the region.
    pub(super) fn holds(&self, depth: f64) -> bool {
        let [start, end] = self.ends;
        (start <= depth && depth < end) != self.is_inverted
    }

    /// The share of a slab between two faces.
    pub(super) fn share(&self, compositing: Compositing, faces: [f64; 2]) -> f64 {
        let in_convex_set = share_of_slab(compositing, faces, self.ends);
        if self.is_inverted { 1.0 - in_convex_set } else { in_convex_set }
    }
}

/// What becomes of a normal, not longer than 1, at a point in the world where lit faces of a region are near:
/// that of the face up to three quarters of a `unit` behind it, and a `unit` further itself.
pub(super) fn normal_by_faces(region: &Region, unit: f64, at: DVec3, normal: DVec3) -> DVec3 {
    let Some((face, behind)) = lit_face(region, unit, at) else { return normal };
    let own = (behind - 0.75).clamp(0.0, 1.0);
    (1.0 - own) * face + own * normal
}

/// The normal of the lit face that is nearest to a point in the world, and how many `unit`s behind it that
/// is.
pub(super) fn lit_face(region: &Region, unit: f64, at: DVec3) -> Option<(DVec3, f64)> {
    if !region.is_lit() || region.planes().is_empty() {
        return None;
    }
    let mut nearest = (DVec3::ZERO, f64::NEG_INFINITY);
    for plane in region.planes() {
        let before = plane.normal().dot(at) - plane.distance();
        if nearest.1 + unit / 1024.0 < before {
            nearest = (plane.normal(), before);
        }
    }
    let out = if region.is_inverted() { -1.0 } else { 1.0 };
    Some((out * nearest.0, -out * nearest.1 / unit))
}

/// By how many `unit`s renderers may disagree on where planes are.
pub(super) const PLACE_OF_A_PLANE: f64 = 1e-5;

/// The pixels, row by row, that may look quite another way to a renderer that rounds otherwise: if the planes
/// were moved by 10⁻⁵ `unit`s, some share would change by more than half. In `extinction`, only where a ray
/// lies within a plane; in the other models, where it also meets one in the middle of a slab. And those of
/// which a sample is as undecided about meshes. Of isosurfaces, those that show another colour if planes are
/// moved or values differ by 10⁻⁵ of their range: where a ray just touches a surface.
pub fn undecided_pixels(scene: &Scene) -> Vec<bool> {
    if scene.settings.mode == Mode::Isosurfaces {
        return density::undecided_isosurfaces(scene);
    }
    let view = View::new(&scene.camera, &scene.image);
    let slabs = match scene.settings.method {
        Method::PostClassified => density::part_faces(scene),
        _ => Frame::new(scene, 0.0).sheets.iter().filter_map(|sheet| sheet.faces).collect(),
    };
    let compositing = splitting(scene.settings.mode);
    let is_undecided = |at: [i64; 2]| {
        scene.layers.iter().any(|layer| {
            let by = PLACE_OF_A_PLANE * layer.volume.grid().unit();
            let [less, more] = [-by, by].map(|by| RegionOnRay::moved(&layer.region, &view, at, by));
            let change = |faces| less.share(compositing, faces) - more.share(compositing, faces);
            slabs.iter().any(|&faces| 0.5 < change(faces).abs())
        })
    };
    let by_meshes = mesh::undecided_pixels(scene, &slabs);
    let pixels = view.pixels().zip(by_meshes);
    pixels.map(|(at, by_meshes)| by_meshes || is_undecided(at)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::{Camera, ImageDesc, Plane, Projection};

    /// Looks along −z from 10; the ray of pixel 0 is the axis, that of pixel 1 is at x = 2 at the depth 10.
    fn view(projection: Projection) -> View {
        let camera = Camera::new(DVec3::Z * 10.0, DVec3::ZERO, DVec3::Y, projection)
            .expect("up is not forward");
        View::new(&camera, &ImageDesc::new(1, 1))
    }

    fn orthographic() -> View {
        view(Projection::Orthographic { view_height: 2.0 })
    }

    fn perspective() -> View {
        view(Projection::Perspective { fov_y_radians: 2.0 * 0.1_f64.atan() })
    }

    fn behind(normal: DVec3, distance: f64) -> Plane {
        Plane::new(normal, distance).expect("the normal is not zero")
    }

    fn ends(planes: Vec<Plane>, view: &View, x: i64) -> [f64; 2] {
        RegionOnRay::new(&Region::new(planes), view, [x, 0]).ends
    }

    fn assert_close(actual: [f64; 2], expected: [f64; 2]) {
        let is_close = |(a, b): (f64, f64)| a == b || (a - b).abs() < 1e-12;
        assert!(actual.into_iter().zip(expected).all(is_close), "{actual:?}, not {expected:?}");
    }

    #[test]
    fn region_interval_by_hand() {
        let all = [f64::NEG_INFINITY, f64::INFINITY];
        let diagonal = DVec3::new(1.0, 0.0, 1.0);
        let across = vec![behind(DVec3::Z, 4.0), behind(-DVec3::Z, 1.0)];
        for view in [orthographic(), perspective()] {
            assert_close(ends(vec![], &view, 0), all);
            assert_close(ends(across.clone(), &view, 1), [6.0, 11.0]);
            // z ≤ 0 on the axis.
            assert_close(ends(vec![behind(diagonal, 0.0)], &view, 0), [10.0, f64::INFINITY]);
        }
        // x + z ≤ 0, where x = 2, or x = 0.2·depth, and z = 10 − depth.
        let diagonal = vec![behind(diagonal, 0.0)];
        assert_close(ends(diagonal.clone(), &orthographic(), 1), [12.0, f64::INFINITY]);
        assert_close(ends(diagonal, &perspective(), 1), [12.5, f64::INFINITY]);
        // x ≤ 1 is parallel to orthographic rays.
        let wall = vec![behind(DVec3::X, 1.0)];
        assert_close(ends(wall.clone(), &orthographic(), 0), all);
        let [start, end] = ends(wall.clone(), &orthographic(), 1);
        assert!(end < start, "{start} {end}");
        assert_close(ends(wall, &perspective(), 1), [f64::NEG_INFINITY, 5.0]);
    }

    #[test]
    fn region_faces_by_hand() {
        let region = Region::new(vec![behind(DVec3::Z, 4.0), behind(DVec3::X, 0.0)]).lit();
        let check = |region: &Region, at: DVec3, expected: DVec3| {
            let normal = normal_by_faces(region, 2.0, at, DVec3::Y);
            assert!(normal.abs_diff_eq(expected, 1e-12), "{at}: {normal}");
        };
        check(&region, DVec3::new(-9.0, 0.0, 5.0), DVec3::Z);
        check(&region, DVec3::new(-9.0, 0.0, 2.5), DVec3::Z);
        check(&region, DVec3::new(-2.5, 0.0, -5.0), 0.5 * (DVec3::X + DVec3::Y));
        check(&region, DVec3::new(-3.5, 0.0, -5.0), DVec3::Y);
        let inverted = region.clone().inverted();
        check(&inverted, DVec3::new(-9.0, 0.0, 5.0), -DVec3::Z);
        check(&inverted, DVec3::new(-9.0, 0.0, 9.0), DVec3::Y);
        check(&Region::new(region.planes().to_vec()), DVec3::Z * 4.0, DVec3::Y);
        // As far from both, and nearer to the second by less and by more than 1/1024 `unit`.
        check(&region, DVec3::new(1.0, 0.0, 5.0), DVec3::Z);
        check(&region, DVec3::new(1.0019, 0.0, 5.0), DVec3::Z);
        check(&region, DVec3::new(1.002, 0.0, 5.0), DVec3::X);
    }

    #[test]
    fn region_share_by_hand() {
        let check = |planes: &[Plane], extinction: f64, other: f64| {
            let region = Region::new(planes.to_vec());
            for (region, sign) in [(region.clone(), 1.0), (region.inverted(), -1.0)] {
                let on_ray = RegionOnRay::new(&region, &orthographic(), [0, 0]);
                for (compositing, expected) in [
                    (Compositing::Extinction, extinction),
                    (Compositing::Separate, other),
                    (Compositing::Associated, other),
                ] {
                    let share = on_ray.share(compositing, [8.0, 12.0]);
                    let expected = if sign < 0.0 { 1.0 - expected } else { expected };
                    assert!((share - expected).abs() < 1e-12, "{region:?} {compositing}: {share}");
                }
            }
        };
        let from = |depth: f64| behind(DVec3::Z, 10.0 - depth);
        let to = |depth: f64| behind(-DVec3::Z, depth - 10.0);
        check(&[], 1.0, 1.0);
        check(&[from(9.0)], 0.75, 1.0);
        check(&[from(11.0)], 0.25, 0.0);
        check(&[from(9.0), to(9.5)], 0.125, 0.0);
        check(&[from(9.5), to(9.0)], 0.0, 0.0);
        check(&[from(13.0)], 0.0, 0.0);
        check(&[to(13.0)], 1.0, 1.0);
        // The middle itself belongs to what begins there.
        check(&[from(10.0)], 0.5, 1.0);
        check(&[to(10.0)], 0.5, 0.0);
    }
}
