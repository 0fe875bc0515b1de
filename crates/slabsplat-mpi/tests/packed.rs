//! Packed volumes, labels and colours, which one rank of each computer unpacks and all there read.

#![expect(clippy::unwrap_used, reason = "functions of tests are tests, too")]

mod common;

use common::{LIMIT, OfComputer, ROUNDED_TWICE, by_ranks, whole};
use fastrand::Rng;
use slabsplat::io::{self, SceneFile, ScratchDesc};
use slabsplat::{Grid, Scaling, SharedDesc, Volume};
use slabsplat_mpi::{DistributedScene, MpiError, ThreadRank};
use slabsplat_seeds::for_each_seed;
use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// What a volume's file is, by its first bytes or by its name.
#[derive(Clone, Copy, Debug)]
enum Kind {
    Gzip,
    Hex,
    Rgb,
    Rgba,
}

const KINDS: [Kind; 4] = [Kind::Gzip, Kind::Hex, Kind::Rgb, Kind::Rgba];

/// A ball with noise.
fn ball(dims: [usize; 3], rng: &mut Rng) -> Vec<u8> {
    let mut samples = Vec::new();
    for at in (0..dims[2])
        .flat_map(|k| (0..dims[1]).flat_map(move |j| (0..dims[0]).map(move |i| [i, j, k])))
    {
        let off = |axis: usize| at[axis] as f64 / dims[axis] as f64 - 0.5;
        let distance = (0..3).map(|axis| off(axis).powi(2)).sum::<f64>().sqrt();
        let noise = rng.f64() * 40.0;
        samples.push((230.0 - 380.0 * distance + noise).clamp(0.0, 255.0) as u8);
    }
    samples
}

/// A NRRD whose samples are written as hexadecimal digits, which no box can be read of.
fn write_hex(path: &Path, dims: [usize; 3], (kind, n_values): (&str, usize), samples: &[u8]) {
    let [x, y, z] = dims;
    let axes = match n_values {
        1 => format!("dimension: 3\nsizes: {x} {y} {z}\n"),
        n => {
            let kinds = format!("kinds: {kind} space space space\n");
            format!("dimension: 4\nsizes: {n} {x} {y} {z}\n{kinds}")
        }
    };
    let digits: String = samples.iter().map(|sample| format!("{sample:02x}")).collect();
    let header = format!("NRRD0004\ntype: uint8\n{axes}encoding: hex\n\n");
    fs::write(path, header + &digits).unwrap();
}

/// Writes a volume, and returns its name.
fn write_volume(folder: &Path, kind: Kind, dims: [usize; 3], rng: &mut Rng) -> &'static str {
    let scalars = ball(dims, rng);
    let mut colors = |n_values: usize| -> Vec<u8> {
        let rest = |value: u8, rng: &mut Rng| [value, rng.u8(..), 255 - value, value];
        scalars.iter().flat_map(|value| rest(*value, rng).into_iter().take(n_values)).collect()
    };
    match kind {
        Kind::Gzip => {
            let grid = Grid::with_spacing(dims, [1.0, 1.2, 0.9]).unwrap();
            let scaling = Scaling { slope: 1.0, intercept: 0.0 };
            let volume = Volume::new(grid, scalars.into(), scaling).unwrap();
            io::write_volume(folder.join("a.nii.gz"), &volume).unwrap();
            "a.nii.gz"
        }
        Kind::Hex => {
            write_hex(&folder.join("a.nrrd"), dims, ("", 1), &scalars);
            "a.nrrd"
        }
        Kind::Rgb => {
            write_hex(&folder.join("a.nrrd"), dims, ("RGB-color", 3), &colors(3));
            "a.nrrd"
        }
        Kind::Rgba => {
            write_hex(&folder.join("a.nrrd"), dims, ("RGBA-color", 4), &colors(4));
            "a.nrrd"
        }
    }
}

