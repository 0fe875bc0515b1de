//! `slabsplat render`.

use crate::{answer, diagnostic, names_in, slabsplat, text};
use std::path::Path;

/// What a scene file has that says nothing of it; for a volume alone it is found.
const DEFAULTS: &str = "--background 0,0,0,0 --light headlight --shading phong";

const SMALL: &str = "--width 24 --height 16";

fn bytes_of(directory: &Path, args: &str) -> Vec<u8> {
    // Scenes of one picture are told apart by what it says.
    answer(directory, &format!("render --no-metadata {args}"));
    let path = directory.join(args.rsplit(' ').next().unwrap_or_default());
    std::fs::read(&path).unwrap_or_else(|error| panic!("{args}: {error}"))
}

/// Width and height in the header of a PNG.
fn png_size(bytes: &[u8]) -> [u32; 2] {
    assert!(bytes.starts_with(b"\x89PNG\r\n\x1a\n"), "the signature of a PNG");
    [16, 20].map(|at| u32::from_be_bytes([0, 1, 2, 3].map(|byte| bytes[at + byte])))
}

#[test]
fn render_builtin_to_png_and_exr() {
    let dir = tempfile::tempdir().unwrap();
    let png = bytes_of(dir.path(), &format!("builtin:cube {SMALL} -o cube.png"));
    assert_eq!(png_size(&png), [24, 16]);
    let exr = bytes_of(dir.path(), &format!("builtin:sphere:12 {SMALL} -o ball.EXR"));
    assert!(exr.starts_with(&[0x76, 0x2f, 0x31, 0x01]), "the signature of an OpenEXR file");
    assert_eq!(names_in(dir.path()), ["ball.EXR", "cube.png"], "and nothing else is left");
}

#[test]
fn render_tells_what_it_did() {
    let dir = tempfile::tempdir().unwrap();
    let args = format!("render builtin:cube {SMALL} --backend cpu -o cube.png");
    let output = slabsplat(dir.path(), &args);
    let line = text(&output.stderr);
    let (found, line) = line.split_once('\n').unwrap();
    assert_eq!(found, "shown as labels: one, in a colour of its own");
    assert!(line.starts_with("cube.png: 24 x 16 pixels, 4096 voxels drawn, "), "{line}");
    assert!(line.ends_with(" ms\n") && line.lines().count() == 1, "{line}");
    assert!(output.stdout.is_empty());
}

#[test]
fn render_stats_of_the_cpu() {
    let dir = tempfile::tempdir().unwrap();
    let args = format!("render builtin:cube {SMALL} --backend cpu --stats -o cube.png");
    let output = slabsplat(dir.path(), &args);
    let stderr = text(&output.stderr);
    assert!(output.status.success() && output.stdout.is_empty(), "{stderr}");
    let (_, stderr) = stderr.split_once('\n').unwrap();
    let (picture, stats) = stderr.split_once('\n').unwrap();
    assert!(picture.starts_with("cube.png: 24 x 16 pixels"), "{stderr}");
    let value = |key: &str| {
        let line = stats.lines().find(|line| line.starts_with(&format!("{key} ")));
        line.unwrap_or_else(|| panic!("{key} in {stderr}"))[key.len()..].trim()
    };
    for stage in ["list", "bricks", "intake", "splat", "image"] {
        assert!(value(stage).ends_with(" ms"), "{stderr}");
    }
    assert_eq!(value("voxels"), "4096");
    for count in ["occluded", "splatted", "culled", "tiles", "saturated tiles"] {
        assert!(value(count).parse::<u64>().is_ok(), "{count} in {stderr}");
    }
    assert!(value("resident").ends_with(" bytes)"), "{stderr}");
    assert!(value("backend").starts_with("cpu on "), "{stderr}");
}

