//! `post-classified` against the float64 reference and against what is known without one.

use slabsplat::glam::{DAffine3, DMat3, DVec3};
use slabsplat::{
    Camera, Compositing, Grid, ImageDesc, Layer, Light, Method, Phong, Projection, RenderSettings,
    Samples, Scaling, Scene, Shading, TransferFunction, Volume,
};
use slabsplat_seeds::{for_each_numbered_seed, for_each_seed};
use slabsplat_tests::exact_settings;
use slabsplat_tests::random_scene::{SceneKind, random_scene};
use slabsplat_tests::reference;
use slabsplat_tests::render::render;
use std::sync::Arc;

/// What a pixel may differ from the reference at most, and on average over a picture.
const MAX_DIFFERENCE: f64 = 1e-3;
const MEAN_DIFFERENCE: f64 = 1e-4;

/// Every kernel, compositing, projection and kind of grid.
#[test]
fn parity_of_densities() {
    check_parity(1.0);
}

/// Where a pixel is a small part of a voxel, a normal is a difference of densities that are nearly alike.
#[test]
fn parity_of_densities_zoomed_in() {
    check_parity(10.0);
}

fn check_parity(zoom: f64) {
    let (mut n_scenes, mut max, mut mean) = (0, 0.0_f64, 0.0_f64);
    for_each_numbered_seed(SceneKind::SHARES, |seed, mut rng| {
        for kind in SceneKind::share(seed).filter(|kind| kind.method == Method::PostClassified) {
            let mut scene = random_scene(&mut rng, &kind);
            scene.camera = zoomed(&scene.camera, zoom);
            let off = reference::render(&scene).compare(&render("cpu", &scene));
            let what = format!("{kind:?}, w {}", scene.settings.slab_width);
            assert!(off.max < MAX_DIFFERENCE, "a pixel is off by {}: {what}", off.max);
            assert!(off.mean < MEAN_DIFFERENCE, "pixels are off by {}: {what}", off.mean);
            (n_scenes, max, mean) = (n_scenes + 1, max.max(off.max), mean.max(off.mean));
        }
    });
    println!("{n_scenes} scenes: at most {max:.1e}, {mean:.1e} on average");
}

/// A section may be another by an eighth of the tolerance, and a density is a mean of many. What an edge of
/// the transfer function lies next to may go either way. Light depends on where a slope points, too, which is
/// anywhere where there is next to none, as in data that are noise.
#[test]
fn tolerance_of_densities() {
    let tolerance = RenderSettings::default().tolerance;
    let mut unlit = Changes { what: "without light", share: 0.01, mean: 0.1, ..Changes::default() };
    let mut lit = Changes { what: "with light", share: 0.05, mean: 0.2, ..Changes::default() };
    for_each_numbered_seed(SceneKind::SHARES, |seed, mut rng| {
        for kind in SceneKind::share(seed).filter(|kind| kind.method == Method::PostClassified) {
            let mut scene = random_scene(&mut rng, &kind);
            scene.camera = zoomed(&scene.camera, 2.0);
            (scene.image.width, scene.image.height) = (70, 50);
            let what = format!("{kind:?}, w {}", scene.settings.slab_width);
            if scene.layers[0].shading != Shading::None {
                lit.check(&what, &scene, tolerance);
                scene.layers[0].shading = Shading::None;
            }
            unlit.check(&what, &scene, tolerance);
        }
    });
    println!("{unlit:?}\n{lit:?}");
    assert!(0 < unlit.n_changed);
}

/// What a tolerance changes of pictures.
#[derive(Clone, Copy, Debug, Default)]
struct Changes {
    what: &'static str,
    /// The part of a picture's pixels that it may change by more than itself.
    share: f64,
    /// By how many of itself it may change them on average.
    mean: f64,
    n_pixels: usize,
    n_changed: usize,
    n_beyond: usize,
    /// The most of any pixel, and of the average of any picture.
    most: [f64; 2],
}

