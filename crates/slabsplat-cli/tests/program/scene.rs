//! Every picture can be made again: `slabsplat scene`, `--save-scene`, and what pictures say of themselves.

use crate::{answer, diagnostic, json, names_in, program, slabsplat, text};
use std::fs;
use std::path::Path;
use std::process::Stdio;

/// Renders to an EXR of few pixels, and returns its bytes.
fn picture(directory: &Path, args: &str, name: &str) -> Vec<u8> {
    let args = format!("render {args} --backend cpu -o {name}");
    let output = slabsplat(directory, &args);
    assert!(output.status.success(), "{args}: {}", text(&output.stderr));
    fs::read(directory.join(name)).expect("it was written")
}

/// Values that vary along all axes, in 8 bits and without a header.
fn write_volume(path: &Path) {
    let samples = (0..7 * 6 * 5).map(|n: u32| (n * n % 251) as u8).collect::<Vec<_>>();
    fs::write(path, samples).expect("there is room for files");
}

fn write_inputs(directory: &Path) {
    write_volume(&directory.join("a.raw"));
    let header =
        "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 7 6 5\nspacings: 1 1.5 0.7\nencoding: raw\n";
    fs::write(directory.join("a.nhdr"), format!("{header}data file: a.raw\n"))
        .expect("there is room for files");
    let labels: Vec<u8> = (0..210_u32).map(|n| (n / 70) as u8).collect();
    fs::write(directory.join("l.nrrd"), [header.as_bytes(), b"\n", &labels].concat())
        .expect("there is room for files");
    fs::write(directory.join("l.ctbl"), "1 a 255 0 0 255\n2 b 0 255 0 51\n9 c 0 0 255 255\n")
        .expect("there is room for files");
    fs::write(directory.join("m.obj"), "v 0 0 0\nv 5 0 0\nv 0 5 3\nf 1 2 3\nl 1 3\np 2\n")
        .expect("there is room for files");
    let map = r#"[{"Points": [0, 0, 0.5, 0, 200, 1, 0.5, 0], "RGBPoints": [0, 0, 0, 1, 200, 1, 0.1, 0.3]}]"#;
    fs::write(directory.join("map.json"), map).expect("there is room for files");
    let pixels =
        image::RgbaImage::from_fn(4, 4, |x, y| image::Rgba([60 * x as u8, 99, 0, 60 * y as u8]));
    pixels.save(directory.join("t.png")).expect("there is room for files");
}

/// What flags say, one case for each that decides a pixel.
const FLAGS: &[&str] = &[
    "",
    "--series 0 --channel 0 --time 0 --level 0 --spacing 1,2,0.3",
    "--opacity 0:0,255:0.7",
    "--color 0:0.1,0.2,0.3;200:1,1,1",
    "--opacity 0:0,255:0.7 --color 0:0.1,0.2,0.3",
    "--preset gray",
    "--transfer-file map.json",
    "--transfer-box 9,120,0,inf:0.3:1,0.2,0.1 --transfer-box 80,200,10,400",
    "--transfer-image t.png:0,255,0,300",
    "--gradient-opacity 0:0,100:0.9",
    "--isosurface 80:0.4:0.9,0.7,0.6 --isosurface 120",
    "--shading none",
    "--ambient 0.3 --diffuse 0.1 --specular 0.7 --shininess 3 --zero-gradient 0.4 --two-sided false",
    "--light 1,2,3:1,0.5,0.1 --light headlight",
    "--labels l.nrrd",
    "--labels l.nrrd --label-colors l.ctbl",
    "--labels l.nrrd --label-colors auto --only-labels 2",
    "--crop 0,0,0,3,4,2",
    "--crop-index 1,1,1,4,4,3 --lit-cuts",
    "--clip 1,2,3,4.7 --clip 1,-0.3,0,2.5 --cut-out",
    "--preset mr-t1 --opacity-scale 0.5",
    "--colormap turbo --window 5:90 --unit-distance 2.5",
    "--percentile 5:95",
    "--view left --azimuth 3 --elevation -7 --roll 11 --zoom 1.2 --pan 0.1,-0.2",
    "--fit volume --look-at 1,2,1",
    "--projection perspective",
    "--projection perspective --fov-y 41",
    "--eye 20,-9,7 --target 3,3,1 --up 0,0.1,1 --view-height 9.1",
    "--background 0.1,0.2,0.3",
    "--background steelblue:#12345678 --samples 9",
    "--title a --axes --scale-bar --color-bar --orientation-marker --width 90 --height 80",
    "--no-annotations --title b",
    "--method every-sample --kernel crawfis-max",
    "--method axis-aligned --mode separate --slab-width 0.7",
    "--method post-classified --opacity-cutoff 0.9 --tolerance 0",
    "--mode maximum",
    "--normalization product --base-slab-width 0.4 --sections 64 --radial-samples 64 --lookup nearest",
    "--layer builtin:cube:8 --mesh m.obj",
    "--mesh m.obj --line-width 0.3 --point-size 2",
];

