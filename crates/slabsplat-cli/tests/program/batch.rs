//! `slabsplat batch`.

use crate::{diagnostic, json, names_in, program, slabsplat, text};

const SMALL: &str = "--width 16 --height 16";

#[test]
fn batch_draws_each_input_as_render_does() {
    let dir = tempfile::tempdir().unwrap();
    let args = format!("batch builtin:cube:8 builtin:sphere:8 {SMALL} -o out --mkdir --json");
    let answer = json(dir.path(), &args);
    assert_eq!(names_in(&dir.path().join("out")), ["cube.png", "sphere.png"]);
    assert_eq!(answer[1]["input"], "builtin:sphere:8");
    assert_eq!(answer[1]["result"]["picture"], "out/sphere.png");
    let args = format!("render builtin:sphere:8 {SMALL} -o out/alone.png");
    assert!(slabsplat(dir.path(), &args).status.success());
    let [alone, in_batch] = ["alone", "sphere"]
        .map(|name| std::fs::read(dir.path().join(format!("out/{name}.png"))).unwrap());
    assert_eq!(alone, in_batch, "metadata included");
}

#[test]
fn batch_goes_on_past_failures() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("broken.nrrd"), "NRRD0004\n").unwrap();
    let args = format!("batch broken.nrrd missing.nii builtin:cube:8 {SMALL} -o . --json");
    let output = slabsplat(dir.path(), &args);
    assert_eq!(output.status.code(), Some(1));
    let stderr = text(&output.stderr);
    for expected in [
        "error: broken.nrrd: ",
        "error: cannot read missing.nii: ",
        "error: 2 of 3 inputs could not be drawn: broken.nrrd, missing.nii\n",
    ] {
        assert!(stderr.contains(expected), "{expected:?} is not in {stderr}");
    }
    let answer: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(answer[0]["result"]["error"].as_str().unwrap().starts_with("broken.nrrd: "));
    assert_eq!(answer[2]["result"]["n_voxels"], 64, "what is opaque of it");
    assert_eq!(names_in(dir.path()), ["broken.nrrd", "cube.png"]);
}

/// A warning belongs to the picture that it is about.
#[test]
fn batch_tells_whose_warnings_they_are() {
    let dir = tempfile::tempdir().unwrap();
    let args = format!(
        "batch builtin:cube:8 builtin:sphere:8 {SMALL} --crop 90,90,90,99,99,99 -o . --json"
    );
    let answer = json(dir.path(), &args);
    for of_one in [0, 1] {
        let warnings = answer[of_one]["result"]["warnings"].as_array().unwrap();
        assert!(
            warnings.len() == 1 && warnings[0].as_str().unwrap().contains("nothing is visible")
        );
    }
}

#[test]
fn batch_refuses_to_lose_pictures() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::create_dir(dir.path().join("a")).unwrap();
    assert!(
        slabsplat(dir.path(), &format!("render builtin:cube:8 {SMALL} -o a/cube.png"))
            .status
            .success()
    );
    for (args, expected) in [
        (
            "batch builtin:cube builtin:cube:9 -o a",
            "builtin:cube and builtin:cube:9 would both be drawn into a/cube.png",
        ),
        ("batch a/cube.png -o a", "a/cube.png is to be drawn, and would be replaced"),
        ("batch builtin:cube -o b", "no folder b; --mkdir makes it"),
        ("batch - -o a", "- gives its picture no name: slabsplat render - -o FILE draws it"),
    ] {
        let line = diagnostic(dir.path(), args);
        assert!(line.contains(expected), "{line}");
    }
    assert_eq!(names_in(&dir.path().join("a")), ["cube.png"]);
}

/// A picture that nobody named replaces nothing but one of its kind.
#[test]
fn render_names_the_picture_itself() {
    let dir = tempfile::tempdir().unwrap();
    let draw = || program(dir.path(), &format!("render builtin:cube:8 {SMALL}")).output().unwrap();
    for _ in 0..2 {
        assert!(draw().status.success(), "{}", text(&draw().stderr));
    }
    assert_eq!(names_in(dir.path()), ["cube.png"]);
    let line = diagnostic(dir.path(), "render cube.png");
    assert!(line.contains("cube.png is there already: name the picture by -o"), "{line}");
    std::fs::write(dir.path().join("cube.png"), "somebody's").unwrap();
    assert!(text(&draw().stderr).contains("cube.png is there already"));
    assert_eq!(std::fs::read(dir.path().join("cube.png")).unwrap(), b"somebody's");
}
