//! Bad input: one plain line on stderr, exit code 1 (2 for usage), nothing half-written.

use crate::{diagnostic, names_in, slabsplat, text};

#[test]
fn error_in_scene_names_key_and_line() {
    let dir = tempfile::tempdir().unwrap();
    let scene = "[volume]\ngenerate = \"cube\"\n[render]\nslab_with = 1.0\n";
    std::fs::write(dir.path().join("a.toml"), scene).unwrap();
    let line = diagnostic(dir.path(), "render a.toml -o a.png");
    assert!(line.contains("a.toml:4") && line.contains("slab_with"), "{line}");
    assert_eq!(names_in(dir.path()), ["a.toml"], "nothing is written");
}

/// What is only found out when the scene is drawn names the scene, too.
#[test]
fn error_of_a_scene_names_it() {
    let dir = tempfile::tempdir().unwrap();
    for (rest, expected) in [
        ("[render]\nkernel = \"box\"", "no kernel"),
        ("[render]\nbackend = \"cray\"", "no backend"),
        ("[render]\nslab_width = 1e-9", "slabs deep"),
        ("[camera]\neye = [0, 0, 0]\ntarget = [0, 0, 0]", "same point"),
    ] {
        let scene = format!("[volume]\ngenerate = \"cube\"\n{rest}\n");
        std::fs::write(dir.path().join("a.toml"), scene).unwrap();
        let line = diagnostic(dir.path(), "render a.toml -o a.png");
        assert!(line.contains("a.toml: ") && line.contains(expected), "{line}");
    }
}

