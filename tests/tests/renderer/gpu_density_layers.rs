//! Several layers of densities on a GPU: as many as there is room for, in tiles that pause and in pictures of
//! several pieces. That random scenes are right is judged in `density_layers.rs`.

use slabsplat::glam::{DAffine3, DVec3};
use slabsplat::{
    Camera, Grid, Image, Isosurface, Layer, Mesh, MeshLayer, MeshParts, Method, Mode, Projection,
    Scaling, Scene, TransferFunction, Volume,
};
use slabsplat_gpu::DeviceInfo;
use slabsplat_tests::on_devices::{alone, as_it_is, in_rounds, on_devices, render, scene, volume};
use slabsplat_tests::render::open;
use slabsplat_tests::spy_device::locked;
use std::sync::{Arc, Mutex};

/// What two backends may differ by.
const PARITY: f32 = 1e-3;

/// Of each way in which densities of several layers are shown one or more.
const MODES: [Mode; 5] =
    [Mode::Extinction, Mode::Separate, Mode::Maximum, Mode::Average, Mode::Isosurfaces];

/// The same waves so often, each turned otherwise, moved and coloured in one of four ways, and as faint as
/// that.
fn layered(n_layers: usize, side: usize, opacity: f64, width: u32, mode: Mode) -> Scene {
    let volume = volume([side; 3]);
    let mut scene = scene(&volume, width, Method::PostClassified);
    scene.settings.mode = mode;
    // Drivers that only play a device take the longer the more splats a tile has.
    scene.settings.slab_width = 1.6;
    scene.layers = (0..n_layers).map(|idx| layer(&volume, idx, opacity)).collect();
    scene
}

fn layer(volume: &Volume, idx: usize, opacity: f64) -> Layer {
    let share = (idx % 4) as f64;
    let center = volume.grid().center_in_world();
    let turn = DAffine3::from_rotation_y(0.7 * idx as f64);
    let aside = center + DVec3::new(0.6, -0.4, 0.5) * share;
    let moved = DAffine3::from_translation(aside) * turn * DAffine3::from_translation(-center);
    let grid = Grid::new(volume.grid().dims(), moved * volume.grid().world_from_index());
    let volume = Volume::new(grid.expect("a turn"), volume.samples().clone(), Scaling::IDENTITY);
    let color = [0.9 - 0.2 * share, 0.2 + 0.2 * share, 0.5 + 0.1 * share];
    let colors = vec![(0.0, color), (1.0, [1.0; 3])];
    let opacities = vec![(0.1, [0.0]), (0.5 + 0.1 * share, [opacity])];
    let transfer = TransferFunction::new(opacities, colors).expect("the points are sorted");
    let surfaces = [0.3, 0.5].map(|value| Isosurface::new(value + 0.03 * share, 0.5, None));
    Layer::new(Arc::new(volume.expect("as many samples")), transfer)
        .isosurfaces(surfaces.into_iter().collect::<Result<_, _>>().expect("shares of one"))
}

fn by_cpu(scene: &Scene) -> Image {
    render(&mut *open("cpu"), scene).expect("the CPU has no limits").image
}

/// And one that is alone again, on the same devices.
#[test]
fn as_many_density_layers_as_there_can_be() {
    let _alone = alone();
    // Drivers that only play a device take the longer the more layers there are: the most in one mode only.
    let [first, ..] = MODES;
    let few = MODES
        .into_iter()
        .flat_map(|mode| [layered(6, 5, 0.3, 12, mode), layered(1, 9, 0.4, 20, mode)]);
    let scenes: Vec<(Scene, Image)> = std::iter::once(layered(16, 4, 0.2, 8, first))
        .chain(few)
        .map(|scene| (scene.clone(), by_cpu(&scene)))
        .collect();
    on_devices(as_it_is, |name, backend, _| {
        for (scene, expected) in &scenes {
            let image = render(backend, scene).expect("a small frame fits").image;
            let what = format!("{name}, {}, {} layers", scene.settings.mode, scene.layers.len());
            let difference = image.max_difference(expected);
            assert!(difference < PARITY, "{what}: {difference}");
            if 1 < scene.layers.len() {
                let mut reversed = scene.clone();
                reversed.layers.reverse();
                let image_of_reversed = render(backend, &reversed).expect("as before").image;
                assert!(image_of_reversed == image, "{what}: their order matters");
            }
        }
    });
}

