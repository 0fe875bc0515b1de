//! Layers and regions (model §§10, 11), on scenes at random: every backend that has the method against the
//! float64 reference and against the CPU at the tolerances of model §9, and what must not change a picture.

use fastrand::Rng;
use slabsplat::{
    Compositing, Image, Layer, Method, Normalization, Region, Scene, Shading, TransferFunction,
};
use slabsplat_seeds::{for_each_numbered_seed, for_each_seed};
use slabsplat_tests::parity::WithinTolerance;
use slabsplat_tests::random_scene::{SceneKind, random_layers, random_scene};
use slabsplat_tests::reference::{self, Difference, ReferenceImage, undecided_pixels};
use slabsplat_tests::render::{backends, backends_in_turn, backends_with, pictures, render};

/// The part of a tolerance that the CPU backend may use up with simpler footprints: the most on sheared
/// grids, cut or not.
const SHARE_OF_FOOTPRINTS: f64 = 0.2;

/// What a pixel may differ from the reference at most, and on average over a picture.
const MAX_DIFFERENCE: f64 = 1e-3;
const MEAN_DIFFERENCE: f64 = 1e-4;

/// What a pixel may differ from that of the CPU backend.
const FROM_CPU: f64 = 1e-3;

/// What a picture may differ by of which each part is rounded on its own.
const ROUNDED_TWICE: f32 = 1e-5;

/// Of so many scenes one is drawn by a GPU, too, and all by the CPU: drivers that only play a device take
/// longer than all else.
const ONE_IN: usize = 2;

/// Up to three layers, by every kernel, compositing, normalisation and projection.
#[test]
fn parity_of_layers() {
    check_parity(Method::ImageAligned);
}

/// One layer of densities, cut.
#[test]
fn parity_of_cut_densities() {
    check_parity(Method::PostClassified);
}