/// The same of a volume whose voxels have colours.
const COLOR_FLAGS: &[&str] = &["", "--colors none", "--opacity-from luminance", "--channel 2"];

#[test]
fn scene_is_written_of_colors() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    let header = "NRRD0004\ntype: uint8\ndimension: 4\nsizes: 4 7 6 5\nencoding: raw\n\
                  kinds: RGBA-color domain domain domain\n\n";
    let samples: Vec<u8> = (0..4 * 210_u32).map(|n| (n * n % 251) as u8).collect();
    fs::write(dir.join("c.nrrd"), [header.as_bytes(), &samples].concat())
        .expect("there is room for files");
    for flags in COLOR_FLAGS {
        let args = format!("c.nrrd {flags} --width 14 --height 11 --save-scene x.toml");
        let first = picture(dir, &args, "first.exr");
        assert!(first == picture(dir, "first.exr", "again.exr"), "{flags}");
        let saved = fs::read_to_string(dir.join("x.toml")).unwrap();
        assert_eq!(saved.contains("opacity_from = "), !flags.contains("channel"), "{saved}");
    }
    let warning = |flags: &str| {
        let output = slabsplat(dir, &format!("render x.toml {flags} -o a.png --backend cpu"));
        text(&output.stderr)
    };
    picture(dir, "c.nrrd --width 14 --height 11 --save-scene x.toml", "first.exr");
    assert!(!warning("").contains("is not the volume"), "{}", warning(""));
    let other: Vec<u8> = samples.iter().enumerate().map(|(n, s)| s ^ u8::from(n == 1)).collect();
    fs::write(dir.join("c.nrrd"), [header.as_bytes(), &other].concat())
        .expect("there is room for files");
    assert!(warning("").contains("is not the volume"), "the green of one voxel is another");
}

#[test]
fn scene_is_written_by_every_flag() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    write_inputs(dir);
    for flags in FLAGS {
        let size = if flags.contains("--width") { "" } else { "--width 14 --height 11" };
        let args = format!("a.nhdr {flags} {size}");
        let first = picture(dir, &format!("{args} --save-scene x.toml"), "first.exr");
        let saved = fs::read_to_string(dir.join("x.toml")).unwrap();
        assert_eq!(answer(dir, "scene first.exr"), saved, "{flags}: the picture says the same");
        assert!(first == picture(dir, "first.exr", "again.exr"), "{flags}");
    }
    let saved = fs::read_to_string(dir.join("x.toml")).unwrap();
    assert!(fs::read(dir.join("first.exr")).unwrap() == picture(dir, "x.toml", "again.exr"));
    assert_eq!(answer(dir, "scene x.toml"), saved);
}

/// Every flag of `render --help` is in that list, or decides no pixel.
#[test]
fn scene_flags_are_all_tried() {
    const OTHERS: &[&str] = &[
        "output",
        "format",
        "save-scene",
        "no-metadata",
        "mkdir",
        "stats",
        "json",
        "verbose",
        "quiet",
        "threads",
        "help",
        "dims",
        "type",
        "endian",
        "header-bytes",
        "allow-external",
        "width",
        "height",
        "backend",
        "memory",
        "scratch",
        "distributed",
        "patience",
    ];
    let help = answer(Path::new("."), "render --help");
    let flags = help.split("--").skip(1).map(|rest| {
        rest.split(|c: char| !(c.is_ascii_lowercase() || c == '-')).next().unwrap_or_default()
    });
    let tried = [FLAGS, COLOR_FLAGS].concat().join(" ");
    for flag in flags {
        let is_tried = tried.contains(&format!("--{flag} ")) || tried.ends_with(flag);
        let is_switch = tried.contains(&format!("--{flag}"));
        assert!(
            is_tried || is_switch || OTHERS.contains(&flag),
            "--{flag} is in no scene of this test"
        );
    }
}

