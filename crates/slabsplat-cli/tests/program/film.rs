//! `turntable` and `film`: films of each format, interrupted and continued.

use crate::{diagnostic, json, names_in, program, slabsplat, text};
use image::AnimationDecoder;
use image::codecs::gif::GifDecoder;
use std::fs::{self, File};
use std::io::BufReader;
use std::path::Path;
use std::process::{Command, Stdio};

const CUBE: &str = "turntable builtin:cube:16 --width 40 --height 30 --backend cpu";

/// Frames of a GIF, as red, green, blue and opacity.
fn frames_of(path: &Path) -> Vec<image::RgbaImage> {
    let file = BufReader::new(File::open(path).expect("the film is there"));
    let frames = GifDecoder::new(file).expect("it is a GIF").into_frames();
    let frames = frames.collect_frames().expect("its frames can be read");
    frames.into_iter().map(image::Frame::into_buffer).collect()
}

#[test]
fn turntable_makes_every_format() {
    let dir = tempfile::tempdir().unwrap();
    for (name, codec) in [
        ("a.gif", "gif"),
        ("a.webp", "webp-lossless"),
        ("a.apng", "png"),
        ("a.png-sequence", "png"),
    ] {
        let made = json(dir.path(), &format!("{CUBE} -o {name} --frames 5 --fps 20 --json"));
        assert_eq!(made["codec"], codec);
        let numbers = ["frames", "width", "height", "continued"].map(|key| made[key].as_u64());
        assert_eq!(numbers, [5, 40, 30, 0].map(Some), "{name}");
        assert_eq!([&made["fps"], &made["duration"]], [20.0, 0.25], "{name}");
    }
    assert_eq!(names_in(dir.path()), ["a.apng", "a.gif", "a.png-sequence", "a.webp"]);
    assert_eq!(names_in(&dir.path().join("a.png-sequence")).len(), 5);
    let frames = frames_of(&dir.path().join("a.gif"));
    assert!(frames.len() == 5 && frames.windows(2).all(|pair| pair[0] != pair[1]));
}

/// A turn by quarters of a cube looks the same four times, but for the light, which turns along.
#[test]
fn turntable_has_camera_and_light_go_around() {
    let dir = tempfile::tempdir().unwrap();
    let made = slabsplat(dir.path(), &format!("{CUBE} -o a.gif --frames 8"));
    assert!(made.status.success(), "{}", text(&made.stderr));
    let frames = frames_of(&dir.path().join("a.gif"));
    let difference = |a: usize, b: usize| {
        let pairs = frames[a].as_raw().iter().zip(frames[b].as_raw());
        pairs.map(|(a, b)| f64::from(a.abs_diff(*b))).sum::<f64>() / frames[a].as_raw().len() as f64
    };
    assert!(
        difference(0, 2) < 1.0 && difference(0, 4) < 1.0,
        "{} {}",
        difference(0, 2),
        difference(0, 4)
    );
    assert!(3.0 < difference(0, 1), "{}", difference(0, 1));
}

/// Nothing of what is seen touches the edge of any frame, but for the haze of kernels, and one comes close.
#[test]
fn turntable_is_within_the_picture_at_any_angle() {
    let dir = tempfile::tempdir().unwrap();
    let shape = "--width 60 --height 60 --frames 16 --background 0,0,0,1 --backend cpu";
    for (volume, flags) in [
        ("builtin:neuron", ""),
        ("builtin:neuron", "--projection perspective --elevation 30"),
        ("builtin:cube:16", "--axis right"),
        ("builtin:cube:16", "--axis x --degrees 90"),
    ] {
        let made = slabsplat(dir.path(), &format!("turntable {volume} -o a.gif {shape} {flags}"));
        assert!(made.status.success(), "{}", text(&made.stderr));
        let mut nearest = u32::MAX;
        for frame in frames_of(&dir.path().join("a.gif")) {
            let is_bright =
                |pixel: &image::Rgba<u8>| pixel.0[..3].iter().any(|channel| 24 < *channel);
            let bright = frame.enumerate_pixels().filter(|(.., pixel)| is_bright(pixel));
            let margins = bright.map(|(x, y, _)| x.min(y).min(59 - x).min(59 - y));
            nearest = nearest.min(margins.min().unwrap_or(u32::MAX));
        }
        assert!((1..10).contains(&nearest), "{volume} {flags}: {nearest} pixels to the edge");
    }
}

