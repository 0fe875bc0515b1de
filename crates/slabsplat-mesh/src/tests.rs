//! Whole frames: no cracks, no order, and what no picture holds.

use super::*;
use crate::tube::Shape;
use slabsplat_backend::{MeshPlan, MeshesPlan};
use slabsplat_core::glam::{DMat3, DQuat, DVec3};
use slabsplat_core::{
    Camera, FrameHandle, Grid, ImageDesc, Mesh, MeshLayer, MeshParts, Projection, View,
};
use slabsplat_seeds::for_each_seed;
use slabsplat_traverse::TileGrid;

const SIDE: u32 = 40;

/// Looks along −z at the origin, from 10; the picture is 4 high at the origin.
fn view(is_perspective: bool) -> View {
    let projection = if is_perspective {
        Projection::Perspective { fov_y_radians: 2.0 * 0.2_f64.atan() }
    } else {
        Projection::Orthographic { view_height: 4.0 }
    };
    let camera = Camera::new(10.0 * DVec3::Z, DVec3::ZERO, DVec3::Y, projection).unwrap();
    let image = ImageDesc::new(SIDE, SIDE);
    let grid = Grid::with_spacing([1; 3], [0.5; 3]).unwrap();
    View::new(&grid, &camera, &image).unwrap()
}

fn layer(positions: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> MeshLayer {
    let parts = MeshParts::new(positions).triangles(triangles);
    MeshLayer::new(Mesh::new(parts).unwrap())
}

/// How many samples of each pixel are hit, and all hits.
fn hits(layers: &[MeshLayer], is_perspective: bool) -> (Vec<usize>, Vec<Hit>) {
    let meshes = layers.iter().map(MeshPlan::new).collect();
    let plan = MeshesPlan::new(view(is_perspective), meshes);
    let tiles = TileGrid::new([SIDE; 2], 16, 1);
    let mut of_tiles = vec![Vec::new(); tiles.n_tiles()];
    let take_all = |of_tile: &mut Vec<_>, on_tile: HitsOnTile<'_>| {
        on_tile.for_each_pixel(|pixel, hits| of_tile.push((pixel, hits.to_vec())));
    };
    let frame = (&plan, &FrameHandle::new());
    Rasterizer::default().for_each_tile(frame, &tiles, &mut of_tiles, take_all).unwrap();
    let (mut counts, mut all) = (vec![0; (SIDE * SIDE) as usize], Vec::new());
    for (tile_idx, of_tile) in of_tiles.into_iter().enumerate() {
        let [left, top] = tiles.origin(tile_idx);
        for ([column, row], hits) in of_tile {
            counts[(top + row) * SIDE as usize + left + column] += hits.len();
            all.extend(hits);
        }
    }
    (counts, all)
}

/// A fan of triangles about a point, out to a rim that is far beyond the picture.
fn fan(rng: &mut fastrand::Rng, n: u32, spread: f64) -> MeshLayer {
    let center = DVec3::new(rng.f64() - 0.5, rng.f64() - 0.5, rng.f64() - 0.5);
    let start = rng.f64();
    let rim = (0..n).map(|idx| {
        let angle = std::f64::consts::TAU * (start + f64::from(idx) / f64::from(n));
        let depth = spread * (rng.f64() - 0.5);
        DVec3::new(50.0 * angle.cos(), 50.0 * angle.sin(), depth)
    });
    let positions = std::iter::once(center).chain(rim).collect();
    layer(positions, (0..n).map(|idx| [0, 1 + idx, 1 + (idx + 1) % n]).collect())
}

