//! Several layers of densities (model §§10, 12), on scenes at random: every backend against the float64
//! reference and against the CPU at the tolerances of model §9, and what must not change a picture.

use fastrand::Rng;
use slabsplat::glam::DVec3;
use slabsplat::{
    Camera, Compositing, Grid, Image, ImageDesc, Isosurface, Layer, Method, Mode, Projection,
    Region, RenderSettings, Renderer, Samples, Scaling, Scene, Shading, TransferFunction, Volume,
};
use slabsplat_seeds::{for_each_numbered_seed, for_each_seed};
use slabsplat_tests::exact_settings;
use slabsplat_tests::random_scene::{SceneKind, random_meshes, random_several_layers};
use slabsplat_tests::reference::{ReferenceImage, render_with_undecided};
use slabsplat_tests::render::{backends_in_turn, open, pictures, render};
use std::sync::Arc;

/// What a pixel may differ from the reference at most, and on average over a picture.
const MAX_DIFFERENCE: f64 = 1e-3;
const MEAN_DIFFERENCE: f64 = 1e-4;

/// Of so many scenes one is drawn by a GPU, too, and all by the CPU: drivers that only play a
/// device take longer than all else.
const ONE_IN: usize = 6;

/// What a pixel may differ from that of the CPU backend.
const FROM_CPU: f64 = 1e-3;

/// The part of all pixels that may lie where a ray just touches a surface.
const UNDECIDED: f64 = 0.05;

/// What a picture may differ by of which each part is rounded on its own.
const ROUNDED_TWICE: f32 = 1e-5;

const STATISTICS: [Mode; 3] = [Mode::Maximum, Mode::Minimum, Mode::Average];

fn kinds_of_densities(seed: u64) -> impl Iterator<Item = SceneKind> {
    SceneKind::share(seed).filter(|kind| kind.method == Method::PostClassified)
}

/// What all scenes of a test come to.
#[derive(Debug, Default)]
struct Tally {
    n_scenes: usize,
    n_pixels: usize,
    n_undecided: usize,
    n_seen: usize,
    max: f64,
    mean: f64,
    from_cpu: f64,
}

impl Tally {
    /// Compares pictures of a scene with the reference's, and with the CPU's.
    fn check(&mut self, scene: &Scene, kind: &SceneKind) {
        let (expected, undecided) = render_with_undecided(scene);
        let n_backends = if self.n_scenes.is_multiple_of(ONE_IN) { 2 } else { 1 };
        let backends = backends_in_turn(Method::PostClassified, self.n_scenes / ONE_IN);
        let pictures = pictures(backends.take(n_backends), scene);
        let (_, by_cpu) = &pictures[0];
        for (backend, image) in &pictures {
            let off = expected.clone().leaving(&undecided, image).compare(image);
            let from_cpu = in_64_bits(by_cpu).leaving(&undecided, image).compare(image).max;
            let RenderSettings { mode, slab_width, .. } = scene.settings;
            let what = format!("{backend}, {kind:?}, {mode}, w {slab_width}");
            assert!(off.max < MAX_DIFFERENCE, "{:?} by {}: {what}", off.worst_pixel, off.max);
            assert!(off.mean < MEAN_DIFFERENCE, "pixels are off by {}: {what}", off.mean);
            assert!(from_cpu < FROM_CPU, "{from_cpu} off the CPU: {what}");
            (self.max, self.mean) = (self.max.max(off.max), self.mean.max(off.mean));
            self.from_cpu = self.from_cpu.max(from_cpu);
        }
        let background = scene.image.premultiplied_background();
        self.n_seen += by_cpu.pixels().iter().filter(|pixel| **pixel != background).count();
        self.n_undecided += undecided.into_iter().filter(|is_undecided| *is_undecided).count();
        self.n_pixels += by_cpu.pixels().len();
        self.n_scenes += 1;
    }
}

fn in_64_bits(image: &Image) -> ReferenceImage {
    let pixels = image.pixels().iter().map(|pixel| pixel.map(f64::from)).collect();
    ReferenceImage { width: image.width(), height: image.height(), pixels }
}