fn has_ffmpeg() -> bool {
    let starts = |tool| {
        let mut command = Command::new(tool);
        command.arg("-version").stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok()
    };
    let has_both = starts("ffmpeg") && starts("ffprobe");
    if !has_both {
        eprintln!(
            "skipped: ffmpeg and ffprobe are not installed, so that no MP4 and no WebM is made"
        );
    }
    has_both
}

#[test]
fn turntable_by_ffmpeg() {
    if !has_ffmpeg() {
        return;
    }
    let dir = tempfile::tempdir().unwrap();
    for (name, codec) in [("a.mp4", "h264"), ("a.webm", "vp9")] {
        let made = json(dir.path(), &format!("{CUBE} -o {name} --frames 6 --fps 12 --json"));
        assert_eq!(made["codec"], codec);
        let mut probe = Command::new("ffprobe");
        probe.args(["-v", "error", "-count_frames", "-of", "csv=p=0", "-show_entries"]);
        probe.arg(
            "stream=codec_name,width,height,pix_fmt,color_space,nb_read_frames:format=duration",
        );
        let output = probe.arg(dir.path().join(name)).output().unwrap();
        let found = text(&output.stdout).split_whitespace().collect::<Vec<_>>().join(" ");
        assert_eq!(found, format!("{codec},40,30,yuv420p,bt709,6 0.500000"));
    }
}

#[test]
fn film_without_ffmpeg_says_what_works() {
    let dir = tempfile::tempdir().unwrap();
    let mut command = program(dir.path(), &format!("{CUBE} -o a.mp4"));
    let output = command.env("PATH", "").output().unwrap();
    let expected = "error: mp4 is made by the program ffmpeg, which is not installed: gif, webp, apng and \
                    png-sequence need no other program\n";
    assert_eq!((text(&output.stderr).as_str(), output.status.code()), (expected, Some(1)));
    assert_eq!(names_in(dir.path()), [""; 0]);
}

/// What ffmpeg says is told whether or not anything can be written beside the film, as on a full disk.
#[cfg(unix)]
#[test]
fn film_tells_what_ffmpeg_says() {
    use std::os::unix::fs::PermissionsExt;
    let dir = tempfile::tempdir().unwrap();
    let ffmpeg = dir.path().join("bin/ffmpeg");
    fs::create_dir(dir.path().join("bin")).unwrap();
    let script = "#!/bin/sh\n[ $1 = -version ] && exit\nrm -f a.mp4.frames/*.log\n\
                  echo 'a.mp4: No space left on device' >&2\nexit 1\n";
    fs::write(&ffmpeg, script).unwrap();
    fs::set_permissions(&ffmpeg, fs::Permissions::from_mode(0o755)).unwrap();
    let path = std::env::var("PATH").unwrap();
    let path = format!("{}:{path}", dir.path().join("bin").display());
    let output =
        program(dir.path(), &format!("{CUBE} -o a.mp4")).env("PATH", path).output().unwrap();
    let expected = "error: ffmpeg cannot make the film: a.mp4: No space left on device; once that is mended, \
                    the same command continues with the frames that are there\n";
    assert_eq!((text(&output.stderr).as_str(), output.status.code()), (expected, Some(1)));
}

#[test]
fn film_draws_a_damaged_frame_again() {
    let dir = tempfile::tempdir().unwrap();
    let args = "turntable builtin:neuron -o a.gif --width 90 --height 90 --backend cpu --frames 40";
    killed(dir.path(), args, "a.gif", 5);
    fs::write(dir.path().join("a.gif.frames/frame_00002.png"), "x").unwrap();
    let output = slabsplat(dir.path(), args);
    let stderr = text(&output.stderr);
    let expected = "warning: frame 2 in a.gif.frames is damaged: ";
    assert!(output.status.success() && stderr.contains(expected), "{stderr}");
    assert!(stderr.contains("; it is drawn again\n"), "{stderr}");
    assert_eq!(frames_of(&dir.path().join("a.gif")).len(), 40);
}

