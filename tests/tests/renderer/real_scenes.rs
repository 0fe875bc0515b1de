//! The scenes on real data. Where their volumes are not, the tests say that they were skipped.

use slabsplat::{Frame, OpenScene, Renderer, backend_named, io};

/// Renders a scene at a quarter of its size, if its volume is there.
fn render(name: &str) -> Option<Frame> {
    let file = io::read_scene(&slabsplat_testdata::scene(name)?).expect("the scene is valid");
    let OpenScene { mut scene, .. } = OpenScene::open(&file).expect("its volume is there");
    (scene.image.width, scene.image.height) = (128, 128);
    let backend = backend_named("cpu").expect("the CPU is always there");
    Some(Renderer::new(backend).render(&scene).expect("the scene can be drawn"))
}

fn share_of_pixels(frame: &Frame, is_meant: impl Fn(&[f32; 4]) -> bool) -> f64 {
    let pixels = frame.image.pixels();
    pixels.iter().filter(|pixel| is_meant(pixel)).count() as f64 / pixels.len() as f64
}

/// 1.62 million voxels lie above the foot of the ramp, and what they hide is opaque.
#[test]
fn brain_is_opaque() {
    let Some(frame) = render("brain") else { return };
    assert_eq!(frame.stats.n_voxels, 1_617_157);
    let opaque = share_of_pixels(&frame, |pixel| 0.99 < pixel[3]);
    let empty = share_of_pixels(&frame, |pixel| pixel[3] == 0.0);
    assert!((0.25..0.45).contains(&opaque) && 0.45 < empty, "{opaque} opaque, {empty} empty");
    // Sulci are darker than gyri: where it is opaque, brightness varies.
    let reds: Vec<f64> =
        frame.image.pixels().iter().filter(|p| 0.99 < p[3]).map(|p| p[0].into()).collect();
    let mean = reds.iter().sum::<f64>() / reds.len() as f64;
    let deviation =
        (reds.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / reds.len() as f64).sqrt();
    assert!((0.4..0.8).contains(&mean) && 0.08 < deviation, "mean {mean}, deviation {deviation}");
}

#[test]
fn haze_hides_nothing() {
    let Some(frame) = render("brain-haze") else { return };
    assert!(1_800_000 < frame.stats.n_voxels, "{}", frame.stats.n_voxels);
    assert_eq!(frame.stats.n_saturated_tiles, 0);
    let seen = share_of_pixels(&frame, |pixel| 0.1 < pixel[3]);
    assert!((0.25..0.5).contains(&seen), "{seen}");
}

#[test]
fn embryo_in_perspective() {
    let Some(frame) = render("embryo-perspective") else { return };
    let opaque = share_of_pixels(&frame, |pixel| 0.99 < pixel[3]);
    assert!((0.1..0.5).contains(&opaque), "{opaque}");
}
