//! Every backend against the float64 reference, on scenes at random: the tolerances of SPEC §9.

use slabsplat::glam::{DAffine3, DMat3, DVec3};
use slabsplat::{
    Camera, Grid, ImageDesc, Method, Projection, RenderSettings, Scaling, Scene, Shading,
    TransferFunction, Volume,
};
use slabsplat_tests::random_scene::{SceneKind, random_scene};
use slabsplat_tests::reference;
use slabsplat_tests::render::{backends, backends_with, render};
use slabsplat_tests::{exact_settings, seeded_rng};

/// What a pixel may differ from the reference at most, and on average over a picture.
const MAX_DIFFERENCE: f64 = 1e-3;
const MEAN_DIFFERENCE: f64 = 1e-4;

/// What a pixel may differ from that of the CPU backend.
const FROM_CPU: f32 = 1e-3;

/// Every method × kernel × compositing × normalisation × projection × grid.
#[test]
fn parity_on_random_scenes() {
    let mut rng = seeded_rng();
    let mut differences = Vec::new();
    let mut farthest_from_cpu = 0.0_f32;
    for kind in SceneKind::all() {
        let (volume, scene) = random_scene(&mut rng, &kind);
        let expected = reference::render(&volume, &scene);
        let by_cpu = render("cpu", &volume, &scene);
        for backend in backends_with(kind.method) {
            let image = render(backend, &volume, &scene);
            let from_cpu = image.max_difference(&by_cpu);
            assert!(from_cpu < FROM_CPU, "{backend} is off the CPU by {from_cpu}: {kind:?}");
            farthest_from_cpu = farthest_from_cpu.max(from_cpu);
            let difference = expected.compare(&image);
            differences.push((difference.max, difference.mean, kind, scene.clone()));
        }
    }
    println!("{:?}: largest difference from the CPU {farthest_from_cpu:.1e}", backends());
    differences.sort_by(|a, b| b.0.total_cmp(&a.0));
    for (max, mean, kind, scene) in differences.iter().take(5) {
        println!("{max:.1e} (mean {mean:.1e}) {kind:?} w {}", scene.settings.slab_width);
    }
    let (max, mean) = (differences[0].0, differences.iter().map(|d| d.1).fold(0.0, f64::max));
    println!("largest difference {max:.1e}, largest mean difference {mean:.1e}");
    assert!(max < MAX_DIFFERENCE, "a pixel is off by {max}");
    assert!(mean < MEAN_DIFFERENCE, "a picture is off by {mean} on average");
}

/// Voxels up to a thousand times as long as they are wide, seen at a slant: their footprints are needles,
/// whose quadratic form has no digits left in 32 bits unless its square is completed first.
#[test]
fn parity_on_needles() {
    for ratio in [10.0, 100.0, 1000.0] {
        for &method in Method::ALL {
            let (volume, scene) = needles(ratio, method);
            let expected = reference::render(&volume, &scene);
            for backend in backends_with(method) {
                let difference = expected.compare(&render(backend, &volume, &scene));
                println!("{ratio} {method} by {backend}: {:.1e}", difference.max);
                assert!(difference.max < MAX_DIFFERENCE, "{ratio} {method}: {}", difference.max);
            }
        }
    }
}

fn needles(ratio: f64, method: Method) -> (Volume, Scene) {
    let turn = DMat3::from_axis_angle(DVec3::new(0.3, 1.0, 0.2).normalize(), 0.7);
    let steps = turn * DMat3::from_diagonal(DVec3::new(1.0, 1.0, ratio));
    let grid = Grid::new([3; 3], DAffine3::from_mat3(steps)).expect("the grid can be inverted");
    let volume = Volume::new(grid, vec![1_u8; 27].into(), Scaling::IDENTITY).expect("27 voxels");
    // Beside the last voxel, where the needles end.
    let target = steps * DVec3::new(1.0, 1.0, 2.8);
    let eye = target + 5.0 * ratio * DVec3::new(-0.6, 0.5, -0.4);
    let projection = Projection::Orthographic { view_height: 8.0 };
    let settings = RenderSettings { method, ..exact_settings() };
    let scene = Scene {
        transfer: TransferFunction::new(vec![(0.0, [1.0])], vec![(0.0, [1.0, 0.8, 0.5])])
            .expect("the points are finite"),
        shading: Shading::None,
        camera: Camera::new(eye, target, DVec3::Y, projection).expect("the eye is off the y axis"),
        image: ImageDesc { width: 24, height: 24, background: [0.0; 4] },
        settings,
    };
    (volume, scene)
}