/// Kills the program once it has stored some frames.
fn killed(directory: &Path, args: &str, name: &str, n_frames: usize) {
    let mut child =
        program(directory, args).stderr(Stdio::null()).spawn().expect("the program starts");
    let frames = directory.join(format!("{name}.frames"));
    loop {
        let names = if frames.is_dir() { names_in(&frames) } else { Vec::new() };
        if n_frames <= names.iter().filter(|name| name.ends_with(".png")).count() {
            break;
        }
        assert!(
            child.try_wait().expect("it is our child").is_none(),
            "it ended before it was killed"
        );
        std::thread::yield_now();
    }
    child.kill().expect("it is our child");
    child.wait().expect("it is our child");
}

#[test]
fn film_that_was_killed_is_continued_with_the_same_bytes() {
    let with_ffmpeg = has_ffmpeg();
    let names = ["a.gif", "a.webp", "a.apng", "a.mp4"];
    for name in names.iter().filter(|name| with_ffmpeg || !name.ends_with("mp4")) {
        let [at_once, continued] = [(); 2].map(|()| tempfile::tempdir().unwrap());
        let args = format!(
            "turntable builtin:neuron -o {name} --width 90 --height 90 --frames 40 --backend cpu --json"
        );
        let made = json(at_once.path(), &args);
        assert_eq!(made["continued"], 0);
        killed(continued.path(), &args, name, 7);
        assert_eq!(names_in(continued.path()), [format!("{name}.frames")]);
        let output = slabsplat(continued.path(), &args);
        let stderr = text(&output.stderr);
        assert!(stderr.starts_with("continued: "), "{stderr}");
        let bytes = [at_once.path(), continued.path()].map(|dir| fs::read(dir.join(name)).unwrap());
        assert!(bytes[0] == bytes[1], "{name}");
        assert_eq!(names_in(continued.path()), [*name]);
    }
}

#[test]
fn film_is_not_continued_by_another() {
    let dir = tempfile::tempdir().unwrap();
    let args = "turntable builtin:neuron -o a.gif --width 90 --height 90 --backend cpu --frames";
    killed(dir.path(), &format!("{args} 40"), "a.gif", 3);
    for (other, what) in
        [("41", "seconds"), ("40 --rock", "turn"), ("40 --slab-width 2", "slab_width")]
    {
        let error = diagnostic(dir.path(), &format!("{args} {other}"));
        let expected = format!(
            "error: a.gif.frames has frames of another film, which differs in {what}: remove that folder, or \
             --restart begins anew\n"
        );
        assert_eq!(error, expected);
    }
    let made = json(dir.path(), &format!("{args} 5 --restart --json"));
    assert_eq!([&made["continued"], &made["frames"]], [0, 5]);
}

#[cfg(unix)]
#[test]
fn film_that_is_interrupted_says_how_to_go_on() {
    use std::io::Read;
    let dir = tempfile::tempdir().unwrap();
    let args =
        "turntable builtin:neuron -o a.gif --width 90 --height 90 --frames 400 --backend cpu";
    let mut child = program(dir.path(), args).stderr(Stdio::piped()).spawn().unwrap();
    while !dir.path().join("a.gif.frames/frame_00001.png").exists() {
        std::thread::yield_now();
    }
    let mut kill = Command::new("kill");
    assert!(kill.arg("-15").arg(child.id().to_string()).status().unwrap().success());
    assert!(!child.wait().unwrap().success());
    let mut said = String::new();
    child.stderr.take().unwrap().read_to_string(&mut said).unwrap();
    assert_eq!(
        said,
        "interrupted: the same command continues a.gif with the frames that are there\n"
    );
}

