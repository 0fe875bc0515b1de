//! Modes in which one density stands for all on its ray (model §12): the CPU against the float64 reference,
//! and what is known without it.

use slabsplat::glam::DVec3;
use slabsplat::{
    Camera, Grid, ImageDesc, Layer, Method, Mode, Projection, Region, RenderSettings, Samples,
    Scaling, Scene, TransferFunction, Volume,
};
use slabsplat_seeds::{for_each_numbered_seed, for_each_seed};
use slabsplat_tests::exact_settings;
use slabsplat_tests::random_scene::{ProjectionKind, SceneKind, random_layers};
use slabsplat_tests::reference::{self, undecided_pixels};
use slabsplat_tests::render::{backends_with, render};

/// What a pixel may differ from the reference at most, and on average over a picture.
const MAX_DIFFERENCE: f64 = 1e-3;
const MEAN_DIFFERENCE: f64 = 1e-4;

const MODES: [Mode; 3] = [Mode::Maximum, Mode::Minimum, Mode::Average];

/// Every kernel, projection and kind of grid, with regions and without.
#[test]
fn parity_of_modes() {
    let (mut n_scenes, mut max, mut mean) = (0, 0.0_f64, 0.0_f64);
    for_each_numbered_seed(SceneKind::SHARES, |seed, mut rng| {
        let kinds = SceneKind::share(seed).filter(|kind| kind.method == Method::PostClassified);
        for (kind, mode) in kinds.flat_map(|kind| MODES.map(|mode| (kind, mode))) {
            let mut scene = random_layers(&mut rng, &kind);
            scene.settings.mode = mode;
            let image = render("cpu", &scene);
            let mut expected = reference::render(&scene);
            for (idx, is_undecided) in undecided_pixels(&scene).into_iter().enumerate() {
                if is_undecided {
                    expected.pixels[idx] = image.pixels()[idx].map(f64::from);
                }
            }
            let off = expected.compare(&image);
            let what = format!("{mode}, {kind:?}, w {}", scene.settings.slab_width);
            assert!(off.max < MAX_DIFFERENCE, "{:?} by {}: {what}", off.worst_pixel, off.max);
            assert!(off.mean < MEAN_DIFFERENCE, "pixels are off by {}: {what}", off.mean);
            (n_scenes, max, mean) = (n_scenes + 1, max.max(off.max), mean.max(off.mean));
        }
    });
    println!("{n_scenes} scenes: at most {max:.1e}, {mean:.1e} on average");
}

/// `image-aligned` and `post-classified` have the same densities.
#[test]
fn modes_of_both_methods_are_one() {
    for_each_seed(1, |mut rng| {
        let kinds = SceneKind::all().into_iter();
        let kinds = kinds.filter(|kind| kind.method == Method::PostClassified).step_by(7);
        for kind in kinds {
            let mut scene = random_layers(&mut rng, &kind);
            for mode in MODES {
                scene.settings.mode = mode;
                let by = |method| {
                    let settings = scene.settings.clone().method(method);
                    render("cpu", &scene.clone().settings(settings))
                };
                assert!(by(Method::ImageAligned) == by(Method::PostClassified), "{kind:?} {mode}");
            }
        }
    });
}

/// Means by whole footprints, as rays are parallel, are those by sheets, which a region asks for that holds
/// everything.
#[test]
fn mean_by_whole_footprints_is_that_by_sheets() {
    let (mut n_scenes, mut max) = (0, 0.0_f64);
    for_each_numbered_seed(SceneKind::SHARES, |seed, mut rng| {
        let kinds = SceneKind::share(seed).filter(|kind| kind.method == Method::PostClassified);
        let is_upright = |kind: &SceneKind| kind.projection == ProjectionKind::Orthographic;
        for kind in kinds.filter(is_upright) {
            let mut scene = random_layers(&mut rng, &kind);
            scene.settings.mode = Mode::Average;
            scene.layers[0].region = Region::default();
            let whole = render("cpu", &scene);
            scene.layers[0].region = everywhere();
            let off = f64::from(render("cpu", &scene).max_difference(&whole));
            assert!(off < 1e-4, "{off}: {kind:?}, w {}", scene.settings.slab_width);
            (n_scenes, max) = (n_scenes + 1, max.max(off));
        }
    });
    println!("{n_scenes} scenes: at most {max:.1e}");
}

