//! What only backends on a GPU can get wrong: limits, memory, loss, and frames under way. Each test runs on
//! every graphics interface that this machine has a driver for.

use slabsplat::glam::{DAffine3, DVec3};
use slabsplat::{
    BackendError, Camera, FrameHandle, Grid, Layer, Lookup, Method, Plane, Projection, Region,
    Scaling, Scene, Volume,
};
use slabsplat_gpu::DeviceInfo;
use slabsplat_tests::on_devices::{
    alone, as_it_is, in_rounds, layered_scene, listed_by_host, on_a_device, on_devices, render,
    scene, stretched, submit, take, transfer, volume, with_host_list,
};
use slabsplat_tests::render::open;
use slabsplat_tests::spy_device::locked;
use std::sync::{Arc, Mutex};

/// What two backends may differ by.
const PARITY: f32 = 1e-3;

/// The methods that classify voxels, as exactly as their samples are.
const METHODS_OF_COLORS: [Method; 3] =
    [Method::ImageAligned, Method::AxisAligned, Method::EverySample];

/// Lists in four chunks, samples in pieces, pictures in bands: the bits are those of one piece.
#[test]
fn small_bindings_give_the_same_bits() {
    let _alone = alone();
    let [large, small] = [volume([44, 40, 36]), volume([9, 8, 7])];
    let chunks = METHODS_OF_COLORS.map(|method| (scene(&large, 20, method), 512 << 10));
    let bands = METHODS_OF_COLORS.map(|method| (scene(&small, 130, method), 128 << 10));
    let densities = scene(&volume([16, 14, 20]), 64, Method::PostClassified);
    // The second layer begins within a chunk, and ends in another.
    let layers = layered_scene([&volume([34, 40, 36]), &stretched(&small, 5.0)], 32);
    let mut by_host = layered_scene([&small, &stretched(&volume([34, 40, 36]), 0.3)], 40);
    by_host.layers[1] = listed_by_host(by_host.layers[1].clone());
    let others = [(densities, 96 << 10), (layers, 512 << 10), (by_host, 512 << 10)];
    for (number, (scene, max_bytes)) in chunks.into_iter().chain(bands).chain(others).enumerate() {
        check_small_bindings(number, scene, max_bytes);
    }
}

fn check_small_bindings(number: usize, mut scene: Scene, max_bytes: u64) {
    scene.settings.sections = 16;
    scene.settings.lookup = Lookup::Nearest;
    let expected = render(&mut *open("cpu"), &scene).expect("the CPU has no limits");
    let pictures = Mutex::new(Vec::new());
    for limit in [u64::MAX, max_bytes] {
        let change = |info: &mut DeviceInfo| {
            info.max_binding_bytes = info.max_binding_bytes.min(limit);
        };
        on_a_device(number, change, |name, backend, _| {
            let what = format!("{name}, scene {number}, {}", scene.settings.method);
            let frame = render(backend, &scene).unwrap_or_else(|e| panic!("{what}: {e}"));
            let difference = frame.image.max_difference(&expected.image);
            assert!(difference < PARITY, "{what}: {difference}");
            pictures.lock().expect("no test failed").push((what, frame));
        });
    }
    let pictures = pictures.into_inner().expect("no test failed");
    for pair in pictures.windows(2) {
        let [(what, whole), (_, cut)] = pair else { unreachable!("windows of two") };
        assert!(whole.image == cut.image, "{what}");
        assert_eq!(whole.stats, cut.stats, "{what}");
    }
}

/// As many layers as there can be, some of which show nothing, and each with a region.
#[test]
fn as_many_layers_as_there_can_be() {
    let _alone = alone();
    let mut scene = scene(&volume([3, 4, 3]), 40, Method::ImageAligned);
    let first = scene.layers[0].clone();
    let grid = first.volume.grid();
    scene.layers.clear();
    for n in 0..64 {
        let moved = DAffine3::from_translation(
            0.9 * DVec3::new(f64::from(n % 8) - 4.0, f64::from(n / 8) - 4.0, 0.0),
        );
        let grid = Grid::new(grid.dims(), moved * grid.world_from_index()).expect("it was moved");
        let volume = Volume::new(grid, first.volume.samples().clone(), Scaling::IDENTITY);
        let mut layer =
            Layer::new(volume.expect("there are as many samples"), first.transfer.clone());
        let plane = Plane::new(DVec3::new(f64::from(n), 9.0, -20.0), f64::from(n - 20));
        layer.region = Region::new(vec![plane.expect("it is not zero")]);
        if n % 9 == 0 {
            layer.transfer = transfer(0.0);
        }
        scene.layers.push(layer);
    }
    let expected = render(&mut *open("cpu"), &scene).expect("the CPU has no limits");
    on_devices(as_it_is, |name, backend, _| {
        let frame = render(backend, &scene).expect("it fits");
        assert_eq!(frame.stats.n_voxels, expected.stats.n_voxels, "{name}");
        let difference = frame.image.max_difference(&expected.image);
        assert!(difference < PARITY, "{name}: {difference}");
    });
}