const KEYS: &str = r#"
volume = { generate = "cube", size = 16 }
image = { width = 40, height = 30, background = [0.0, 0.0, 0.0, 1.0] }
[film]
fps = 10
[[film.keys]]
at = 0.5
camera = { eye = [0, 0, 90], up = [0, 1, 0] }
[[film.keys]]
at = 1
region = { planes = [[1, 0, 0, 0]] }
slab_width = 2
[[film.keys]]
at = 1.5
opacity_scale = 0
"#;

#[test]
fn film_of_key_frames() {
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("a.toml"), KEYS).unwrap();
    let made = json(dir.path(), "film a.toml -o a.gif --json");
    assert!(made["frames"] == 15 && made["fps"] == 10.0, "{made}");
    let frames = frames_of(&dir.path().join("a.gif"));
    let n_bright = |idx: usize| frames[idx].pixels().filter(|pixel| 60 < pixel.0[1]).count();
    assert!(n_bright(14) == 0 && 0 < n_bright(9), "it fades away");
    // From above the cube is a square, half of which is cut off.
    let (square, half) = (n_bright(5), n_bright(9));
    assert!((3 * half..6 * half).contains(&(2 * square)), "{square} {half}");
    // The first frame is the scene.
    let still = slabsplat(dir.path(), "render a.toml -o a.png");
    assert!(still.status.success());
    let still = image::open(dir.path().join("a.png")).unwrap().into_rgba8();
    let differences = still.as_raw().iter().zip(frames[0].as_raw()).map(|(a, b)| a.abs_diff(*b));
    assert!(differences.max() < Some(40), "colours of a palette");
}

/// A film of each format that has room for it is made again of what it says, to the last byte; what has none
/// has a scene file.
#[test]
fn film_is_made_again_of_what_it_says() {
    let dir = tempfile::tempdir().unwrap();
    let run = |args: &str| {
        let output = slabsplat(dir.path(), args);
        assert!(output.status.success(), "{args}: {}", text(&output.stderr));
    };
    let bytes = |name: &str| fs::read(dir.path().join(name)).unwrap();
    fs::write(dir.path().join("keys.toml"), KEYS).unwrap();
    let turn = "--axis right --degrees 100 --rock --frames 6 --fps 7.3 --light 1,2,3";
    for (what, film) in [("key", "film keys.toml".to_owned()), ("turn", format!("{CUBE} {turn}"))] {
        for ending in ["webp", "apng", "gif"] {
            let [first, again] = [1, 2].map(|n| format!("{what}{n}.{ending}"));
            run(&format!("{film} -o {first} --save-scene {what}.toml"));
            let source = if ending == "gif" { format!("{what}.toml") } else { first.clone() };
            run(&format!("film {source} -o {again}"));
            assert!(bytes(&first) == bytes(&again), "{first}");
        }
        run(&format!("{film} -o {what}.png-sequence"));
        // Every frame is a picture like any other.
        let frame = format!("{what}.png-sequence/frame_00004.png");
        run(&format!("render {frame} -o {what}.png"));
        let [a, b] = [frame, format!("{what}.png")]
            .map(|name| image::open(dir.path().join(name)).unwrap().into_rgba8());
        assert!(a == b, "{what}");
    }
    run(&format!("{CUBE} -o silent.webp --frames 2 --no-metadata"));
    let check = |args: &str, expected: &str| {
        let error = diagnostic(dir.path(), args);
        assert!(error.contains(expected), "{error}");
    };
    check("scene silent.webp", "with --no-metadata");
    check(
        "scene key1.gif",
        "gif has no room for what it shows: take the scene file that --save-scene wrote",
    );
    check("info turn.png-sequence", "name one of its frames, as turn.png-sequence/frame_00000.png");
    check("film turn1.apng -o turn1.apng", "is to be filmed, and would be replaced");
    check(
        "render builtin:cube:8 -o a.webm",
        "a.webm is the name of a film, which `turntable` and `film` make",
    );
}

