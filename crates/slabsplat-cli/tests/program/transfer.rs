//! Transfer functions by flags, in and out of files: `--preset`, `--window` and their kin, `presets`, `tf`.

use crate::{answer, diagnostic, json, names_in, slabsplat, text};
use slabsplat::io::{COLORMAP_NAMES, PRESET_NAMES};
use std::path::Path;

/// A slab of values from −1000 to 1000, as Hounsfield units.
fn write_ct(folder: &Path) {
    let header = "NRRD0004\ntype: int16\ndimension: 3\nsizes: 8 8 21\nencoding: ascii\n\n";
    let values = (0..21).map(|z| format!("{} ", 100 * z - 1000).repeat(64));
    let text = header.to_owned() + &values.collect::<String>();
    std::fs::write(folder.join("ct.nrrd"), text).expect("the folder can be written");
}

/// What a line of warnings holds; the command succeeds.
fn warnings(folder: &Path, args: &str) -> String {
    let output = slabsplat(folder, args);
    let stderr = text(&output.stderr);
    assert!(output.status.success(), "{args}: {stderr}");
    stderr.lines().filter(|line| line.starts_with("warning: ")).collect()
}

#[test]
fn presets_are_listed() {
    let list = answer(Path::new("."), "presets");
    let known = json(Path::new("."), "presets --json");
    let help = answer(Path::new("."), "render --help");
    for (idx, name) in PRESET_NAMES.iter().enumerate() {
        assert!(list.contains(name) && help.contains(name), "{name}");
        assert_eq!(known[idx]["name"], *name);
        assert!(known[idx]["opacity"].as_array().is_some_and(|points| 1 < points.len()), "{name}");
    }
    for name in COLORMAP_NAMES {
        assert!(help.contains(name), "{name}");
    }
}

#[test]
fn tf_converts_there_and_back() {
    let dir = tempfile::tempdir().unwrap();
    let folder = dir.path();
    write_ct(folder);
    answer(folder, "tf --preset ct-bone -o bone.json");
    answer(folder, "tf bone.json -o bone.vp");
    answer(folder, "tf bone.vp -o bone.toml");
    let points = json(folder, "tf --preset ct-bone --json");
    let again = json(folder, "tf bone.vp --json");
    assert_eq!(again["color"], points["color"]);
    let opacity = |points: &serde_json::Value, value: f64| {
        let points = points["opacity"].as_array().expect("there are points");
        let point =
            points.iter().find(|point| point[0].as_f64() == Some(value)).expect("it is there");
        point[1].as_f64().expect("it is a number")
    };
    for value in [150.0, 300.0, 500.0, 1500.0] {
        assert!((opacity(&again, value) - opacity(&points, value)).abs() < 1e-9, "at {value}");
    }
    // The section is one that a scene may have.
    let section = std::fs::read_to_string(folder.join("bone.toml")).unwrap();
    let scene = format!("[volume]\npath = \"ct.nrrd\"\n{section}");
    std::fs::write(folder.join("scene.toml"), scene).unwrap();
    assert_eq!(json(folder, "tf scene.toml --json"), again);
}

#[test]
fn tf_draws_over_the_volume() {
    let dir = tempfile::tempdir().unwrap();
    write_ct(dir.path());
    answer(dir.path(), "tf ct.nrrd --preset ct-bone -o a.png --width 200 --height 150");
    let png = std::fs::read(dir.path().join("a.png")).unwrap();
    assert_eq!(&png[16..24], [0, 0, 0, 200, 0, 0, 0, 150], "width and height");
    let drawing = answer(dir.path(), "tf ct.nrrd --window -200:800");
    let ends =
        drawing.lines().find(|line| line.trim().starts_with("-1000")).expect("there is an axis");
    assert!(ends.trim().ends_with("1000") && drawing.contains('*'), "{drawing}");
    assert!(drawing.contains("-200 ") && drawing.contains("800 "), "{drawing}");
}