#[test]
fn scene_of_a_raw_file_and_of_standard_input() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    write_volume(&dir.join("a.raw"));
    let raw = "--dims 7,5,3 --type uint16 --endian big --spacing 1,2,3 --width 9 --height 9";
    let first = picture(dir, &format!("a.raw {raw} --save-scene x.toml"), "first.png");
    assert!(first == picture(dir, "x.toml", "again.png"));
    assert!(first == picture(dir, "first.png", "again.png"));
    let fed = |args: &str, name: &str| {
        let mut command = program(dir, &format!("render {args} -o {name} --backend cpu"));
        let status =
            command.stdin(fs::File::open(dir.join("a.raw")).unwrap()).stderr(Stdio::null());
        assert!(status.status().unwrap().success(), "{args}");
        fs::read(dir.join(name)).unwrap()
    };
    let first = fed(&format!("- {raw}"), "first.png");
    assert!(first == fed("first.png", "again.png"));
}

#[test]
fn scene_of_a_volume_and_of_a_picture() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    write_inputs(dir);
    let scene = answer(dir, "scene a.nhdr");
    for expected in ["path = \"a.nhdr\"", "hash = \"xxh3:", "opacity = [[", "eye = [", "[render]"] {
        assert!(scene.contains(expected), "{expected} is not in {scene}");
    }
    fs::create_dir(dir.join("out")).unwrap();
    picture(dir, "a.nhdr --width 9 --height 9 --save-scene out/x.toml", "out/a.png");
    let saved = fs::read_to_string(dir.join("out/x.toml")).unwrap();
    assert!(saved.contains("path = \"../a.nhdr\""), "{saved}");
    let printed = answer(dir, "scene out/a.png");
    assert!(printed.contains("path = \"out/../a.nhdr\""), "{printed}");
    answer(dir, "scene out/a.png --tolerance 0.25 -o out/y.toml");
    let changed = fs::read_to_string(dir.join("out/y.toml")).unwrap();
    assert!(
        changed.contains("tolerance = 0.25") && changed.contains("path = \"../a.nhdr\""),
        "{changed}"
    );
    // The volume need not be there to know what the picture shows.
    fs::remove_file(dir.join("a.nhdr")).unwrap();
    assert_eq!(answer(dir, "scene out/a.png"), printed);
    let line = diagnostic(dir, "render out/a.png -o b.png");
    assert!(
        line.contains("a.nhdr") && line.contains("start slabsplat where the file is"),
        "{line}"
    );
}

#[test]
fn scene_of_a_picture_tells_of_other_volumes() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    write_inputs(dir);
    picture(dir, "a.nhdr --labels l.nrrd --mesh m.obj --width 9 --height 9", "a.png");
    let again = "render a.png -o b.png --backend cpu";
    assert!(!text(&slabsplat(dir, again).stderr).contains("warning"));
    let mut samples = fs::read(dir.join("a.raw")).unwrap();
    samples[7] ^= 1;
    fs::write(dir.join("a.raw"), samples).unwrap();
    let labels = fs::read(dir.join("l.nrrd")).unwrap();
    fs::write(dir.join("l.nrrd"), [&labels[..labels.len() - 1], &[1]].concat()).unwrap();
    fs::write(dir.join("m.obj"), "v 0 0 0\nv 5 0 0\nv 0 5 4\nf 1 2 3\n").unwrap();
    let stderr = text(&slabsplat(dir, again).stderr);
    for expected in
        ["a.nhdr is not the volume", "l.nrrd does not hold the labels", "m.obj is not the mesh"]
    {
        assert!(stderr.contains(&format!("warning: {expected}")), "{stderr}");
    }
}