impl Changes {
    fn check(&mut self, what: &str, scene: &Scene, tolerance: f64) {
        let exact = render("cpu", scene);
        let settings = scene.settings.clone().tolerance(tolerance);
        let by_tolerance = render("cpu", &scene.clone().settings(settings));
        let change = |(a, b): (&[f32; 4], &[f32; 4])| {
            (0..4).map(|channel| f64::from((a[channel] - b[channel]).abs())).fold(0.0, f64::max)
        };
        let changes: Vec<f64> =
            by_tolerance.pixels().iter().zip(exact.pixels()).map(change).collect();
        let n_over = |limit: f64| changes.iter().filter(|&&change| limit < change).count();
        let n_beyond = n_over(tolerance);
        let share = n_beyond as f64 / changes.len() as f64;
        assert!(share <= self.share, "{n_beyond} pixels {}: {what}", self.what);
        let mean = by_tolerance.mean_difference(&exact);
        assert!(mean <= self.mean * tolerance, "pixels by {mean} {}: {what}", self.what);
        self.n_pixels += changes.len();
        self.n_changed += n_over(0.0);
        self.n_beyond += n_beyond;
        let max = changes.iter().copied().fold(0.0, f64::max);
        self.most = [self.most[0].max(max), self.most[1].max(mean)];
    }
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
    Camera::new(camera.eye(), camera.target(), camera.up(), projection)
        .expect("it looks where it looked before")
}

/// Looks along −z at the middle of a volume, 4 pixels to a world unit.
fn scene(volume: &Arc<Volume>, opacity: Vec<(f64, [f64; 1])>, settings: RenderSettings) -> Scene {
    let target = volume.grid().center_in_world();
    let projection = Projection::Orthographic { view_height: 10.0 };
    let transfer = TransferFunction::new(opacity, vec![(0.0, [0.0; 3]), (40.0, [1.0; 3])])
        .expect("the points rise");
    let camera = Camera::new(target + 50.0 * DVec3::Z, target, DVec3::Y, projection)
        .expect("up is not forward");
    let layer = Layer::new(volume.clone(), transfer).shading(Shading::None);
    Scene::new(layer, camera).image(ImageDesc::new(40, 40)).settings(settings)
}

fn volume(dims: [usize; 3], value: impl Fn([usize; 3]) -> f64) -> Arc<Volume> {
    let grid = Grid::with_spacing(dims, [1.0; 3]).expect("no axis is empty");
    let samples = (0..grid.n_voxels()).map(|i| value(grid.voxel_coords(i))).collect();
    let volume = Volume::new(grid, Samples::F64(samples), Scaling::IDENTITY);
    Arc::new(volume.expect("one sample a voxel"))
}

fn settings(compositing: Compositing, slab_width: f64) -> RenderSettings {
    exact_settings()
        .method(Method::PostClassified)
        .mode(compositing.into())
        .slab_width(slab_width)
        .opacity_cutoff(1.0)
}

/// A constant volume is what it is for `image-aligned`, its border too. Halves of slabs are composited one
/// by one, which only `extinction` does not see.
#[test]
fn constant_volume_is_image_aligned() {
    let dims = [6, 5, 7];
    let constant = volume(dims, |_| 13.0);
    for slab_width in [0.4, 1.0, 2.5] {
        let settings = settings(Compositing::Extinction, slab_width);
        let mut scene = scene(&constant, vec![(0.0, [0.7])], settings);
        scene.camera = scene.camera.orbited(0.5);
        let post = render("cpu", &scene);
        scene.settings.method = Method::ImageAligned;
        let difference = render("cpu", &scene).max_difference(&post);
        assert!(difference < 5e-4, "{slab_width}: {difference}");
    }
}

/// In `extinction` lengths add up, whatever the slabs are.
#[test]
fn constant_volume_does_not_depend_on_slab_width() {
    let dims = [6, 5, 7];
    let constant = volume(dims, |_| 13.0);
    let of = |slab_width| {
        let settings = settings(Compositing::Extinction, slab_width);
        render("cpu", &scene(&constant, vec![(0.0, [0.3])], settings))
    };
    let thin = of(0.2);
    for slab_width in [0.7, 1.0, 3.0, 1e6] {
        let difference = thin.max_difference(&of(slab_width));
        assert!(difference < 2e-4, "{slab_width}: {difference}");
    }
}