/// Every sample of the picture is hit, whatever edges run through it and wherever they meet: also through
/// samples themselves.
#[test]
fn shared_edges_leave_no_crack() {
    for_each_seed(1, |mut rng| {
        for n in [3, 4, 7, 64, 1000, 20_000] {
            for is_perspective in [false, true] {
                let fan = fan(&mut rng, n, 6.0);
                let (counts, _) = hits(&[fan], is_perspective);
                assert!(counts.iter().all(|n| *n == N_SAMPLES), "{n} {is_perspective}");
            }
        }
        // The middle just on a sample, and edges through others.
        let [x, y] = samples::SAMPLES[3].map(|at| at / 10.0);
        let around = [[-9.0, y], [x, -9.0], [9.0, y], [9.0, 9.0], [x, 9.0]];
        let rim = around.map(|[x, y]| DVec3::new(x, -y, 0.0));
        let positions = std::iter::once(DVec3::new(x, -y, 0.0)).chain(rim).collect();
        let triangles = (0..5).map(|idx| [0, 1 + idx, 1 + (idx + 1) % 5]).collect();
        let (counts, _) = hits(&[layer(positions, triangles)], false);
        assert!(counts.iter().all(|n| *n == N_SAMPLES), "{counts:?}");
    });
}

/// A ball's near side and its far side cover the same samples, once each.
#[test]
fn closed_surface_has_no_holes() {
    for_each_seed(1, |mut rng| {
        let (n_rings, n_around) = (40_u32, 57_u32);
        let turn = DMat3::from_quat(DQuat::from_rotation_x(6.0 * rng.f64()));
        let vertex = |ring: u32, at: u32| {
            let down = std::f64::consts::PI * f64::from(ring) / f64::from(n_rings);
            let around = std::f64::consts::TAU * f64::from(at) / f64::from(n_around);
            let [sin, cos] = [down.sin(), down.cos()];
            turn * DVec3::new(sin * around.cos(), sin * around.sin(), cos) * 1.5
        };
        let rings = (0..=n_rings).flat_map(|ring| (0..n_around).map(move |at| vertex(ring, at)));
        let positions: Vec<DVec3> = rings.collect();
        let (mut front, mut back) = (Vec::new(), Vec::new());
        for (ring, at) in (0..n_rings).flat_map(|ring| (0..n_around).map(move |at| (ring, at))) {
            let [a, b] = [at, (at + 1) % n_around].map(|at| ring * n_around + at);
            for triangle in [[a, a + n_around, b], [b, a + n_around, b + n_around]] {
                let [p, q, r] = triangle.map(|vertex| positions[vertex as usize]);
                let faces_us = 0.0 < (q - p).cross(r - p).z;
                if faces_us { &mut front } else { &mut back }.push(triangle);
            }
        }
        let [front, back] =
            [front, back].map(|side| hits(&[layer(positions.clone(), side)], false));
        assert_eq!(front.0, back.0);
        let n_hits: usize = front.0.iter().sum();
        let expected = std::f64::consts::PI * 15.0 * 15.0 * N_SAMPLES as f64;
        assert!((n_hits as f64 / expected - 1.0).abs() < 0.01, "{n_hits} {expected}");
    });
}

/// The nearest is hit, in whatever order; at one depth the darker.
#[test]
fn order_decides_nothing() {
    let wall = |z: f64, gray: f64| {
        let corners = [[-9.0, -9.0], [9.0, -9.0], [0.0, 30.0]];
        let positions = corners.map(|[x, y]| DVec3::new(x, y, z)).to_vec();
        layer(positions, vec![[0, 1, 2]]).color([gray; 3])
    };
    for (walls, expected) in [
        ([wall(0.0, 0.25), wall(1.0, 0.75)], 0.75),
        ([wall(0.5, 0.25), wall(0.5, 0.75)], 0.25),
        ([wall(9.0, 0.25), wall(9.8, 0.75)], 0.25),
    ] {
        let [a, b] = walls;
        let one = hits(&[a.clone(), b.clone()], true).1;
        assert_eq!(one, hits(&[b, a], true).1);
        assert!(!one.is_empty() && one.iter().all(|hit| hit.color == [expected; 3]), "{expected}");
    }
}

