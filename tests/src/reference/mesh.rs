//! What the rays of a pixel's samples hit of opaque meshes (model §14): every triangle, line and point is
//! asked.

use super::shaded_by_normals;
use super::sheet::{Premultiplied, share_of_slab, splitting};
use super::tube::{Tube, tubes};
use super::view::View;
use rayon::prelude::*;
use slabsplat_core::glam::{DMat3, DVec3};
use slabsplat_core::{Compositing, Light, MeshLayer, Region, Scene, Shading};

/// Where a pixel's samples are, from its corner.
const SAMPLES: [[f64; 2]; 8] = {
    let rows = [4, 6, 0, 2, 7, 5, 3, 1];
    let mut samples = [[0.0; 2]; 8];
    let mut column = 0;
    while column < 8 {
        samples[column] = [(2 * column + 1) as f64 / 16.0, (2 * rows[column] + 1) as f64 / 16.0];
        column += 1;
    }
    samples
};

/// Depths are one that differ by rounding alone, as those of a triangle that is there twice, for both sides.
const ONE_DEPTH: f64 = 1e-10;

/// All triangles, lines and points of a scene.
pub(super) struct Surfaces<'a> {
    triangles: Vec<Triangle<'a>>,
    tubes: Vec<Tube<'a>>,
    near_depth: f64,
}

struct Triangle<'a> {
    corners: [DVec3; 3],
    /// Each of length 1, or 0.
    normals: [DVec3; 3],
    colors: [[f64; 3]; 3],
    light: (&'a Shading, &'a [Light]),
    region: &'a Region,
}

/// Where a ray ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Hit {
    /// From the eye.
    pub(super) depth: f64,
    /// Lit.
    pub(super) color: [f64; 3],
}

impl<'a> Surfaces<'a> {
    pub(super) fn new(scene: &'a Scene, view: &View) -> Self {
        let units = scene.layers.iter().map(|layer| layer.volume.grid().unit());
        let unit = units.reduce(f64::min).unwrap_or_else(|| unit_of_meshes(&scene.meshes));
        let triangles =
            scene.meshes.iter().flat_map(|layer| triangles(layer, &scene.lights)).collect();
        let tubes = scene.meshes.iter().flat_map(|layer| tubes(layer, &scene.lights)).collect();
        Self { triangles, tubes, near_depth: view.near_depth(unit) }
    }

    /// The hits of a pixel's samples; of a scene without meshes that of a single ray, which hits nothing.
    pub(super) fn hits(&self, view: &View, at: [i64; 2]) -> Vec<Option<Hit>> {
        if self.triangles.is_empty() && self.tubes.is_empty() {
            return vec![None];
        }
        let corner = at.map(|pixel| pixel as f64);
        let samples = SAMPLES.map(|[x, y]| [corner[0] + x, corner[1] + y]);
        samples.map(|sample| self.hit(view, sample)).to_vec()
    }

    fn hit(&self, view: &View, sample: [f64; 2]) -> Option<Hit> {
        let start = view.point_in_world(sample, 0.0);
        let step = view.point_in_world(sample, 1.0) - start;
        let hit = |triangle: &Triangle<'_>| {
            let (depth, [u, v]) = triangle.met_by(start, step)?;
            let is_there =
                self.near_depth <= depth && triangle.region.contains(start + depth * step);
            let color = || triangle.color([1.0 - u - v, u, v], view.axes.forward);
            is_there.then(|| Hit { depth, color: color() })
        };
        let hit_of_tube = |tube: &Tube<'_>| {
            let is_there = |depth: &f64| {
                self.near_depth <= *depth && tube.region.contains(start + *depth * step)
            };
            let depth = tube.met_by(start, step).into_iter().find(is_there)?;
            Some(Hit { depth, color: tube.color(start + depth * step, &view.axes) })
        };
        let of_tubes = self.tubes.iter().filter_map(hit_of_tube);
        let hits: Vec<Hit> = self.triangles.iter().filter_map(hit).chain(of_tubes).collect();
        let nearest = hits.iter().map(|hit| hit.depth).fold(f64::INFINITY, f64::min);
        let at_one_depth = |hit: &Hit| hit.depth - nearest <= ONE_DEPTH * nearest.abs().max(1.0);
        let in_order =
            |a: &Hit, b: &Hit| a.color.partial_cmp(&b.color).expect("colours are numbers");
        hits.into_iter().filter(at_one_depth).min_by(in_order)
    }
}

