//! The gallery of the documentation: its pictures are those of its commands.

use crate::{slabsplat, text};
use image::codecs::webp::WebPDecoder;
use image::{AnimationDecoder, RgbaImage};
use std::io::BufReader;
use std::path::Path;

const GALLERY: &str = include_str!("../../../../docs/gallery.md");

/// What a picture may differ from the one that is kept, in levels of 8 bits, on average: another machine
/// rounds otherwise, and JPEG spreads that.
const MAX_MEAN_DIFFERENCE: f64 = 0.5;

#[test]
fn gallery_is_drawn_by_its_commands() {
    let dir = tempfile::tempdir().unwrap();
    let kept = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/images/gallery");
    let commands: Vec<&str> = commands(GALLERY).collect();
    assert!(9 < commands.len(), "{commands:?}");
    for command in commands {
        let mut words = shlex::split(command).unwrap();
        let Some(volume) = slabsplat_testdata::volume(&words[2]) else { continue };
        let name = words[4].clone();
        assert!(GALLERY.contains(&format!("](images/gallery/{name})")), "{name} is shown");
        words[2] = volume.canonicalize().unwrap().display().to_string();
        let output = run(dir.path(), &words[1..]);
        let [drawn, kept] = [dir.path(), &kept].map(|folder| frames(&folder.join(&name)));
        assert_eq!(drawn.len(), kept.len(), "{name}: {output}");
        for (drawn, kept) in drawn.iter().zip(&kept) {
            let difference = mean_difference(drawn, kept);
            assert!(difference <= MAX_MEAN_DIFFERENCE, "{name}: {difference} levels");
        }
    }
}

#[test]
fn gallery_shows_every_preset() {
    for name in slabsplat::io::PRESET_NAMES {
        assert!(GALLERY.contains(&format!("![{name}](images/gallery/{name}.jpg)")), "{name}");
        assert!(GALLERY.contains(&format!(" -o {name}.jpg --preset {name} ")), "{name}");
    }
}

/// The lines of the listings that call the program.
fn commands(document: &str) -> impl Iterator<Item = &str> {
    let listings = document.split("```sh\n").skip(1).filter_map(|rest| rest.split("```").next());
    listings.flat_map(str::lines).filter(|line| line.starts_with("slabsplat "))
}

fn run(directory: &Path, words: &[String]) -> String {
    let mut command = crate::program(directory, "");
    let output =
        command.args(words).args(["--backend", "cpu"]).output().expect("the program starts");
    assert!(output.status.success(), "{words:?}: {}", text(&output.stderr));
    text(&output.stderr)
}

fn frames(path: &Path) -> Vec<RgbaImage> {
    if path.extension().is_none_or(|extension| extension != "webp") {
        return vec![image::open(path).expect("a picture").into_rgba8()];
    }
    let file = std::fs::File::open(path).expect("a film");
    let decoder = WebPDecoder::new(BufReader::new(file)).expect("an animation");
    decoder.into_frames().map(|frame| frame.expect("a frame").into_buffer()).collect()
}

fn mean_difference(a: &RgbaImage, b: &RgbaImage) -> f64 {
    assert_eq!(a.dimensions(), b.dimensions());
    let sum: u64 = a.iter().zip(b.iter()).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
    sum as f64 / a.len() as f64
}

/// The README's commands on what is built in draw something, too, and in the order in which they stand.
#[test]
fn readme_commands_on_built_in_volumes_run() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::create_dir(dir.path().join("docs")).unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    std::fs::copy(root.join("docs/example.toml"), dir.path().join("docs/example.toml")).unwrap();
    let readme = std::fs::read_to_string(root.join("README.md")).unwrap();
    let mut n = 0;
    for command in commands(&readme) {
        let mut words = shlex::split(command).unwrap();
        let is_here = |word: &String| {
            word.starts_with("builtin:")
                || word.starts_with("docs/")
                || dir.path().join(word).is_file()
        };
        if words[1] != "render"
            || !is_here(&words[2])
            || words.iter().any(|word| word == "--backend")
        {
            continue;
        }
        for side in ["--width", "--height"] {
            if !words.iter().any(|word| word == side) {
                words.extend([side, "64"].map(str::to_owned));
            }
        }
        run(dir.path(), &words[1..]);
        n += 1;
    }
    assert!(15 < n, "{n} commands");
    assert!(slabsplat(dir.path(), "scene neuron.png").status.success());
}