#[test]
fn too_many_density_layers_are_an_error() {
    let _alone = alone();
    let scene = layered(17, 3, 0.4, 8, Mode::Extinction);
    on_devices(as_it_is, |name, backend, orders| {
        let error = render(backend, &scene).expect_err("they are too many").to_string();
        assert!(error.contains("densities of 16 layers at a time, not of 17"), "{name}: {error}");
        assert_eq!(locked(orders).n_submitted, 0, "{name}");
    });
}

/// In a single tile, which pauses, and so faint that what comes then is seen.
#[test]
fn density_layers_in_tiles_that_pause() {
    let _alone = alone();
    for mode in MODES {
        let opacity = if mode.compositing().is_some() { 0.02 } else { 0.6 };
        let mut scene = layered(2, 9, opacity, 8, mode);
        scene.image.background = [1.0, 0.5, 0.0, 1.0];
        let expected = by_cpu(&scene);
        on_devices(in_rounds, |name, backend, orders| {
            let image = render(backend, &scene).expect("it fits").image;
            let difference = image.max_difference(&expected);
            assert!(difference < PARITY, "{name}, {mode}: {difference}");
            assert!(1 < locked(orders).n_submitted, "{name}, {mode}: one round was enough");
        });
    }
}

/// The bits are those of a picture in one piece. By one density of each of three layers a band is a third as
/// high, as its pixels hold as much more.
#[test]
fn density_layers_on_pictures_in_bands() {
    let _alone = alone();
    let scene = layered(3, 6, 0.3, 64, Mode::Minimum);
    let expected = by_cpu(&scene);
    let pictures = Mutex::new(Vec::new());
    for limit in [u64::MAX, 1 << 16] {
        let change = |info: &mut DeviceInfo| {
            info.max_binding_bytes = info.max_binding_bytes.min(limit);
        };
        on_devices(change, |name, backend, _| {
            let image = render(backend, &scene).expect("it fits").image;
            let difference = image.max_difference(&expected);
            assert!(difference < PARITY, "{name}: {difference}");
            pictures.lock().expect("no test failed").push(image);
        });
    }
    let pictures = pictures.into_inner().expect("no test failed");
    let (whole, in_bands) = pictures.split_at(pictures.len() / 2);
    assert!(whole == in_bands);
}

/// Before all densities, among those of one layer or several, and behind them, and in tiles that pause.
#[test]
fn rays_end_among_densities() {
    let _alone = alone();
    for (n_layers, mode) in [(1, Mode::Extinction), (3, Mode::Extinction), (2, Mode::Separate)] {
        for (opacity, side, width) in [(0.3, 8, 24), (0.02, 10, 8)] {
            let mut scene = layered(n_layers, side, opacity, width, mode);
            let center = scene.layers[0].volume.grid().center_in_world();
            scene.meshes = [-2.0, 0.1, 2.0].map(|by| wall(&scene.camera, center, by)).to_vec();
            let expected = by_cpu(&scene);
            on_devices(in_rounds, |name, backend, orders| {
                let image = render(backend, &scene).expect("it fits").image;
                let difference = image.max_difference(&expected);
                assert!(difference < PARITY, "{name}, {mode}, {n_layers}: {difference}");
                let is_faint = opacity < 0.1;
                assert!(!is_faint || 1 < locked(orders).n_submitted, "{name}: one round");
            });
        }
    }
}

/// A triangle across a third of the view, so many sizes of the volume behind its centre, and oblique.
fn wall(camera: &Camera, center: DVec3, by: f64) -> MeshLayer {
    let axes = camera.axes();
    let Projection::Orthographic { view_height } = camera.projection() else {
        unreachable!("the camera is one of our own")
    };
    let middle = center + axes.forward * (by * view_height) + axes.right * (0.3 * by * view_height);
    let corner = |right: f64, up: f64, forward: f64| {
        middle + view_height * (right * axes.right + up * axes.up + forward * axes.forward)
    };
    let corners = vec![corner(-0.3, -0.4, -0.1), corner(0.3, -0.3, 0.1), corner(0.0, 0.5, 0.05)];
    let parts = MeshParts::new(corners).triangles(vec![[0, 1, 2]]);
    MeshLayer::new(Mesh::new(parts).expect("its corners are there"))
}
