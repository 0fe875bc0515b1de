//! Finished frames, on the CPU.

use super::*;
use crate::Automatic;
use slabsplat_core::{Annotations, Finish, Grid, ImageDesc, RenderSettings, Volume};

const RED: [f32; 4] = [1.0, 0.0, 0.0, 1.0];
const CLEAR: [f32; 4] = [0.0; 4];

/// A translucent ball before nothing.
fn ball(side: u32) -> Scene {
    let grid = Grid::centered([24; 3], [1.0; 3]).unwrap();
    let volume = Volume::from_fn(grid, |at| {
        let squares = at.map(|i| (i as f64 - 11.5).powi(2));
        if squares.iter().sum::<f64>() < 81.0 { 200_u8 } else { 0 }
    });
    let image = ImageDesc::new(side, side).background(CLEAR);
    let mut scene = Automatic::new(volume).scene(image, RenderSettings::default());
    let color = [(0.0, [0.9, 0.5, 0.2])];
    let opacity = [(0.0, 0.0), (200.0, 0.08)];
    scene.layers[0].transfer = slabsplat_core::TransferFunction::new(opacity, color).unwrap();
    scene
}

fn picture(scene: &Scene) -> Picture {
    Renderer::open("cpu", |_| {}).unwrap().picture(scene, Acquisition::default()).unwrap()
}

fn with(scene: &Scene, finish: Finish) -> Scene {
    scene.clone().finish(finish)
}

#[test]
fn picture_of_one_sample_is_the_frame() {
    let scene = ball(40);
    let frame = Renderer::open("cpu", |_| {}).unwrap().render(&scene).unwrap();
    let picture = picture(&scene);
    assert!(picture.frame.image == frame.image && !picture.is_blank);
    assert!(matches!(frame_scene(&scene).unwrap(), Cow::Borrowed(_)));
}

/// How opaque things are does not depend on how many samples there are: within the ball, where nothing has an
/// edge, pixels are the same but for where in them it is sampled.
#[test]
fn picture_samples_leave_opacity() {
    let scene = ball(40);
    let one = picture(&scene).frame.image;
    for samples in [4, 9, 16] {
        let many = picture(&with(&scene, Finish::default().samples(samples))).frame.image;
        assert_eq!([many.width(), many.height()], [40, 40]);
        let mean = |image: &Image| {
            let sum: f64 = image.pixels().iter().map(|pixel| f64::from(pixel[3])).sum();
            sum / 1600.0
        };
        let (mean_one, mean_many) = (mean(&one), mean(&many));
        assert!((mean_one / mean_many - 1.0).abs() < 0.01, "{samples}: {mean_one} {mean_many}");
        let difference = (one.pixel(20, 20)[3] - many.pixel(20, 20)[3]).abs();
        assert!(difference < 0.01 && 0.3 < one.pixel(20, 20)[3], "{samples}: {difference}");
        assert!(1e-3 < one.max_difference(&many), "{samples} samples change edges");
    }
}

#[test]
fn picture_samples_are_averaged_premultiplied() {
    let mut image = Image::filled(4, 2, CLEAR);
    image.pixels_mut()[0] = RED;
    image.pixels_mut()[7] = [0.0, 0.4, 0.0, 0.8];
    let averaged = averaged(image, 2);
    assert_eq!([averaged.width(), averaged.height()], [2, 1]);
    assert_eq!(averaged.pixel(0, 0), [0.25, 0.0, 0.0, 0.25]);
    assert_eq!(averaged.pixel(1, 0), [0.0, 0.1, 0.0, 0.2]);
}

#[test]
fn picture_gradient_is_behind() {
    let mut scene = ball(40);
    scene.image.background = RED;
    let below = [0.0, 0.0, 1.0, 1.0];
    let scene = with(&scene, Finish::default().background_below(below));
    let Picture { frame, is_blank, .. } = picture(&scene);
    let at = |x, y| frame.image.pixel(x, y);
    assert!(0.98 < at(0, 0)[0] && at(0, 0)[2] < 0.02 && !is_blank);
    assert!(0.98 < at(39, 39)[2] && at(39, 39)[0] < 0.02);
    // What is translucent lets it through.
    let clear = picture(&ball(40)).frame.image;
    let behind = [0.4875, 0.0, 0.5125, 1.0];
    for x in [0, 20, 33] {
        for (channel, expected) in at(x, 20).into_iter().zip(over(clear.pixel(x, 20), behind)) {
            assert!((channel - expected).abs() < 1e-6, "{x}: {channel} {expected}");
        }
    }
}

#[test]
fn picture_of_nothing_is_blank_whatever_is_behind() {
    let mut scene = ball(20);
    let none = slabsplat_core::TransferFunction::new([(0.0, 0.0)], [(0.0, [1.0; 3])]).unwrap();
    scene.layers[0].transfer = none;
    scene.image.background = RED;
    assert!(picture(&scene).is_blank);
    let finish = Finish::default().samples(4).background_below([0.0, 1.0, 0.0, 1.0]);
    let finish = finish.annotations(Annotations::default().axes());
    assert!(picture(&with(&scene, finish)).is_blank);
}

#[test]
fn picture_with_too_many_samples_is_an_error() {
    let mut scene = ball(20);
    scene.image.width = 32768;
    scene.image.height = 4096;
    scene.finish.samples = 4;
    let error = Renderer::open("cpu", |_| {}).unwrap().picture(&scene, Acquisition::default());
    let error = error.unwrap_err().to_string();
    assert!(error.starts_with("4 samples for each of 32768 x 4096 pixels take 8.6 GB"), "{error}");
}

#[cfg(feature = "annotations")]
#[test]
fn picture_edges_lie_behind() {
    let scene = ball(200);
    let plain = picture(&scene);
    let annotations = Annotations::default().axes();
    let annotated = picture(&with(&scene, Finish::default().annotations(annotations)));
    let (plain, image) = (plain.frame.image, annotated.frame.image);
    // Where the ball is nearly opaque nothing shines through, and beside it there are lines.
    let n_changed = plain.pixels().iter().zip(image.pixels()).filter(|(a, b)| a != b).count();
    assert!(200 < n_changed, "{n_changed}");
    let opaque = |pixel: &[f32; 4]| pixel[3];
    for (plain, drawn) in plain.pixels().iter().zip(image.pixels()) {
        assert!(opaque(plain) <= opaque(drawn) + 1e-5);
    }
}

#[cfg(not(feature = "annotations"))]
#[test]
fn picture_without_annotations_says_so() {
    let annotations = Annotations::default().scale_bar();
    let picture = picture(&with(&ball(20), Finish::default().annotations(annotations)));
    assert_eq!(picture.notes, ["this program was built without annotations: none are drawn"]);
}
