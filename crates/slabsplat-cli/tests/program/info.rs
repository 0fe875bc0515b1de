//! `slabsplat info`.

use crate::{answer, json};
use serde_json::json as value;
use std::process::{Command, Stdio};

#[test]
fn info_json_has_the_agreed_keys() {
    let dir = tempfile::tempdir().unwrap();
    let info = json(dir.path(), "info builtin:cube --json");
    let expected = value!({
        "dims": [28, 28, 28],
        "spacing": [1.0, 1.0, 1.0],
        "affine": [
            [1.0, 0.0, 0.0, -13.5],
            [0.0, 1.0, 0.0, -13.5],
            [0.0, 0.0, 1.0, -13.5],
            [0.0, 0.0, 0.0, 1.0],
        ],
        "dtype": "uint8",
        "min": 0.0,
        "max": 255.0,
        "voxels": 21952,
        "nan": 0,
        "minus_infinity": 0,
        "infinity": 0,
        "format": "built-in",
    });
    assert_eq!(info, expected);
}

#[test]
fn info_of_numbers_that_json_lacks() {
    let dir = tempfile::tempdir().unwrap();
    let write = |name: &str, samples: [f32; 2]| {
        std::fs::write(dir.path().join(name), samples.map(f32::to_le_bytes).concat()).unwrap();
    };
    write("nan.raw", [f32::NAN; 2]);
    write("inf.raw", [1.5, f32::INFINITY]);
    let flags = "--dims 2,1,1 --type float32";
    let nan = json(dir.path(), &format!("info nan.raw {flags} --json"));
    assert_eq!([&nan["min"], &nan["max"], &nan["nan"]], [&value!(null), &value!(null), &value!(2)]);
    let inf = json(dir.path(), &format!("info inf.raw {flags} --json"));
    let expected = [&value!(1.5), &value!(1.5), &value!(0), &value!(1)];
    assert_eq!([&inf["min"], &inf["max"], &inf["minus_infinity"], &inf["infinity"]], expected);
    let text = answer(dir.path(), &format!("info nan.raw {flags}"));
    assert!(text.contains("none is finite"), "{text}");
    let text = answer(dir.path(), &format!("info inf.raw {flags}"));
    assert!(text.contains("infinite 0 -inf, 1 +inf"), "{text}");
}

#[test]
fn info_text_is_aligned() {
    let dir = tempfile::tempdir().unwrap();
    let text = answer(dir.path(), "info builtin:marschner-lobb:8 --spacing 1,1,2.5");
    for line in ["dims     8 x 8 x 8", "dtype    float32", "spacing  1 x 1 x 2.5", "voxels   512"] {
        assert!(text.lines().any(|found| found == line), "{line} in {text}");
    }
    let values = text.lines().map(|line| line.split_at(9));
    for (key, value) in values {
        assert!(key.ends_with(' ') && !value.is_empty(), "{key}{value} in {text}");
    }
}

/// `slabsplat info .. | head -0`: the reader is gone before anything is written.
#[test]
fn info_without_a_reader_is_no_error() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_slabsplat"))
        .args(["info", "builtin:cube"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert!(output.stderr.is_empty(), "{}", crate::text(&output.stderr));
    assert!(output.status.success());
}

#[test]
fn info_of_a_mesh() {
    let dir = tempfile::tempdir().unwrap();
    let mesh = "v 0 0 0\nv 2 0 0 1 0 0\nv 0 3 4\nf 1 2 3\nf 1 1 2\n";
    std::fs::write(dir.path().join("a.obj"), mesh).unwrap();
    let expected = value!({
        "format": "OBJ",
        "triangles": 1,
        "lines": 0,
        "points": 0,
        "left_out": 1,
        "vertices": 3,
        "normals": false,
        "colors": true,
        "min": [0.0, 0.0, 0.0],
        "max": [2.0, 3.0, 4.0],
    });
    assert_eq!(json(dir.path(), "info a.obj --json"), expected);
    let text = answer(dir.path(), "info a.obj");
    assert!(text.contains("0, 0, 0 to 2, 3, 4"), "{text}");
}
