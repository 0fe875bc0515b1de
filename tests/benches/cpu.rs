//! Whole frames on the CPU, through the facade: `cargo xtask bench cpu`.
//!
//! A new camera for each frame. The scenes are those of `tests/scenes` whose volumes are there, and the
//! built-in volumes as they look by themselves; for these also the first frame, which sorts, lists and makes
//! tables. Stages by themselves are benchmarks of the crates that have them.

use criterion::measurement::WallTime;
use criterion::{BatchSize, BenchmarkGroup, Criterion, criterion_group, criterion_main};
use slabsplat::{
    Automatic, Backend, ImageDesc, OpenScene, RenderSettings, Renderer, Scene, backend_named, io,
};

/// By how much the camera turns from frame to frame, in radians.
const TURN: f64 = 0.01;

const BUILTIN_SIDE: u32 = 256;

fn cpu() -> Box<dyn Backend> {
    backend_named("cpu").expect("the CPU is always there")
}

fn scenes(c: &mut Criterion) {
    let mut group = c.benchmark_group("scene");
    group.sample_size(10);
    for &name in slabsplat_testdata::SCENES {
        let Some(path) = slabsplat_testdata::scene(name) else { continue };
        let file = io::read_scene(&path).expect("the scene is valid");
        let opened = OpenScene::open(&file).expect("its volume is there");
        turning(&mut group, name, &opened.scene);
    }
    group.finish();
}

fn builtins(c: &mut Criterion) {
    let mut group = c.benchmark_group("builtin");
    group.sample_size(10);
    for &name in io::BUILTIN_NAMES {
        let volume = io::builtin_volume(name, None).expect("the name is listed");
        let image = ImageDesc::new(BUILTIN_SIDE, BUILTIN_SIDE);
        let scene = Automatic::new(volume).scene(image, RenderSettings::default());
        turning(&mut group, name, &scene);
        first(&mut group, name, &scene);
    }
    group.finish();
}

/// Frames of a camera that turns.
fn turning(group: &mut BenchmarkGroup<'_, WallTime>, name: &str, scene: &Scene) {
    let mut renderer = Renderer::new(cpu());
    let mut scene = scene.clone();
    group.bench_function(format!("{name}/turning"), |b| {
        b.iter(|| {
            scene.camera = scene.camera.orbited(TURN);
            renderer.render(&scene).expect("the scene can be drawn")
        });
    });
}

/// Frames of renderers that have drawn nothing before.
fn first(group: &mut BenchmarkGroup<'_, WallTime>, name: &str, scene: &Scene) {
    group.bench_function(format!("{name}/first"), |b| {
        b.iter_batched(
            || Renderer::new(cpu()),
            |mut renderer| renderer.render(scene).expect("the scene can be drawn"),
            BatchSize::LargeInput,
        );
    });
}

criterion_group!(benches, scenes, builtins);
criterion_main!(benches);