/// A backend on a GPU draws and says so, or says why it cannot.
#[test]
fn render_by_each_backend() {
    let dir = tempfile::tempdir().unwrap();
    let found = crate::json(dir.path(), "backends --json");
    for backend in found["backends"].as_array().unwrap() {
        let name = backend["name"].as_str().unwrap();
        let args = format!("render builtin:cube {SMALL} --backend {name} -o {name}.png");
        if let Some(reason) = backend["unavailable"].as_str() {
            let line = diagnostic(dir.path(), &args);
            assert!(line.contains(&format!("\"{name}\" is not available: {reason}")), "{line}");
            continue;
        }
        let output = slabsplat(dir.path(), &args);
        let stderr = text(&output.stderr);
        assert!(output.status.success() && stderr.contains("4096 voxels drawn"), "{stderr}");
        assert_eq!(stderr.contains(&format!(" ms, {name} on ")), name != "cpu", "{stderr}");
    }
}

/// The scene's backend is taken, unless a flag names another.
#[test]
fn render_backend_of_the_scene() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("cray.toml"), format!("{SCENE}backend = \"cray\"\n")).unwrap();
    std::fs::write(dir.path().join("auto.toml"), format!("{SCENE}backend = \"auto\"\n")).unwrap();
    assert!(diagnostic(dir.path(), "render cray.toml -o a.png").contains("\"cray\""));
    assert!(diagnostic(dir.path(), "render auto.toml --backend cray -o a.png").contains("cray"));
    bytes_of(dir.path(), "cray.toml --backend cpu -o cpu.png");
    bytes_of(dir.path(), "auto.toml -o auto.png");
}

const SCENE: &str = r#"
[volume]
generate = "cube"
[classify]
opacity = [[0.0, 0.0], [255.0, 0.5]]
color = [[0.0, 1.0, 0.5, 0.25]]
[shading]
model = "phong"
ambient = 0.2
[camera]
eye = [50.0, -30.0, 20.0]
target = [0.0, 0.0, 0.0]
up = [0.0, 0.0, 1.0]
view_height = 30.0
[image]
width = 24
height = 16
background = [0.0, 0.0, 0.5, 1.0]
[render]
method = "axis-aligned"
slab_width = 0.5
mode = "separate"
"#;

/// The flags say all that the file says or leaves to its defaults, so that the pictures must be the same.
#[test]
fn render_flags_mean_what_keys_mean() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("cube.toml"), SCENE).unwrap();
    let by_keys = bytes_of(dir.path(), "cube.toml -o keys.exr");
    let by_flags = bytes_of(
        dir.path(),
        "builtin:cube --opacity 0:0,255:0.5 --color 0:1,0.5,0.25 --shading phong --ambient 0.2 \
         --eye 50,-30,20 --target 0,0,0 --up 0,0,1 --view-height 30 --width 24 --height 16 --background 0,0,0.5 \
         --light headlight --method axis-aligned --slab-width 0.5 --mode separate --backend cpu -o flags.exr",
    );
    assert!(by_keys == by_flags, "keys and flags differ");
}

/// Each flag overrides the scene: the picture changes, and changes back if it says what the file says.
#[test]
fn render_flags_override_keys() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("cube.toml"), SCENE).unwrap();
    let plain = bytes_of(dir.path(), "cube.toml -o plain.exr");
    for flags in [
        "--opacity -5:0,255:0.9",
        "--color 0:1,1,1",
        "--preset ct-bone",
        "--shading none",
        "--gradient-opacity 0:0,90:1",
        "--transfer-box 0,255,0,inf:0.5:0,1,0",
        "--diffuse 0.1",
        "--light -1,-2,-3",
        "--light headlight:1,0.5,0",
        "--light headlight --light 0,0,1:0,0,1",
        "--projection perspective",
        "--projection perspective --fov-y 50",
        "--eye -50,0,0",
        "--target 0,0,-2",
        "--up 0,1,0",
        "--view-height 60",
        "--width 25",
        "--height 17",
        "--background 0,0,0,0",
        "--method image-aligned",
        "--kernel crawfis-max",
        "--mode associated",
        "--spacing 1,1,0.5",
    ] {
        let changed = bytes_of(dir.path(), &format!("cube.toml {flags} -o changed.exr"));
        assert!(changed != plain, "{flags} changes nothing");
    }
    for flags in ["--slab-width 0.5", "--ambient 0.2", "--two-sided true", "--backend cpu"] {
        let same = bytes_of(dir.path(), &format!("cube.toml {flags} -o same.exr"));
        assert!(same == plain, "{flags} is what the scene says or does anyway");
    }
}