impl Drop for Tally {
    fn drop(&mut self) {
        println!("{self:?}");
    }
}

/// Every kernel, compositing, projection and kind of grid.
#[test]
fn parity_of_density_layers() {
    let mut tally = Tally::default();
    for_each_numbered_seed(SceneKind::SHARES, |seed, mut rng| {
        for kind in kinds_of_densities(seed) {
            tally.check(&random_several_layers(&mut rng, &kind), &kind);
        }
    });
}

#[test]
fn parity_of_density_layers_beside_meshes() {
    let mut tally = Tally::default();
    for_each_numbered_seed(SceneKind::SHARES, |seed, mut rng| {
        for kind in kinds_of_densities(seed) {
            let mut scene = random_several_layers(&mut rng, &kind);
            scene.meshes = random_meshes(&mut rng, &kind).meshes;
            tally.check(&scene, &kind);
        }
    });
}

#[test]
fn parity_of_layers_by_one_density() {
    let mut tally = Tally::default();
    for_each_numbered_seed(SceneKind::SHARES, |seed, mut rng| {
        // Modes in turn, and others with each share: all kinds by all modes would take minutes.
        let modes = STATISTICS.into_iter().cycle().skip(seed as usize % STATISTICS.len());
        for (kind, mode) in kinds_of_densities(seed).zip(modes) {
            let mut scene = random_several_layers(&mut rng, &kind);
            scene.settings.mode = mode;
            tally.check(&scene, &kind);
        }
    });
}

#[test]
fn parity_of_isosurfaces_of_layers() {
    let mut tally = Tally::default();
    for_each_numbered_seed(SceneKind::SHARES, |seed, mut rng| {
        for kind in kinds_of_densities(seed) {
            let mut scene = random_several_layers(&mut rng, &kind);
            add_isosurfaces(&mut rng, &mut scene);
            tally.check(&scene, &kind);
        }
    });
    let Tally { n_undecided, n_pixels, n_seen, .. } = tally;
    assert!((n_undecided as f64) < UNDECIDED * n_pixels as f64, "{n_undecided} of {n_pixels}");
    assert!(n_pixels < 10 * n_seen, "{n_seen} of {n_pixels}");
}

/// Up to three of each layer, of the first at least one.
fn add_isosurfaces(rng: &mut Rng, scene: &mut Scene) {
    scene.settings.mode = Mode::Isosurfaces;
    for (idx, layer) in scene.layers.iter_mut().enumerate() {
        let volume = &layer.volume;
        let values = (0..volume.grid().n_voxels()).map(|i| volume.value(i));
        let [lo, hi] = values
            .filter(|v| v.is_finite())
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], v| [lo.min(v), hi.max(v)]);
        let least = usize::from(idx == 0);
        let surfaces = (0..rng.usize(least..=3)).map(|_| {
            let color = rng.bool().then(|| [0; 3].map(|_| rng.f64()));
            let opacity = if rng.bool() { 1.0 } else { rng.f64() };
            isosurface(lo + (hi - lo) * (0.1 + 0.8 * rng.f64()), opacity, color)
        });
        layer.isosurfaces = surfaces.collect();
    }
}

fn isosurface(value: f64, opacity: f64, color: Option<[f64; 3]>) -> Isosurface {
    Isosurface::new(value, opacity, color).expect("a number, and shares of one")
}

