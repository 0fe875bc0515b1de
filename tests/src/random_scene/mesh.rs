//! Meshes at random: soups of triangles, closed surfaces with smooth normals or flat faces, triangles far
//! larger than the scene, lines and points, at any position, light, colour and region.

use super::{between, random_direction, random_shading, region};
use fastrand::Rng;
use slabsplat_core::glam::{DAffine3, DMat3, DQuat, DVec3};
use slabsplat_core::{Mesh, MeshLayer, MeshParts, ViewAxes};
use std::collections::HashSet;

/// One to three meshes within or around a sphere.
pub(super) fn random_meshes(
    rng: &mut Rng,
    axes: &ViewAxes,
    center: DVec3,
    radius: f64,
) -> Vec<MeshLayer> {
    let mesh = |rng: &mut Rng| {
        let mut parts = match rng.u32(..6) {
            0 => soup(rng),
            1 | 2 => ball(rng),
            3 => huge_triangle(rng),
            4 => polyline(rng),
            _ => edges_of(ball(rng)),
        };
        if rng.u32(..3) == 0 {
            let color = |_: &DVec3| [0; 3].map(|_| rng.f32());
            parts.colors = parts.positions.iter().map(color).collect();
        }
        let turn =
            DMat3::from_quat(DQuat::from_axis_angle(random_direction(rng), between(rng, 0.0, 3.0)));
        let mut sizes = DVec3::from_array([0; 3].map(|_| radius * between(rng, 0.3, 1.0)));
        sizes[rng.usize(..3)] *= [1.0, -1.0][rng.usize(..2)];
        let world_from_mesh = DAffine3::from_mat3_translation(
            turn * DMat3::from_diagonal(sizes),
            center + 0.7 * radius * rng.f64() * random_direction(rng),
        );
        let mesh = Mesh::new(parts).expect("there are as many colours as vertices");
        let layer = MeshLayer::new(mesh).shading(random_shading(rng)).placed(world_from_mesh);
        let mut layer = layer.expect("no side is flat");
        if rng.u32(..3) != 0 {
            layer = layer.line_width(radius * between(rng, 0.02, 0.3));
        }
        if rng.bool() {
            layer = layer.point_size(radius * between(rng, 0.02, 0.6));
        }
        if rng.bool() {
            layer = layer.color([0; 3].map(|_| rng.f64()));
        }
        if rng.u32(..3) == 0 {
            layer = layer.region(region::random_region(rng, axes, center, radius));
        }
        layer
    };
    (0..rng.usize(1..=3)).map(|_| mesh(rng)).collect()
}

fn soup(rng: &mut Rng) -> MeshParts {
    let n_vertices = rng.u32(3..20);
    let positions = (0..n_vertices).map(|_| 1.2 * rng.f64() * random_direction(rng)).collect();
    let triangles = (0..rng.usize(1..30)).map(|_| [0; 3].map(|_| rng.u32(..n_vertices))).collect();
    MeshParts::new(positions).triangles(triangles)
}

/// A ball of rings, of which some triangles may be missing.
fn ball(rng: &mut Rng) -> MeshParts {
    let [n_rings, n_around] = [rng.u32(2..8), rng.u32(3..12)];
    let vertex = |ring: u32, at: u32| {
        let [down, around] = [
            std::f64::consts::PI * f64::from(ring) / f64::from(n_rings),
            std::f64::consts::TAU * f64::from(at) / f64::from(n_around),
        ];
        DVec3::new(down.sin() * around.cos(), down.sin() * around.sin(), down.cos())
    };
    let rings = (0..=n_rings).flat_map(|ring| (0..n_around).map(move |at| vertex(ring, at)));
    let positions: Vec<DVec3> = rings.collect();
    let mut triangles = Vec::new();
    for (ring, at) in (0..n_rings).flat_map(|ring| (0..n_around).map(move |at| (ring, at))) {
        let [a, b] = [at, (at + 1) % n_around].map(|at| ring * n_around + at);
        triangles.extend([[a, a + n_around, b], [b, a + n_around, b + n_around]]);
    }
    let n_missing = if rng.bool() { rng.usize(..4) } else { 0 };
    for _ in 0..n_missing {
        triangles.swap_remove(rng.usize(..triangles.len()));
    }
    let is_smooth = rng.bool();
    let normals = positions.iter().map(|position| (2.0 * *position).as_vec3().to_array());
    let normals = if is_smooth { normals.collect() } else { Vec::new() };
    MeshParts::new(positions).triangles(triangles).normals(normals)
}

/// Lines one behind the other, some of no length or far beyond the scene, and some of their ends as points.
fn polyline(rng: &mut Rng) -> MeshParts {
    let n_vertices = rng.u32(1..9);
    let mut positions: Vec<DVec3> =
        (0..n_vertices).map(|_| 1.3 * rng.f64() * random_direction(rng)).collect();
    if rng.u32(..4) == 0 {
        positions[rng.usize(..n_vertices as usize)] *= 10_f64.powf(between(rng, 1.0, 3.0));
    }
    let mut lines: Vec<[u32; 2]> = (1..n_vertices).map(|end| [end - 1, end]).collect();
    if rng.bool() {
        lines.push([0, 0]);
    }
    let points = (0..n_vertices).filter(|_| rng.u32(..3) == 0).collect();
    MeshParts::new(positions).lines(lines).points(points)
}

/// Some of a surface's edges, and its faces. Vertices at a pole are at one position, and no two edges lie in
/// each other, so that it is colours, and not rounding, that decides between them.
fn edges_of(surface: MeshParts) -> MeshParts {
    let rounded = |at: DVec3| (at * f64::from(1 << 20)).round() / f64::from(1 << 20);
    let positions: Vec<DVec3> = surface.positions.iter().map(|at| rounded(*at)).collect();
    let sides = surface.triangles.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *c]]);
    let mut taken = HashSet::new();
    let is_new = |line: &[u32; 2]| {
        // 0 and −0 are one position.
        let mut ends = line.map(|end| (positions[end as usize] + 0.0).to_array().map(f64::to_bits));
        ends.sort_unstable();
        taken.insert(ends)
    };
    let lines = sides.step_by(3).filter(is_new).collect();
    MeshParts::new(positions).triangles(surface.triangles).lines(lines)
}

fn huge_triangle(rng: &mut Rng) -> MeshParts {
    let size = 10_f64.powf(between(rng, 1.0, 4.0));
    let [x, y] = [random_direction(rng), random_direction(rng)].map(|side| size * side);
    let positions = vec![x, y, -x - y];
    MeshParts::new(positions).triangles(vec![[0, 1, 2]])
}
