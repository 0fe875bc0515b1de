//! `slabsplat render --memory`: volumes that are read box by box.

use crate::{answer, diagnostic, json, names_in};
use std::path::Path;

/// A scene that leaves nothing open, but for the volume's file.
const SCENE: &str = "[volume]\npath = \"FILE\"\n[classify]\nopacity = [[20.0, 0.0], [200.0, 0.4]]\n\
    color = [[20.0, 1.0, 0.2, 0.1], [200.0, 0.3, 0.9, 1.0]]\n[camera]\nprojection = \"orthographic\"\n\
    eye = [200.0, 130.0, 160.0]\ntarget = [0.0, 0.0, 0.0]\nup = [0.0, 0.0, 1.0]\nview_height = 90.0\n\
    [image]\nwidth = 80\nheight = 60\n[render]\ntolerance = 0.0\nopacity_cutoff = 1.0\n";

/// Writes a volume in that format, and its scene.
fn write(folder: &Path, file: &str) {
    answer(folder, &format!("convert builtin:sphere:64 {file}"));
    let scene = SCENE.replace("FILE", file);
    std::fs::write(folder.join("scene.toml"), scene).expect("the folder can be written to");
}

/// By the program's own comparison of two pictures.
#[test]
fn memory_changes_no_picture() {
    for file in ["ball.nii", "ball.raw", "ball.zarr"] {
        let dir = tempfile::tempdir().unwrap();
        write(dir.path(), file);
        answer(dir.path(), "render scene.toml --backend cpu -o whole.exr");
        let done = json(dir.path(), "render scene.toml --memory 65MiB --json -o parts.exr");
        assert!(1 < done["n_boxes"].as_u64().unwrap(), "{done}");
        assert_eq!(done["volumes"][0]["dims"], serde_json::json!([64, 64, 64]));
        let [whole, parts] = ["whole.exr", "parts.exr"].map(|name| pixels(&dir.path().join(name)));
        let off = whole.iter().zip(&parts).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(whole.len() == parts.len() && off < 1e-5, "{file}: {off}");
    }
}

/// A gigabyte of voxels in half of that, if it is there.
#[test]
fn memory_of_the_large_brain() {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/scenes");
    if !scenes.join("../data/large/brain_985x1165x945_uint8.raw").is_file() {
        return println!("skipped: there is no brain of 10⁹ voxels in tests/data/large");
    }
    let dir = tempfile::tempdir().unwrap();
    let scene = scenes.join("brain-large.toml");
    let scene = format!("{} --tolerance 0 --opacity-cutoff 1", scene.display());
    let done = json(dir.path(), &format!("render {scene} --memory 512MiB --json -o parts.exr"));
    if let Some(peak) = done["peak_bytes"].as_u64() {
        assert!(peak < 512 << 20, "{done}");
    }
    answer(dir.path(), &format!("render {scene} --backend cpu -o whole.exr"));
    let [whole, parts] = ["whole.exr", "parts.exr"].map(|name| pixels(&dir.path().join(name)));
    let off = whole.iter().zip(&parts).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    println!("{done}: off by {off}");
    assert!(whole.len() == parts.len() && off < 1e-5, "{off}");
}

/// All values of a picture in EXR.
fn pixels(path: &Path) -> Vec<f32> {
    image::open(path).expect("a picture was written").to_rgba32f().into_raw()
}

/// A volume without a scene is found out about by an overview.
#[test]
fn memory_of_a_volume_alone() {
    let dir = tempfile::tempdir().unwrap();
    write(dir.path(), "ball.nii");
    answer(
        dir.path(),
        "render ball.nii --memory 70MiB --width 60 --height 60 -o ball.png --save-scene s.toml",
    );
    let scene = std::fs::read_to_string(dir.path().join("s.toml")).unwrap();
    assert!(scene.contains("ball.nii") && !scene.contains("hash"), "{scene}");
    answer(dir.path(), "render s.toml -o again.png");
}

#[test]
fn memory_says_what_it_cannot() {
    let dir = tempfile::tempdir().unwrap();
    write(dir.path(), "ball.nrrd");
    for (args, expected) in [
        ("scene.toml --memory 1GiB", "box by box: slabsplat convert"),
        ("builtin:cube --memory 1GiB", "made whole"),
        ("scene.toml --memory 1GiB --backend none", "none"),
        ("- --memory 1GiB", "standard input"),
    ] {
        let said = diagnostic(dir.path(), &format!("render {args} -o a.png"));
        assert!(said.contains(expected), "{said}");
    }
    write(dir.path(), "ball.nii");
    for (args, expected) in [
        ("--memory 1MiB", "too few"),
        ("--memory 1GiB --method every-sample", "not the method every-sample"),
        ("--memory 1GiB --mode maximum", "not the mode maximum"),
    ] {
        let said = diagnostic(dir.path(), &format!("render scene.toml {args} -o a.png"));
        assert!(said.contains(expected), "{said}");
    }
    assert!(!names_in(dir.path()).contains(&"a.png".to_owned()), "nothing is half written");
}
