//! The selection of voxels against the definition, which splats them all.

use super::*;
use fastrand::Rng;
use slabsplat_backend::{Planner, Splats};
use slabsplat_core::glam::{DAffine3, DMat3, DVec3};
use slabsplat_core::{
    Camera, Grid, ImageDesc, Isosurface, Layer, Method, Mode, Projection, RenderSettings, Scaling,
    Scene, TransferFunction,
};
use slabsplat_seeds::for_each_seed;

#[test]
fn selection_changes_nothing() {
    for_each_seed(4, |mut rng| {
        let (mut n_left_out, mut n_seen, mut worst) = (0, 0, 0.0_f32);
        // Until enough of them show anything, however the dice fall.
        for nth in 0..200 {
            if 60 <= nth && 30 < n_seen {
                break;
            }
            let volume = blobs(&mut rng);
            let scene = scene(&mut rng, volume);
            let plan = Planner::default().plan(&scene).unwrap();
            let layer = &plan.layers[0];
            let Splats::Densities(splats) = &layer.splats else { panic!("{:?}", layer.splats) };
            let frame = &FrameHandle::new();
            let size = layer.view.image_size();
            let mut tiles = Tiles::new(size, border(splats.shown), frame).unwrap();
            let (mut buffers, mut watch) = (Buffers::default(), Stopwatch::start(frame));
            let level = Level::new();
            let shown = splats.shown;
            let drawn = render(&plan, shown, level, &mut tiles, &mut buffers, &mut watch);
            let [n_selected, _] = drawn.unwrap();
            let selected = tiles.image([0.0; 4], frame);
            // Of a range that all values lie in, nothing is left out.
            let volume = layer.volume;
            let finite = finite_range(volume, frame).unwrap();
            let everything = IsoRange { lo: f64::NEG_INFINITY, hi: f64::INFINITY };
            let shown_all = (&[everything][..], 0.0);
            let all = Selection::new(volume, finite, shown_all, &Reach::none(), frame).unwrap();
            assert_eq!(all.n_voxels, volume.grid().n_voxels());
            tiles.clear(frame);
            let Buffers { of_layers, to_draw } = &mut buffers;
            let mut to_draw_all = of_layers[0].prepare(layer, frame).unwrap().unwrap();
            to_draw_all.voxels = Selected::new(&all, volume, to_draw_all.scale);
            draw(&plan, shown, level, &[to_draw_all], &mut tiles, to_draw, &mut watch).unwrap();
            let difference = tiles.image([0.0; 4], frame).max_difference(&selected);
            worst = worst.max(difference);
            let most = match (scene.settings.mode, scene.settings.tolerance) {
                // Where a ray meets a surface, and what it faces there, is as exact as that is steep.
                (Mode::Isosurfaces, 0.0) => 5e-5,
                // Sums are rounded: the mean of values at the end of a visible range may lie within it.
                (_, 0.0) => 2e-6,
                // By default the outer sheets of a slope are not counted on, which shows most on plateaus.
                (Mode::Isosurfaces, _) => 5e-4,
                (_, _) => 5e-6,
            };
            assert!(difference <= most, "{difference}: {scene:?}");
            n_left_out += all.n_voxels as u64 - n_selected;
            n_seen += u32::from(selected.pixels().iter().any(|pixel| 0.0 < pixel[3]));
        }
        println!("{n_left_out} voxels left out, {n_seen} pictures not empty, {worst}");
        assert!(10_000 < n_left_out && 30 < n_seen, "{n_left_out} {n_seen}");
    });
}

/// Plateaus of the values 0 to 5 in balls, with air of value 1 around them.
fn blobs(rng: &mut Rng) -> Volume {
    let dims = [0; 3].map(|_| rng.usize(12..26));
    let balls: Vec<_> = (0..2)
        .map(|_| (dims.map(|n| n as f64 * rng.f64()), 1.0 + 4.0 * rng.f64(), rng.u8(0..6)))
        .collect();
    let shear = |rng: &mut Rng| 0.5 * rng.f64() - 0.25;
    let columns = DMat3::from_cols(
        DVec3::new(1.0, shear(rng), 0.0),
        DVec3::new(shear(rng), 1.0 + rng.f64(), 0.0),
        DVec3::new(0.0, shear(rng), 1.0),
    );
    let grid = Grid::new(dims, DAffine3::from_mat3(columns)).unwrap();
    let value = |idx: usize| {
        let at = DVec3::from_array(grid.voxel_coords(idx).map(|c| c as f64));
        let inside = |(center, radius, _): &&([f64; 3], f64, u8)| {
            at.distance(DVec3::from_array(*center)) < *radius
        };
        balls.iter().find(inside).map_or(1, |ball| ball.2)
    };
    let samples: Vec<u8> = (0..grid.n_voxels()).map(value).collect();
    Volume::new(grid, samples.into(), Scaling { slope: 0.3, intercept: -0.1 }).unwrap()
}

/// Something visible between two values, from a step or from 0, often just at the value of a plateau.
fn scene(rng: &mut Rng, volume: Volume) -> Scene {
    let grid = volume.grid();
    let modes = [Mode::Extinction, Mode::Isosurfaces, Mode::Maximum, Mode::Minimum];
    let mode = modes[rng.usize(..modes.len())];
    // A plateau that lies just on a step is speckled where one density stands for all.
    let off = if mode.statistic().is_some() { 0.05 } else { 0.0 };
    let step = |plateau: u8| 0.3 * f64::from(plateau) - 0.1 + off;
    let [lo, hi] = [step(rng.u8(1..4)), step(rng.u8(4..6))];
    let rise = if rng.bool() { 0.0 } else { 0.5 };
    let opacity = vec![(lo, [0.0]), (lo, [rise]), (hi, [0.7]), (hi, [0.0])];
    let eye = grid.center_in_world() + 60.0 * DVec3::new(rng.f64(), rng.f64(), 0.3 + rng.f64());
    let target = grid.center_in_world();
    let projection = if rng.bool() {
        Projection::Orthographic { view_height: [9.0, 25.0, 90.0][rng.usize(..3)] }
    } else {
        Projection::Perspective { fov_y_radians: [0.3, 0.6, 1.6][rng.usize(..3)] }
    };
    let color = vec![(lo, [1.0; 3]), (hi, [0.2; 3])];
    let transfer = TransferFunction::new(opacity, color).unwrap();
    let settings = RenderSettings::default()
        .method(Method::PostClassified)
        .tolerance([0.0, 0.05][rng.usize(..2)])
        .slab_width([0.4, 1.0, 2.0][rng.usize(..3)]);
    let camera = Camera::new(eye, target, DVec3::Y, projection).unwrap();
    // Often just at the value of a plateau, too.
    let value = if rng.bool() { lo } else { 0.5 * (lo + hi) };
    let surface = Isosurface::new(value, 0.5, None).unwrap();
    let settings = settings.mode(mode);
    Scene::new(Layer::new(volume, transfer).isosurfaces(vec![surface]), camera)
        .image(ImageDesc::new(70, 50))
        .settings(settings)
}