#[test]
fn render_settings_of_the_paper() {
    let dir = tempfile::tempdir().unwrap();
    let flags = "--slab-width 2 --normalization product --base-slab-width 0.25 --sections 64 \
                 --radial-samples 32 --lookup nearest --opacity-cutoff 1 --mode separate";
    bytes_of(dir.path(), &format!("builtin:cube {SMALL} {flags} -o paper.png"));
}

#[test]
fn render_raw_as_described() {
    let dir = tempfile::tempdir().unwrap();
    // 4 x 3 x 2 samples of 16 bits, bright, after a header of 5 bytes.
    let samples = (0..24_u16).flat_map(|v| (1000 * v).to_be_bytes());
    let bytes: Vec<u8> = [7; 5].into_iter().chain(samples).collect();
    std::fs::write(dir.path().join("v.raw"), bytes).unwrap();
    let flags = "--dims 4,3,2 --type uint16 --endian big --header-bytes 5 --spacing 1,1,2";
    bytes_of(dir.path(), &format!("v.raw {flags} {SMALL} -o raw.png"));
    let info = crate::json(dir.path(), &format!("info v.raw {flags} --json"));
    assert_eq!(info["max"], 23000.0);
    assert_eq!(info["spacing"], serde_json::json!([1.0, 1.0, 2.0]));
    assert_eq!(info["format"], "raw");
}

#[test]
fn render_of_nothing_says_so() {
    let dir = tempfile::tempdir().unwrap();
    let output = slabsplat(dir.path(), "render builtin:cube --opacity 300:0,400:1 -o a.png");
    let stderr = text(&output.stderr);
    assert!(output.status.success() && stderr.contains("nothing is visible"), "{stderr}");
    assert!(stderr.contains("0 to 255"), "{stderr}");
    for (flags, expected) in [
        ("--clip 1,0,0,-999", "all of it is cut off"),
        ("--crop 0,0,0,0,0,0", "all of it is cut off"),
        ("--crop -99,-99,-99,99,99,99 --cut-out", "all of it is cut off"),
        ("--eye 0,0,-90 --target 0,0,-99 --up 0,1,0", "the camera looks past it"),
    ] {
        let output = slabsplat(dir.path(), &format!("render builtin:cube {flags} -o a.png"));
        let stderr = text(&output.stderr);
        assert!(output.status.success() && stderr.contains(expected), "{flags}: {stderr}");
    }
}

/// A cube of 8 voxels a side, whose middle is in the world's origin.
#[test]
fn render_cuts_by_flags_as_by_keys() {
    let dir = tempfile::tempdir().unwrap();
    let whole = format!("builtin:cube:8 --width 24 --height 24 --backend cpu {DEFAULTS}");
    let whole = bytes_of(dir.path(), &format!("{whole} -o whole.exr"));
    let mut pictures = vec![whole];
    for (name, flags, keys) in [
        ("crop", "--crop -9,-9,-9,0,9,9", "box = [[-9, -9, -9], [0, 9, 9]]"),
        (
            "index",
            "--crop-index 0,0,0,7,3.2,7 --lit-cuts",
            "box = [[0, 0, 0], [7, 3.2, 7]]\nindex = true\nlit = true",
        ),
        (
            "clip",
            "--clip 0,0,1,1 --clip 0,-1,0,1 --cut-out",
            "planes = [[0, 0, 1, 1], [0, -1, 0, 1]]\ninvert = true",
        ),
    ] {
        let rest = format!("--width 24 --height 24 --backend cpu {DEFAULTS}");
        let by_flags =
            bytes_of(dir.path(), &format!("builtin:cube:8 {flags} {rest} -o {name}-flags.exr"));
        let scene = format!("[volume]\ngenerate = \"cube\"\nsize = 8\n[region]\n{keys}\n");
        std::fs::write(dir.path().join("a.toml"), scene).unwrap();
        let by_keys = bytes_of(dir.path(), &format!("a.toml {rest} -o {name}-keys.exr"));
        assert!(by_flags == by_keys, "{name}");
        assert!(!pictures.contains(&by_keys), "{name} is another picture");
        pictures.push(by_keys);
    }
}

