//! Several lights in any colours (model §6): scenes at random against the float64 reference, at the
//! tolerances of model §9, and GPUs against the CPU.

use slabsplat::{Light, Scene};
use slabsplat_seeds::{for_each_numbered_seed, for_each_seed};
use slabsplat_tests::random_scene::{SceneKind, add_lights, random_scene};
use slabsplat_tests::reference;
use slabsplat_tests::render::{backends_in_turn, render};

/// What a pixel may differ from the reference at most, and on average over a picture.
const MAX_DIFFERENCE: f64 = 1e-3;
const MEAN_DIFFERENCE: f64 = 1e-4;

/// A light that is rounded as the sum of two.
const ROUNDED: f32 = 1e-6;

#[test]
fn parity_of_lights() {
    let (mut n_scenes, mut max) = (0, 0.0_f64);
    for_each_numbered_seed(SceneKind::SHARES, |seed, mut rng| {
        for (number, kind) in SceneKind::share(seed).step_by(6).enumerate() {
            let mut scene = random_scene(&mut rng, &kind);
            add_lights(&mut rng, &mut scene);
            let image = render("cpu", &scene);
            let off = reference::render(&scene).compare(&image);
            let what = format!("{kind:?}, {:?}", scene.lights);
            assert!(off.max < MAX_DIFFERENCE, "{:?}: {}: {what}", off.worst_pixel, off.max);
            assert!(off.mean < MEAN_DIFFERENCE, "{}: {what}", off.mean);
            (n_scenes, max) = (n_scenes + 1, max.max(off.max));
            for backend in backends_in_turn(kind.method, number).skip(1) {
                let difference = render(backend, &scene).max_difference(&image);
                assert!(f64::from(difference) < MAX_DIFFERENCE, "{backend}: {difference}: {what}");
            }
        }
    });
    println!("{n_scenes} scenes: at most {max:.1e}");
}

/// A white light is one of red and one of cyan, and a black one is none.
#[test]
fn lights_add_up() {
    for_each_seed(1, |mut rng| {
        for kind in SceneKind::all().into_iter().step_by(17) {
            let scene = random_scene(&mut rng, &kind);
            let [light] = scene.lights.as_slice() else { panic!("{:?}", scene.lights) };
            let with = |lights: &[Light]| -> Scene { scene.clone().lights(lights.to_vec()) };
            let [red, cyan, black] =
                [[1.0, 0.0, 0.0], [0.0, 1.0, 1.0], [0.0; 3]].map(|color| light.color(color));
            let whole = render("cpu", &scene);
            for lights in [&[red, cyan][..], &[cyan, red], &[*light, black]] {
                let difference = render("cpu", &with(lights)).max_difference(&whole);
                assert!(difference < ROUNDED, "{difference}: {kind:?}");
            }
        }
    });
}
