//! Voxels with colours of their own (model §15): scenes at random by every backend against the float64
//! reference and against the CPU, at the tolerances of model §9; and what cannot be drawn of them.

use fastrand::Rng;
use slabsplat::glam::DVec3;
use slabsplat::{
    Camera, ColorSamples, Compositing, Grid, ImageDesc, Layer, Method, Mode, Projection, Region,
    Renderer, Scaling, Scene, Shading, TransferFunction, Volume, VoxelColors,
};
use slabsplat_seeds::{for_each_numbered_seed, for_each_seed};
use slabsplat_tests::parity::Parity;
use slabsplat_tests::random_scene::{
    SceneKind, add_colors, add_gradient_opacity, add_labels, add_transfer_2d, random_layers,
    random_scene,
};
use slabsplat_tests::render::{backends, open, render};

/// Of one layer or several, by every method that draws them; half of them with labels, whose colours come
/// first, and some with what else classifies voxels.
#[test]
fn parity_of_colors() {
    let mut parity = Parity::default();
    for_each_numbered_seed(1, |seed, mut rng| {
        let has_colors = |kind: &SceneKind| kind.method != Method::PostClassified;
        for kind in SceneKind::share(seed).filter(has_colors).step_by(3) {
            let scene = colored_scene(&mut rng, &kind);
            parity.check(&mut rng, &kind, &scene);
        }
    });
    println!("{parity}");
}

fn colored_scene(rng: &mut Rng, kind: &SceneKind) -> Scene {
    let mut scene = random_scene(rng, kind);
    if kind.method == Method::ImageAligned {
        // A region's faces decide pixels by their rounding where sums cannot be split.
        scene.layers = random_layers(rng, kind).layers;
        scene.layers.iter_mut().for_each(|layer| layer.region = Region::default());
    }
    add_colors(rng, &mut scene);
    if rng.bool() {
        add_labels(rng, &mut scene);
    }
    if rng.u32(..4) == 0 {
        add_gradient_opacity(rng, &mut scene);
    }
    if rng.u32(..4) == 0 {
        add_transfer_2d(rng, &mut scene);
    }
    scene
}

/// What is cached of colours does not show in the next frame.
#[test]
fn colors_take_turns() {
    for_each_seed(1, |mut rng| {
        let kinds = SceneKind::all().into_iter().filter(|kind| kind.method == Method::ImageAligned);
        for (number, kind) in kinds.step_by(47).enumerate() {
            let plain = random_scene(&mut rng, &kind);
            let mut scenes = [plain.clone(), plain.clone(), plain.clone(), plain];
            scenes[1..].iter_mut().for_each(|scene| add_colors(&mut rng, scene));
            add_labels(&mut rng, &mut scenes[2]);
            scenes[3].settings.mode = Compositing::ALL[rng.usize(..Compositing::ALL.len())].into();
            // The CPU first; the others take longer, where a driver plays them.
            let n_backends = if number == 0 { backends().len() } else { 1 };
            for backend in &backends()[..n_backends] {
                let fresh: Vec<_> = scenes.iter().map(|scene| render(backend, scene)).collect();
                let mut renderer = Renderer::new(open(backend));
                for _ in 0..2 * scenes.len() {
                    let turn = rng.usize(..scenes.len());
                    let image = renderer.render(&scenes[turn]).expect("the scene is valid").image;
                    assert!(image == fresh[turn], "{backend}, turn {turn}");
                }
            }
        }
    });
}

/// The first and the last voxel of a row, red and blue, so far apart that no ray meets both; the transfer
/// function is white.
fn two_voxels() -> Scene {
    let grid = Grid::with_spacing([7, 1, 1], [1.0; 3]).expect("a grid");
    let samples = vec![200_u8, 0, 0, 0, 0, 0, 200];
    let volume = Volume::new(grid, samples.into(), Scaling::IDENTITY).expect("a volume");
    let mut colors = vec![[9, 99, 199]; 7];
    (colors[0], colors[6]) = ([255, 51, 0], [0, 0, 102]);
    let colors = VoxelColors::new(grid.dims(), ColorSamples::U8(colors)).expect("seven colours");
    let transfer = TransferFunction::new([(0.0, [0.0]), (200.0, [0.9])], [(0.0, [1.0; 3])]);
    let transfer = transfer.expect("a function");
    let projection = Projection::Orthographic { view_height: 10.0 };
    let target = DVec3::new(3.0, 0.0, 0.0);
    let camera = Camera::new(target + 50.0 * DVec3::Z, target, DVec3::Y, projection);
    let layer = Layer::new(volume, transfer).shading(Shading::None).colors(colors);
    let image = ImageDesc::new(20, 10);
    Scene::new(layer, camera.expect("a camera")).image(image)
}

#[test]
fn colors_are_those_of_voxels() {
    for backend in backends() {
        let image = render(backend, &two_voxels());
        let check = |x: u32, expected: [f32; 3]| {
            let [r, g, b, alpha] = image.pixel(x, 5);
            assert!(0.1 < alpha, "{backend}: nothing is to be seen at {x}");
            for (channel, expected) in [r, g, b].into_iter().zip(expected) {
                assert!((channel / alpha - expected).abs() < 1e-5, "{backend}: {expected} at {x}");
            }
        };
        check(6, [1.0, 0.2, 0.0]);
        check(13, [0.0, 0.0, 0.4]);
    }
}

/// Layers that differ in their colours alone are summed in one order, wherever they stand in the scene.
#[test]
fn colors_of_layers_have_one_order() {
    let mut scene = two_voxels();
    let others = ColorSamples::U8(vec![[3, 150, 77]; 7]);
    let others = VoxelColors::new([7, 1, 1], others).expect("seven colours");
    scene.layers.push(scene.layers[0].clone().colors(others));
    scene.layers.push(scene.layers[0].clone().colors(None));
    let expected = render("cpu", &scene);
    scene.layers.rotate_left(1);
    assert!(render("cpu", &scene) == expected);
    scene.layers.swap(0, 1);
    assert!(render("cpu", &scene) == expected);
}

#[test]
fn colors_have_no_densities() {
    let mut renderer = Renderer::new(open("cpu"));
    let mut check = |change: &dyn Fn(&mut Scene), expected: &str| {
        let mut scene = two_voxels();
        change(&mut scene);
        let error = renderer.render(&scene).expect_err("it cannot be drawn").to_string();
        assert!(error.contains(expected), "{error} should contain {expected}");
    };
    let what = "shows densities, which have no colours of voxels";
    check(&|scene| scene.settings.mode = Mode::Maximum, what);
    check(&|scene| scene.settings.method = Method::PostClassified, what);
    let others = VoxelColors::new([1, 7, 1], ColorSamples::U16(vec![[0; 3]; 7])).expect("colours");
    check(
        &|scene| scene.layers[0].colors = Some(others.clone()),
        "colours of [1, 7, 1] voxels are not those of a volume of [7, 1, 1]",
    );
}