/// A CT's plateau just on a step of the transfer function: all of it is on the far side. NaN voxels are
/// holes, not values.
#[test]
fn plateau_on_a_step_has_no_speckle() {
    let dims = [6, 5, 7];
    let grid = Grid::with_spacing(dims, [1.0; 3]).expect("no axis is empty");
    for (sample, intercept) in [(24_i16, -1024.0), (1337, -1000.1), (-3, 0.3), (32767, 1e6)] {
        let scaling = Scaling { slope: 0.7, intercept };
        let value = scaling.apply(sample.into());
        let mut samples = vec![sample; grid.n_voxels()];
        // Something else far off, for a range of values.
        samples[0] = -9000;
        let volume = Volume::new(grid, samples.into(), scaling).expect("one sample a voxel");
        let volume = Arc::new(volume);
        let steps =
            vec![(value - 1.0, [0.0]), (value, [0.0]), (value, [0.5]), (value + 1.0, [0.5])];
        let stepped = scene(&volume, steps, settings(Compositing::Extinction, 1.0));
        let mut low = stepped.clone();
        low.layers[0].transfer = TransferFunction::new(
            vec![(value - 1.0, [0.0]), (value - 0.5, [0.0]), (value - 0.5, [0.5])],
            stepped.layers[0].transfer.color_points().points().to_vec(),
        )
        .expect("the points rise");
        let (stepped, low) = (render("cpu", &stepped), render("cpu", &low));
        // Away from the odd voxel, in the lower left corner.
        for (x, y) in (18..40).flat_map(|x| (0..20).map(move |y| (x, y))) {
            assert_eq!(stepped.pixel(x, y), low.pixel(x, y), "{value} at ({x}, {y})");
        }
    }
}

/// A ramp across the image, visible from 4.3 voxels on: the edge is there, and it is sharp.
#[test]
fn step_on_a_ramp_across_the_image() {
    let dims = [10, 10, 6];
    let ramp = volume(dims, |[i, _, _]| i as f64);
    let threshold = 4.3;
    let opacity = vec![(0.0, [0.0]), (threshold, [0.0]), (threshold, [0.9])];
    let mut scene = scene(&ramp, opacity, settings(Compositing::Extinction, 1.0));
    let projection = Projection::Orthographic { view_height: 1.0 };
    let target = DVec3::new(threshold, 4.5, 2.5);
    scene.camera = Camera::new(target + 50.0 * DVec3::Z, target, DVec3::Y, projection)
        .expect("up is not forward");
    let image = render("cpu", &scene);
    for y in 0..40 {
        // The edge goes through the middle, but for what the kernel makes of a ramp: less than 1/50 voxel.
        // Where the outermost kernels end in depth, there is a trace of less even a ramp.
        let [before, behind] = [18, 21].map(|x| image.pixel(x, y)[3]);
        assert!(before < 0.03 && 0.97 < behind, "row {y}: {before} {behind}");
    }
}

/// A ramp in depth: the colour says at which value the ray stopped.
#[test]
fn step_on_a_ramp_in_depth() {
    let dims = [10, 10, 24];
    // It rises away from the eye.
    let ramp = volume(dims, |[_, _, k]| 23.0 - k as f64);
    for threshold in [9.0, 11.37] {
        let opacity = vec![(0.0, [0.0]), (threshold, [0.0]), (threshold, [1.0])];
        let scene = scene(&ramp, opacity, settings(Compositing::Extinction, 0.1));
        let [red, .., alpha] = render("cpu", &scene).pixel(20, 20);
        let value = 40.0 * f64::from(red / alpha);
        // Slabs 0.1 thick of an extinction of 13.8: the light comes from 0.07 voxels behind the surface, and
        // a slab may begin up to 0.1 too late.
        let expected = threshold + 0.07;
        assert!((value - expected).abs() < 0.08, "{threshold}: {value}");
    }
}