/// With planes: without any there is nothing to cut.
fn everywhere() -> Region {
    Region::in_box([DVec3::splat(-1e6), DVec3::splat(1e6)]).expect("it ends behind where it starts")
}

/// A volume of `dims` voxels, seen along −z, 4 pixels a voxel; the opacity of a value is a hundredth of it.
fn scene(dims: [usize; 3], value: impl Fn([usize; 3]) -> f64, settings: RenderSettings) -> Scene {
    let grid = Grid::with_spacing(dims, [1.0; 3]).expect("no axis is empty");
    let samples = (0..grid.n_voxels()).map(|i| value(grid.voxel_coords(i))).collect();
    let volume = Volume::new(grid, Samples::F64(samples), Scaling::IDENTITY)
        .expect("there is a sample for every voxel");
    let opacity = vec![(0.0, [0.0]), (100.0, [1.0])];
    let transfer = TransferFunction::new(opacity, vec![(0.0, [1.0; 3])]).expect("the points rise");
    let target = grid.center_in_world();
    let projection = Projection::Orthographic { view_height: 10.0 };
    let camera = Camera::new(target + 50.0 * DVec3::Z, target, DVec3::Y, projection)
        .expect("up is not forward");
    Scene::new(Layer::new(volume, transfer), camera)
        .image(ImageDesc::new(40, 40))
        .settings(settings)
}

/// What has one density everywhere has its opacity, and at the rim, where rays graze it, less: no mode draws
/// a line around a volume whose values are in the middle of the transfer function.
#[test]
fn rims_fade_out() {
    for slab_width in [0.3, 1.0, 1.7] {
        for mode in MODES {
            let settings = exact_settings().mode(mode).slab_width(slab_width);
            let mut even = scene([5, 6, 7], |_| 20.0, settings);
            even.camera = even.camera.orbited(0.3);
            for backend in backends_with(Method::PostClassified) {
                let image = render(backend, &even);
                let most = image.pixels().iter().map(|pixel| pixel[3]).fold(0.0, f32::max);
                let n_seen = image.pixels().iter().filter(|pixel| 0.1 < pixel[3]).count();
                let what = format!("{backend}, {mode}, {slab_width}: {most} {n_seen}");
                assert!((0.1999..0.2001).contains(&most) && 400 < n_seen, "{what}");
            }
        }
    }
}

/// A ramp along the view: the ends and the middle are known, up to what a kernel makes of the ends.
#[test]
fn modes_of_a_ramp() {
    for slab_width in [0.3, 1.0, 1.7] {
        for (mode, expected) in [(Mode::Maximum, 0.7), (Mode::Minimum, 0.2), (Mode::Average, 0.45)]
        {
            let settings = exact_settings().mode(mode).slab_width(slab_width);
            let ramp = scene([9, 9, 26], |[_, _, k]| 20.0 + 2.0 * k as f64, settings);
            let [.., opacity] = render("cpu", &ramp).pixel(20, 20);
            assert!((opacity - expected).abs() < 0.011, "{mode}, {slab_width}: {opacity}");
        }
    }
}

/// A peak has one height, wherever it lies between slabs.
#[test]
fn maximum_does_not_depend_on_where_slabs_are() {
    let heights = |mode: Mode| {
        let along_z = (0..20).map(|step| 0.05 * f64::from(step));
        let heights = along_z.map(|from_voxel| {
            let bump = |[_, _, k]: [usize; 3]| {
                let x = (k as f64 - 10.0 - from_voxel) / 1.5;
                let bump = 80.0 * (-x * x).exp();
                if mode == Mode::Maximum { bump } else { 80.0 - bump }
            };
            let settings = exact_settings().mode(mode);
            render("cpu", &scene([7, 7, 21], bump, settings)).pixel(20, 20)[3]
        });
        heights.fold([f32::INFINITY, f32::NEG_INFINITY], |[lo, hi], h| [lo.min(h), hi.max(h)])
    };
    for (mode, off) in [(Mode::Maximum, 0.0), (Mode::Minimum, 0.8)] {
        let [least, largest] = heights(mode).map(|height| (height - off).abs());
        let [low, high] = [least.min(largest), least.max(largest)];
        // The kernel blurs the bump, which is 0.8 high, to somewhat less.
        assert!(0.6 < low && high < 0.8 && high - low < 0.01, "{mode}: {low} to {high}");
    }
}