#[test]
fn film_moves_isosurfaces() {
    let dir = tempfile::tempdir().unwrap();
    let scene = r#"
        volume = { generate = "sphere", size = 24 }
        image = { width = 40, height = 40, background = [0.0, 0.0, 0.0, 1.0] }
        classify = { preset = "gray", isosurfaces = [{ value = 250, color = [1, 1, 1] }] }
        render = { mode = "isosurfaces" }
        [film]
        fps = 4
        [[film.keys]]
        at = 1
        classify = { isosurfaces = [{ value = 20, color = [1, 1, 1] }] }
    "#;
    fs::write(dir.path().join("a.toml"), scene).unwrap();
    let made = json(dir.path(), "film a.toml -o a.gif --json");
    assert_eq!(made["frames"], 4);
    let frames = frames_of(&dir.path().join("a.gif"));
    let sizes = frames.iter().map(|frame| frame.pixels().filter(|pixel| 20 < pixel.0[1]).count());
    let sizes: Vec<usize> = sizes.collect();
    assert!(sizes.windows(2).all(|pair| pair[0] < pair[1]), "the surface grows: {sizes:?}");
    fs::write(
        dir.path().join("b.toml"),
        scene.replace("[{ value = 20, color = [1, 1, 1] }]", "[{ value = 1 }, { value = 2 }]"),
    )
    .unwrap();
    let error = diagnostic(dir.path(), "film b.toml -o b.gif");
    assert!(
        error.contains("keys change the isosurfaces of layer 0: the scene and each"),
        "{error}"
    );
}

#[test]
fn film_where_nothing_is_visible_says_so() {
    let dir = tempfile::tempdir().unwrap();
    let output = slabsplat(dir.path(), &format!("{CUBE} -o a.gif --frames 1 --opacity 0:0"));
    let stderr = text(&output.stderr);
    assert!(stderr.contains("warning: nothing is visible in any frame: "), "{stderr}");
    assert!(stderr.contains("40 x 30 pixels, 1 frame, "), "{stderr}");
}

#[test]
fn film_says_what_is_wrong() {
    let dir = tempfile::tempdir().unwrap();
    let check = |args: &str, expected: &str| {
        assert_eq!(diagnostic(dir.path(), args), format!("error: {expected}\n"), "{args}");
    };
    check(
        "turntable builtin:cube:8 -o a.avi",
        "cannot tell the format of a.avi: name the film one of .mp4, .webm, .gif, .webp, .apng, .png-sequence",
    );
    check(
        "turntable builtin:cube:8 -o b/a.gif",
        "cannot write b/a.gif: there is no folder b; --mkdir makes it",
    );
    check(
        "turntable builtin:cube:8 -o a.gif --fps 0",
        "a film has 0.1 to 240 frames a second, and not 0",
    );
    check(
        "turntable builtin:cube:8 -o a.gif --frames 200000",
        "a film has 1 to 100000 frames, which last 4000 seconds at 25 a second, and not 200000",
    );
    check(
        "turntable builtin:cube:8 -o a.gif --seconds -1",
        "a film lasts a positive number of seconds, and not -1",
    );
    check("turntable builtin:cube:8 -o a.gif --fps 60", "gif shows at most 50 frames a second");
    check(
        "turntable absent.nii -o a.webp --width 20000 --height 1",
        "webp has frames of up to 16384 pixels a side, and not 20000 x 1",
    );
    check(
        "turntable builtin:cube:8 -o a.gif --degrees inf",
        "--degrees is up to 360000 either way, and not inf",
    );
    fs::write(dir.path().join("a.toml"), "volume = { generate = \"cube\", size = 8 }").unwrap();
    check(
        "film a.toml -o a.gif",
        "a.toml: it has no [film] with key frames; slabsplat turntable films what has none",
    );
    let no_keys = "volume = { generate = \"cube\", size = 8 }\n[film]\nseconds = 3\n";
    fs::write(dir.path().join("a.toml"), no_keys).unwrap();
    check(
        "film a.toml -o a.gif",
        "a.toml: it has no [film] with key frames; slabsplat turntable films what has none",
    );
    let help = text(&slabsplat(dir.path(), "film -h").stdout)
        .split_whitespace()
        .collect::<Vec<_>>()
        .join(" ");
    assert!(
        help.contains("[default: as the scene file says; else until the last key; of a turn 6]"),
        "{help}"
    );
    let keys = "volume = { generate = \"cube\", size = 8 }\n[[film.keys]]\nat = 1\n[[film.keys]]\nat = 1\n";
    fs::write(dir.path().join("b.toml"), keys).unwrap();
    let error = diagnostic(dir.path(), "film b.toml -o a.gif");
    assert!(error.contains("b.toml:5: key 1 of the film: at is 1"), "{error}");
    fs::create_dir(dir.path().join("c.gif")).unwrap();
    check("turntable builtin:cube:8 -o c.gif", "cannot write c.gif: it is a folder");
    assert_eq!(names_in(dir.path()), ["a.toml", "b.toml", "c.gif"]);
}

