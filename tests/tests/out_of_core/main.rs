//! Scenes that are drawn box by box from their files (`DividedScene`): the picture is that of all voxels in
//! memory, and the heap stays within what was asked for.
//!
//! It is on its own, as the heap is counted for the whole process.

#![expect(clippy::unwrap_used, reason = "functions of tests are tests, too")]

mod files;
mod pictures;
mod refinement;
mod scenes;

use fastrand::Rng;
use slabsplat::{
    DividedDesc, DividedError, DividedScene, Grid, Image, OpenScene, Renderer, Scaling, Volume,
    backend_named, io,
};
use slabsplat_seeds::for_each_seed;
use slabsplat_tests::render::backends;
use std::fs;
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

#[global_allocator]
static HEAP: dhat::Alloc = dhat::Alloc;

/// One test at a time: the heap is all of the process's.
static ALONE: Mutex<()> = Mutex::new(());

fn alone() -> MutexGuard<'static, ()> {
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What a picture may differ by of which each part is rounded on its own.
const ROUNDED_TWICE: f32 = 1e-5;

/// What the mean of a picture may be off by that is drawn of overviews.
const COARSE: f64 = 0.02;

/// What a picture may be off by whose back has 8 bits.
const OF_BYTES: f64 = 0.5 / 255.0;

/// What the program is granted beside what it has on its heap.
const BESIDE_HEAP: u64 = 40 << 20;

/// Blobs, noise, and nothing between them.
fn write_volume(folder: &Path, dims: [usize; 3], rng: &mut Rng) {
    let [nx, ny, nz] = dims;
    let blobs = [0; 6].map(|_| dims.map(|n| rng.f64() * n as f64));
    let mut samples = Vec::with_capacity(nx * ny * nz);
    for (k, j, i) in
        (0..nz).flat_map(|k| (0..ny).flat_map(move |j| (0..nx).map(move |i| (k, j, i))))
    {
        let from = |at: &[f64; 3]| {
            let [x, y, z] = [i as f64 - at[0], j as f64 - at[1], k as f64 - at[2]];
            (x * x + y * y + z * z).sqrt()
        };
        let nearest = blobs.iter().map(from).fold(f64::INFINITY, f64::min);
        let noise = if nearest < 20.0 { rng.f64() * 20.0 } else { 0.0 };
        samples.push((230.0 - 9.0 * nearest + noise).clamp(0.0, 255.0) as u8);
    }
    let header = format!(
        "NRRD0004\ntype: uint8\ndimension: 3\nsizes: {nx} {ny} {nz}\nspacings: 1 1.3 0.8\n\
         encoding: raw\ndata file: volume.raw\n"
    );
    fs::write(folder.join("volume.nhdr"), header).unwrap();
    fs::write(folder.join("volume.raw"), samples).unwrap();
}

fn scene_text(rng: &mut Rng, opacity: f64, render: &str) -> String {
    let eye = [0; 3].map(|_| 400.0 * (rng.f64() - 0.5));
    let is_far = eye.iter().any(|c| 80.0 < c.abs());
    let size = if rng.bool() || !is_far {
        "projection = \"perspective\"\nfov_y = 40.0"
    } else {
        "projection = \"orthographic\"\nview_height = 140.0"
    };
    format!(
        "[volume]\npath = \"volume.nhdr\"\n[classify]\nopacity = [[60.0, 0.0], [200.0, {opacity}]]\n\
         color = [[60.0, 1.0, 0.2, 0.1], [200.0, 0.3, 0.9, 1.0]]\n[camera]\neye = {eye:?}\n\
         target = [48.0, 45.0, 40.0]\nup = [0.1, 0.2, 1.0]\n{size}\n[image]\nwidth = 72\nheight = 60\n\
         background = [0.1, 0.2, 0.3, 1.0]\n[render]\n{render}\n"
    )
}

fn whole(file: &io::SceneFile) -> Image {
    let opened = OpenScene::open(file).unwrap();
    let name = if file.backend == "auto" { "cpu" } else { &file.backend };
    let mut renderer = Renderer::new(backend_named(name).unwrap());
    renderer.picture(&opened.scene, opened.acquisition).unwrap().frame.image
}

fn opened(folder: &Path, text: &str) -> io::SceneFile {
    let path = folder.join("scene.toml");
    fs::write(&path, text).unwrap();
    io::read_scene(&path).unwrap()
}

/// As large as it needs to be for so many bytes in boxes.
fn divided(file: &io::SceneFile, of_boxes: u64) -> DividedScene {
    DividedScene::open(file, needed_of(file, 1) + of_boxes).unwrap()
}

/// As large as it needs to be for the smallest boxes that there are.
fn in_smallest_boxes(file: &io::SceneFile) -> DividedScene {
    // A byte for boxes is said to be too little, too.
    let beside_boxes = needed_of(file, 1);
    DividedScene::open(file, needed_of(file, beside_boxes + 1)).unwrap()
}

/// What it says that it takes, where there is less.
fn needed_of(file: &io::SceneFile, memory_bytes: u64) -> u64 {
    match DividedScene::open(file, memory_bytes) {
        Err(DividedError::NoRoom(no_room)) => no_room.needed_bytes,
        other => panic!("{memory_bytes} bytes are too few: {other:?}"),
    }
}

/// As large as it needs to be to be shown while it is drawn, and to have boxes of so many bytes.
fn refined(file: &io::SceneFile, of_boxes: u64) -> DividedScene {
    let open = |memory_bytes| {
        let desc = DividedDesc::new(memory_bytes).refined();
        DividedScene::open_as(file, &desc)
    };
    let Err(DividedError::NoRoom(no_room)) = open(1) else { panic!("a byte is too little") };
    open(no_room.needed_bytes + of_boxes).unwrap()
}
