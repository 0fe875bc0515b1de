//! Densities on GPUs: the method `post-classified`, and the modes of one density or of surfaces, against the
//! CPU.

use fastrand::Rng;
use slabsplat::glam::DVec3;
use slabsplat::{
    Camera, Grid, Image, ImageDesc, Isosurface, Layer, Method, Mode, Projection, Samples, Scaling,
    Scene, TransferFunction, Volume,
};
use slabsplat_seeds::for_each_numbered_seed;
use slabsplat_tests::exact_settings;
use slabsplat_tests::random_scene::{SceneKind, add_lights, random_layers};
use slabsplat_tests::reference::undecided_pixels;
use slabsplat_tests::render::{backends, render};

/// What two backends may differ by.
const PARITY: f32 = 1e-3;

/// The modes that show densities by every method with slabs.
const MODES: [Mode; 4] = [Mode::Maximum, Mode::Minimum, Mode::Average, Mode::Isosurfaces];

/// Every kernel, compositing, projection and kind of grid, near and far, with regions and without, in any
/// lights: some in each mode, frame after frame on one renderer.
#[test]
fn densities_by_every_backend() {
    let mut worst: Vec<(Mode, usize, f32)> = Vec::new();
    for_each_numbered_seed(2, |seed, mut rng| {
        let kinds = SceneKind::share(seed).filter(|kind| kind.method == Method::PostClassified);
        for (number, kind) in kinds.enumerate() {
            let mode = MODES.get((number + seed as usize) % 7).copied();
            let scene = random_layers(&mut rng, &kind);
            let scene = random_densities(&mut rng, scene, mode.unwrap_or(kind.compositing.into()));
            let what = format!("{kind:?}, w {}", scene.settings.slab_width);
            let off = assert_drawn_alike(&scene, &what);
            let mode = scene.settings.mode;
            match worst.iter_mut().find(|(of, ..)| *of == mode) {
                Some((_, n_scenes, worst)) => (*n_scenes, *worst) = (*n_scenes + 1, worst.max(off)),
                None => worst.push((mode, 1, off)),
            }
        }
    });
    for (mode, n_scenes, off) in worst {
        println!("{mode}: {n_scenes} scenes, at most {off:.1e} off the CPU");
    }
}

/// Of any pixel that is decided, the largest difference of any backend from the CPU.
fn assert_drawn_alike(scene: &Scene, what: &str) -> f32 {
    let by_cpu = render("cpu", scene);
    let undecided = undecided_pixels(scene);
    let mut worst = 0.0_f32;
    for &backend in backends().iter().filter(|name| **name != "cpu") {
        let off = difference(&render(backend, scene), &by_cpu, &undecided);
        let mode = scene.settings.mode;
        assert!(off < PARITY, "a pixel is off by {off}: {backend}, {mode}, {what}");
        worst = worst.max(off);
    }
    worst
}

fn difference(image: &Image, other: &Image, undecided: &[bool]) -> f32 {
    let pixels = image.pixels().iter().zip(other.pixels()).zip(undecided);
    let decided = pixels.filter(|(_, is_undecided)| !**is_undecided);
    let channels = decided.flat_map(|((a, b), _)| a.iter().zip(b));
    channels.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

/// The scene in that mode, from near or far, and perhaps by other lights.
fn random_densities(rng: &mut Rng, mut scene: Scene, mode: Mode) -> Scene {
    scene.settings.mode = mode;
    if rng.u32(..4) == 0 {
        add_lights(rng, &mut scene);
    }
    let zoom = [1.0, 1.0, 3.0, 10.0][rng.usize(..4)];
    scene.camera = zoomed(&scene.camera, zoom);
    let layer = &mut scene.layers[0];
    let [lo, hi] = finite_range(&layer.volume);
    let surfaces = (0..rng.usize(1..=3)).map(|_| {
        let color = rng.bool().then(|| [0; 3].map(|_| rng.f64()));
        let value = lo + (hi - lo) * (0.1 + 0.8 * rng.f64());
        Isosurface::new(value, [1.0, rng.f64()][rng.usize(..2)], color).expect("shares of one")
    });
    layer.isosurfaces = surfaces.collect();
    scene
}

fn finite_range(volume: &Volume) -> [f64; 2] {
    let values = (0..volume.grid().n_voxels()).map(|voxel_idx| volume.value(voxel_idx));
    let finite = values.filter(|value| value.is_finite());
    finite.fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], v| [lo.min(v), hi.max(v)])
}

