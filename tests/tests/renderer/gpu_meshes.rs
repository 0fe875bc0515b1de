//! Opaque meshes on a GPU: what of their surfaces goes to the device, and when, and what limits do to them.
//! That the pictures are right is judged in `meshes.rs`.

use slabsplat::glam::DVec3;
use slabsplat::{
    BackendError, Camera, Grid, Image, ImageDesc, Layer, Mesh, MeshLayer, MeshParts, Mode, Planner,
    Projection, Scaling, Scene, TransferFunction, Volume,
};
use slabsplat_gpu::DeviceInfo;
use slabsplat_tests::exact_settings;
use slabsplat_tests::on_devices::{
    alone, as_it_is, in_rounds, on_devices, render, submit_plan, take,
};
use slabsplat_tests::render::open;
use slabsplat_tests::spy_device::locked;
use std::sync::Mutex;

/// What two backends may differ by.
const PARITY: f32 = 1e-3;

/// A cube of so many voxels a side, each of that opacity, and in it a double pyramid that is `size` as large.
fn scene(side: usize, opacity: f64, size: f64, width: u32) -> Scene {
    let grid = Grid::with_spacing([side; 3], [1.0; 3]).expect("the spacing is positive");
    let samples: Vec<u8> = (0..grid.n_voxels()).map(|idx| (idx % 200) as u8).collect();
    let center = grid.center_in_world();
    let volume = Volume::new(grid, samples.into(), Scaling::IDENTITY).expect("one sample a voxel");
    let transfer = transfer(opacity);
    let projection = Projection::Orthographic { view_height: 1.6 * side as f64 };
    let eye = center + DVec3::new(3.0, 2.0, -2.5) * side as f64;
    let camera = Camera::new(eye, center, DVec3::Y, projection).expect("up is not forward");
    Scene::new(Layer::new(volume, transfer), camera)
        .meshes(vec![MeshLayer::new(double_pyramid(center, 0.5 * size * side as f64))])
        .image(ImageDesc::new(width, width * 3 / 4).background([0.1, 0.2, 0.3, 0.4]))
        .settings(exact_settings().mode(Mode::Extinction))
}

fn transfer(opacity: f64) -> TransferFunction {
    let colors = vec![(0.0, [1.0, 0.3, 0.1]), (200.0, [0.2, 0.9, 1.0])];
    TransferFunction::new(vec![(0.0, [opacity])], colors).expect("the points are sorted")
}

fn double_pyramid(center: DVec3, radius: f64) -> Mesh {
    let tips = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| radius * axis);
    let colors = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.2, 0.2, 1.0]];
    let positions = tips.into_iter().flat_map(|tip| [center + tip, center - tip]).collect();
    let corners = |face: u32| [face & 1, 2 + ((face >> 1) & 1), 4 + (face >> 2)];
    let parts = MeshParts::new(positions)
        .triangles((0..8).map(corners).collect())
        .colors(colors.into_iter().flat_map(|color| [color; 2]).collect());
    Mesh::new(parts).expect("each vertex has a colour")
}

fn by_cpu(scene: &Scene) -> Image {
    render(&mut *open("cpu"), scene).expect("the CPU has no limits").image
}

/// Surfaces are sent when they change, and nothing else is then.
#[test]
fn surfaces_move_when_they_change() {
    let _alone = alone();
    on_devices(as_it_is, |name, backend, orders| {
        let mut scene = scene(12, 0.1, 1.0, 64);
        let mut planner = Planner::default();
        let mut n_written = |scene: &Scene| {
            locked(orders).bytes_written = 0;
            let plan = planner.plan(scene).expect("the scene is valid");
            let frame = submit_plan(backend, &plan).expect("a small frame fits");
            let image = take(backend, &frame).expect("the device is there").image;
            let difference = image.max_difference(&by_cpu(scene));
            assert!(difference < PARITY, "{name}: {difference}");
            locked(orders).bytes_written
        };
        let first = n_written(&scene);
        let again = n_written(&scene);
        scene.meshes[0].color = Some([0.5; 3]);
        let recolored = n_written(&scene);
        scene.layers[0].transfer = transfer(0.2);
        let reclassified = n_written(&scene);
        let meshes = std::mem::take(&mut scene.meshes);
        let without = n_written(&scene);
        scene.meshes = meshes;
        let back = n_written(&scene);
        let what = format!(
            "{name}: first {first}, again {again}, recolored {recolored}, reclassified {reclassified}, \
             without {without}, back {back} bytes"
        );
        println!("{what}");
        assert!(again <= 512 && reclassified <= 1024 && without <= 1024, "{what}");
        // More than one surface in each of a tenth of all pixels, and at most one for each sample.
        let n_pixels = 64 * 48;
        assert!((n_pixels / 10 * 16..n_pixels * 8 * 16).contains(&recolored), "{what}");
        assert!(recolored <= back, "{what}");
    });
}

/// The bits are those of a picture in one piece.
#[test]
fn surfaces_on_pictures_in_bands() {
    let _alone = alone();
    let scene = scene(7, 0.3, 0.3, 400);
    let expected = by_cpu(&scene);
    let pictures = Mutex::new(Vec::new());
    for limit in [u64::MAX, 3 << 18] {
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

/// Of which a large picture may have more than can be bound.
#[test]
fn too_many_surfaces_are_an_error() {
    let _alone = alone();
    let scene = scene(5, 0.3, 1.5, 400);
    let few = |info: &mut DeviceInfo| info.max_binding_bytes = 3 << 18;
    on_devices(few, |name, backend, _| {
        let error = render(backend, &scene).expect_err("they are too many");
        assert!(matches!(error, BackendError::OutOfMemory { .. }), "{name}: {error}");
        assert!(error.to_string().contains("surfaces of meshes"), "{name}: {error}");
        let mut smaller = scene.clone();
        (smaller.image.width, smaller.image.height) = (60, 45);
        assert!(render(backend, &smaller).is_ok(), "{name}");
    });
}

/// Memory may run out before they are there. The next frame is right.
#[test]
fn surfaces_are_sent_again_after_a_loss() {
    let _alone = alone();
    let scene = scene(5, 0.3, 0.8, 24);
    on_devices(as_it_is, |name, backend, orders| {
        let expected = render(backend, &scene).expect("a tiny frame fits").image;
        let mut larger = scene.clone();
        (larger.image.width, larger.image.height) = (64, 48);
        for n_buffers in 0..4 {
            locked(orders).buffers_left = Some(n_buffers);
            assert!(render(backend, &larger).is_err() || 0 < n_buffers, "{name}, {n_buffers}");
            locked(orders).buffers_left = None;
            let image = render(backend, &scene).expect("there is memory again").image;
            assert!(image == expected, "{name}, after {n_buffers} buffers");
        }
    });
}

/// So faint, and in so few tiles, that tiles pause: before surfaces, among them, and behind.
#[test]
fn rays_end_in_tiles_that_pause() {
    let _alone = alone();
    for (size, background) in [(0.5, [0.0; 4]), (1.2, [1.0; 4])] {
        let mut scene = scene(26, 1e-3, size, 12);
        scene.image.background = background;
        let expected = by_cpu(&scene);
        on_devices(in_rounds, |name, backend, orders| {
            let image = render(backend, &scene).expect("it fits").image;
            let difference = image.max_difference(&expected);
            assert!(difference < PARITY, "{name}, {size}: {difference}");
            assert!(1 < locked(orders).n_submitted, "{name}, {size}: one round was enough");
        });
    }
}