/// Flags and the keys of a scene are one thing.
#[test]
fn flags_are_keys() {
    let dir = tempfile::tempdir().unwrap();
    write_ct(dir.path());
    let map = r#"[{"RGBPoints": [0, 0, 0, 1, 1, 1, 0, 0], "ColorSpace": "Diverging"}]"#;
    std::fs::write(dir.path().join("map.json"), map).unwrap();
    for (flags, keys) in [
        ("--preset ct-bone", "preset = \"ct-bone\""),
        ("--preset mr-t1 --percentile 5:95", "preset = \"mr-t1\"\npercentile = [5, 95]"),
        ("--colormap magma_r --window -10:90", "colormap = \"magma_r\"\nwindow = [-10, 90]"),
        ("--window 0:500 --opacity-scale 0.25", "window = [0, 500]\nopacity_scale = 0.25"),
        ("--transfer-file map.json --unit-distance 3", "file = \"map.json\"\nunit_distance = 3"),
        ("--opacity 0:0,9:1 --colormap hot", "opacity = [[0, 0], [9, 1]]\ncolormap = \"hot\""),
    ] {
        let scene = format!("[volume]\npath = \"ct.nrrd\"\n[classify]\n{keys}\n");
        std::fs::write(dir.path().join("scene.toml"), scene).unwrap();
        let [of_flags, of_keys] =
            [format!("tf ct.nrrd {flags} --json"), "tf scene.toml --json".to_owned()]
                .map(|args| json(dir.path(), &args));
        assert_eq!(of_flags, of_keys, "{flags}");
        // A flag says another thing than the scene.
        let other = json(dir.path(), "tf scene.toml --preset gray --json");
        assert_eq!(other, json(dir.path(), "tf ct.nrrd --preset gray --json"), "over {keys}");
    }
}

#[test]
fn presets_say_what_does_not_suit() {
    let dir = tempfile::tempdir().unwrap();
    write_ct(dir.path());
    let render = |input: &str, flags: &str| {
        warnings(dir.path(), &format!("render {input} -o a.png --width 16 --height 16 {flags}"))
    };
    assert_eq!(render("ct.nrrd", "--preset ct-skin-bone"), "");
    assert!(render("ct.nrrd", "--preset mr-t1").contains("look like Hounsfield units"));
    let cube = render("builtin:cube", "--preset ct-bone");
    assert!(
        cube.contains("ct-bone is for Hounsfield units") && cube.contains("give a window"),
        "{cube}"
    );
    assert_eq!(render("builtin:cube", "--preset ct-bone --window 0:255"), "");
}

/// Ten typical mistakes, and what is said of them.
#[test]
fn errors_of_fitting() {
    let dir = tempfile::tempdir().unwrap();
    write_ct(dir.path());
    std::fs::write(dir.path().join("odd.json"), r#"{"RGBPoints": [0, 1]}"#).unwrap();
    std::fs::write(dir.path().join("short.vp"), "1\n1\n0.9\n").unwrap();
    let files = names_in(dir.path());
    for (args, expected) in [
        (
            "render ct.nrrd -o a.png --preset ct-bones",
            "no preset \"ct-bones\": choose one of ct-bone",
        ),
        ("render ct.nrrd -o a.png --colormap jet", "no colour map \"jet\": choose one of viridis"),
        ("render ct.nrrd -o a.png --window 5:5", "to a greater one, not from 5 to 5"),
        ("render ct.nrrd -o a.png --percentile 1:101", "percentiles go from 0 to 100"),
        ("render ct.nrrd -o a.png --percentile 1:2", "are the same value, -1000"),
        ("render ct.nrrd -o a.png --opacity 0:1 --color 0:1,1,1 --window 0:9", "leave one out"),
        ("render ct.nrrd -o a.png --opacity-scale -1", "at least 0, not by -1"),
        ("render ct.nrrd -o a.png --unit-distance 0", "a positive length, not 0"),
        ("render ct.nrrd -o a.png --transfer-file odd.json", "RGBPoints has 2 numbers"),
        (
            "render ct.nrrd -o a.png --transfer-file short.vp",
            "short.vp: a volume property of 3D Slicer has 9 lines",
        ),
        ("tf", "there is nothing to show"),
        ("tf missing.vp", "cannot read missing.vp"),
        ("tf odd.json", "RGBPoints has 2 numbers"),
        ("tf ct.nrrd -o a.txt.gz", "name it .png (a drawing), .json (ParaView), .vp (3D Slicer)"),
        ("tf --preset gray --percentile 1:2", "name a volume"),
        ("tf ct.nrrd -o nowhere/a.vp", "nowhere"),
    ] {
        let line = diagnostic(dir.path(), args);
        assert!(line.contains(expected), "{args}: {line}");
        assert_eq!(names_in(dir.path()), files, "{args} leaves nothing behind");
    }
    for args in ["--color 0:1,1,1 --colormap hot", "--window 0:1 --percentile 1:2", "--window 5"] {
        let output = slabsplat(dir.path(), &format!("render ct.nrrd -o a.png {args}"));
        assert_eq!(output.status.code(), Some(2), "{args}");
    }
}
