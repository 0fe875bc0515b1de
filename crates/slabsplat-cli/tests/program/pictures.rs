//! Formats of pictures, read back.

use crate::{answer, diagnostic, names_in, slabsplat};
use image::ColorType;
use std::path::Path;

const CUBE: &str =
    "render builtin:cube:8 --backend cpu --width 40 --height 30 --background 0.2,0.4,0.6";

/// What a picture is read as; formats that the crate of tests does not read are told by their first bytes.
fn read(path: &Path) -> image::DynamicImage {
    image::open(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

#[test]
fn pictures_of_every_format() {
    let dir = tempfile::tempdir().unwrap();
    for (name, begin) in [
        ("a.png", &b"\x89PNG"[..]),
        ("a.exr", b"\x76\x2f\x31\x01"),
        ("a.tif", b"II*\0"),
        ("a.tiff", b"II*\0"),
        ("a.JPG", b"\xff\xd8\xff"),
        ("a.jpeg", b"\xff\xd8\xff"),
        ("a.webp", b"RIFF"),
    ] {
        answer(dir.path(), &format!("{CUBE} -o {name}"));
        let bytes = std::fs::read(dir.path().join(name)).unwrap();
        assert!(bytes.starts_with(begin), "{name}");
    }
    let png = read(&dir.path().join("a.png")).into_rgba8();
    assert_eq!(png.get_pixel(0, 0).0, [51, 102, 153, 255]);
    let jpeg = read(&dir.path().join("a.jpeg"));
    assert_eq!((jpeg.color(), jpeg.width(), jpeg.height()), (ColorType::Rgb8, 40, 30));
    for (png, jpeg) in png.pixels().zip(jpeg.into_rgb8().pixels()) {
        for channel in 0..3 {
            assert!(png[channel].abs_diff(jpeg[channel]) < 40, "{png:?} {jpeg:?}");
        }
    }
}

/// On standard output as well; what is written is all of what is written into a file.
#[test]
fn pictures_on_standard_output() {
    let dir = tempfile::tempdir().unwrap();
    for format in ["png", "exr", "tiff", "tiff-float", "jpeg", "webp"] {
        let bytes = slabsplat(dir.path(), &format!("{CUBE} --format {format} --no-metadata -o -"));
        answer(dir.path(), &format!("{CUBE} --format {format} --no-metadata -o a"));
        assert!(bytes.stdout == std::fs::read(dir.path().join("a")).unwrap(), "{format}");
    }
}

/// Whatever its format, a picture says what it shows.
#[test]
fn pictures_are_rendered_again() {
    let dir = tempfile::tempdir().unwrap();
    answer(dir.path(), &format!("{CUBE} --title ä -o first.png"));
    let first = read(&dir.path().join("first.png"));
    for name in ["a.exr", "a.tif", "a.jpg", "a.webp"] {
        answer(dir.path(), &format!("{CUBE} --title ä -o {name}"));
        let scene = answer(dir.path(), &format!("scene {name}"));
        assert!(scene.contains("title = \"ä\""), "{name}: {scene}");
        answer(dir.path(), &format!("render {name} -o again.png"));
        assert!(read(&dir.path().join("again.png")) == first, "{name}");
    }
    answer(dir.path(), &format!("{CUBE} --format tiff-float -o b.tif"));
    assert!(answer(dir.path(), "scene b.tif").contains("generate = \"cube\""));
}

/// A TIFF that says nothing of a scene is a volume.
#[test]
fn pictures_in_tiff_are_volumes_too() {
    let dir = tempfile::tempdir().unwrap();
    answer(dir.path(), &format!("{CUBE} --no-metadata -o slice.tif"));
    answer(dir.path(), "render slice.tif --width 20 --height 20 -o a.png");
    let scene = answer(dir.path(), "scene slice.tif");
    assert!(scene.contains("path = \"slice.tif\""), "{scene}");
}

#[test]
fn picture_formats_say_what_they_lack() {
    let dir = tempfile::tempdir().unwrap();
    let check = |flags: &str, expected: &str| {
        let line = diagnostic(dir.path(), &format!("{CUBE} {flags}"));
        assert!(line.contains(expected), "{line} should contain {expected}");
        assert_eq!(names_in(dir.path()), [""; 0]);
    };
    let all = "name it .png, .exr, .tif, .jpg or .webp";
    check("-o a.gif", all);
    check("-o a", all);
    let cleared = CUBE.replace("0.2,0.4,0.6", "transparent");
    let line = diagnostic(dir.path(), &format!("{cleared} -o a.jpg"));
    assert!(line.contains("JPEG has no transparency: an opaque background is needed"), "{line}");
    let line =
        diagnostic(dir.path(), &format!("{} -o a.jpg", CUBE.replace("0.6", "0.6:#00000000")));
    assert!(line.contains("JPEG has no transparency"), "{line}");
    // Before anything is read: the volume is not even there.
    let absent = "render absent.nii --background transparent -o a.jpg";
    let line = diagnostic(dir.path(), absent);
    assert!(line.contains("JPEG has no transparency"), "{line}");
    let line = diagnostic(dir.path(), "render absent.nii --width 20000 --height 9 -o a.webp");
    assert!(line.contains("sides of a WebP are at most 16384 pixels"), "{line}");
    let line = diagnostic(dir.path(), "render absent.nii -o a.jpg");
    assert!(line.contains("absent.nii"), "a background that is found is opaque: {line}");
    let wide = CUBE.replace("--width 40", "--width 20000");
    let line = diagnostic(dir.path(), &format!("{wide} -o a.webp"));
    assert!(line.contains("sides of a WebP are at most 16384 pixels"), "{line}");
    assert_eq!(names_in(dir.path()), [""; 0]);
}
