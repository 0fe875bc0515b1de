//! The figures and tables of the paper as numbers (model §§2–4), out of the reference renderer and out
//! of every backend.
//!
//! `slabsplat::paper` has their set-up, of which the paper leaves much unsaid.

use slabsplat::paper::{
    self, CubeView, cube, face_means, face_profile, single_voxel, stripes, sum_over_picture,
};
use slabsplat_core::{Compositing, Method, Normalization, Scene};
use slabsplat_tests::reference;
use slabsplat_tests::render::{backends, render};

/// The red channel of a picture, by column and row, and what made it.
struct Picture {
    by: &'static str,
    red: Box<dyn Fn(u32, u32) -> f64>,
}

/// The scene by the reference, and by every backend.
fn pictures(scene: &Scene) -> Vec<Picture> {
    let image = reference::render(scene);
    let by_reference = Picture { by: "reference", red: Box::new(move |x, y| image.pixel(x, y)[0]) };
    let by_backends = backends().iter().map(|by| {
        let image = render(by, scene);
        Picture { by, red: Box::new(move |x, y| image.pixel(x, y)[0].into()) }
    });
    std::iter::once(by_reference).chain(by_backends).collect()
}

/// What tables may cost in a sum over all 4225 pixels of the single voxel: 2·10⁻⁷ each.
const TABLE_SUM: f64 = 8.5e-4;

/// model §2, the table below "Slab hierarchy": half a unit of its last digit.
#[test]
fn single_voxel_normalization() {
    for (normalization, expected) in [
        (Normalization::None, [1.270, 2.330, 2.819]),
        (Normalization::Paper, [1.270, 2.061, 2.397]),
        (Normalization::Product, [1.270, 1.283, 1.286]),
    ] {
        for (slab_width, expected) in [0.5, 1.0, 2.0].into_iter().zip(expected) {
            let settings = paper::settings().slab_width(slab_width).normalization(normalization);
            let voxel = single_voxel(settings);
            let [width, height] = [voxel.image.width, voxel.image.height];
            for Picture { by, red } in pictures(&voxel) {
                let sum = sum_over_picture([width, height], red);
                println!("{by} {normalization} {slab_width}: {sum:.5}, model {expected}");
                let tolerance = if by == "reference" { 5.1e-4 } else { 5.1e-4 + TABLE_SUM };
                let difference = (sum - expected).abs();
                assert!(difference < tolerance, "{by} {normalization} {slab_width}: {sum}");
            }
        }
    }
}

fn figure(method: Method, angle_degrees: f64, slab_width: f64) -> Vec<Picture> {
    let settings = paper::settings().method(method).slab_width(slab_width);
    pictures(&cube(&CubeView { angle_degrees, opacity: 1.0, ambient: 0.0, settings }))
}

/// Of a mean over a face: half a unit of the last digit that the model has, and what tables cost.
const MEAN_ERROR: f64 = 1e-4;

/// Model §4, "Popping in numbers". The window is the whole face, edges included; a pixel more or less of it
/// moves each number by 0.003 to 0.01.
#[test]
fn figures_2_and_6_popping() {
    for (method, [left, right]) in [
        (Method::AxisAligned, [0.9338, 0.3620]),
        (Method::ImageAligned, [0.3193, 0.3188]),
        (Method::EverySample, [0.1265, 0.1207]),
    ] {
        for (angle_degrees, expected) in [(44.9, [left, right]), (45.1, [right, left])] {
            for Picture { by, red } in figure(method, angle_degrees, 1.0) {
                let means = face_means(red);
                let name = format!("{method} {angle_degrees} by {by}");
                println!("{name}: {means:.4?}, model {expected:?}");
                for (mean, expected) in means.into_iter().zip(expected) {
                    assert!((mean - expected).abs() < MEAN_ERROR, "{name}: {means:?}");
                }
            }
        }
    }
}

/// Figure 7: slabs of width 2 leave stripes on a face, slabs of 1 and 0.5 do not. The number is the
/// standard deviation along the face over the mean.
#[test]
fn figure_7_stripes() {
    let [half, one, two] =
        [0.5, 1.0, 2.0].map(|slab_width| figure(Method::ImageAligned, 45.0, slab_width));
    for ((half, one), two) in half.into_iter().zip(one).zip(two) {
        let by = half.by;
        let found = [half, one, two].map(|picture| stripes(&face_profile(picture.red)));
        println!("{by}: stripes at w = 0.5, 1, 2: {found:.4?}");
        let [half, one, two] = found;
        assert!(half < 0.01 && one < 0.01, "{by}: {found:?}");
        assert!(5.0 * one.max(half) < two, "{by}: {found:?}");
    }
}

/// A row of model §3's table of brightness, at w = 0.25, 1 and 2 relative to 0.5.
struct BrightnessRow {
    compositing: Compositing,
    normalization: Normalization,
    expected: [Option<f64>; 3],
}

const BRIGHTNESS: [BrightnessRow; 5] = [
    BrightnessRow {
        compositing: Compositing::Separate,
        normalization: Normalization::None,
        expected: [Some(0.491), Some(2.058), Some(4.219)],
    },
    BrightnessRow {
        compositing: Compositing::Separate,
        normalization: Normalization::Paper,
        expected: [None, Some(1.911), Some(3.564)],
    },
    BrightnessRow {
        compositing: Compositing::Separate,
        normalization: Normalization::Product,
        expected: [None, Some(1.335), Some(1.934)],
    },
    BrightnessRow {
        compositing: Compositing::Associated,
        normalization: Normalization::None,
        expected: [Some(0.978), Some(1.043), Some(1.119)],
    },
    BrightnessRow {
        compositing: Compositing::Extinction,
        normalization: Normalization::None,
        expected: [Some(1.003), Some(0.988), Some(0.946)],
    },
];

/// Half a unit of the last digit that the model has, and what tables cost.
const BRIGHTNESS_ERROR: f64 = 6e-4;

#[test]
fn lit_face_brightness() {
    BRIGHTNESS.iter().for_each(BrightnessRow::check);
}

impl BrightnessRow {
    /// Brightness of the right face at 45°, and in whose picture.
    fn of(&self, slab_width: f64) -> Vec<(&'static str, f64)> {
        let (compositing, normalization) = (self.compositing, self.normalization);
        let settings = paper::settings()
            .slab_width(slab_width)
            .mode(compositing.into())
            .normalization(normalization);
        let angle_degrees = 45.0;
        let view = CubeView { angle_degrees, opacity: 0.5, ambient: 0.1, settings };
        let pictures = pictures(&cube(&view)).into_iter();
        pictures.map(|Picture { by, red }| (by, face_means(red)[1])).collect()
    }

    fn check(&self) {
        let bases = self.of(0.5);
        for (slab_width, expected) in [0.25, 1.0, 2.0].into_iter().zip(self.expected) {
            let Some(expected) = expected else { continue };
            for ((by, brightness), (_, base)) in self.of(slab_width).into_iter().zip(&bases) {
                let ratio = brightness / base;
                let name = format!("{by}, {} + {}", self.compositing, self.normalization);
                println!("{name} {slab_width}: {ratio:.4}, model {expected}");
                let error = (ratio - expected).abs();
                assert!(error < BRIGHTNESS_ERROR, "{name} {slab_width}: {ratio}");
            }
        }
    }
}