#[test]
fn errors_say_what_and_where() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("empty.nrrd"), "").unwrap();
    std::fs::write(dir.path().join("a.raw"), [0; 7]).unwrap();
    std::fs::write(dir.path().join("broken.stl"), [b'x'; 99]).unwrap();
    std::fs::write(dir.path().join("a.obj"), "v 0 0 0\nv 9 0 0\nv 0 9 9\nf 1 2 3\n").unwrap();
    std::fs::write(dir.path().join("text.toml"), "= what = is = this").unwrap();
    std::fs::create_dir(dir.path().join("dir.png")).unwrap();
    let files = names_in(dir.path());
    for (args, expected) in [
        ("render missing.nrrd -o a.png", "missing.nrrd"),
        ("render missing.toml -o a.png", "missing.toml"),
        ("render text.toml -o a.png", "text.toml:1"),
        ("render empty.nrrd -o a.png", "empty.nrrd"),
        ("render builtin:teapot -o a.png", "marschner-lobb"),
        ("render builtin:cube --layer missing.nrrd -o a.png", "missing.nrrd"),
        ("render builtin:cube --mesh missing.ply -o a.png", "missing.ply"),
        (
            "render builtin:cube --mesh a.raw -o a.png",
            "expected PLY (.ply), STL (.stl) or OBJ (.obj)",
        ),
        ("render broken.stl -o a.png", "broken.stl: cut off: it has 0 of "),
        ("info broken.stl", "broken.stl: cut off: it has 0 of "),
        ("render builtin:cube --mesh a.obj --method every-sample -o a.png", "draws no meshes"),
        ("render builtin:cube --mesh a.obj --mode maximum -o a.png", "draws no meshes"),
        ("render a.obj --spacing 1,1,1 -o a.png", "there is no volume"),
        ("render builtin:cube --cut-out -o a.png", "add --crop or --clip"),
        ("render builtin:cube --lit-cuts -o a.png", "add --crop or --clip"),
        ("render builtin:cube --clip 1,0,0,0 --method axis-aligned -o a.png", "cuts nothing off"),
        ("render builtin:cube --mode maximum --method every-sample -o a.png", "has none of"),
        (
            "render builtin:cube --method every-sample --layer builtin:cube -o a.png",
            "the method every-sample draws one layer, not 2",
        ),
        ("render builtin:cube --mode isosurfaces -o a.png", "add --isosurface"),
        (
            "render builtin:cube --isosurface 9 --isosurface 9:1 -o a.png",
            "two isosurfaces of the value 9",
        ),
        (
            "render builtin:cube --isosurface 9 --mode average -o a.png",
            "does nothing in the mode average",
        ),
        ("render a.obj -o a.obj --format png", "a.obj is to be drawn, and would be replaced"),
        ("render text.toml -o a.png --save-scene text.toml", "text.toml is to be drawn"),
        ("render builtin:cube:many -o a.png", "\"many\""),
        ("render builtin:cube:2000000 -o a.png", "4 to 1024"),
        ("render builtin:cube -o a.gif", "name it .png, .exr, .tif, .jpg or .webp"),
        ("render builtin:cube -o nowhere/a.png", "no folder nowhere; --mkdir makes it"),
        ("render builtin:cube -o empty.nrrd/a.png", "empty.nrrd is no folder"),
        ("render builtin:cube -o dir.png", "is a folder"),
        ("render builtin:cube --slab-width 0 -o a.png", "slab_width"),
        ("render builtin:cube --slab-width NaN -o a.png", "slab_width"),
        ("render builtin:cube --sections 1 -o a.png", "sections"),
        ("render builtin:cube --opacity-cutoff -1 -o a.png", "opacity_cutoff"),
        ("render builtin:cube --tolerance -1 -o a.png", "tolerance"),
        ("render builtin:cube --ambient -1 -o a.png", "ambient"),
        ("render builtin:cube --shading none --light 0,0,1 -o a.png", "--light"),
        ("render builtin:cube --light 0,0,1:1,2,-3 -o a.png", "colour of a light"),
        ("render builtin:cube --eye nan,0,0 --target 0,0,0 -o a.png", "eye"),
        ("render builtin:cube --eye 9,9,9 -o a.png", "add --target"),
        ("render builtin:cube --zoom 0 -o a.png", "zoom must be a positive number"),
        ("render builtin:cube --azimuth nan -o a.png", "azimuth must be finite"),
        ("render builtin:cube --up 0,0,0 -o a.png", "up vector"),
        ("render builtin:cube --view-height -3 -o a.png", "view_height"),
        ("render builtin:cube --view-height 1e-37 --spacing 1,1.2,0.7 -o a.png", "view_height"),
        ("render builtin:cube --view-height 1e300 -o a.png", "view_height"),
        ("render builtin:cube --projection perspective --fov-y 180 -o a.png", "fov_y"),
        ("render builtin:cube --width 0 -o a.png", "0 x 512"),
        ("render builtin:cube --height 4000000000 -o a.png", "4000000000"),
        ("render builtin:cube --backend cray -o a.png", "\"cray\""),
        ("render builtin:cube --dims 1,2,3 --type uint8 -o a.png", "built in"),
        ("info a.raw", "--dims and --type"),
        ("info a.raw --dims 1,2,3", "--type"),
        ("info a.raw --dims 1,2,3 --type uint8", "needs 6 bytes of data, has 7"),
        ("info a.raw --dims 0,2,3 --type uint8", "empty"),
        ("info a.raw --dims 9999999,9999999,9999999 --type float64", "too many voxels"),
        ("info .", "error"),
        ("popping builtin:cube --backend cray", "\"cray\""),
        ("popping builtin:cube --step 0", "positive step"),
        ("popping builtin:cube --from 0 --to inf", "finite"),
        ("popping builtin:cube --to 1", "fewer than 3 frames"),
        ("bench missing.toml", "missing.toml"),
        ("bench builtin:cube --backend cray", "\"cray\""),
        ("bench builtin:cube --slab-width 0 --json", "slab_width"),
        ("demo empty.nrrd", "empty.nrrd"),
        ("demo empty.nrrd/below", "empty.nrrd"),
    ] {
        let line = diagnostic(dir.path(), args);
        assert!(line.contains(expected), "{args}: {line}");
        assert_eq!(names_in(dir.path()), files, "{args} leaves nothing behind");
    }
}