/// Nor does it matter by which of the methods that have them modes of densities are drawn.
#[test]
fn order_of_density_layers_changes_no_bit() {
    for_each_seed(1, |mut rng| {
        let kinds = SceneKind::all().into_iter();
        let kinds = kinds.filter(|kind| kind.method == Method::PostClassified).step_by(4);
        for kind in kinds {
            let mut scene = random_several_layers(&mut rng, &kind);
            scene.settings.tolerance = [0.0, 0.05][rng.usize(..2)];
            let composited = scene.settings.mode;
            add_isosurfaces(&mut rng, &mut scene);
            for mode in [composited, Mode::Isosurfaces].into_iter().chain(STATISTICS) {
                scene.settings.mode = mode;
                let expected = render("cpu", &scene);
                rng.shuffle(&mut scene.layers);
                scene.layers.iter_mut().for_each(|layer| layer.isosurfaces.reverse());
                if mode.compositing().is_none() {
                    let settings = scene.settings.clone().method(Method::ImageAligned);
                    let scene = scene.clone().settings(settings);
                    assert!(render("cpu", &scene) == expected, "{mode} {kind:?}");
                }
                assert!(render("cpu", &scene) == expected, "{mode} {kind:?}");
            }
        }
    });
}

/// What was drawn before leaves no trace, whichever layers it had and whatever it showed of them.
#[test]
fn density_layers_come_and_go() {
    for_each_seed(1, |mut rng| {
        let mut renderer = Renderer::new(open("cpu"));
        let kinds = SceneKind::all().into_iter();
        for kind in kinds.filter(|kind| kind.method == Method::PostClassified).step_by(11) {
            let mut scene = random_several_layers(&mut rng, &kind);
            let composited = scene.settings.mode;
            add_isosurfaces(&mut rng, &mut scene);
            let modes = [composited, Mode::Isosurfaces, Mode::Average, Mode::Maximum];
            for mode in modes {
                scene.settings.mode = mode;
                let alone = scene.clone().layers(vec![scene.layers[0].clone()]);
                for scene in [&scene, &alone, &scene] {
                    let image = renderer.render(scene).expect("the scene is valid").image;
                    assert!(image == render("cpu", scene), "{mode} {kind:?}");
                }
            }
        }
    });
}

/// What a region takes its complement brings back, if its faces are not lit.
#[test]
fn densities_of_region_and_complement_are_the_whole() {
    let mut worst = 0.0_f32;
    for_each_numbered_seed(SceneKind::SHARES, |seed, mut rng| {
        let are_extinct = |kind: &SceneKind| kind.compositing == Compositing::Extinction;
        for kind in kinds_of_densities(seed).filter(are_extinct) {
            let mut scene = random_several_layers(&mut rng, &kind);
            let lit = std::mem::take(&mut scene.layers[0].region);
            let region = Region::new(lit.planes().to_vec());
            let [first, ..] = &*scene.layers else { continue };
            let halves =
                [region.clone(), region.inverted()].map(|region| first.clone().region(region));
            let layers = halves.into_iter().chain(scene.layers[1..].iter().cloned());
            let in_halves = scene.clone().layers(layers.collect());
            let difference = render("cpu", &in_halves).max_difference(&render("cpu", &scene));
            assert!(difference < ROUNDED_TWICE, "{difference}: {kind:?}");
            worst = worst.max(difference);
        }
    });
    println!("at most {worst:.1e}");
}

/// A layer of which nothing is seen, on the same grid, changes nothing.
#[test]
fn density_layer_beside_nothing_is_alone() {
    let mut worst = 0.0_f32;
    for_each_seed(1, |mut rng| {
        let kinds = SceneKind::all().into_iter();
        for kind in kinds.filter(|kind| kind.method == Method::PostClassified).step_by(7) {
            let mut scene = random_several_layers(&mut rng, &kind);
            scene.layers.truncate(1);
            let composited = scene.settings.mode;
            add_isosurfaces(&mut rng, &mut scene);
            let mut nothing = scene.layers[0].clone();
            let positions: Vec<f64> = nothing.transfer.positions().collect();
            nothing.transfer = TransferFunction::new(
                vec![(positions[0], [0.0])],
                nothing.transfer.color_points().points().to_vec(),
            )
            .expect("a point");
            nothing.isosurfaces = Vec::new();
            for mode in [composited, Mode::Isosurfaces].into_iter().chain(STATISTICS) {
                scene.settings.mode = mode;
                let layers = vec![nothing.clone(), scene.layers[0].clone()];
                let beside = render("cpu", &scene.clone().layers(layers));
                let difference = beside.max_difference(&render("cpu", &scene));
                assert!(difference < ROUNDED_TWICE, "{difference}: {mode} {kind:?}");
                worst = worst.max(difference);
            }
        }
    });
    println!("at most {worst:.1e}");
}

