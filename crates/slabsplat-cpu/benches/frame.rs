//! Whole frames by each method, of a ball in 96³ voxels: opaque, where most of it is occluded, and a haze,
//! where every section counts.

use criterion::{Criterion, criterion_group, criterion_main};
use slabsplat_backend::{Backend, Planner};
use slabsplat_core::glam::DVec3;
use slabsplat_core::{
    Camera, FrameHandle, Grid, ImageDesc, Layer, Method, Projection, RenderSettings, Scaling,
    Scene, TransferFunction, Volume,
};
use slabsplat_cpu::CpuBackend;
use std::sync::Arc;

const SIDE: usize = 96;

fn ball() -> Volume {
    let grid = Grid::with_spacing([SIDE; 3], [1.0; 3]).expect("the grid is not empty");
    let center = grid.center_in_index();
    let samples: Vec<f32> = (0..grid.n_voxels())
        .map(|idx| {
            let at = DVec3::from_array(grid.voxel_coords(idx).map(|c| c as f64));
            (0.45 * SIDE as f64 - at.distance(center)).clamp(0.0, 1.0) as f32
        })
        .collect();
    Volume::new(grid, samples.into(), Scaling::IDENTITY).expect("one sample a voxel")
}

fn scene(volume: &Arc<Volume>, opacity: f64, method: Method) -> Scene {
    let projection = Projection::Orthographic { view_height: SIDE as f64 };
    let target = DVec3::splat(0.5 * SIDE as f64);
    let eye = target + DVec3::new(300.0, 200.0, 100.0);
    let color = vec![(0.0, [0.9, 0.8, 0.7])];
    let transfer = TransferFunction::new(vec![(0.0, [0.0]), (1.0, [opacity])], color)
        .expect("the points are sorted");
    let camera = Camera::new(eye, target, DVec3::Z, projection).expect("the eye is off the axis");
    Scene::new(Layer::new(volume.clone(), transfer), camera)
        .image(ImageDesc::new(256, 256))
        .settings(RenderSettings::default().method(method))
}

fn frame(c: &mut Criterion) {
    let volume = Arc::new(ball());
    let mut backend = CpuBackend::new();
    let mut planner = Planner::default();
    let mut group = c.benchmark_group("frame");
    group.sample_size(10);
    for (name, opacity) in [("opaque", 0.8), ("haze", 0.02)] {
        for &method in Method::ALL {
            let mut scene = scene(&volume, opacity, method);
            group.bench_function(format!("{name}/{method}"), |b| {
                b.iter(|| {
                    scene.camera = scene.camera.orbited(0.01);
                    let plan = planner.plan(&scene).expect("it is valid");
                    let frame = FrameHandle::new();
                    backend.submit(&plan, &frame).expect("the CPU has no limits");
                    backend.poll_image(&frame).expect("the frame was submitted")
                });
            });
        }
    }
    group.finish();
}

criterion_group!(benches, frame);
criterion_main!(benches);
