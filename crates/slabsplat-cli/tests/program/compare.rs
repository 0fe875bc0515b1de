//! `slabsplat compare`.

use crate::{answer, diagnostic, json, names_in, slabsplat, text};
use slabsplat::{ImageDesc, RenderSettings};

const SMALL: &str = "builtin:cube --width 40 --height 30 --backend cpu";

#[test]
fn compare_figures_are_those_of_the_pictures() {
    let dir = tempfile::tempdir().unwrap();
    let args = format!("compare {SMALL} --vary slab-width=1,2 --panes here --json");
    let report = json(dir.path(), &args);
    assert_eq!(report["reference"], "slab_width 1");
    let [same, other] = [0, 1].map(|idx| &report["compared"][idx]);
    assert_eq!(same["largest"], 0.0);
    assert!(same["psnr_db"].is_null(), "a picture has no distance from itself: {same}");
    assert_eq!(other["settings"]["slab_width"], "2");
    let expected = ["slab_width-1-difference.png", "slab_width-1.png"]
        .into_iter()
        .chain(["slab_width-2-difference.png", "slab_width-2.png"]);
    let here = dir.path().join("here");
    assert!(names_in(&here).iter().map(String::as_str).eq(expected), "{:?}", names_in(&here));
    // From the pictures, which are opaque and have 8 bits.
    let read = |name: &str| image::open(here.join(name)).unwrap().to_rgb8().into_raw();
    let (a, b) = (read("slab_width-1.png"), read("slab_width-2.png"));
    let difference = |(a, b): (&u8, &u8)| (f64::from(*a) - f64::from(*b)).abs() / 255.0;
    let squares: f64 = a.iter().zip(&b).map(difference).map(|d| d * d).sum();
    let psnr = -10.0 * (squares / a.len() as f64).log10();
    let found = other["psnr_db"].as_f64().unwrap();
    assert!((found - psnr).abs() < 0.5, "{found} dB, {psnr} dB by bytes");
    let largest = a.iter().zip(&b).map(difference).fold(0.0, f64::max);
    assert!((other["largest"].as_f64().unwrap() - largest).abs() < 0.01, "{other}, {largest}");
    let gain = report["gain"].as_f64().unwrap();
    assert!((0.3..=1.001).contains(&(gain * largest)), "the scale is filled: {gain}, {largest}");
}

/// A sheet says which scene it compares, and each picture by itself what it shows.
#[test]
fn compare_pictures_are_made_again() {
    let dir = tempfile::tempdir().unwrap();
    let vary = "--vary slab-width=1,2 --json";
    let first = json(dir.path(), &format!("compare {SMALL} -o a.png --panes here {vary}"));
    let again = json(dir.path(), &format!("compare a.png -o b.png {vary}"));
    let largest = |report: &serde_json::Value| report["compared"][1]["largest"].clone();
    assert_eq!(largest(&first), largest(&again));
    let pixels = |name: &str| image::open(dir.path().join(name)).unwrap().into_rgba8();
    assert!(pixels("a.png") == pixels("b.png"));
    answer(dir.path(), "render here/slab_width-2.png -o again.png");
    assert!(pixels("here/slab_width-2.png") == pixels("again.png"));
    answer(dir.path(), &format!("compare {SMALL} -o c.png --no-metadata {vary}"));
    let error = diagnostic(dir.path(), "scene c.png");
    assert!(error.contains("a picture that does not say what it shows"), "{error}");
}

/// Empty pictures are equal, and that is not all that is said of them.
#[test]
fn compare_of_nothing_says_so() {
    let dir = tempfile::tempdir().unwrap();
    let args = format!("compare {SMALL} --vary slab-width=1,2 --opacity 0:0");
    let stderr = text(&slabsplat(dir.path(), &args).stderr);
    for width in [1, 2] {
        let expected =
            format!("warning: slab_width {width}: nothing is visible: the opacity of all values");
        assert!(stderr.contains(&expected), "{stderr}");
    }
}