/// What does not fit is an error that says how much it needs and has, and the backend continues.
#[test]
fn what_does_not_fit_is_an_error() {
    let _alone = alone();
    let (large, small) = (volume([40, 36, 30]), volume([5, 4, 3]));
    let by_device: fn(Scene) -> Scene = |scene| scene;
    let check = |change: fn(&mut DeviceInfo), list: fn(Scene) -> Scene, what: &str| {
        on_devices(change, |name, backend, _| {
            let scene_of = |volume: &Arc<Volume>| {
                let mut scene = list(scene(volume, 24, Method::ImageAligned));
                scene.settings.sections = 16;
                scene.settings.radial_samples = 16;
                scene.settings.lookup = Lookup::Nearest;
                scene
            };
            let error = render(backend, &scene_of(&large)).expect_err("it is too large");
            let BackendError::OutOfMemory { needed_bytes, available_bytes, .. } = &error else {
                panic!("{name}, {what}: {error}");
            };
            assert!(available_bytes < needed_bytes, "{name}, {what}: {error}");
            assert!(error.to_string().contains(what), "{name}: {error}");
            let frame = render(backend, &scene_of(&small));
            assert!(frame.is_ok(), "{name}, {what}: {frame:?}");
        });
    };
    check(|info| info.max_binding_bytes = 30_000, by_device, "samples");
    check(|info| info.max_binding_bytes = 64 << 10, by_device, "relevant voxels");
    check(|info| info.max_binding_bytes = 64 << 10, with_host_list, "relevant voxels");
    check(|info| info.memory_bytes = Some(4 << 20), by_device, "on");
}

/// Memory may run out at any buffer. The frame is lost, and the next one is right.
#[test]
fn out_of_memory_is_survived() {
    let _alone = alone();
    let volume = volume([9, 8, 7]);
    let scene = with_host_list(layered_scene([&volume, &stretched(&volume, 0.7)], 24));
    on_devices(as_it_is, |name, backend, _| {
        let expected = render(backend, &scene).expect("a tiny frame fits").image;
        let n_failures = Mutex::new(0);
        for n_buffers in 0..80 {
            on_devices(as_it_is, |other, backend, orders| {
                if other != name {
                    return;
                }
                locked(orders).buffers_left = Some(n_buffers);
                if let Err(error) = render(backend, &scene) {
                    assert!(matches!(error, BackendError::OutOfMemory { .. }), "{name}: {error}");
                    *n_failures.lock().expect("no test failed") += 1;
                }
                let frame = render(backend, &scene).expect("there is memory again");
                assert!(frame.image == expected, "{name}, after {n_buffers} buffers");
            });
        }
        let n_failures = n_failures.into_inner().expect("no test failed");
        assert!(30 < n_failures && n_failures < 80, "{name}: {n_failures} failures");
    });
}

/// Records that the host has listed go to the device before their frame does. Whichever does not get there,
/// the frame is lost, and the next one is right.
#[test]
fn lost_works_are_survived() {
    let _alone = alone();
    let volume = volume([9, 8, 7]);
    let scenes = [0.3, 0.2].map(|opacity| {
        let mut scene = layered_scene([&volume, &stretched(&volume, 0.7)], 24);
        scene.layers[0].transfer = transfer(opacity);
        scene.layers = scene.layers.into_iter().map(listed_by_host).collect();
        scene
    });
    on_devices(as_it_is, |name, backend, orders| {
        let expected =
            scenes.each_ref().map(|scene| render(backend, scene).expect("it fits").image);
        for n_works in 0..4 {
            locked(orders).works_left = Some(n_works);
            let failed = render(backend, &scenes[0]).is_err();
            locked(orders).works_left = None;
            // One for each layer, and the frame's own.
            assert_eq!(failed, n_works < 3, "{name}, after {n_works} works");
            for (scene, expected) in scenes.iter().zip(&expected) {
                let frame = render(backend, scene).expect("there is memory again");
                assert!(frame.image == *expected, "{name}, after {n_works} works");
            }
        }
    });
}

/// Of every frame that was under way, and of all that come after.
#[test]
fn lost_device_is_an_error() {
    let _alone = alone();
    let volume = volume([5, 4, 3]);
    let scene = scene(&volume, 24, Method::ImageAligned);
    on_devices(as_it_is, |name, backend, orders| {
        let frame = submit(backend, &scene).expect("a tiny frame fits");
        locked(orders).lost = Some("it fell off the bus");
        let is_lost = |error: &BackendError| matches!(error, BackendError::DeviceLost { .. });
        let error = take(backend, &frame).expect_err("the device is lost");
        assert!(
            is_lost(&error) && error.to_string().contains("fell off the bus"),
            "{name}: {error}"
        );
        assert_eq!(take(backend, &frame), Err(BackendError::UnknownFrame), "{name}");
        let error = submit(backend, &scene).expect_err("the device is lost");
        assert!(is_lost(&error), "{name}: {error}");
    });
}

