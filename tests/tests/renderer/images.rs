//! Pictures for what a number cannot say: each shows one matter, and was looked at before it was
//! accepted.
//!
//! `SPLAT_TEST_UPDATE=name` writes the expected picture of that name (`all` writes every one). A failure
//! leaves the actual and the expected picture and eight times their difference in
//! `target/test-images/`.

use slabsplat::glam::{DAffine3, DMat3, DVec3};
use slabsplat::{
    Camera, Grid, Image, ImageDesc, Layer, Light, Method, Mode, Phong, Projection, Scene, Shading,
    TransferFunction, Volume, io,
};
use slabsplat_tests::exact_settings;
use slabsplat_tests::render::{backends, render};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What an 8-bit channel may differ: backends agree to 10⁻³, which may tip a rounding.
const MAX_STEPS: u8 = 1;

const SIDE: u32 = 64;

fn check(name: &str, scene: &Scene) {
    let expected_path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("images/{name}.png"));
    let wanted = std::env::var("SPLAT_TEST_UPDATE").unwrap_or_default();
    for backend in backends() {
        let actual = render(backend, scene);
        if wanted == name || wanted == "all" {
            io::write_png(&expected_path, &actual).expect("tests/images can be written");
            continue;
        }
        let dir = failures_dir();
        let actual_path = dir.join(format!("{name}-{backend}-actual.png"));
        io::write_png(&actual_path, &actual).expect("target can be written");
        let steps = largest_difference(&actual_path, &expected_path, &dir, name);
        assert!(steps <= MAX_STEPS, "{name} by {backend}: {steps} steps, see {}", dir.display());
        std::fs::remove_file(actual_path).expect("it was just written");
    }
}

fn failures_dir() -> PathBuf {
    let dir = Path::new(env!("CARGO_TARGET_TMPDIR")).join("../test-images");
    std::fs::create_dir_all(&dir).expect("target can be written");
    dir
}

fn largest_difference(actual: &Path, expected: &Path, dir: &Path, name: &str) -> u8 {
    let read = |path: &Path| {
        let missing = |err| panic!("{}: {err}; SPLAT_TEST_UPDATE={name} makes it", path.display());
        image::open(path).unwrap_or_else(missing).into_rgba8()
    };
    let (actual, expected) = (read(actual), read(expected));
    assert_eq!(actual.dimensions(), expected.dimensions(), "{name}");
    let mut difference = actual.clone();
    for (pixel, (a, b)) in difference.pixels_mut().zip(actual.pixels().zip(expected.pixels())) {
        pixel.0 = std::array::from_fn(|c| a.0[c].abs_diff(b.0[c]));
    }
    let steps = difference.pixels().flat_map(|p| p.0).max().unwrap_or(0);
    if MAX_STEPS < steps {
        for pixel in difference.pixels_mut() {
            pixel.0 = pixel.0.map(|d| d.saturating_mul(8));
            pixel.0[3] = 255;
        }
        difference.save(dir.join(format!("{name}-difference.png"))).expect("target can be written");
        expected.save(dir.join(format!("{name}-expected.png"))).expect("target can be written");
    }
    steps
}

fn builtin(name: &str, size: usize) -> Arc<Volume> {
    Arc::new(io::builtin_volume(name, Some(size)).expect("it is built in"))
}

/// Looks at the world's origin.
fn scene(
    volume: impl Into<Arc<Volume>>,
    eye: [f64; 3],
    projection: Projection,
    opacity: &[(f64, f64)],
) -> Scene {
    let opacity = opacity.iter().copied();
    let transfer = TransferFunction::new(opacity, vec![(0.0, [0.95, 0.8, 0.55])])
        .expect("the points are sorted");
    let camera = Camera::new(DVec3::from(eye), DVec3::ZERO, DVec3::Z, projection)
        .expect("the eye is off the z axis");
    Scene::new(Layer::new(volume, transfer), camera)
        .image(ImageDesc::new(SIDE, SIDE).background([0.0, 0.0, 0.0, 1.0]))
        .settings(exact_settings())
}

fn parallel(view_height: f64) -> Projection {
    Projection::Orthographic { view_height }
}

/// The three methods side by side where they differ most: a solid cube whose faces are equally lit.
#[test]
fn image_cube_by_method() {
    let volume = builtin("cube", 28);
    for (name, method) in [
        ("cube-image-aligned", Method::ImageAligned),
        ("cube-axis-aligned", Method::AxisAligned),
        ("cube-every-sample", Method::EverySample),
    ] {
        let opacity = [(0.0, 0.0), (255.0, 0.5)];
        let mut scene = scene(volume.clone(), [30.0, 29.0, 18.0], parallel(34.0), &opacity);
        scene.settings.method = method;
        scene.settings.mode = Mode::Separate;
        // As in the paper's figures: what is within a cube is not seen.
        scene.layers[0].shading = Shading::Phong(Phong::default().zero_gradient(0.0));
        check(name, &scene);
    }
}

/// The light comes from the upper left, so the ball is bright there and dark on the other side.
#[test]
fn image_light_from_the_upper_left() {
    let (ball, opacity) = (builtin("sphere", 32), [(60.0, 0.0), (200.0, 0.8)]);
    let mut scene = scene(ball, [0.0, -40.0, 0.0], parallel(38.0), &opacity);
    let light = Light::towards(DVec3::new(-1.0, -0.6, 1.0)).expect("it is a direction");
    scene.lights = vec![light];
    scene.layers[0].shading = Shading::Phong(Phong::default().two_sided(false));
    check("light-upper-left", &scene);
}