#[test]
fn metadata_can_be_left_out_and_tells_no_folders() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    fs::create_dir(dir.join("private")).unwrap();
    write_inputs(&dir.join("private"));
    let small = "--width 9 --height 9";
    let volume = dir.join("private/a.nhdr");
    picture(dir, &format!("private/a.nhdr {small} --no-metadata"), "a.png");
    let bytes = fs::read(dir.join("a.png")).unwrap();
    assert!(!bytes.windows(4).any(|chunk| chunk == b"iTXt"), "nothing is told");
    let line = diagnostic(dir, "render a.png -o b.png");
    assert!(line.contains("a.png is a picture that does not say what it shows"), "{line}");
    assert!(diagnostic(dir, "scene a.png").contains("does not say what it shows"));
    let line = diagnostic(dir, "scene none.png");
    assert!(line.contains("cannot read none.png") && !line.contains("folders"), "{line}");
    fs::create_dir(dir.join("public")).unwrap();
    picture(dir, &format!("{} {small}", volume.display()), "public/a.exr");
    let bytes = fs::read(dir.join("public/a.exr")).unwrap();
    assert!(!bytes.windows(7).any(|word| word == b"private"), "the folder is not told");
    // It is found beside the picture, or where the program is started.
    let first = fs::read(dir.join("public/a.exr")).unwrap();
    let again =
        program(&dir.join("private"), "render ../public/a.exr -o ../b.exr --backend cpu").output();
    assert!(again.unwrap().status.success());
    let json = json(dir, "render private/a.nhdr --json -q --no-metadata -o c.png");
    assert_eq!(json["volumes"], serde_json::Value::Null);
    assert_eq!(first.len(), fs::read(dir.join("b.exr")).unwrap().len());
}

#[test]
fn render_answers_in_json() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    let args =
        "render builtin:cube --width 9 --height 7 --opacity 300:0,301:1 --backend cpu --threads 2";
    let json = json(dir, &format!("{args} --json --save-scene a.toml -o a.png"));
    assert_eq!(
        [&json["picture"], &json["format"], &json["scene_file"]],
        ["a.png", "png", "a.toml"]
    );
    assert_eq!([&json["width"], &json["height"], &json["threads"]], [9, 7, 2]);
    assert!(json["seconds"].as_f64().is_some_and(|seconds| 0.0 < seconds), "{json}");
    assert_eq!([&json["backend"], &json["volumes"][0]["name"]], ["cpu", "builtin:cube"]);
    let warning = json["warnings"][0].as_str().unwrap();
    assert!(warning.starts_with("nothing is visible"), "{warning}");
    assert_eq!(json["n_voxels"], 0);
    let quiet = slabsplat(dir, &format!("{args} -q -o a.png"));
    assert!(quiet.status.success() && quiet.stderr.is_empty(), "{}", text(&quiet.stderr));
    let verbose = text(&slabsplat(dir, &format!("{args} -v -o a.png")).stderr);
    assert!(
        verbose.contains("volume of [28, 28, 28] voxels, values from")
            && verbose.contains("resident "),
        "{verbose}"
    );
}

#[test]
fn render_to_standard_output() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    let args = "render builtin:cube --width 9 --height 7 --backend cpu";
    let file = picture(dir, "builtin:cube --width 9 --height 7", "a.png");
    let piped = slabsplat(dir, &format!("{args} -o -"));
    assert!(piped.status.success() && piped.stdout == file, "{}", text(&piped.stderr));
    assert!(text(&piped.stderr).contains("\nstandard output: 9 x 7 pixels"));
    let exr = slabsplat(dir, &format!("{args} -o - --format exr")).stdout;
    assert!(exr.starts_with(&[0x76, 0x2f, 0x31, 0x01]), "the signature of an OpenEXR file");
    answer(dir, &format!("{args} -o picture --format png"));
    assert!(fs::read(dir.join("picture")).unwrap() == file);
    assert_eq!(names_in(dir), ["a.png", "picture"]);
    let line = diagnostic(dir, &format!("{args} --json -o -"));
    assert!(line.contains("cannot both go to standard output"), "{line}");
}

#[test]
fn render_makes_folders_if_it_is_told_to() {
    let dir = tempfile::tempdir().unwrap();
    let dir = dir.path();
    let args = "render builtin:cube --width 9 --height 7 --backend cpu";
    let line = diagnostic(dir, &format!("{args} -o b/c/a.png"));
    assert!(line.contains("b/c/a.png: there is no folder b/c; --mkdir makes it"), "{line}");
    let line = diagnostic(dir, &format!("{args} -o a.png --save-scene b/a.toml"));
    assert!(line.contains("b/a.toml: there is no folder b; --mkdir makes it"), "{line}");
    assert!(
        diagnostic(dir, &format!("{args} -o a.png --save-scene a.txt")).contains("named .toml")
    );
    assert_eq!(names_in(dir), [""; 0], "nothing is made");
    answer(dir, &format!("{args} --mkdir -o b/c/a.png --save-scene d/a.toml"));
    assert_eq!(names_in(&dir.join("b/c")), ["a.png"]);
    assert_eq!(names_in(&dir.join("d")), ["a.toml"]);
}
