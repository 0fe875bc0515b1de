//! Levels of detail (model §16): cells of voxels against the voxels, and the CPU's cells against the reference's.

use slabsplat_core::{
    Camera, Compositing, Layer, Method, Normalization, Projection, RenderSettings, Scene, Shading,
    TransferFunction,
};
use slabsplat_seeds::for_each_numbered_seed;
use slabsplat_tests::random_scene::{SceneKind, random_scene};
use slabsplat_tests::reference::{render, render_within_tolerance};
use slabsplat_tests::render::render as by_backend;

/// A random scene from so far away that a pixel covers some voxels.
fn minified(rng: &mut fastrand::Rng, kind: &SceneKind) -> Scene {
    let mut scene = random_scene(rng, kind);
    let by = 2.0 + 8.0 * rng.f64();
    (scene.image.width, scene.image.height) = (14, 12);
    let volume = &scene.layers[0].volume;
    let pixel = volume.grid().unit() * by;
    let camera = &scene.camera;
    let (eye, target, up) = (camera.eye(), camera.target(), camera.axes().up);
    let height = pixel * f64::from(scene.image.height);
    let projection = match camera.projection() {
        Projection::Orthographic { .. } => Projection::Orthographic { view_height: height },
        Projection::Perspective { .. } => Projection::Perspective {
            fov_y_radians: 2.0 * (0.5 * height / eye.distance(target)).atan(),
        },
    };
    scene.camera = Camera::new(eye, target, up, projection).expect("it was one");
    scene
}

fn may_merge(kind: &SceneKind) -> bool {
    kind.method == Method::ImageAligned
        && kind.compositing == Compositing::Extinction
        && kind.normalization == Normalization::None
}

/// As opaque as half of them may be, in colours as far apart as can be.
fn gaudy(scene: &Scene, opacity: f64, rng: &mut fastrand::Rng) -> Layer {
    let layer = scene.layers[0].clone();
    let values = (0..layer.volume.grid().n_voxels()).map(|idx| layer.volume.value(idx));
    let (lo, hi) = values
        .filter(|value| value.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), value| (lo.min(value), hi.max(value)));
    let (lo, hi) = if lo < hi { (lo, hi) } else { (0.0, 1.0) };
    let middle = lo + (hi - lo) * (0.2 + 0.6 * rng.f64());
    let transfer = TransferFunction::new(
        vec![(lo, [opacity * rng.f64()]), (middle, [opacity])],
        vec![(middle, [0.0; 3]), (middle, [1.0; 3])],
    );
    let layer = layer.transfer(transfer.expect("the points rise"));
    if rng.bool() { layer.shading(Shading::None) } else { layer }
}

#[test]
fn detail_levels_on_random_scenes() {
    let (mut worst, mut worst_of_cpu, mut n_drawn) = (0.0_f64, 0.0_f64, 0);
    for_each_numbered_seed(SceneKind::SHARES, |seed, mut rng| {
        for kind in SceneKind::share(seed).filter(may_merge) {
            let mut scene = minified(&mut rng, &kind);
            let opacity = [0.01, 0.05, 0.1, 0.22][rng.usize(..4)];
            scene.layers[0] = gaudy(&scene, opacity, &mut rng);
            scene.settings.tolerance = RenderSettings::default().tolerance;
            let [exact, cells] = [render(&scene), render_within_tolerance(&scene)];
            let off = exact.compare_reference(&cells).max;
            let by_cpu = cells.compare(&by_backend("cpu", &scene)).max;
            println!("{off:.4} {by_cpu:.4} opacity {opacity} {kind:?}");
            worst = worst.max(off);
            worst_of_cpu = worst_of_cpu.max(by_cpu);
            n_drawn += 1;
        }
    });
    println!(
        "at most {worst:.4} from voxels, {worst_of_cpu:.1e} from the reference in {n_drawn} scenes"
    );
}
