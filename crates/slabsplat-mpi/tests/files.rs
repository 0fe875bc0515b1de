//! Scenes of files at random, drawn by 1 to 8 ranks that are threads: the picture is that of one process with
//! all voxels in memory.

#![expect(clippy::unwrap_used, reason = "functions of tests are tests, too")]

mod common;

use common::{LIMIT, ROUNDED_TWICE, by_ranks, whole};
use fastrand::Rng;
use slabsplat::io;
use slabsplat::{FrameHandle, SharedDesc};
use slabsplat_mpi::{Communicator, DistributedScene, ThreadRank};
use slabsplat_seeds::for_each_seed;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

/// Blobs and noise in some of the volume, and nothing in the rest.
fn write_volume(folder: &Path, name: &str, rng: &mut Rng) {
    let dims = [0; 3].map(|_| rng.usize(9..50));
    let blobs = [0; 4].map(|_| dims.map(|n| rng.f64() * n as f64));
    let spacings = [0; 3].map(|_| 0.6 + rng.f64());
    let mut samples = Vec::new();
    for at in (0..dims[2]).flat_map(|k| {
        (0..dims[1]).flat_map(move |j| (0..dims[0]).map(move |i| [i as f64, j as f64, k as f64]))
    }) {
        let from = |blob: &[f64; 3]| {
            (0..3).map(|axis| (at[axis] - blob[axis]).powi(2)).sum::<f64>().sqrt()
        };
        let nearest = blobs.iter().map(from).fold(f64::INFINITY, f64::min);
        let noise = if nearest < 12.0 { rng.f64() * 30.0 } else { 0.0 };
        samples.push((225.0 - 14.0 * nearest + noise).clamp(0.0, 255.0) as u8);
    }
    let [x, y, z] = dims;
    let [sx, sy, sz] = spacings;
    let header = format!(
        "NRRD0004\ntype: uint8\ndimension: 3\nsizes: {x} {y} {z}\nspacings: {sx} {sy} {sz}\n\
         encoding: raw\ndata file: {name}.raw\n"
    );
    fs::write(folder.join(format!("{name}.nhdr")), header).unwrap();
    fs::write(folder.join(format!("{name}.raw")), samples).unwrap();
}

/// One layer or two, with or without a region, of any compositing, normalisation, projection, width and
/// tolerance.
fn scene_text(rng: &mut Rng, n_layers: usize) -> String {
    let mut text = String::new();
    for layer in 0..n_layers {
        let opacity = [0.03, 0.3, 0.97][rng.usize(..3)];
        write!(
            text,
            "[[layers]]\n[layers.volume]\npath = \"{layer}.nhdr\"\n[layers.classify]\n\
             opacity = [[60.0, 0.0], [200.0, {opacity}]]\n\
             color = [[60.0, 1.0, 0.2, 0.1], [200.0, 0.3, 0.9, 1.0]]\n"
        )
        .unwrap();
        if rng.u8(..3) == 0 {
            let lit = rng.bool();
            write!(text, "[layers.region]\nplanes = [[0.6, 0.8, 0.1, 18.0]]\nlit = {lit}\n")
                .unwrap();
        }
    }
    let eye = [0; 3].map(|_| 200.0 * (rng.f64() - 0.5));
    let size = if rng.bool() {
        "projection = \"perspective\"\nfov_y = 40.0"
    } else {
        "projection = \"orthographic\"\nview_height = 70.0"
    };
    let kernel = ["gaussian", "crawfis-max"][rng.usize(..2)];
    let mode = ["extinction", "separate", "associated"][rng.usize(..3)];
    let width = [0.3, 0.77, 1.0, 2.0, 3.3][rng.usize(..5)];
    let tolerance = [0.0, 0.0, 0.05][rng.usize(..3)];
    write!(
        text,
        "[camera]\neye = {eye:?}\ntarget = [20.0, 18.0, 22.0]\nup = [0.1, 0.2, 1.0]\n{size}\n\
         [image]\nwidth = {}\nheight = {}\nbackground = [0.1, 0.2, 0.3, 1.0]\n\
         [render]\nkernel = \"{kernel}\"\nmode = \"{mode}\"\nslab_width = {width}\n\
         tolerance = {tolerance}\nopacity_cutoff = 1.0\n",
        rng.u32(20..70),
        rng.u32(20..70),
    )
    .unwrap();
    text
}