fn check_parity(method: Method) {
    let mut tallies: Vec<(&str, Tally)> =
        backends_with(method).map(|backend| (backend, Tally::default())).collect();
    for_each_numbered_seed(SceneKind::SHARES, |seed, mut rng| {
        let kinds = SceneKind::share(seed).filter(|kind| kind.method == method);
        for (number, kind) in kinds.step_by(2).enumerate() {
            let scene = random_layers(&mut rng, &kind);
            let expected = reference::render(&scene);
            let undecided = undecided_pixels(&scene);
            let n_backends = if number.is_multiple_of(ONE_IN) { 2 } else { 1 };
            let backends = backends_in_turn(method, number / ONE_IN).take(n_backends);
            let pictures = pictures(backends, &scene);
            let by_cpu = in_64_bits(&pictures[0].1);
            for (backend, image) in &pictures {
                let compare = |expected: &ReferenceImage| {
                    expected.clone().leaving(&undecided, image).compare(image)
                };
                let (off, from_cpu) = (compare(&expected), compare(&by_cpu).max);
                let what = format!("{backend}, {}", what(&kind, &scene));
                let Difference { max, mean, worst_pixel, .. } = off;
                assert!(max < MAX_DIFFERENCE, "{worst_pixel:?} is off by {max}: {what}");
                assert!(mean < MEAN_DIFFERENCE, "pixels are off by {mean}: {what}");
                assert!(from_cpu < FROM_CPU, "{from_cpu} off the CPU: {what}");
                let tally = tallies.iter_mut().find(|(name, _)| name == backend);
                let tally = &mut tally.expect("it has a tally").1;
                tally.add(&off, from_cpu);
                tally.n_undecided += undecided.iter().filter(|is_undecided| **is_undecided).count();
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
    n_undecided: usize,
    max: f64,
    mean: f64,
    from_cpu: f64,
}

impl Tally {
    fn add(&mut self, off: &Difference, from_cpu: f64) {
        self.n_scenes += 1;
        self.max = self.max.max(off.max);
        self.mean = self.mean.max(off.mean);
        self.from_cpu = self.from_cpu.max(from_cpu);
    }
}

fn in_64_bits(image: &Image) -> ReferenceImage {
    let pixels = image.pixels().iter().map(|pixel| pixel.map(f64::from)).collect();
    ReferenceImage { width: image.width(), height: image.height(), pixels }
}

fn what(kind: &SceneKind, scene: &Scene) -> String {
    let regions: Vec<&Region> = scene.layers.iter().map(|layer| &layer.region).collect();
    format!("{kind:?}, w {}, {regions:?}", scene.settings.slab_width)
}

/// What a region takes its complement brings back, if its faces are not lit.
#[test]
fn region_and_complement_are_the_whole() {
    let mut worst = 0.0_f32;
    for_each_numbered_seed(SceneKind::SHARES, |seed, mut rng| {
        let are_extinct = |kind: &SceneKind| {
            kind.method == Method::ImageAligned && kind.compositing == Compositing::Extinction
        };
        for (number, kind) in SceneKind::share(seed).filter(are_extinct).enumerate() {
            let scene = random_scene(&mut rng, &kind);
            let lit = random_layers(&mut rng, &kind).layers.swap_remove(0).region;
            let region = Region::new(lit.planes().to_vec());
            let layer = &scene.layers[0];
            let parts =
                [region.clone(), region.inverted()].map(|region| layer.clone().region(region));
            let parts = scene.clone().layers(parts.to_vec());
            let n_backends = if number.is_multiple_of(ONE_IN) { 2 } else { 1 };
            for backend in backends_in_turn(kind.method, number / ONE_IN).take(n_backends) {
                let difference = render(backend, &parts).max_difference(&render(backend, &scene));
                let what = what(&kind, &parts);
                assert!(difference < ROUNDED_TWICE, "{difference} by {backend}: {what}");
                worst = worst.max(difference);
            }
        }
    });
    println!("at most {worst:.1e}");
}

#[test]
fn order_of_layers_changes_no_bit() {
    for_each_seed(1, |mut rng| {
        let has_layers = |kind: &SceneKind| kind.method == Method::ImageAligned;
        // Every 16th, and another one of 16 with each seed: none is more likely to depend on an order.
        let first = rng.usize(..16);
        for kind in SceneKind::all().into_iter().filter(has_layers).skip(first).step_by(16) {
            let mut scene = random_layers(&mut rng, &kind);
            scene.settings.tolerance = [0.0, 0.05][rng.usize(..2)];
            for backend in backends() {
                let expected = render(backend, &scene);
                for _ in 0..2 {
                    rng.shuffle(&mut scene.layers);
                    assert!(
                        render(backend, &scene) == expected,
                        "{backend}, {}",
                        what(&kind, &scene)
                    );
                }
            }
        }
    });
}

/// All layers together may be off by no more than the tolerance of the picture, cut or not; and every backend
/// merges what the definition says.
#[test]
fn tolerance_of_layers() {
    let (mut worst, mut worst_from_exact) = (0.0_f64, 0.0_f64);
    for_each_numbered_seed(SceneKind::SHARES, |seed, mut rng| {
        let merges = |kind: &SceneKind| {
            kind.method == Method::ImageAligned
                && kind.compositing == Compositing::Extinction
                && kind.normalization == Normalization::None
        };
        let kinds = SceneKind::share(seed).filter(merges);
        let kinds = kinds.flat_map(|kind| [1e-3, 0.05].map(|t| (kind, t)));
        for (number, (kind, tolerance)) in kinds.enumerate() {
            let mut scene = random_layers(&mut rng, &kind);
            (scene.image.width, scene.image.height) = (16, 16);
            scene.settings.tolerance = tolerance;
            if rng.bool() {
                scene.layers.iter_mut().for_each(|layer| make_haze(&mut rng, layer));
            }
            let what = what(&kind, &scene);
            let (within, undecided) = (WithinTolerance::new(&scene), undecided_pixels(&scene));
            for backend in backends_in_turn(Method::ImageAligned, number) {
                let drawn = (backend, &render(backend, &scene));
                let [merged, exact] = within.check(drawn, &undecided, SHARE_OF_FOOTPRINTS, &what);
                worst = worst.max(merged / tolerance);
                worst_from_exact = worst_from_exact.max(exact / tolerance);
            }
        }
    });
    println!("{worst:.2} tolerances from what merges, {worst_from_exact:.2} from exact");
}

/// A haze of colours as far apart as can be, which change at one of its values.
fn make_haze(rng: &mut Rng, layer: &mut Layer) {
    let alpha = 0.1 * rng.f64();
    let value = layer.transfer.positions().next().expect("a function has points");
    let color = vec![(value, [0.0; 3]), (value, [1.0; 3])];
    layer.transfer =
        TransferFunction::new(vec![(value, [alpha])], color).expect("both points are sorted");
    layer.shading = Shading::None;
}