/// A scene of a packed volume, maybe with packed labels; how many files have to be unpacked.
fn write_scene(folder: &Path, kind: Kind, rng: &mut Rng) -> (SceneFile, usize) {
    let dims = [0; 3].map(|_| rng.usize(12..40));
    let name = write_volume(folder, kind, dims, rng);
    let mut text = format!("[volume]\npath = \"{name}\"\n");
    let has_labels = rng.bool();
    if has_labels {
        let labels: Vec<u8> = (0..dims.iter().product()).map(|at| (at / 97 % 4) as u8).collect();
        write_hex(&folder.join("labels.nrrd"), dims, ("", 1), &labels);
        text += "[labels]\npath = \"labels.nrrd\"\n";
    }
    let opacity = [0.05, 0.4, 0.95][rng.usize(..3)];
    let eye = [0; 3].map(|_| 200.0 * (rng.f64() - 0.5));
    let middle = dims.map(|n| 0.5 * n as f64);
    let tolerance = [0.0, 0.05][rng.usize(..2)];
    text += &format!(
        "[classify]\nopacity = [[60.0, 0.0], [200.0, {opacity}]]\n\
         color = [[60.0, 1.0, 0.2, 0.1], [200.0, 0.3, 0.9, 1.0]]\n\
         [camera]\nprojection = \"orthographic\"\nview_height = 60.0\neye = {eye:?}\n\
         target = {middle:?}\nup = [0.1, 0.2, 1.0]\n\
         [image]\nwidth = 40\nheight = 36\n\
         [render]\ntolerance = {tolerance}\nopacity_cutoff = 1.0\n"
    );
    let path = folder.join("scene.toml");
    fs::write(&path, text).unwrap();
    (io::read_scene(&path).unwrap(), 1 + usize::from(has_labels))
}

#[test]
fn ranks_draw_what_one_of_them_unpacks() {
    let mut worst = 0.0_f32;
    for_each_seed(8, |mut rng| {
        let (folder, scratch) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let kind = KINDS[rng.usize(..KINDS.len())];
        let (file, n_packed) = write_scene(folder.path(), kind, &mut rng);
        let expected = whole(&file);
        for ranks in [[1, 1], [2, 2], [3, 1], [5, 2], [4, 4]] {
            let n_unpacked = Arc::new(AtomicUsize::new(0));
            let counted = n_unpacked.clone();
            let scratch_desc = ScratchDesc::default().folder(scratch.path()).on_use(move |_| {
                counted.fetch_add(1, Ordering::Relaxed);
            });
            let picture = by_ranks(&file, &SharedDesc::default().scratch(scratch_desc), ranks);
            let off = expected.max_difference(&picture);
            worst = worst.max(off);
            assert!(off < ROUNDED_TWICE, "{kind:?} by {ranks:?}: {off}");
            let [n_ranks, n_each] = ranks;
            let n_computers = n_ranks.div_ceil(n_each);
            let n_unpacked = n_unpacked.load(Ordering::Relaxed);
            assert_eq!(n_unpacked, n_packed * n_computers, "{kind:?} by {ranks:?}");
            assert_eq!(fs::read_dir(scratch.path()).unwrap().count(), 0);
        }
    });
    println!("off by {worst} at most");
}

/// A folder that is not there or has no room, and a file that breaks off, on all ranks by one error.
#[test]
fn ranks_fail_together_where_one_unpacks() {
    let (folder, scratch) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let (file, _) = write_scene(folder.path(), Kind::Gzip, &mut Rng::with_seed(4));
    let fail = |scratch_desc: ScratchDesc, expected: &str| {
        let desc = SharedDesc::default().scratch(scratch_desc);
        let open = |of: &ThreadRank| {
            DistributedScene::open(&OfComputer { of, n_each: 2 }, &file, &desc).unwrap_err()
        };
        let errors: Vec<MpiError> = ThreadRank::run(5, LIMIT, open);
        assert!(errors.windows(2).all(|pair| pair[0] == pair[1]), "{errors:?}");
        let said = errors[0].to_string();
        assert!(errors[0].is_shared() && said.contains(expected), "{said}");
        assert!(said.starts_with("rank 0: ") && said.contains("a.nii.gz"), "{said}");
        assert_eq!(fs::read_dir(scratch.path()).unwrap().count(), 0);
    };
    let here = ScratchDesc::default().folder(scratch.path());
    fail(here.clone().folder(scratch.path().join("none")), "No such file");
    fail(here.clone().most_bytes(1000), "choose another folder");
    let path = folder.path().join("a.nii.gz");
    let bytes = fs::read(&path).unwrap();
    fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    fail(here, "needs");
}