#[test]
fn ranks_are_one_process() {
    let mut worst = 0.0_f32;
    for_each_seed(6, |mut rng| {
        let folder = tempfile::tempdir().unwrap();
        let n_layers = rng.usize(1..3);
        (0..n_layers).for_each(|layer| write_volume(folder.path(), &layer.to_string(), &mut rng));
        let text = scene_text(&mut rng, n_layers);
        let path = folder.path().join("scene.toml");
        fs::write(&path, &text).unwrap();
        let file = io::read_scene(&path).unwrap();
        let expected = whole(&file);
        for n_ranks in [1, 2, 3, 4, 5, 8] {
            let off =
                expected.max_difference(&by_ranks(&file, &SharedDesc::default(), [n_ranks; 2]));
            worst = worst.max(off);
            assert!(off < ROUNDED_TWICE, "{n_ranks} ranks: {off}, {text}");
        }
    });
    println!("off by {worst} at most");
}

/// Where a pixel covers a dozen voxels, the smallest boxes need more than a rank's part: it has that, too.
#[test]
fn ranks_have_room_for_minified_volumes() {
    let folder = tempfile::tempdir().unwrap();
    let volume = io::builtin_volume("sphere", Some(240)).unwrap();
    io::write_volume(folder.path().join("volume.npy"), &volume).unwrap();
    let path = folder.path().join("scene.toml");
    let text = "[volume]\npath = \"volume.npy\"\n[image]\nwidth = 16\nheight = 16\n\
                [render]\nopacity_cutoff = 1.0\n";
    fs::write(&path, text).unwrap();
    let file = io::read_scene(&path).unwrap();
    let expected = whole(&file);
    let off = expected.max_difference(&by_ranks(&file, &SharedDesc::default(), [4; 2]));
    assert!(off < ROUNDED_TWICE, "{off}");
    // What is said is kept to.
    let little = SharedDesc::default().memory_bytes(Some(110 << 20));
    let errors = ThreadRank::run(4, LIMIT, |comm| {
        DistributedScene::open(comm, &file, &little).unwrap_err().to_string()
    });
    assert!(errors[0].contains("110 MiB of memory are too few"), "{errors:?}");
}

/// What a rank cannot read fails on all of them, by one error.
#[test]
fn ranks_fail_together() {
    let folder = tempfile::tempdir().unwrap();
    let mut rng = Rng::with_seed(3);
    write_volume(folder.path(), "0", &mut rng);
    let path = folder.path().join("scene.toml");
    fs::write(&path, scene_text(&mut rng, 1)).unwrap();
    let file = io::read_scene(&path).unwrap();
    let mut without = file.clone();
    without.layers[0].volume = io::VolumeSource::File(folder.path().join("none.nhdr"));
    let errors = ThreadRank::run(4, LIMIT, |comm| {
        let file = if comm.rank() == 2 { &without } else { &file };
        DistributedScene::open(comm, file, &SharedDesc::default()).unwrap_err()
    });
    assert!(errors.windows(2).all(|pair| pair[0] == pair[1]), "{errors:?}");
    assert!(errors[0].is_shared() && errors[0].to_string().starts_with("rank 2: "), "{errors:?}");
    // A frame that is cancelled on one rank is on all.
    let errors = ThreadRank::run(3, LIMIT, |comm| {
        let scene = DistributedScene::open(comm, &file, &SharedDesc::default()).unwrap();
        let handle = FrameHandle::new();
        if comm.rank() == 1 {
            handle.cancel();
        }
        scene.picture(comm, &handle).unwrap_err()
    });
    assert!(errors.iter().all(|error| error.to_string().starts_with("rank 1: ")), "{errors:?}");
}