#[test]
fn compare_sheet_of_methods() {
    let dir = tempfile::tempdir().unwrap();
    let text = answer(dir.path(), &format!("compare {SMALL} -o sheet.png --popping"));
    for method in ["image-aligned", "axis-aligned", "every-sample", "post-classified"] {
        let line = text.lines().find(|line| line.starts_with(method)).unwrap();
        let ratio = line.split_whitespace().rev().nth(1).unwrap();
        assert!(ratio.parse::<f64>().is_ok_and(|ratio| 1.0 <= ratio), "{line}");
    }
    let sheet = image::open(dir.path().join("sheet.png")).unwrap();
    assert!(4 * 40 < sheet.width() && 2 * 30 < sheet.height());
    assert!(sheet.to_rgba8().pixels().all(|pixel| pixel.0[3] == 255), "it suits any page");
}

/// What cannot be drawn says why, and the others are drawn.
#[test]
fn compare_draws_what_it_can() {
    let dir = tempfile::tempdir().unwrap();
    let args =
        format!("compare {SMALL} --vary kernel=gaussian,none,crawfis-max -o sheet.png --json");
    let report = json(dir.path(), &args);
    let error = |idx: usize| &report["compared"][idx]["error"];
    assert!(error(0).is_null() && error(2).is_null(), "{report}");
    assert!(error(1).as_str().unwrap().contains("there is no kernel \"none\""), "{report}");
    assert!(report["compared"][1]["largest"].is_null());
    let why = diagnostic(dir.path(), &format!("compare {SMALL} --vary kernel=none,gaussian"));
    assert!(why.contains("the reference, kernel none, cannot be drawn"), "{why}");
    let by =
        format!("compare {SMALL} --vary kernel=none,gaussian --reference kernel=gaussian --json");
    assert_eq!(json(dir.path(), &by)["reference"], "kernel gaussian");
}

#[test]
fn compare_mistakes() {
    let dir = tempfile::tempdir().unwrap();
    let check = |args: &str, expected: &str| {
        let error = diagnostic(dir.path(), &format!("compare {SMALL} {args}"));
        assert!(error.contains(expected), "{args}: {error}");
    };
    check("--vary slab_width=1,2 --reference slab_width=3", "none of what is compared");
    check("--vary slab_width=1 --vary slab-width=2", "slab_width is varied twice");
    check(
        "--vary sections=16,17,18,19,20,21,22,23,24 --vary ambient=0,.1,.2,.3,.4,.5,.6,.7",
        "72 combinations",
    );
    check("-o sheet.bmp", "sheet.bmp");
    check("-o no/sheet.png", "there is no folder no");
    let large = "compare builtin:cube --width 8192 --height 8192 --backend cpu -o sheet.png";
    let error = diagnostic(dir.path(), large);
    assert!(error.contains("a sheet of 4 pictures needs smaller pictures"), "{error}");
    assert!(names_in(dir.path()).is_empty(), "nothing is written");
    assert!(ImageDesc::new(8192, 8192).checked().is_ok());
    for args in ["--vary slab_width=0", "--vary width=2", "--vary slab_width", "--gain 0"] {
        let output = slabsplat(dir.path(), &format!("compare {SMALL} {args}"));
        assert_eq!(output.status.code(), Some(2), "{args}: {}", text(&output.stderr));
    }
}

/// The default of what is varied stays as it is in a scene of its own.
#[test]
fn compare_with_default_is_the_same() {
    let dir = tempfile::tempdir().unwrap();
    let tolerance = RenderSettings::default().tolerance;
    let report = json(
        dir.path(),
        &format!("compare {SMALL} --vary tolerance={tolerance},0 --tolerance 0.5 --json"),
    );
    assert_eq!(report["reference"], format!("tolerance {tolerance}"));
}
