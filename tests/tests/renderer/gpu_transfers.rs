//! What moves to a GPU when little changes: on every graphics interface that this machine has a driver for.

use slabsplat::{Grid, Method, Planner, Scaling, Scene, Shading, Volume};
use slabsplat_tests::on_devices::{
    alone, as_it_is, layered_scene, on_devices, scene, stretched, submit_plan, take, transfer,
    volume, with_host_list,
};
use slabsplat_tests::spy_device::locked;
use std::sync::Arc;

/// A camera moves its own few hundred bytes, a transfer function a few more, and nobody the samples.
#[test]
fn little_moves_when_little_changes() {
    let _alone = alone();
    let volume = volume([20, 20, 20]);
    on_devices(as_it_is, |name, backend, orders| {
        let mut scene = scene(&volume, 32, Method::ImageAligned);
        let mut planner = Planner::default();
        let mut n_written = |scene: &Scene| {
            locked(orders).bytes_written = 0;
            let plan = planner.plan(scene).expect("the scene is valid");
            let frame = submit_plan(backend, &plan).expect("a small frame fits");
            take(backend, &frame).expect("the device is there");
            locked(orders).bytes_written
        };
        let first = n_written(&scene);
        assert!(8 * volume.grid().n_voxels() <= first, "{name}: {first} bytes at first");
        let again = n_written(&scene);
        scene.layers[0].shading = Shading::None;
        let relit = n_written(&scene);
        scene.layers[0].transfer = transfer(0.2);
        let reclassified = n_written(&scene);
        println!("{name}: again {again}, relit {relit}, reclassified {reclassified} bytes");
        assert!(again <= 512 && relit <= 512 && reclassified <= 1024, "{name}");
    });
}

/// Of a layer that the host lists no sample is sent, and records only if what they are made of changes.
#[test]
fn little_moves_when_a_list_of_the_host_stays() {
    let _alone = alone();
    let volume = volume([20, 20, 20]);
    on_devices(as_it_is, |name, backend, orders| {
        let by_device = scene(&volume, 32, Method::ImageAligned);
        let mut scene = with_host_list(by_device.clone());
        let mut planner = Planner::default();
        let mut sent = |scene: &Scene| {
            locked(orders).bytes_written = 0;
            let plan = planner.plan(scene).expect("the scene is valid");
            let frame = submit_plan(backend, &plan).expect("a small frame fits");
            let n_voxels = take(backend, &frame).expect("the device is there").stats.n_voxels;
            (locked(orders).bytes_written, 32 * n_voxels as usize)
        };
        sent(&scene);
        let (again, _) = sent(&scene);
        scene.layers[0].shading = Shading::None;
        let (relit, _) = sent(&scene);
        scene.layers[0].gradient_opacity = None;
        let (reclassified, records) = sent(&scene);
        let all = [again, relit, reclassified, records];
        println!("{name}: again {again}, relit {relit}, reclassified {reclassified} of {records}");
        assert!(again <= 512 && relit <= 512, "{name}: {all:?}");
        assert!(records <= reclassified && reclassified <= records + 1024, "{name}: {all:?}");
        let samples = 8 * volume.grid().n_voxels();
        let (by_device, _) = sent(&by_device);
        assert!(samples <= by_device, "{name}: they were not there before");
    });
}

/// A layer that changes leaves the others as they are, wherever they stand in the plan's order.
#[test]
fn little_moves_when_one_layer_changes() {
    let _alone = alone();
    let volume = volume([12, 12, 12]);
    on_devices(as_it_is, |name, backend, orders| {
        let mut scene = layered_scene([&volume, &stretched(&volume, 0.7)], 32);
        scene.settings.sections = 16;
        scene.settings.radial_samples = 16;
        let mut planner = Planner::default();
        let mut n_written = |scene: &Scene| {
            locked(orders).bytes_written = 0;
            let plan = planner.plan(scene).expect("the scene is valid");
            let frame = submit_plan(backend, &plan).expect("a small frame fits");
            take(backend, &frame).expect("the device is there");
            locked(orders).bytes_written
        };
        let first = n_written(&scene);
        assert!(2 * 8 * volume.grid().n_voxels() <= first, "{name}: {first} bytes at first");
        // The second frame is the first that is told how it follows another.
        let second = n_written(&scene);
        let again = n_written(&scene);
        assert!(again <= second && second <= 1024, "{name}: {second}, {again} bytes");
        scene.layers[1].transfer = transfer(0.2);
        let reclassified = n_written(&scene);
        scene.layers.swap(0, 1);
        let reordered = n_written(&scene);
        // Two layers of one volume, whose samples are there once.
        let [first, second] = &mut *scene.layers else { panic!("there are two") };
        first.volume = second.volume.clone();
        let shared = n_written(&scene);
        let what = format!("{again}, {reclassified}, {reordered}, {shared} bytes by {name}");
        println!("{what}");
        assert!(again <= 1024 && reclassified <= 2048 && reordered == again, "{what}");
        assert!(shared < 8 * volume.grid().n_voxels(), "{what}");
    });
}

/// On a cubic grid a turned camera changes nothing but itself.
#[test]
fn camera_moves_a_few_hundred_bytes() {
    let _alone = alone();
    let grid = Grid::with_spacing([12; 3], [1.0; 3]).expect("the spacing is positive");
    let samples: Vec<f64> = (0..grid.n_voxels()).map(|i| (i % 7) as f64 / 7.0).collect();
    let cubic = Volume::new(grid, samples.into(), Scaling::IDENTITY).expect("one sample a voxel");
    let volume = Arc::new(cubic);
    on_devices(as_it_is, |name, backend, orders| {
        let mut scene = scene(&volume, 32, Method::ImageAligned);
        let mut planner = Planner::default();
        for turn in 0..6 {
            locked(orders).bytes_written = 0;
            let plan = planner.plan(&scene).expect("the scene is valid");
            let frame = submit_plan(backend, &plan).expect("a small frame fits");
            take(backend, &frame).expect("the device is there");
            let n_bytes = locked(orders).bytes_written;
            // A turn may change how many bits tell the slabs apart, and so a few passes.
            assert!(turn == 0 || n_bytes <= 1024, "{name}, turn {turn}: {n_bytes} bytes");
            scene.camera = scene.camera.orbited(0.05);
        }
    });
}
