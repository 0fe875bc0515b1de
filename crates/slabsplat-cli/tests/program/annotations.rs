//! What is drawn on pictures, how they are sampled, and what is behind them.

use crate::{answer, diagnostic, json, slabsplat, text};
use image::{Rgba, RgbaImage};
use std::path::Path;

const SPHERE: &str = "render builtin:sphere:24 --backend cpu --width 240 --height 180";

const ALL: &str = "--title Ball --axes --scale-bar --color-bar --orientation-marker";

fn picture(directory: &Path, flags: &str) -> RgbaImage {
    answer(directory, &format!("{SPHERE} {flags} -o a.png"));
    image::open(directory.join("a.png")).expect("it was written").into_rgba8()
}

fn n_different(a: &RgbaImage, b: &RgbaImage) -> usize {
    assert_eq!(a.dimensions(), b.dimensions());
    a.pixels().zip(b.pixels()).filter(|(a, b)| a != b).count()
}

/// Each flag draws something, somewhere else than the others.
#[test]
fn annotations_are_drawn() {
    let dir = tempfile::tempdir().unwrap();
    // One that is found leaves room for them.
    let camera = "--eye 0,90,0 --target 0,0,0 --up 0,0,1 --view-height 40";
    let plain = picture(dir.path(), camera);
    for (flag, [x, y, width, height]) in [
        ("--title Ball", [60, 0, 120, 40]),
        ("--scale-bar", [160, 140, 80, 40]),
        ("--orientation-marker", [0, 90, 90, 90]),
    ] {
        let drawn = picture(dir.path(), &format!("{camera} {flag}"));
        assert!(20 < n_different(&plain, &drawn), "{flag}");
        for (at_x, at_y, pixel) in drawn.enumerate_pixels() {
            let is_there = (x..x + width).contains(&at_x) && (y..y + height).contains(&at_y);
            assert!(is_there || pixel == plain.get_pixel(at_x, at_y), "{flag} at {at_x}, {at_y}");
        }
    }
    for flag in ["--axes", "--color-bar"] {
        let drawn = picture(dir.path(), &format!("{camera} {flag}"));
        assert!(100 < n_different(&plain, &drawn), "{flag}");
    }
}

/// A picture says what is drawn on it, and is drawn again to the same bits, with flags laid over it.
#[test]
fn annotations_are_of_the_scene() {
    let dir = tempfile::tempdir().unwrap();
    let flags = format!("{ALL} --samples 4 --background white:steelblue");
    let first = picture(dir.path(), &flags);
    answer(dir.path(), "render a.png -o again.png");
    let again = image::open(dir.path().join("again.png")).unwrap().into_rgba8();
    assert_eq!(n_different(&first, &again), 0);
    let scene = answer(dir.path(), "scene a.png");
    for line in ["title = \"Ball\"", "axes = true", "samples = 4", "background_below = ["] {
        assert!(scene.contains(line), "{line} is not in {scene}");
    }
    answer(dir.path(), "render a.png --no-annotations --samples 1 --background black -o plain.png");
    let scene = answer(dir.path(), "scene plain.png");
    assert!(!scene.contains("[annotations]") && scene.contains("samples = 1"), "{scene}");
    assert!(!scene.contains("background_below"), "{scene}");
}

#[test]
fn annotations_that_are_not_drawn_are_told() {
    let dir = tempfile::tempdir().unwrap();
    let warnings = |args: &str| {
        let answer = json(dir.path(), &format!("render {args} --backend cpu --json -o a.png"));
        let warnings = answer["warnings"].as_array().unwrap().iter();
        warnings.map(|warning| warning.as_str().unwrap().to_owned()).collect::<Vec<_>>()
    };
    let small = warnings(&format!("builtin:sphere:12 --width 16 --height 16 {ALL}"));
    for what in ["the scale bar", "the colour bar", "the orientation marker", "the box of axes"] {
        assert!(small.iter().any(|line| line.contains(what)), "{what}: {small:?}");
    }
    let nameless = warnings("builtin:sphere:12 --scale-bar");
    assert!(nameless[0].contains("does not say in which unit"), "{nameless:?}");
    let title = dir.path().join("a.toml");
    std::fs::write(title, "[volume]\ngenerate = \"cube\"\n[annotations]\ntitle = \"漢\"\n")
        .unwrap();
    let expected = "the font of the title has no 漢: boxes are in their place";
    assert_eq!(warnings("a.toml"), [expected]);
}