#[test]
fn render_several_layers() {
    let dir = tempfile::tempdir().unwrap();
    let flags = format!("--width 24 --height 24 --backend cpu {DEFAULTS}");
    let layer =
        |name: &str| format!("[[layers]]\n[layers.volume]\ngenerate = \"{name}\"\nsize = 9\n");
    let both = layer("cube") + &layer("sphere");
    std::fs::write(dir.path().join("both.toml"), both).unwrap();
    let by_file = bytes_of(dir.path(), &format!("both.toml {flags} -o file.exr"));
    let by_flag = |first: &str, second: &str| {
        let args = format!("builtin:{first}:9 --layer builtin:{second}:9 {flags} -o flag.exr");
        bytes_of(dir.path(), &args)
    };
    assert!(by_flag("cube", "sphere") == by_file);
    assert!(by_flag("sphere", "cube") == by_file, "in any order");
    let info = crate::json(dir.path(), "info both.toml --json");
    assert_eq!(info.as_array().map(Vec::len), Some(2), "{info}");
}

/// A cube of 9 voxels a side, whose middle is in the world's origin, and labels of 3 mm, 1 to 27.
#[test]
fn render_labels_by_flags_as_by_keys() {
    let dir = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &[u8]| std::fs::write(dir.path().join(name), text).unwrap();
    let mut labels = b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 3 3 3\nspace dimension: 3\n\
        space directions: (3,0,0) (0,3,0) (0,0,3)\nspace origin: (-3,-3,-3)\nencoding: raw\n\n"
        .to_vec();
    labels.extend(1..=27);
    write("labels.nrrd", &labels);
    write("table.txt", b"25 a 255 0 0 0\n26 b 0 255 0 0\n");
    let rest = format!("--width 24 --height 24 --backend cpu {DEFAULTS}");
    let scene = |keys: &str| {
        let volume = "[volume]\ngenerate = \"cube\"\nsize = 9\n";
        write("a.toml", format!("{volume}[labels]\npath = \"labels.nrrd\"\n{keys}").as_bytes());
        bytes_of(dir.path(), &format!("a.toml {rest} -o keys.exr"))
    };
    let mut pictures = vec![bytes_of(dir.path(), &format!("builtin:cube:9 {rest} -o plain.exr"))];
    for (flags, keys) in [
        ("", ""),
        ("--label-colors table.txt", "colors = \"table.txt\""),
        ("--only-labels 25,27", "only = [25, 27]"),
        ("--only-labels 25,26 --label-colors auto", "only = [25, 26]\ncolors = \"auto\""),
    ] {
        let flags = format!("builtin:cube:9 --labels labels.nrrd {flags} {rest} -o flags.exr");
        let by_flags = bytes_of(dir.path(), &flags);
        assert!(by_flags == scene(keys), "{flags}");
        assert!(!pictures.contains(&by_flags), "{flags} is another picture");
        pictures.push(by_flags);
    }
    let stderr = |flags: &str| {
        let output =
            slabsplat(dir.path(), &format!("render builtin:cube:9 {flags} {rest} -o a.png"));
        (output.status.success(), text(&output.stderr))
    };
    let (_, warnings) = stderr("--labels labels.nrrd --label-colors table.txt");
    assert!(warnings.contains("without a colour"), "{warnings}");
    for (flags, expected) in [
        ("--only-labels 3", "--only-labels does nothing without labels"),
        ("--labels gone.nrrd", "cannot read "),
        ("--labels labels.nrrd --label-colors labels.nrrd", "labels.nrrd: "),
        ("--labels labels.nrrd --method post-classified", "have no labels"),
        ("--labels labels.nrrd --mode maximum", "have no labels"),
    ] {
        let (is_drawn, error) = stderr(flags);
        assert!(!is_drawn && error.contains(expected), "{flags}: {error}");
    }
}