impl Triangle<'_> {
    /// The depth at which a ray meets it, and the shares of its second and its third corner there (Möller &
    /// Trumbore, Journal of Graphics Tools 2(1), 1997).
    fn met_by(&self, start: DVec3, step: DVec3) -> Option<(f64, [f64; 2])> {
        let [a, b, c] = self.corners;
        let (right, left) = (b - a, c - a);
        let across = step.cross(left);
        let volume = right.dot(across);
        if volume == 0.0 {
            return None;
        }
        let from_corner = start - a;
        let upwards = from_corner.cross(right);
        let [u, v] = [from_corner.dot(across) / volume, step.dot(upwards) / volume];
        let is_inside = 0.0 <= u && 0.0 <= v && u + v <= 1.0;
        is_inside.then(|| (left.dot(upwards) / volume, [u, v]))
    }

    fn color(&self, shares: [f64; 3], forward: DVec3) -> [f64; 3] {
        let normal: DVec3 = (0..3).map(|corner| shares[corner] * self.normals[corner]).sum();
        let of_channel = |channel: usize| {
            (0..3).map(|corner| shares[corner] * self.colors[corner][channel]).sum()
        };
        let color = [0, 1, 2].map(of_channel);
        shaded_by_normals(self.light, color, &[(normal.normalize_or_zero(), 1.0)], forward)
    }
}

fn triangles<'a>(layer: &'a MeshLayer, lights: &'a [Light]) -> impl Iterator<Item = Triangle<'a>> {
    let MeshLayer { mesh, color, shading, region, .. } = layer;
    let world_from_mesh = layer.world_from_mesh();
    let world_from_normal: DMat3 = world_from_mesh.matrix3.inverse().transpose();
    (0..mesh.triangles().len()).map(move |triangle| {
        let wide = |of_corners: [[f32; 3]; 3]| of_corners.map(|it| it.map(f64::from));
        let flat = mesh.face_normal(triangle);
        let normals = mesh.normals(triangle).map(|it| wide(it).map(DVec3::from_array));
        let turned = |normal: DVec3| (world_from_normal * normal).normalize_or_zero();
        let default = [MeshLayer::DEFAULT_COLOR; 3];
        let own = mesh.colors(triangle).map_or(default, wide);
        Triangle {
            corners: mesh.corners(triangle).map(|corner| world_from_mesh.transform_point3(corner)),
            normals: normals.unwrap_or([flat; 3]).map(turned),
            colors: color.map_or(own, |color| [color; 3]),
            light: (shading, lights),
            region,
        }
    })
}

/// 1/1024 of the diagonal of the box around all.
fn unit_of_meshes(meshes: &[MeshLayer]) -> f64 {
    let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for layer in meshes {
        if let Some([low, high]) = layer.bounds() {
            (min, max) = (min.min(low), max.max(high));
        }
    }
    (max - min).length() / 1024.0
}

/// What part of a slab lies before a depth.
pub(super) fn share_before(compositing: Compositing, faces: [f64; 2], depth: f64) -> f64 {
    share_of_slab(compositing, faces, [f64::NEG_INFINITY, depth])
}

/// The mean of what samples show: what `before` returns of a depth, or of all of it, and then the surface or
/// the background.
pub(super) fn mean_of_samples(
    hits: &[Option<Hit>],
    [r, g, b, opacity]: [f64; 4],
    before: impl Fn(Option<f64>) -> Premultiplied,
) -> [f64; 4] {
    let background = Premultiplied { color: [r, g, b].map(|c| c * opacity), opacity };
    let mut sum = [0.0; 4];
    for hit in hits {
        let mut pixel = before(hit.map(|hit| hit.depth));
        let surface = hit.map(|hit| Premultiplied { color: hit.color, opacity: 1.0 });
        pixel.lay_over(surface.unwrap_or(background));
        let [r, g, b] = pixel.color;
        for (sum, channel) in sum.iter_mut().zip([r, g, b, pixel.opacity]) {
            *sum += channel;
        }
    }
    sum.map(|channel| channel / hits.len() as f64)
}

/// By how many pixels renderers may disagree on where edges are, and by how many world units on depths.
const PLACE_OF_AN_EDGE: f64 = 1e-5;

/// By how much colours may differ, and depths as part of a slab, of which a picture shows nothing: of what
/// lies a hundred-thousandth of a pixel apart. Rounding moves things by less than a thousandth of that.
const MUCH_OF_A_COLOR: f64 = 1e-3;
const MUCH_OF_A_SLAB: f64 = 1e-2;