/// An eye inside the volume: far more splats than expected, for which room is made afterwards.
#[test]
fn close_ups_find_room() {
    let _alone = alone();
    let volume = volume([30, 30, 30]);
    let mut scene = scene(&volume, 400, Method::EverySample);
    let target = volume.grid().center_in_world();
    let projection = Projection::Perspective { fov_y_radians: 1.9 };
    let eye = target + DVec3::new(3.0, 0.5, 0.2);
    scene.camera = Camera::new(eye, target, DVec3::Y, projection).expect("up is not forward");
    let expected = render(&mut *open("cpu"), &scene).expect("the CPU has no limits").image;
    on_devices(as_it_is, |name, backend, orders| {
        let frame = render(backend, &scene).expect("it fits");
        let difference = frame.image.max_difference(&expected);
        assert!(difference < PARITY, "{name}: {difference}");
        assert!(1 < locked(orders).n_submitted, "{name}: there was room at once");
        locked(orders).n_submitted = 0;
        let again = render(backend, &scene).expect("it fits");
        assert!(again.image == frame.image, "{name}");
        assert_eq!(locked(orders).n_submitted, 1, "{name}: the room is kept");
    });
}

/// More splats on a tile than a dispatch takes on. Mesa's software driver ended loops early here, and
/// rows of pixels were missing.
#[test]
fn crowded_tiles_pause() {
    let _alone = alone();
    let volume = volume([24, 24, 24]);
    let of_method = |method| scene(&volume, 12, method);
    let layers = layered_scene([&volume, &stretched(&volume, 0.8)], 12);
    // What is summed again after a pause takes a program that plays a card too long, of more voxels.
    let densities = scene(&self::volume([12; 3]), 12, Method::PostClassified);
    let scenes = METHODS_OF_COLORS.map(of_method).into_iter().chain([layers, densities]);
    for (number, mut scene) in scenes.enumerate() {
        let method = scene.settings.method;
        for layer in &mut scene.layers {
            layer.transfer = transfer(1e-4);
        }
        let expected = render(&mut *open("cpu"), &scene).expect("the CPU has no limits");
        on_a_device(number, in_rounds, |name, backend, orders| {
            let frame = render(backend, &scene).expect("it fits");
            let difference = frame.image.max_difference(&expected.image);
            assert!(difference < PARITY, "{name}, {method}: {difference}");
            assert!(1 < locked(orders).n_submitted, "{name}, {method}: one round was enough");
        });
    }
}

/// A picture in so many bands that there is no room for as many rounds as a tile needs.
#[test]
fn too_crowded_tiles_are_an_error() {
    let _alone = alone();
    let volume = volume([25, 25, 25]);
    let mut scene = scene(&volume, 568, Method::ImageAligned);
    scene.layers[0].transfer = transfer(1e-4);
    scene.settings.slab_width = 0.1;
    scene.settings.sections = 16;
    scene.settings.radial_samples = 16;
    scene.settings.lookup = Lookup::Nearest;
    let target = volume.grid().center_in_world();
    let projection = Projection::Orthographic { view_height: 5e3 };
    let eye = target + DVec3::new(90.0, 60.0, -75.0);
    scene.camera = Camera::new(eye, target, DVec3::Y, projection).expect("up is not forward");
    let small = |info: &mut DeviceInfo| {
        in_rounds(info);
        info.max_binding_bytes = 128 << 10;
    };
    on_a_device(0, small, |name, backend, _| {
        let error = render(backend, &scene).expect_err("the tile is too crowded");
        assert!(matches!(error, BackendError::Unable { .. }), "{name}: {error}");
        let mut easy = scene.clone();
        easy.settings.slab_width = 4.0;
        assert!(render(backend, &easy).is_ok(), "{name}: the next one is done");
    });
}

/// Several frames under way, of two volumes, taken in another order than submitted.
#[test]
fn frames_under_way_keep_apart() {
    let _alone = alone();
    let volumes = [volume([12, 10, 9]), volume([9, 13, 8])];
    let mut scenes: Vec<_> =
        (0..5).map(|i| scene(&volumes[i % 2], 20 + 6 * i as u32, Method::ALL[i % 4])).collect();
    scenes.insert(3, layered_scene([&volumes[1], &volumes[0]], 30));
    scenes.insert(4, with_host_list(scenes[3].clone()));
    scenes[1] = with_host_list(scenes[1].clone());
    on_devices(as_it_is, |name, backend, _| {
        let ids: Vec<FrameHandle> =
            scenes.iter().map(|scene| submit(backend, scene).expect("it fits")).collect();
        for (i, scene) in scenes.iter().enumerate().rev() {
            let image = take(backend, &ids[i]).expect("the device is there").image;
            let expected = render(&mut *open("cpu"), scene).expect("it fits").image;
            let difference = image.max_difference(&expected);
            assert!(difference < PARITY, "{name}, frame {i}: {difference}");
        }
    });
}