fn zoomed(camera: &Camera, zoom: f64) -> Camera {
    let projection = match camera.projection() {
        Projection::Orthographic { view_height } => {
            Projection::Orthographic { view_height: view_height / zoom }
        }
        Projection::Perspective { fov_y_radians } => {
            Projection::Perspective { fov_y_radians: fov_y_radians / zoom }
        }
    };
    Camera::new(camera.eye(), camera.target(), camera.up(), projection).expect("it was one before")
}

/// Numbers that 32-bit floats do not hold, infinities and NaN, by values that fall with samples too.
#[test]
fn densities_of_every_sample_type() {
    const MODES: [Mode; 3] = [Mode::Extinction, Mode::Maximum, Mode::Isosurfaces];
    for_each_numbered_seed(1, |seed, mut rng| {
        for of_type in 0..8 {
            let turn = seed as usize + of_type;
            let scaling = [Scaling::IDENTITY, Scaling { slope: -0.3, intercept: 1e3 }][turn % 2];
            let samples = samples(&mut rng, of_type);
            let what = format!("{:?}, {scaling:?}", samples.sample_type());
            let mut scene = scene(samples, scaling);
            scene.settings.mode = MODES[turn % 3];
            assert_drawn_alike(&scene, &what);
        }
    });
}

const DIMS: [usize; 3] = [6, 5, 4];

fn samples(rng: &mut Rng, of_type: usize) -> Samples {
    fn random<T>(next: impl FnMut(usize) -> T) -> Vec<T> {
        (0..DIMS.iter().product()).map(next).collect()
    }
    let mut any = |value: f64| match rng.u32(..30) {
        0 => f64::NAN,
        1 => f64::INFINITY,
        2 => f64::NEG_INFINITY,
        _ => value + rng.f64(),
    };
    match of_type {
        0 => random(|n| (n * 97) as u8).into(),
        1 => random(|n| (n * 97) as u8 as i8).into(),
        2 => random(|n| 60_000 + (n * 97 % 5000) as u16).into(),
        3 => random(|n| -32_000 + (n * 97 % 5000) as i16).into(),
        4 => random(|n| u32::MAX - (n * 97 % 300) as u32).into(),
        5 => random(|n| i32::MIN + (n * 97 % 300) as i32).into(),
        6 => random(|n| any((n * 97 % 50) as f64) as f32).into(),
        _ => random(|n| any(1e12 + (n * 97 % 500) as f64)).into(),
    }
}

/// A volume as it comes, and a transfer function and surfaces over all its values.
fn scene(samples: Samples, scaling: Scaling) -> Scene {
    let grid = Grid::with_spacing(DIMS, [1.0, 1.3, 0.8]).expect("the spacing is positive");
    let volume = Volume::new(grid, samples, scaling).expect("one sample a voxel");
    let [lo, hi] = finite_range(&volume);
    let at = |share: f64| lo + (hi - lo) * share;
    let opacities = vec![(at(0.2), [0.0]), (at(0.8), [0.4])];
    let colors = vec![(at(0.0), [1.0, 0.0, 0.2]), (at(1.0), [0.1, 1.0, 0.4])];
    let transfer = TransferFunction::new(opacities, colors).expect("the points are sorted");
    let surfaces = [0.35, 0.6].map(|share| Isosurface::new(at(share), 0.7, None));
    let mut layer = Layer::new(volume, transfer);
    layer.isosurfaces = surfaces.into_iter().collect::<Result<_, _>>().expect("shares of one");
    let target = grid.center_in_world();
    let projection = Projection::Orthographic { view_height: 7.0 };
    let eye = target + DVec3::new(9.0, 6.0, -7.0);
    let camera = Camera::new(eye, target, DVec3::Y, projection).expect("up is not forward");
    Scene::new(layer, camera)
        .image(ImageDesc::new(30, 22))
        .settings(exact_settings().method(Method::PostClassified))
}