/// The pixels, row by row, of which a sample may look quite another way to a renderer that rounds otherwise:
/// if what is hit so little beside it has another colour or depth, or if it lies just in the middle of a slab
/// that a surface does not split.
pub(super) fn undecided_pixels(scene: &Scene, slabs: &[[f64; 2]]) -> Vec<bool> {
    let view = View::new(&scene.camera, &scene.image);
    let surfaces = Surfaces::new(scene, &view);
    let compositing = splitting(scene.settings.mode);
    let thickness = slabs.first().map_or(f64::INFINITY, |[front, back]| back - front);
    let much = MUCH_OF_A_SLAB * thickness;
    let is_in_a_middle = |hit: Hit| {
        let [less, more] = [-PLACE_OF_AN_EDGE, PLACE_OF_AN_EDGE].map(|by| hit.depth + by);
        let share = |faces, depth| share_before(compositing, faces, depth);
        slabs.iter().any(|&faces| 0.5 < share(faces, more) - share(faces, less))
    };
    let is_undecided = |at: [i64; 2]| {
        let corner = at.map(|pixel| pixel as f64);
        SAMPLES.iter().any(|[x, y]| {
            let beside = |[dx, dy]: [f64; 2]| {
                let by = [dx, dy].map(|d| d * PLACE_OF_AN_EDGE);
                surfaces.hit(&view, [corner[0] + x + by[0], corner[1] + y + by[1]])
            };
            let here = beside([0.0; 2]);
            let aside = [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]];
            aside.into_iter().any(|by| are_apart(here, beside(by), much))
                || here.is_some_and(is_in_a_middle)
        })
    };
    if scene.meshes.is_empty() {
        return vec![false; view.pixels().len()];
    }
    view.pixels().map(is_undecided).collect()
}

/// Whether two rays that are next to each other end at different things: at colours that are not alike, or at
/// depths that differ by so much.
fn are_apart(a: Option<Hit>, b: Option<Hit>, much: f64) -> bool {
    match (a, b) {
        (None, None) => false,
        (Some(a), Some(b)) => {
            let change = (0..3).map(|c| (a.color[c] - b.color[c]).abs()).fold(0.0, f64::max);
            MUCH_OF_A_COLOR < change || much < (a.depth - b.depth).abs()
        }
        _ => true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle<'a>(shading: &'a Shading, region: &'a Region) -> Triangle<'a> {
        Triangle {
            corners: [DVec3::ZERO, DVec3::X * 4.0, DVec3::Y * 2.0],
            normals: [DVec3::X, DVec3::Y, DVec3::Z],
            colors: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            light: (shading, &[]),
            region,
        }
    }

    #[test]
    fn mesh_triangle_is_met_by_hand() {
        let (shading, region) = (Shading::None, Region::default());
        let triangle = triangle(&shading, &region);
        let check = |x: f64, y: f64, expected: Option<(f64, [f64; 2])>| {
            let start = DVec3::new(x, y, 10.0);
            assert_eq!(triangle.met_by(start, DVec3::NEG_Z), expected, "{x} {y}");
            assert_eq!(triangle.met_by(start - 20.0 * DVec3::Z, DVec3::Z), expected, "{x} {y}");
        };
        check(1.0, 1.0, Some((10.0, [0.25, 0.5])));
        check(2.0, 1.0, Some((10.0, [0.5, 0.5])));
        check(0.0, 0.0, Some((10.0, [0.0, 0.0])));
        check(2.1, 1.0, None);
        check(-0.1, 1.0, None);
        check(1.0, -0.1, None);
        assert_eq!(triangle.met_by(DVec3::ONE, DVec3::X), None, "along it");
        assert_eq!(triangle.color([0.5, 0.25, 0.25], DVec3::Z), [0.5, 0.25, 0.25]);
    }

    #[test]
    fn mesh_share_by_hand() {
        let check = |depth: f64, extinction: f64, other: f64| {
            assert_eq!(share_before(Compositing::Extinction, [2.0, 6.0], depth), extinction);
            for compositing in [Compositing::Separate, Compositing::Associated] {
                assert_eq!(share_before(compositing, [2.0, 6.0], depth), other);
            }
        };
        check(1.0, 0.0, 0.0);
        check(3.0, 0.25, 0.0);
        check(4.0, 0.5, 0.0);
        check(5.0, 0.75, 1.0);
        check(9.0, 1.0, 1.0);
    }

    #[test]
    fn mesh_samples_are_a_rook_each() {
        for axis in 0..2 {
            let mut positions = SAMPLES.map(|sample| sample[axis]);
            positions.sort_by(f64::total_cmp);
            assert_eq!(positions, std::array::from_fn(|i| (2 * i + 1) as f64 / 16.0));
        }
    }

    #[test]
    fn mesh_mean_of_samples_by_hand() {
        let hit = |depth: f64| Some(Hit { depth, color: [1.0, 0.5, 0.0] });
        let before = |depth: Option<f64>| {
            let opacity = if depth == Some(1.0) { 0.0 } else { 0.5 };
            Premultiplied { color: [0.0, 0.0, opacity], opacity }
        };
        let mean = mean_of_samples(&[hit(1.0), hit(3.0), None, None], [0.0; 4], before);
        assert_eq!(mean, [0.375, 0.1875, 0.375, 0.75]);
    }
}