/// A tolerance of all layers together is one of the picture. Where a volume ends may move by a third of a
/// voxel (docs/numerics.md, "Separable footprints"), which is more than a pixel here: a pixel is beyond the
/// tolerance if it is beyond that of all pixels next to it.
#[test]
fn tolerance_of_density_layers() {
    let tolerance = RenderSettings::default().tolerance;
    let (mut n_pixels, mut n_beyond, mut worst_mean) = (0, 0, 0.0_f64);
    for_each_numbered_seed(SceneKind::SHARES, |seed, mut rng| {
        for kind in kinds_of_densities(seed) {
            let mut scene = random_several_layers(&mut rng, &kind);
            (scene.image.width, scene.image.height) = (70, 50);
            scene.layers.iter_mut().for_each(|layer| layer.shading = Shading::None);
            let exact = render("cpu", &scene);
            let settings = scene.settings.clone().tolerance(tolerance);
            let image = render("cpu", &scene.clone().settings(settings));
            let n_beyond_here = n_beyond_neighbors(&image, &exact, tolerance as f32);
            let mean = image.mean_difference(&exact);
            assert_eq!(n_beyond_here, 0, "{kind:?}");
            assert!(mean <= 0.1 * tolerance, "{mean}: {kind:?}");
            n_pixels += exact.pixels().len();
            n_beyond += n_beyond_here;
            worst_mean = worst_mean.max(mean);
        }
    });
    println!("{n_beyond} of {n_pixels} pixels beyond, means of {worst_mean:.1e} at most");
}

/// How many pixels have a channel outside of what the exact picture has there and around it.
fn n_beyond_neighbors(image: &Image, exact: &Image, tolerance: f32) -> usize {
    let around = |at: u32, len: u32| at.saturating_sub(1)..=(at + 1).min(len - 1);
    let is_beyond = |x: u32, y: u32, channel: usize| {
        let neighbors = around(y, exact.height())
            .flat_map(|y| around(x, exact.width()).map(move |x| exact.pixel(x, y)[channel]));
        let [low, high] = neighbors
            .fold([f32::INFINITY, f32::NEG_INFINITY], |[lo, hi], v| [lo.min(v), hi.max(v)]);
        !(low - tolerance..=high + tolerance).contains(&image.pixel(x, y)[channel])
    };
    let all = (0..image.height()).flat_map(|y| (0..image.width()).map(move |x| (x, y)));
    all.filter(|&(x, y)| (0..4).any(|channel| is_beyond(x, y, channel))).count()
}

/// A layer that is the same everywhere: of this opacity and grey.
fn medium(opacity: f64, gray: f64) -> Layer {
    let grid = Grid::with_spacing([9, 9, 9], [1.0; 3]).expect("no axis is empty");
    let samples = Samples::F64(vec![1.0; grid.n_voxels()]);
    let volume = Volume::new(grid, samples, Scaling::IDENTITY).expect("one sample a voxel");
    let transfer = TransferFunction::new(vec![(0.0, [opacity])], vec![(0.0, [gray; 3])]);
    Layer::new(volume, transfer.expect("an opacity and a grey")).shading(Shading::None)
}

/// Looks along −z at the middle of such layers, slabs of two voxels' width.
fn scene(layers: Vec<Layer>, mode: Mode) -> Scene {
    let target = layers[0].volume.grid().center_in_world();
    let projection = Projection::Orthographic { view_height: 4.0 };
    let camera = Camera::new(target + 50.0 * DVec3::Z, target, DVec3::Y, projection)
        .expect("up is not forward");
    let settings = exact_settings().method(Method::PostClassified).mode(mode).slab_width(2.0);
    Scene::new(layers[0].clone(), camera)
        .layers(layers)
        .image(ImageDesc::new(8, 8))
        .settings(settings)
}