/// Tiles, rows and rectangles lose no hit of a line or a point: every sample asks every one, and finds as
/// much, also of those that pass by the eye or go far beyond the picture.
#[test]
fn tubes_are_found_wherever_they_are() {
    for_each_seed(12, |mut rng| {
        let is_perspective = rng.bool();
        let view = view(is_perspective);
        let extent = [1.0, 3.0, 30.0][rng.usize(..3)];
        let point = |rng: &mut fastrand::Rng| {
            DVec3::from_array([0; 3].map(|_| extent * (2.0 * rng.f64() - 1.0)))
        };
        let positions: Vec<DVec3> = (0..8).map(|_| point(&mut rng)).collect();
        let (lines, points) = (vec![[0, 1], [1, 2], [3, 4], [5, 5]], vec![6, 7]);
        let parts = MeshParts::new(positions).lines(lines).points(points);
        let layer = MeshLayer::new(Mesh::new(parts).unwrap());
        let layer = layer.line_width(0.02 + 2.0 * rng.f64()).point_size(0.02 + 2.0 * rng.f64());
        let mesh = &layer.mesh;
        let lines = mesh.lines().iter().map(|ends| (*ends, layer.line_radius()));
        let points = mesh.points().iter().map(|point| ([*point; 2], layer.point_radius()));
        let to_view = view.axes();
        let in_view = |vertex: u32| {
            let from_origin = mesh.positions()[vertex as usize] - view.origin_in_world();
            let axes = [to_view.right, to_view.up, to_view.forward];
            DVec3::from_array(axes.map(|axis| axis.dot(from_origin)))
        };
        let shapes: Vec<Shape> = lines
            .chain(points)
            .map(|(ends, radius)| Shape { ends: ends.map(in_view), radius })
            .collect();
        let is_hit = |at: [f64; 2]| {
            let ray = view.ray(at);
            let mut depths = shapes.iter().filter_map(|shape| shape.met_by(&ray)).flatten();
            depths.any(|depth| view.near_depth() <= depth)
        };
        let (counts, _) = hits(std::slice::from_ref(&layer), is_perspective);
        for (idx, n_hits) in counts.into_iter().enumerate() {
            let corner = [idx as u32 % SIDE, idx as u32 / SIDE].map(f64::from);
            let at = |sample: &&[f64; 2]| is_hit([corner[0] + sample[0], corner[1] + sample[1]]);
            assert_eq!(n_hits, samples::SAMPLES.iter().filter(at).count(), "{idx}: {layer:?}");
        }
    });
}

/// A triangle that is there for both sides, in other colours, is one: rounding does not mix them.
#[test]
fn both_sides_are_equally_deep() {
    for_each_seed(1, |mut rng| {
        for is_perspective in [false, true] {
            let corners = [0; 3].map(|_| DVec3::from_array([0; 3].map(|_| 4.0 * rng.f64() - 2.0)));
            let side =
                |triangle, gray: f64| layer(corners.to_vec(), vec![triangle]).color([gray; 3]);
            for other in [[1, 0, 2], [2, 1, 0], [1, 2, 0]] {
                let all = hits(&[side([0, 1, 2], 0.75), side(other, 0.25)], is_perspective).1;
                assert!(all.iter().all(|hit| hit.color == [0.25; 3]), "{other:?}");
            }
        }
    });
}

/// A floor that begins behind the eye ends at the horizon.
#[test]
fn triangles_are_cut_off_at_the_near_depth() {
    let corners = [[-1e6, 1e3], [1e6, 1e3], [0.0, -1e6]];
    let floor = corners.map(|[x, z]| DVec3::new(x, -1.0, z)).to_vec();
    let (counts, all) = hits(&[layer(floor, vec![[0, 1, 2]])], true);
    for (idx, n) in counts.into_iter().enumerate() {
        let row = idx / SIDE as usize;
        let is_floor = SIDE as usize / 2 <= row;
        assert_eq!(n, if is_floor { N_SAMPLES } else { 0 }, "{idx}");
    }
    // The eye is 10 from the origin; nothing is nearer than half a unit.
    assert!(all.iter().all(|hit| -9.5 <= hit.depth && hit.depth.is_finite()));
}

#[test]
fn nothing_is_hit_of_what_numbers_do_not_hold() {
    for size in [1e-200, 1e160, 1e300] {
        let corners = [DVec3::ZERO, size * DVec3::X, size * DVec3::Y].to_vec();
        let (_, all) = hits(&[layer(corners, vec![[0, 1, 2]])], true);
        assert!(all.iter().all(|hit| hit.depth.is_finite()), "{size}");
    }
    assert!(hits(&[MeshLayer::new(Mesh::default())], true).1.is_empty());
}