/// Labels of which nothing is seen, and labels that are elsewhere, are told with the cause.
#[test]
fn render_labels_that_show_nothing() {
    let dir = tempfile::tempdir().unwrap();
    let write = |name: &str, origin: i32, labels: &[u8]| {
        let header = format!(
            "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 3 3 3\nspace dimension: 3\n\
             space directions: (3,0,0) (0,3,0) (0,0,3)\n\
             space origin: ({origin},{origin},{origin})\nencoding: raw\n\n"
        );
        std::fs::write(dir.path().join(name), [header.as_bytes(), labels].concat()).unwrap();
    };
    let labels: Vec<u8> = (1..=27).collect();
    write("labels.nrrd", -3, &labels);
    write("far.nrrd", 100, &labels);
    write("zeros.nrrd", -3, &[0; 27]);
    let check = |flags: &str, expected: &[&str]| {
        let flags = format!("render builtin:cube:9 {flags} {SMALL} -o a.png");
        let output = slabsplat(dir.path(), &flags);
        let stderr = text(&output.stderr);
        let warnings = stderr.lines().filter_map(|line| line.strip_prefix("warning: "));
        assert_eq!(warnings.collect::<Vec<_>>(), expected, "{flags}: {stderr}");
        assert!(output.status.success());
    };
    let invisible = "no label of labels.nrrd that voxels have is visible: they have \
                     1, 2, 3, 4, 5, 6, 7, 8 and 19 more";
    let nothing = "nothing is visible: all labels that voxels have are invisible";
    let missing = "labels.nrrd has no such labels: 99";
    check("--labels labels.nrrd --only-labels 99", &[missing, invisible, nothing]);
    check("--labels labels.nrrd --only-labels 0", &[invisible, nothing]);
    let beside = "far.nrrd lies beside the volume, so that no voxel has one of its labels";
    check("--labels far.nrrd", &[beside]);
    check("--labels far.nrrd --only-labels 5", &[beside, nothing]);
    check("--labels zeros.nrrd", &["all voxels have the label 0 of zeros.nrrd"]);
    let opacity = "--opacity 0:0,200:0,300:0";
    let values = "nothing is visible: the opacity of all values, 0 to 255, is 0";
    check(&format!("--labels labels.nrrd {opacity}"), &[values]);
}

#[test]
fn render_by_every_mode() {
    let dir = tempfile::tempdir().unwrap();
    let of = |mode: &str| {
        bytes_of(dir.path(), &format!("builtin:sphere:12 {SMALL} --mode {mode} -o {mode}.exr"))
    };
    let modes = ["separate", "associated", "extinction", "maximum", "minimum", "average"];
    let mut pictures = modes.map(of).to_vec();
    pictures.sort();
    pictures.dedup();
    assert_eq!(pictures.len(), modes.len(), "each is another picture");
}

/// A square before a volume, and the same alone: told what is left out, with the light that flags say.
#[test]
fn render_mesh_beside_a_volume_and_alone() {
    let dir = tempfile::tempdir().unwrap();
    let square = "v -9 -9 20\nv 9 -9 20\nv 9 9 20\nv -9 9 20\nf 1 2 3 4\nf 1 2 9\n";
    std::fs::write(dir.path().join("a.obj"), square).unwrap();
    let scene = "[mesh]\npath = \"a.obj\"\ncolor = [1, 0, 0]\n[shading]\nmodel = \"none\"\n";
    std::fs::write(dir.path().join("a.toml"), scene).unwrap();
    let view = "--eye 0,0,50 --target 0,0,0 --up 0,1,0 --view-height 10 --width 8 --height 8";
    let args = format!("render builtin:cube --mesh a.obj {view} -o both.exr");
    let output = slabsplat(dir.path(), &args);
    let stderr = text(&output.stderr);
    assert!(output.status.success(), "{stderr}");
    assert!(stderr.contains("a.obj: 1 of 3 triangles are left out"), "{stderr}");
    let [alone, behind] = ["a.obj", "builtin:cube --layer a.obj"]
        .map(|input| bytes_of(dir.path(), &format!("{input} {view} -o it.exr")));
    assert_eq!(bytes_of(dir.path(), &format!("a.obj {view} -o both.exr")), alone);
    assert_eq!(behind, alone, "the square hides the cube");
    let red = bytes_of(dir.path(), &format!("a.toml {view} -o red.png"));
    let lit = bytes_of(dir.path(), &format!("a.toml {view} --shading phong -o lit.png"));
    assert_ne!(red, lit);
    // The camera finds it.
    let output = slabsplat(dir.path(), "render a.obj --width 8 --height 8 -o found.png");
    assert!(!text(&output.stderr).contains("nothing is visible"), "{}", text(&output.stderr));
}