/// Red and opacity of the pixel in the middle.
fn middle(image: &Image) -> [f64; 2] {
    let [red, .., opacity] = image.pixel(4, 4).map(f64::from);
    [red, opacity]
}

/// Two media in each other are one of the sum of both, as the compositing means it.
#[test]
fn media_in_each_other_by_hand() {
    let check = |mode: Mode, one: Layer| {
        let both = vec![medium(0.3, 0.2), medium(0.2, 0.9)];
        let [joined, expected] =
            [both, vec![one]].map(|layers| middle(&render("cpu", &scene(layers, mode))));
        for (a, b) in joined.into_iter().zip(expected) {
            assert!((a - b).abs() < 1e-5, "{mode}: {joined:?}, not {expected:?}");
        }
    };
    let [a, b] = [0.3_f64, 0.2].map(|opacity| -(1.0 - opacity).ln());
    let mixed = (a * 0.2 + b * 0.9) / (a + b);
    check(Mode::Extinction, medium(0.44, mixed));
    check(Mode::Associated, medium(0.5, (0.06 + 0.18) / 0.5));
    check(Mode::Separate, medium(0.5, (0.06 + 0.18) / 0.5));
    for mode in STATISTICS {
        check(mode, medium(0.44, mixed));
    }
}

/// Slabs are as thin as the finest voxels want them.
#[test]
fn density_layer_of_huge_voxels_is_seen() {
    let mut fine = medium(0.5, 1.0);
    let grid = Grid::with_spacing([3, 3, 3], [1e-3; 3]).expect("no axis is empty");
    let volume = Volume::new(grid, Samples::F64(vec![1.0; 27]), Scaling::IDENTITY);
    fine.volume = Arc::new(volume.expect("one sample a voxel"));
    for mode in [Mode::Extinction, Mode::Average] {
        let mut alone = scene(vec![medium(0.05, 0.5)], mode);
        alone.settings.tolerance = RenderSettings::default().tolerance;
        let layers = vec![medium(0.05, 0.5), fine.clone()];
        let both = scene(layers, mode).settings(alone.settings.clone());
        let [expected, opacity] = [alone, both].map(|scene| middle(&render("cpu", &scene))[1]);
        assert!((opacity - expected).abs() < 0.01, "{mode}: {opacity}, not {expected}");
    }
}

/// Surfaces at one position are in one order all over, whichever layer comes first in the scene.
#[test]
fn isosurfaces_at_one_depth_do_not_flicker() {
    let grid = Grid::with_spacing([12, 12, 12], [1.0; 3]).expect("no axis is empty");
    let middle = grid.center_in_world();
    let value = |idx: usize| {
        100.0 - 10.0 * DVec3::from_array(grid.voxel_coords(idx).map(|c| c as f64)).distance(middle)
    };
    let samples = Samples::F64((0..grid.n_voxels()).map(value).collect());
    let volume = Volume::new(grid, samples, Scaling::IDENTITY).expect("one sample a voxel");
    let volume = Arc::new(volume);
    let transfer = TransferFunction::new(vec![(0.0, [1.0])], vec![(0.0, [1.0; 3])]);
    let transfer = transfer.expect("a point each");
    let layer = |color| {
        Layer::new(volume.clone(), transfer.clone())
            .shading(Shading::None)
            .isosurfaces(vec![isosurface(60.0, 1.0, Some(color))])
    };
    let layers = vec![layer([1.0, 0.0, 0.0]), layer([0.0, 1.0, 0.0])];
    let mut scene = scene(layers, Mode::Isosurfaces);
    scene.camera = scene.camera.orbited(20.0);
    let image = render("cpu", &scene);
    scene.layers.reverse();
    assert!(render("cpu", &scene) == image);
    let colors = [[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0]];
    let n_of = colors.map(|color| image.pixels().iter().filter(|pixel| **pixel == color).count());
    assert!(n_of == [64, 0] || n_of == [0, 64], "{n_of:?}");
}