/// A field that is linear in the world has one normal everywhere, on any grid and in either projection, and
/// at the border of the grid too.
#[test]
fn linear_field_is_lit_evenly() {
    let columns = DMat3::from_cols(
        DVec3::new(1.0, 0.1, 0.0),
        DVec3::new(0.3, 1.4, 0.0),
        DVec3::new(0.0, -0.2, 1.9),
    );
    let grid = Grid::new([14, 10, 8], DAffine3::from_mat3(columns)).expect("it can be inverted");
    let slope = DVec3::new(0.5, -0.3, 0.7);
    let value = |idx: usize| {
        let at = DVec3::from_array(grid.voxel_coords(idx).map(|c| c as f64));
        grid.world_from_index().transform_point3(at).dot(slope)
    };
    let samples: Vec<f64> = (0..grid.n_voxels()).map(value).collect();
    let volume = Volume::new(grid, samples.into(), Scaling::IDENTITY).expect("one sample a voxel");
    let volume = Arc::new(volume);
    let light = DVec3::new(1.0, 2.0, 3.0).normalize();
    let phong = Phong::default().ambient(0.1).diffuse(0.9).specular(0.0).two_sided(true);
    let expected = 0.1 + 0.9 * slope.normalize().dot(light).abs();
    let target = grid.center_in_world();
    let mut scene = scene(&volume, vec![(0.0, [1.0])], settings(Compositing::Extinction, 0.7));
    scene.lights = vec![Light::towards(light).expect("the direction is not zero")];
    // A plane through the middle.
    let middle = target.dot(slope);
    let opacity = vec![(middle - 0.5, [0.0]), (middle, [0.9]), (middle + 0.5, [0.0])];
    scene.layers[0].transfer =
        TransferFunction::new(opacity, vec![(0.0, [1.0; 3])]).expect("the points rise");
    scene.layers[0].shading = Shading::Phong(phong);
    for projection in [
        Projection::Orthographic { view_height: 8.0 },
        Projection::Perspective { fov_y_radians: 0.9 },
    ] {
        let eye = target + DVec3::new(9.0, 4.0, 14.0);
        scene.camera = Camera::new(eye, target, DVec3::Y, projection).expect("up is not forward");
        let image = render("cpu", &scene);
        for (x, y) in (14..26).flat_map(|x| (14..26).map(move |y| (x, y))) {
            let [red, .., alpha] = image.pixel(x, y).map(f64::from);
            // Kernels are no more than nearly linear on a ramp.
            let is_right = (red / alpha - expected).abs() < 0.03;
            assert!(
                0.3 < alpha && is_right,
                "{projection:?} ({x}, {y}): {} {expected}",
                red / alpha
            );
        }
    }
}

/// A picture does not depend on where its frame is: a window of it has the same pixels, borders too.
#[test]
fn border_of_the_image_does_not_show() {
    for_each_seed(1, |mut rng| {
        let dims = [10, 10, 10];
        let values: Vec<f64> = (0..1000).map(|_| 40.0 * rng.f64()).collect();
        let volume = volume(dims, |[i, j, k]| values[i + 10 * j + 100 * k]);
        let opacity = vec![(10.0, [0.0]), (40.0, [0.8])];
        let mut wide = scene(&volume, opacity, settings(Compositing::Extinction, 1.0));
        wide.layers[0].shading = Shading::Phong(Phong::default());
        let mut narrow = wide.clone();
        (narrow.image.width, narrow.image.height) = (20, 20);
        let projection = Projection::Orthographic { view_height: 5.0 };
        let Scene { camera, .. } = wide;
        narrow.camera = Camera::new(camera.eye(), camera.target(), camera.up(), projection)
            .expect("it is the same view");
        let (wide, narrow) = (render("cpu", &wide), render("cpu", &narrow));
        for (x, y) in (0..20).flat_map(|x| (0..20).map(move |y| (x, y))) {
            let (inside, window) = (wide.pixel(x + 10, y + 10), narrow.pixel(x, y));
            let close = inside.iter().zip(window).all(|(a, b)| (a - b).abs() < 1e-5);
            assert!(close, "({x}, {y}): {inside:?} {window:?}");
        }
    });
}