/// Lines and points alone, as thick as flags and files say, and the camera finds them.
#[test]
fn render_lines_and_points() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("a.obj"), "v -9 0 0\nv 9 0 0\nv 0 9 0\nl 1 2 3\np 3\n").unwrap();
    std::fs::write(dir.path().join("b.obj"), "v 1 2 3\nv 4 5 nan\n").unwrap();
    let of = |args: &str| bytes_of(dir.path(), &format!("{args} --width 16 --height 16 -o a.exr"));
    let mut pictures = ["", "--line-width 2", "--point-size 4", "--line-width 2 --point-size 4"]
        .map(|flags| of(&format!("a.obj {flags}")))
        .to_vec();
    let scene = "[mesh]\npath = \"a.obj\"\n";
    std::fs::write(dir.path().join("plain.toml"), scene).unwrap();
    std::fs::write(dir.path().join("a.toml"), format!("{scene}line_width = 2\n")).unwrap();
    assert!(of("a.toml") == of("plain.toml --line-width 2"));
    assert!(
        of("a.toml --line-width 1") == of("plain.toml --line-width 1"),
        "flags come before files"
    );
    pictures.sort();
    pictures.dedup();
    assert_eq!(pictures.len(), 4);
    let output = slabsplat(dir.path(), "render b.obj --width 8 --height 8 -o b.png");
    let stderr = text(&output.stderr);
    assert!(
        stderr.contains("1 of 2 points are left out: 1 have a corner that is not finite"),
        "{stderr}"
    );
    assert!(output.status.success() && !stderr.contains("nothing is visible"), "{stderr}");
    for (args, expected) in [
        ("builtin:cube --line-width 2", "--line-width does nothing without a mesh"),
        ("a.obj --point-size 0", "a width is a number above 0"),
        ("a.obj --point-size nan", "a width is a number above 0"),
    ] {
        let stderr = text(&slabsplat(dir.path(), &format!("render {args} -o a.png")).stderr);
        assert!(stderr.contains(expected), "{stderr}");
    }
}

/// A side turns the picture, and fills it again; turns alone of a scene file keep its size.
#[test]
fn render_cameras_that_people_say() {
    let dir = tempfile::tempdir().unwrap();
    let rest = "--width 24 --height 24 --backend cpu";
    let of =
        |flags: &str| bytes_of(dir.path(), &format!("builtin:neuron:12 {flags} {rest} -o a.exr"));
    let mut pictures = vec![of("")];
    for flags in [
        "--view front",
        "--view back",
        "--view left",
        "--view right",
        "--view top",
        "--view bottom",
        "--view iso",
        "--azimuth 20",
        "--elevation -20",
        "--roll 30",
        "--zoom 1.5",
        "--pan 0.1,-0.1",
        "--look-at 1,2,3",
        "--fit volume",
        "--fov 40",
        "--fov 40 --view left",
        "--eye 50,0,0 --target 0,0,0",
        "--eye 50,0,0 --look-at 0,0,2",
    ] {
        let picture = of(flags);
        assert!(!pictures.contains(&picture), "{flags} is another picture");
        pictures.push(picture);
    }
    assert!(of("--view front --azimuth 90") == of("--view right"), "a quarter to the right");
    assert!(of("--fov 40") == of("--fov-y 40"), "two names of one flag");
    assert!(of("--fit visible") == pictures[0], "which is the default");
    std::fs::write(dir.path().join("a.toml"), SCENE).unwrap();
    let of_file = |flags: &str| bytes_of(dir.path(), &format!("a.toml {flags} -o b.exr"));
    assert!(of_file("--azimuth 360 --zoom 1") != of_file("--azimuth 180"));
    let close = of_file("--zoom 2");
    assert!(close == of_file("--view-height 15"), "half of the scene's height");
}
