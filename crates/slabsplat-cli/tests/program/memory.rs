//! `slabsplat render --memory`: volumes that are read box by box.

use crate::{answer, diagnostic, json, names_in, slabsplat, text};
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
    let files = ["ball.nii", "ball.raw", "ball.zarr", "ball.npy", "ball.nii.gz", "ball.nrrd"];
    for file in files {
        let dir = tempfile::tempdir().unwrap();
        write(dir.path(), file);
        std::fs::create_dir(dir.path().join("scratch")).unwrap();
        answer(dir.path(), "render scene.toml --backend cpu -o whole.exr");
        let args = "render scene.toml --memory 65MiB --scratch scratch --json -o parts.exr";
        let done = json(dir.path(), args);
        assert!(1 < done["n_boxes"].as_u64().unwrap(), "{done}");
        let is_packed = ["ball.nii.gz", "ball.nrrd"].contains(&file);
        let n_scratch = done["volumes"][0]["scratch_bytes"].as_u64();
        assert_eq!(n_scratch, is_packed.then_some(64 * 64 * 64), "{file}");
        assert_eq!(names_in(&dir.path().join("scratch")), [""; 0]);
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

/// A volume without a scene is found out about box by box.
#[test]
fn memory_of_a_volume_alone() {
    let dir = tempfile::tempdir().unwrap();
    write(dir.path(), "ball.nii");
    let args =
        "render ball.nii --memory 70MiB --width 60 --height 60 -o ball.png --save-scene s.toml";
    let said = text(&slabsplat(dir.path(), args).stderr);
    assert!(said.contains("\nshown as ") || said.starts_with("shown as "), "{said}");
    let scene = std::fs::read_to_string(dir.path().join("s.toml")).unwrap();
    assert!(scene.contains("ball.nii") && !scene.contains("hash"), "{scene}");
    answer(dir.path(), "render s.toml -o again.png");
}

/// A film's frames are those in core, but for the last bit of a byte; a camera that is found is the same.
#[test]
fn memory_changes_no_film() {
    let dir = tempfile::tempdir().unwrap();
    write(dir.path(), "ball.nii.gz");
    let film =
        "turntable ball.nii.gz --frames 3 --width 40 --height 30 --backend cpu --tolerance 0";
    answer(dir.path(), &format!("{film} -o whole.png-sequence"));
    let args = format!("{film} --memory 70MiB --json -o parts.png-sequence --save-scene s.toml");
    let done = json(dir.path(), &args);
    assert_eq!(done["device"], "cpu, box by box", "{done}");
    for frame in names_in(&dir.path().join("whole.png-sequence")) {
        let [whole, parts] = ["whole", "parts"]
            .map(|name| pixels(&dir.path().join(format!("{name}.png-sequence/{frame}"))));
        let off = whole.iter().zip(&parts).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(whole.len() == parts.len() && off < 1.5 / 255.0, "{frame}: {off}");
    }
    answer(dir.path(), "film s.toml --frames 2 --memory 1GiB -o again.gif");
}

#[test]
fn memory_says_what_it_cannot() {
    let dir = tempfile::tempdir().unwrap();
    for (args, expected) in
        [("builtin:cube --memory 1GiB", "made whole"), ("- --memory 1GiB", "standard input")]
    {
        let said = diagnostic(dir.path(), &format!("render {args} -o a.png"));
        assert!(said.contains(expected), "{said}");
    }
    write(dir.path(), "ball.nii");
    for (args, expected) in [
        ("--memory 1MiB", "too few"),
        ("--memory 1GiB --backend none", "none"),
        ("--memory 1GiB --method every-sample", "not the method every-sample"),
        ("--memory 1GiB --mode maximum", "not the mode maximum"),
    ] {
        let said = diagnostic(dir.path(), &format!("render scene.toml {args} -o a.png"));
        assert!(said.contains(expected), "{said}");
    }
    assert!(!names_in(dir.path()).contains(&"a.png".to_owned()), "nothing is half written");
}

/// Chunks that are damaged are named, and raw files that are cut off; those that are missing are filled.
#[test]
fn memory_of_damaged_files() {
    let dir = tempfile::tempdir().unwrap();
    write(dir.path(), "ball.zarr");
    let args = "render scene.toml --memory 65MiB -o parts.exr";
    let chunk = dir.path().join("ball.zarr/0/0/0/0");
    let chunk = if chunk.is_file() { chunk } else { dir.path().join("ball.zarr/0/0.0.0") };
    let bytes = std::fs::read(&chunk).expect("the ball has a chunk");
    for damaged in [&bytes[..bytes.len() / 2], b"no chunk at all"] {
        std::fs::write(&chunk, damaged).unwrap();
        let said = diagnostic(dir.path(), args);
        assert!(said.contains("ball.zarr/0/0") && said.contains("a chunk"), "{said}");
        assert!(!names_in(dir.path()).contains(&"parts.exr".to_owned()));
    }
    std::fs::remove_file(&chunk).unwrap();
    let said = text(&slabsplat(dir.path(), args).stderr);
    assert!(said.contains("nothing is visible"), "{said}");
    write(dir.path(), "ball.raw");
    let bytes = std::fs::read(dir.path().join("ball.raw")).unwrap();
    std::fs::write(dir.path().join("ball.raw"), &bytes[1..]).unwrap();
    let said = diagnostic(dir.path(), &args.replace("parts", "raw"));
    assert!(said.contains("needs 262144 bytes of data, has 262143"), "{said}");
    assert!(!names_in(dir.path()).contains(&"raw.exr".to_owned()));
}

/// What is said of scratch, and that none is there which may not be.
#[test]
fn memory_tells_of_scratch() {
    let dir = tempfile::tempdir().unwrap();
    write(dir.path(), "ball.nii.gz");
    std::fs::create_dir(dir.path().join("here")).unwrap();
    let args = "render scene.toml --memory 1GiB --scratch here -o a.png";
    let said = text(&slabsplat(dir.path(), args).stderr);
    let expected =
        "ball.nii.gz is unpacked into here first: 256.0 KiB there, until the program ends";
    assert!(said.starts_with(expected), "{said}");
    assert_eq!(names_in(&dir.path().join("here")), [""; 0]);
    let said = diagnostic(dir.path(), &args.replace("here", "nowhere"));
    assert!(said.contains("ball.nii.gz: it cannot be unpacked into nowhere: No such"), "{said}");
    let output = slabsplat(dir.path(), "render scene.toml --scratch here -o b.png");
    assert!(text(&output.stderr).contains("--memory"), "scratch is for parts alone");
}

/// A disk on which the volume has no room, and one that fills while it is written, if we may make one.
#[cfg(target_os = "linux")]
#[test]
fn memory_of_a_full_disk() {
    let dir = tempfile::tempdir().unwrap();
    write(dir.path(), "ball.nii.gz");
    let args = "render scene.toml --memory 1GiB -o a.png --scratch small";
    let small = dir.path().join("small");
    std::fs::create_dir(&small).unwrap();
    let program = env!("CARGO_BIN_EXE_slabsplat");
    let run = |before: &str| {
        let mut command = std::process::Command::new("sh");
        command.arg("-c").arg(format!("{before}; exec {program} {args}")).current_dir(dir.path());
        let output = command.output().unwrap();
        assert_eq!(names_in(&small), [""; 0]);
        assert_eq!(output.status.code(), Some(1));
        text(&output.stderr).lines().last().unwrap_or_default().to_owned()
    };
    let said = run("ulimit -f 8");
    assert!(
        said.contains("ball.nii.gz: it cannot be unpacked into small: File too large"),
        "{said}"
    );
    let mut mount = std::process::Command::new("mount");
    mount.args(["-t", "tmpfs", "-o", "size=64k", "tmpfs"]).arg(&small);
    if !mount.output().is_ok_and(|output| output.status.success()) {
        return println!("skipped: a small disk cannot be mounted here");
    }
    let said = run("true");
    std::process::Command::new("umount").arg(&small).status().unwrap();
    let expected = "takes 256.0 KiB of scratch, and 64.0 KiB are there for it in small";
    assert!(said.contains(expected), "{said}");
}
