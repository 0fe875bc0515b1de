//! `slabsplat convert`: the same volume under another name.

use super::{diagnostic, json, slabsplat, text};
use std::fs;

#[test]
fn convert_there_and_back() {
    let dir = tempfile::tempdir().expect("a folder can be made");
    let dir = dir.path();
    let info = |name: &str| {
        let mut info = json(dir, &format!("info {name} --json"));
        info.as_object_mut().expect("an object").remove("format");
        info
    };
    let original = info("builtin:marschner-lobb:20");
    let mut from = "builtin:marschner-lobb:20".to_owned();
    for name in ["a.nrrd", "b.mha", "c.raw", "d.zarr"] {
        let output = slabsplat(dir, &format!("convert {from} {name}"));
        let said = text(&output.stderr);
        assert!(output.status.success(), "{said}");
        assert!(said.contains(&format!("{name}: 20 x 20 x 20 voxels")), "{said}");
        assert_eq!(info(name)["min"], original["min"], "{name}");
        assert_eq!(info(name)["affine"], original["affine"], "{name}");
        from = name.to_owned();
    }
}

#[test]
fn convert_refuses_before_it_reads() {
    let dir = tempfile::tempdir().expect("a folder can be made");
    fs::write(dir.path().join("scene.toml"), "[volume]\ngenerate = \"cube\"\n").expect("written");
    for (args, expected) in [
        ("convert none.nrrd a.png", "cannot tell the format of a.png"),
        ("convert scene.toml a.nrrd", "is a scene"),
        ("convert builtin:cube none/a.nrrd", "cannot write none/a.nrrd"),
        ("convert none.nrrd a.nrrd", "cannot read none.nrrd"),
    ] {
        let said = diagnostic(dir.path(), args);
        assert!(said.contains(expected), "{said}");
    }
    assert!(!dir.path().join("a.nrrd").exists());
}