#[test]
fn errors_of_transfer_functions() {
    let dir = tempfile::tempdir().unwrap();
    for (args, expected) in [
        ("render builtin:cube --opacity 0:2 -o a.png", "point 0 of opacity lies outside 0 to 1"),
        ("render builtin:cube --opacity 5:0,0:1 -o a.png", "out of order"),
        ("render builtin:cube --color inf:0,0,0 -o a.png", "not finite"),
        ("render builtin:cube --gradient-opacity 0:2 -o a.png", "lies outside 0 to 1"),
        ("render builtin:cube --transfer-image no.png:0,1,0,1 -o a.png", "cannot read no.png"),
        (
            "render builtin:cube --transfer-box 0,9,0,9 --mode maximum -o a.png",
            "no two-dimensional transfer functions",
        ),
        ("render builtin:cube --preset ct-fog -o a.png", "ct-bone"),
        ("render builtin:cube --transfer-file no.json -o a.png", "no.json"),
    ] {
        let line = diagnostic(dir.path(), args);
        assert!(line.contains(expected), "{args}: {line}");
        assert!(names_in(dir.path()).is_empty(), "{args} leaves nothing behind");
    }
}

#[test]
fn errors_of_memory_say_what_each_volume_needs() {
    let dir = tempfile::tempdir().unwrap();
    let huge = r#"{"dims": [60000, 60000, 60000], "type": "uint8"}"#;
    std::fs::write(dir.path().join("huge.json"), huge).unwrap();
    let small = r#"{"dims": [10, 10, 10], "type": "int16", "endian": "little"}"#;
    std::fs::write(dir.path().join("small.json"), small).unwrap();
    let line = diagnostic(dir.path(), "render small.json --layer huge.json -o a.png");
    let needs = ["196.5 TiB of memory", "small.json 2.0 KiB", "huge.json 196.5 TiB"];
    assert!(needs.iter().all(|need| line.contains(need)), "{line}");
}

#[test]
fn errors_keep_the_old_picture() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("a.png"), "old").unwrap();
    diagnostic(dir.path(), "render missing.nrrd -o a.png");
    assert_eq!(std::fs::read(dir.path().join("a.png")).unwrap(), b"old");
}

#[test]
fn errors_of_usage_exit_with_2() {
    let dir = tempfile::tempdir().unwrap();
    for args in [
        "",
        "draw",
        "render",
        "render -o a.png",
        "render builtin:cube -o a.png --methods image-aligned",
        "render builtin:cube -o a.png --method splat",
        "render builtin:cube -o a.png --eye 1,2",
        "render builtin:cube -o a.png --view behind",
        "render builtin:cube -o a.png --view front --eye 1,2,3",
        "render builtin:cube -o a.png --pan 1",
        "render builtin:cube -o a.png --kernel box",
        "render builtin:cube -o a.png --isosurface nan",
        "render builtin:cube -o a.png --transfer-box 3,2,0,1",
        "render builtin:cube -o a.png --transfer-image a.png",
        "render builtin:cube -o a.png --isosurface 9:2",
        "render builtin:cube -o a.png --width -1",
        "render builtin:cube -o a.png --preset ct-bone --transfer-file a.json",
        "bench",
        "bench builtin:cube --frames 0",
        "bench builtin:cube --frames many",
        "info builtin:cube --type complex64",
        "render builtin:cube --spacing 0,1,1 -o a.png",
        "render builtin:cube --spacing -1,1,1 -o a.png",
    ] {
        let output = slabsplat(dir.path(), args);
        assert_eq!(output.status.code(), Some(2), "{args}: {}", text(&output.stderr));
        assert!(output.stdout.is_empty() && !output.stderr.is_empty(), "{args}");
    }
}
