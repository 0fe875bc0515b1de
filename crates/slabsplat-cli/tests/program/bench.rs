//! `slabsplat bench`.

use crate::{answer, diagnostic, json, slabsplat, text};

const SMALL: &str = "--width 24 --height 16 --backend cpu";

#[test]
fn bench_json_has_all_keys() {
    let dir = tempfile::tempdir().unwrap();
    let report = json(dir.path(), &format!("bench builtin:cube {SMALL} --frames 3 --json"));
    let keys: Vec<_> = report.as_object().unwrap().keys().map(String::as_str).collect();
    let expected = [
        "backend",
        "device",
        "frames_ms",
        "height",
        "median_ms",
        "min_ms",
        "n_culled",
        "n_occluded",
        "n_splats",
        "n_voxels",
        "resident_bytes",
        "scene",
        "stages",
        "threads",
        "width",
    ];
    assert_eq!(keys, expected);
    for (key, expected) in
        [("backend", "cpu".into()), ("scene", "builtin:cube".into()), ("n_voxels", 4096.into())]
    {
        let expected: serde_json::Value = expected;
        assert_eq!(report[key], expected, "{key}");
    }
    assert_eq!([&report["width"], &report["height"]], [24, 16]);
    assert!(0 < report["threads"].as_u64().unwrap());
    assert!(report["stages"].as_array().unwrap().iter().any(|stage| stage["name"] == "splat"));
}

#[test]
fn bench_times_are_of_one_series() {
    let dir = tempfile::tempdir().unwrap();
    let report = json(dir.path(), &format!("bench builtin:cube {SMALL} --frames 3 --json"));
    let mut ms: Vec<f64> = serde_json::from_value(report["frames_ms"].clone()).unwrap();
    assert_eq!(ms.len(), 3, "{report}");
    ms.sort_by(f64::total_cmp);
    assert!(0.0 < ms[0], "{report}");
    assert_eq!(report["min_ms"], ms[0]);
    assert_eq!(report["median_ms"], ms[1]);
}

#[test]
fn bench_table() {
    let dir = tempfile::tempdir().unwrap();
    let table = answer(dir.path(), &format!("bench builtin:cube {SMALL} --frames 1"));
    let keys: Vec<&str> = table.lines().filter_map(|line| line.split(' ').next()).collect();
    for key in ["scene", "backend", "frames", "median", "fastest", "splat", "voxels", "resident"] {
        assert!(keys.contains(&key), "{key} in {table}");
    }
    assert!(table.contains("builtin:cube, 24 x 16 pixels\n"), "{table}");
}

/// The flags are those of `render`, and what only shows in a frame names the scene.
#[test]
fn bench_takes_scenes_and_flags() {
    let dir = tempfile::tempdir().unwrap();
    let scene = "[volume]\ngenerate = \"cube\"\n[image]\nwidth = 9\nheight = 8\n";
    std::fs::write(dir.path().join("a.toml"), scene).unwrap();
    let report = json(dir.path(), "bench a.toml --frames 1 --height 7 --json");
    assert_eq!([&report["width"], &report["height"]], [9, 7]);
    let line = diagnostic(dir.path(), "bench a.toml --frames 1 --slab-width 1e-9");
    assert!(line.contains("a.toml: ") && line.contains("slabs deep"), "{line}");
}

#[test]
fn bench_writes_no_file() {
    let dir = tempfile::tempdir().unwrap();
    let output = slabsplat(dir.path(), &format!("bench builtin:cube {SMALL} --frames 1"));
    assert!(output.status.success() && output.stderr.is_empty(), "{}", text(&output.stderr));
    assert!(crate::names_in(dir.path()).is_empty());
}