#[test]
fn annotations_of_odd_pictures() {
    let dir = tempfile::tempdir().unwrap();
    for size in ["--width 3000 --height 20", "--width 1 --height 1", "--width 9 --height 700"] {
        for camera in ["--projection perspective", "--projection orthographic"] {
            answer(dir.path(), &format!("render builtin:cube:8 {ALL} {size} {camera} -o a.png"));
        }
    }
}

#[test]
fn background_by_name_and_as_a_gradient() {
    let dir = tempfile::tempdir().unwrap();
    let corners = |flags: &str| {
        let picture = picture(dir.path(), flags);
        [*picture.get_pixel(0, 0), *picture.get_pixel(239, 179)]
    };
    assert_eq!(corners("--background steelblue"), [Rgba([70, 130, 180, 255]); 2]);
    assert_eq!(corners("--background #ff8000"), [Rgba([255, 128, 0, 255]); 2]);
    assert_eq!(corners("--background 1,0,0"), [Rgba([255, 0, 0, 255]); 2]);
    let [above, below] = corners("--background red:#0000ff");
    assert!(
        250 < above[0] && above[2] < 5 && below[0] < 5 && 250 < below[2],
        "{above:?} {below:?}"
    );
    assert_eq!(corners("--background transparent"), [Rgba([0; 4]); 2]);
}

/// A transparent picture laid on a colour is the picture that was drawn before it.
#[test]
fn background_transparency_is_straight() {
    let dir = tempfile::tempdir().unwrap();
    let flags = "--opacity 0:0,200:0.03 --view front --scale-bar";
    let on_red = picture(dir.path(), &format!("{flags} --background 1,0,0"));
    let clear = picture(dir.path(), &format!("{flags} --background transparent"));
    // The bar's colours depend on what is behind it.
    let rows = 0..120;
    let mut n_translucent = 0;
    for (x, y) in rows.flat_map(|y| (0..240).map(move |x| (x, y))) {
        let Rgba([r, g, b, a]) = *clear.get_pixel(x, y);
        let opacity = f32::from(a) / 255.0;
        n_translucent += usize::from(20 < a && a < 235);
        let expected = [r, g, b].map(f32::from).map(|channel| channel * opacity);
        let behind = [255.0 * (1.0 - opacity), 0.0, 0.0];
        for channel in 0..3 {
            let drawn = f32::from(on_red.get_pixel(x, y)[channel]);
            let laid = expected[channel] + behind[channel];
            assert!((drawn - laid).abs() < 2.5, "{x}, {y}: {drawn} {laid}");
        }
    }
    assert!(1000 < n_translucent, "{n_translucent}");
}

#[test]
fn samples_smooth_edges_and_keep_sizes() {
    let dir = tempfile::tempdir().unwrap();
    let plain = picture(dir.path(), "--background white");
    let smooth = picture(dir.path(), "--background white --samples 9");
    assert!(100 < n_different(&plain, &smooth));
    let largest = plain.pixels().zip(smooth.pixels()).map(|(a, b)| a[1].abs_diff(b[1])).max();
    assert!(largest < Some(100), "{largest:?}");
}

#[test]
fn finish_errors_say_what() {
    let dir = tempfile::tempdir().unwrap();
    let check = |flags: &str, expected: &str| {
        let line = diagnostic(dir.path(), &format!("{SPHERE} {flags} -o a.png"));
        assert!(line.contains(expected), "{line} should contain {expected}");
    };
    check("--samples 0", "samples of a pixel are 1, 4, 9,");
    check("--samples 100", "samples of a pixel are 1, 4, 9,");
    let wide = "render builtin:cube --width 9000 --height 180 --samples 64 -o a.png";
    let line = diagnostic(dir.path(), wide);
    assert!(line.contains("64 samples for each of 9000 x 180 pixels take"), "{line}");
    check("--title=", "a title says something");
    let output = slabsplat(dir.path(), &format!("{SPHERE} --background 2,0,0 -o a.png"));
    assert_eq!(output.status.code(), Some(2));
    let stderr = text(&output.stderr);
    assert!(stderr.contains("red, green, blue and opacity are from 0 to 1"), "{stderr}");
    let output = slabsplat(dir.path(), &format!("{SPHERE} --background nonsense -o a.png"));
    assert_eq!(output.status.code(), Some(2));
    let stderr = text(&output.stderr);
    assert!(stderr.contains("\"nonsense\" is no colour: name one of CSS"), "{stderr}");
}