/// Right is right, up is up, and near hides far.
#[test]
fn image_orientation() {
    let grid =
        Grid::new([20; 3], DAffine3::from_mat3_translation(DMat3::IDENTITY, DVec3::splat(-9.5)))
            .expect("the grid is upright");
    let sample = |idx: usize| match grid.voxel_coords(idx) {
        [x, 8..12, 8..12] if 8 <= x => 1_u8,
        [8..12, 8..12, z] if 8 <= z => 2,
        [8..12, y, 8..12] if y < 8 => 3,
        _ => 0,
    };
    let samples: Vec<u8> = (0..grid.n_voxels()).map(sample).collect();
    let volume = Volume::new(grid, samples.into(), slabsplat::Scaling::IDENTITY)
        .expect("one sample a voxel");
    let mut scene = scene(volume, [14.0, -34.0, 12.0], parallel(28.0), &[(0.0, 0.0), (1.0, 0.9)]);
    // The arm along +x is red, that along +z green, and the one towards the eye, along −y, blue.
    let colors = vec![(1.0, [0.9, 0.2, 0.2]), (2.0, [0.2, 0.8, 0.2]), (3.0, [0.3, 0.4, 1.0])];
    scene.layers[0].transfer = TransferFunction::new(vec![(0.0, [0.0]), (1.0, [0.9])], colors)
        .expect("the points are sorted");
    check("orientation", &scene);
}

/// The signal that shows what a kernel loses, on a grid that is sheared: ripples without blocks.
#[test]
fn image_sheared_grid() {
    let volume = builtin("marschner-lobb", 32);
    let columns = DMat3::from_cols(
        DVec3::new(1.0, 0.0, 0.0),
        DVec3::new(0.4, 1.0, 0.0),
        DVec3::new(0.0, 0.3, 1.4),
    );
    let center = columns * DVec3::splat(15.5);
    let sheared = DAffine3::from_mat3_translation(columns, -center);
    let grid = Grid::new(volume.grid().dims(), sheared).expect("the grid can be inverted");
    let volume = Volume::clone(&volume).with_grid(grid).expect("the grid has the same size");
    let mut scene = scene(volume, [50.0, -30.0, 60.0], parallel(62.0), &[(0.45, 0.0), (0.55, 0.8)]);
    // Of so much detail, no more fits the size that a test's picture may have.
    (scene.image.width, scene.image.height) = (52, 52);
    check("sheared-grid", &scene);
}

/// From the middle of a hollow ball with a chequered wall: the wall all round, and nothing of what is
/// behind the eye.
#[test]
fn image_eye_inside() {
    let grid =
        Grid::new([32; 3], DAffine3::from_mat3_translation(DMat3::IDENTITY, DVec3::splat(-15.5)))
            .expect("the grid is upright");
    let sample = |idx: usize| {
        let coords = grid.voxel_coords(idx);
        let radius = DVec3::from_array(coords.map(|c| c as f64 - 15.5)).length();
        let is_wall = (11.0..14.0).contains(&radius);
        let is_white = coords.into_iter().map(|c| c / 4).sum::<usize>() % 2 == 0;
        if is_wall { 1 + u8::from(is_white) } else { 0 }
    };
    let samples: Vec<u8> = (0..grid.n_voxels()).map(sample).collect();
    let volume = Volume::new(grid, samples.into(), slabsplat::Scaling::IDENTITY)
        .expect("one sample a voxel");
    let wide = Projection::Perspective { fov_y_radians: 1.2 };
    let mut scene = scene(volume, [0.0, 3.0, -2.0], wide, &[(0.0, 0.0), (1.0, 0.9)]);
    scene.layers[0].shading = Shading::None;
    let colors = vec![(1.0, [0.1, 0.3, 0.5]), (2.0, [0.9, 0.9, 0.8])];
    scene.layers[0].transfer = TransferFunction::new(vec![(0.0, [0.0]), (1.0, [0.9])], colors)
        .expect("the points are sorted");
    (scene.image.width, scene.image.height) = (42, 42);
    check("eye-inside", &scene);
}

/// A volume of which a pixel covers 4 voxels keeps its shape and its average colour.
#[test]
fn image_minified() {
    let (neuron, opacity) = (builtin("neuron", 128), [(40.0, 0.0), (255.0, 0.6)]);
    check("minified", &scene(neuron, [50.0, -40.0, 30.0], parallel(256.0), &opacity));
}

/// Nothing is drawn, and the background shows: a picture that is not empty by accident.
#[test]
fn image_of_nothing_is_background() {
    let volume = builtin("cube", 28);
    let mut scene = scene(volume, [40.0, 0.0, 0.0], parallel(30.0), &[(0.0, 0.0)]);
    scene.image.background = [0.2, 0.4, 0.6, 1.0];
    for backend in backends() {
        let expected = Image::filled(SIDE, SIDE, [0.2, 0.4, 0.6, 1.0]);
        assert!(render(backend, &scene).max_difference(&expected) < 1e-6, "{backend}");
    }
}
