//! Every backend against the float64 reference, on scenes at random: the tolerances of model §9.

use slabsplat::glam::{DAffine3, DMat3, DVec3};
use slabsplat::{
    Camera, Grid, ImageDesc, Layer, Method, Projection, Scaling, Scene, Shading, TransferFunction,
    Volume,
};
use slabsplat_seeds::for_each_numbered_seed;
use slabsplat_tests::exact_settings;
use slabsplat_tests::random_scene::{SceneKind, random_scene};
use slabsplat_tests::reference::{self, Difference};
use slabsplat_tests::render::{backends, backends_in_turn, pictures, render};

/// What a pixel may differ from the reference at most, and on average over a picture.
const MAX_DIFFERENCE: f64 = 1e-3;
const MEAN_DIFFERENCE: f64 = 1e-4;

/// What a pixel may differ from that of the CPU backend.
const FROM_CPU: f32 = 1e-3;

/// Of so many scenes one is drawn by a GPU, too, and all by the CPU: drivers that only play a device take
/// longer than all else.
const ONE_IN: usize = 2;

/// Every method × kernel × compositing × normalisation × projection × grid.
#[test]
fn parity_on_random_scenes() {
    let mut tallies: Vec<(&str, Tally)> =
        backends().iter().map(|b| (*b, Tally::default())).collect();
    for_each_numbered_seed(SceneKind::SHARES, |seed, mut rng| {
        for (number, kind) in SceneKind::share(seed).enumerate() {
            let scene = random_scene(&mut rng, &kind);
            let expected = reference::render(&scene);
            let n_backends = if number.is_multiple_of(ONE_IN) { 2 } else { 1 };
            let backends = backends_in_turn(kind.method, number / ONE_IN).take(n_backends);
            let pictures = pictures(backends, &scene);
            let (_, by_cpu) = &pictures[0];
            for (backend, image) in &pictures {
                let (from_cpu, off) = (image.max_difference(by_cpu), expected.compare(image));
                let what = format!("{backend}, {kind:?}, w {}", scene.settings.slab_width);
                assert!(from_cpu < FROM_CPU, "{from_cpu} off the CPU: {what}");
                assert!(off.max < MAX_DIFFERENCE, "a pixel is off by {}: {what}", off.max);
                assert!(off.mean < MEAN_DIFFERENCE, "pixels are off by {}: {what}", off.mean);
                let tally = tallies.iter_mut().find(|(name, _)| name == backend);
                tally.expect("it has a tally").1.add(&off, from_cpu);
            }
        }
    });
    for (backend, tally) in tallies {
        println!("{backend}: {tally:?}");
    }
}

/// The largest differences, each over all scenes.
#[derive(Debug, Default)]
struct Tally {
    n_scenes: usize,
    max: f64,
    mean: f64,
    from_cpu: f32,
}

impl Tally {
    fn add(&mut self, off: &Difference, from_cpu: f32) {
        self.n_scenes += 1;
        self.max = self.max.max(off.max);
        self.mean = self.mean.max(off.mean);
        self.from_cpu = self.from_cpu.max(from_cpu);
    }
}

/// Voxels up to a thousand times as long as they are wide, seen at a slant: their footprints are needles,
/// whose quadratic form has no digits left in 32 bits unless its square is completed first.
#[test]
fn parity_on_needles() {
    for (turn, ratio) in [10.0, 100.0, 1000.0].into_iter().enumerate() {
        for (number, &method) in Method::ALL.iter().enumerate() {
            let scene = needles(ratio, method);
            let expected = reference::render(&scene);
            for backend in backends_in_turn(method, turn + number) {
                let difference = expected.compare(&render(backend, &scene));
                println!("{ratio} {method} by {backend}: {:.1e}", difference.max);
                assert!(difference.max < MAX_DIFFERENCE, "{ratio} {method}: {}", difference.max);
            }
        }
    }
}

fn needles(ratio: f64, method: Method) -> Scene {
    let turn = DMat3::from_axis_angle(DVec3::new(0.3, 1.0, 0.2).normalize(), 0.7);
    let steps = turn * DMat3::from_diagonal(DVec3::new(1.0, 1.0, ratio));
    let grid = Grid::new([3; 3], DAffine3::from_mat3(steps)).expect("the grid can be inverted");
    let volume = Volume::new(grid, vec![1_u8; 27].into(), Scaling::IDENTITY).expect("27 voxels");
    // Beside the last voxel, where the needles end.
    let target = steps * DVec3::new(1.0, 1.0, 2.8);
    let eye = target + 5.0 * ratio * DVec3::new(-0.6, 0.5, -0.4);
    let projection = Projection::Orthographic { view_height: 8.0 };
    let settings = exact_settings().method(method);
    let transfer = TransferFunction::new(vec![(0.0, [1.0])], vec![(0.0, [1.0, 0.8, 0.5])])
        .expect("the points are finite");
    let camera = Camera::new(eye, target, DVec3::Y, projection);
    let layer = Layer::new(volume, transfer).shading(Shading::None);
    Scene::new(layer, camera.expect("the eye is off the y axis"))
        .image(ImageDesc::new(24, 24))
        .settings(settings)
}
