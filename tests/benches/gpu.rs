//! Whole frames on every GPU backend, stage by stage: `cargo xtask bench gpu [SCENE …]`.
//!
//! A new camera for each frame, reading back excluded where the device has timestamps. Scenes that are not
//! named are the brain, opaque and as a haze, where its volume is, and a volume of 512³ voxels of which 20
//! million are relevant. Software drivers get few and small frames: they show that it runs.

use slabsplat::glam::DVec3;
use slabsplat::{
    Backend, Camera, Frame, Grid, Layer, OpenScene, Projection, Renderer, Scaling, Scene,
    TransferFunction, Volume, io,
};
use slabsplat_gpu::{Device, DeviceInfo, DeviceKind, GpuBackend, OpenOptions};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// By how much the camera turns from frame to frame, in radians.
const TURN: f64 = 0.01;

/// A scene, and the pictures that are made of it.
struct Case {
    name: String,
    scene: Scene,
    sides: &'static [u32],
}

fn main() {
    let paths: Vec<PathBuf> =
        std::env::args().skip(1).filter(|a| !a.starts_with('-')).map(PathBuf::from).collect();
    let gpus = open_all();
    let is_software = |(_, info, _): &(_, DeviceInfo, _)| info.kind == DeviceKind::Software;
    let all_software = gpus.iter().all(is_software);
    if gpus.is_empty() {
        println!("There is no device to measure.");
        return;
    }
    let cases = cases(&paths, all_software);
    for (name, info, backend) in gpus {
        let mut renderer = Renderer::new(backend);
        println!("\n{name}: {} ({}, {:?})", info.name, info.driver, info.kind);
        println!("medians in ms; n is in thousands\n");
        println!("{:<28} {:>9} {:>9}  stages", "picture", "device", "whole");
        for case in &cases {
            for &side in case.sides {
                measure(case, side, &mut renderer, info.kind);
            }
        }
    }
}

fn open_all() -> Vec<(&'static str, DeviceInfo, Box<dyn Backend>)> {
    fn boxed<D: Device + 'static>(
        name: &'static str,
        device: D,
    ) -> (&'static str, DeviceInfo, Box<dyn Backend>) {
        let info = device.info().clone();
        (name, info, Box::new(GpuBackend::new(name, device)))
    }
    let options = OpenOptions::default();
    let ash = slabsplat_ash::open(&options).map(|device| boxed("ash", device));
    let wgpu = slabsplat_wgpu::open(&options).map(|device| boxed("wgpu", device));
    let report = |result: Result<_, slabsplat_gpu::Unavailable>| {
        result.inspect_err(|reason| println!("not measured: {reason}")).ok()
    };
    [ash, wgpu].into_iter().filter_map(report).collect()
}

fn cases(paths: &[PathBuf], is_software: bool) -> Vec<Case> {
    let sides: &[u32] = if is_software { &[64] } else { &[512, 1024] };
    if !paths.is_empty() {
        return paths.iter().map(|path| scene_file(path, sides)).collect();
    }
    let brains = ["brain", "brain-haze"].into_iter().filter_map(slabsplat_testdata::scene);
    let mut cases: Vec<Case> = brains.map(|path| scene_file(&path, sides)).collect();
    cases.push(if is_software { waves(64, &[64]) } else { waves(512, &[1024]) });
    cases
}

fn scene_file(path: &Path, sides: &'static [u32]) -> Case {
    let file = io::read_scene(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let opened =
        OpenScene::open(&file).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    Case { name, scene: opened.scene, sides }
}

/// Folded sheets through a cube, 15 % of its voxels, half transparent.
fn waves(side: usize, sides: &'static [u32]) -> Case {
    let grid = Grid::with_spacing([side; 3], [1.0; 3]).expect("the grid is not empty");
    let scale = 40.0 / side as f64;
    let sample = |idx: usize| {
        let [x, y, z] = grid.voxel_coords(idx).map(|c| c as f64 * scale);
        let wave = (x + (0.7 * y).sin()).sin() * (y + (0.5 * z).cos()).cos() + (0.6 * z).sin();
        (127.0 + 60.0 * wave) as u8
    };
    let samples: Vec<u8> = (0..grid.n_voxels()).map(sample).collect();
    let volume = Volume::new(grid, samples.into(), Scaling::IDENTITY).expect("one sample a voxel");
    let target = volume.grid().center_in_world();
    let eye = target + DVec3::new(2.0, 1.2, 0.8) * side as f64;
    let projection = Projection::Orthographic { view_height: 1.5 * side as f64 };
    let transfer = TransferFunction::new(
        vec![(171.0, [0.0]), (190.0, [0.4]), (240.0, [0.6])],
        vec![(150.0, [0.2, 0.4, 0.9]), (240.0, [1.0, 0.8, 0.3])],
    )
    .expect("the points are sorted");
    let camera = Camera::new(eye, target, DVec3::Z, projection).expect("the eye is off the axis");
    let scene = Scene::new(Layer::new(volume, transfer), camera);
    Case { name: format!("waves of {side}^3"), scene, sides }
}

fn measure(case: &Case, side: u32, renderer: &mut Renderer, kind: DeviceKind) {
    let n_frames = if kind == DeviceKind::Software { 3 } else { 100 };
    let mut scene = case.scene.clone();
    (scene.image.width, scene.image.height) = (side, side);
    // The first frames upload, compile and find room.
    for _ in 0..2 {
        renderer.render(&scene).unwrap_or_else(|error| panic!("{}: {error}", case.name));
    }
    let mut frames = Vec::with_capacity(n_frames);
    for _ in 0..n_frames {
        scene.camera = scene.camera.orbited(TURN);
        let started = Instant::now();
        let frame =
            renderer.render(&scene).unwrap_or_else(|error| panic!("{}: {error}", case.name));
        frames.push((frame, started.elapsed().as_secs_f64() * 1e3));
    }
    report(&format!("{}, {side}^2", case.name), &frames);
}

fn report(name: &str, frames: &[(Frame, f64)]) {
    let total = |frame: &Frame| frame.cost.stages.iter().map(|stage| stage.ms).sum();
    let device = median(frames.iter().map(|(frame, _)| total(frame)));
    let whole = median(frames.iter().map(|(_, ms)| *ms));
    let last = &frames[frames.len() - 1].0;
    let stage_ms = |idx: usize| {
        let ms = frames.iter().filter_map(|(frame, _)| frame.cost.stages.get(idx));
        median(ms.map(|stage| stage.ms))
    };
    let stages: Vec<String> = (last.cost.stages.iter().enumerate())
        .map(|(idx, stage)| format!("{} {:.3}", stage.name, stage_ms(idx)))
        .collect();
    let stats = &last.stats;
    println!("{name:<28} {device:>9.3} {whole:>9.3}  {}", stages.join(", "));
    println!(
        "{:<28} voxels {}, splats {}, culled {} ({} not tossed), tiles {} ({} saturated), {} MiB resident",
        "",
        stats.n_voxels / 1000,
        stats.n_splats / 1000,
        stats.n_culled / 1000,
        last.cost.n_hidden / 1000,
        stats.n_tiles,
        stats.n_saturated_tiles,
        last.cost.resident_bytes >> 20,
    );
}

fn median(numbers: impl Iterator<Item = f64>) -> f64 {
    let mut numbers: Vec<f64> = numbers.collect();
    numbers.sort_by(f64::total_cmp);
    numbers.get(numbers.len() / 2).copied().unwrap_or(f64::NAN)
}