#[test]
fn film_of_one_pixel_and_one_frame() {
    let dir = tempfile::tempdir().unwrap();
    for name in ["a.gif", "a.webp", "a.apng"] {
        let args =
            format!("turntable builtin:cube:8 -o {name} --frames 1 --width 1 --height 1 --json");
        let made = json(dir.path(), &args);
        assert_eq!([&made["frames"], &made["width"], &made["height"]], [1, 1, 1]);
    }
}

#[test]
fn film_before_nothing_says_what_becomes_of_opacity() {
    let dir = tempfile::tempdir().unwrap();
    let args = "turntable builtin:cube:8 --frames 2 --width 9 --height 9 --background 0,0,0,0 -o";
    let warned = |name: &str| {
        text(&slabsplat(dir.path(), &format!("{args} {name}")).stderr).contains("warning: ")
    };
    assert_eq!(["a.gif", "a.webp", "a.apng"].map(warned), [true, false, false]);
}

/// What is drawn on pictures is drawn on each frame, and what is averaged is so in each.
#[test]
fn film_frames_are_finished_as_pictures_are() {
    let dir = tempfile::tempdir().unwrap();
    // A camera that is found would make room for the title.
    let cube = "turntable builtin:cube:8 --frames 3 --width 90 --height 90 --backend cpu \
                --eye 20,-30,20 --target 0,0,0 --up 0,0,1 --view-height 16";
    for (name, flags) in [("plain", ""), ("titled", "--title Cube"), ("fine", "--samples 4")] {
        let made = slabsplat(dir.path(), &format!("{cube} -o {name}.gif {flags}"));
        assert!(made.status.success(), "{}", text(&made.stderr));
    }
    let [plain, titled, fine] =
        ["plain", "titled", "fine"].map(|name| frames_of(&dir.path().join(format!("{name}.gif"))));
    for idx in 0..3 {
        let differs = |other: &[image::RgbaImage], rows: std::ops::Range<u32>| {
            let mut pixels = rows.flat_map(|y| (0..90).map(move |x| (x, y)));
            pixels.any(|(x, y)| {
                let [a, b] = [&plain[idx], &other[idx]].map(|frame| frame.get_pixel(x, y).0);
                a.iter().zip(b).any(|(a, b)| 60 < a.abs_diff(b))
            })
        };
        assert!(differs(&titled, 0..20) && !differs(&titled, 60..90), "{idx}");
        assert!(plain[idx] != fine[idx] && !differs(&fine, 0..90), "{idx}");
    }
}

/// A film takes the place of a film or of nothing.
#[cfg(unix)]
#[test]
fn film_replaces_no_link_and_no_stream() {
    let dir = tempfile::tempdir().unwrap();
    std::os::unix::fs::symlink("elsewhere.gif", dir.path().join("a.gif")).unwrap();
    for (output, expected) in
        [("a.gif", "a.gif is in the way"), ("- --format gif", "cannot go to standard output")]
    {
        let args = format!("turntable builtin:cube:8 --width 8 --height 8 --frames 2 -o {output}");
        let line = diagnostic(dir.path(), &args);
        assert!(line.contains(expected), "{line}");
    }
    assert_eq!(names_in(dir.path()), ["a.gif"]);
}
