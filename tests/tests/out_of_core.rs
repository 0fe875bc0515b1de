//! Scenes that are drawn box by box from their files (`DividedScene`): the picture is that of all voxels in
//! memory, and the heap stays within what was asked for.
//!
//! It is on its own, as the heap is counted for the whole process.

#![expect(clippy::unwrap_used, reason = "functions of tests are tests, too")]

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
    let fixed = match DividedScene::open(file, 1) {
        Err(DividedError::NoRoom(no_room)) => no_room.needed_bytes,
        other => panic!("a byte is too little: {other:?}"),
    };
    DividedScene::open(file, fixed + of_boxes).unwrap()
}

#[test]
fn out_of_core_is_in_core_within_its_memory() {
    let _alone = alone();
    for_each_seed(4, |mut rng| {
        let folder = tempfile::tempdir().unwrap();
        write_volume(folder.path(), [97, 70, 101], &mut rng);
        let opacity = [0.02, 0.3, 0.95][rng.usize(..3)];
        let text = scene_text(&mut rng, opacity, "tolerance = 0.0\nopacity_cutoff = 1.0");
        let file = opened(folder.path(), &text);
        let expected = whole(&file);
        for of_boxes in [12 << 20, 24 << 20] {
            let scene = divided(&file, of_boxes);
            let picture = scene.picture(&slabsplat::FrameHandle::new()).unwrap().frame.image;
            let off = expected.max_difference(&picture);
            assert!(off < ROUNDED_TWICE, "{} boxes: {off}, {text}", scene.n_boxes());
            assert!(1 < scene.n_boxes(), "{} boxes", scene.n_boxes());
        }
        // By default rays end at an opacity, which may be in another slab.
        let text = text.replace("opacity_cutoff = 1.0", "opacity_cutoff = 0.998");
        let file = opened(folder.path(), &text);
        let scene = divided(&file, 12 << 20);
        let picture = scene.picture(&slabsplat::FrameHandle::new()).unwrap().frame.image;
        let off = whole(&file).max_difference(&picture);
        assert!(off <= 2e-3 + ROUNDED_TWICE, "{off}, {text}");
    });
    check_memory();
}

/// By the GPU backend that the facade is built with here, against its own picture of the whole.
#[test]
fn out_of_core_by_a_gpu_is_in_core() {
    if !backends().contains(&"wgpu") {
        return;
    }
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let mut rng = Rng::with_seed(11);
    write_volume(folder.path(), [47, 40, 53], &mut rng);
    let text = scene_text(&mut rng, 0.3, "tolerance = 0.0\nopacity_cutoff = 1.0");
    let mut file = opened(folder.path(), &text);
    "wgpu".clone_into(&mut file.backend);
    let scene = divided(&file, 4 << 20);
    assert!(1 < scene.n_boxes() && scene.backend() == "wgpu", "{} boxes", scene.n_boxes());
    let picture = scene.picture(&slabsplat::FrameHandle::new()).unwrap().frame.image;
    let off = whole(&file).max_difference(&picture);
    assert!(off < ROUNDED_TWICE, "{off}, {text}");
    assert_eq!(scene.to_file().unwrap().backend, "wgpu");
}

/// Two layers of one packed volume share its scratch, and it is never in memory whole.
#[test]
fn out_of_core_unpacks_what_is_packed() {
    let _alone = alone();
    for_each_seed(2, |mut rng| {
        let folder = tempfile::tempdir().unwrap();
        write_volume(folder.path(), [97, 70, 101], &mut rng);
        let volume = io::read_volume(folder.path().join("volume.nhdr")).unwrap().volume;
        io::write_volume(folder.path().join("volume.nii.gz"), &volume).unwrap();
        let text = scene_text(&mut rng, 0.3, "tolerance = 0.0\nopacity_cutoff = 1.0");
        let text = text.replace("volume.nhdr", "volume.nii.gz");
        let file = opened(folder.path(), &text);
        let scene = divided(&file, 12 << 20);
        let picture = scene.picture(&slabsplat::FrameHandle::new()).unwrap().frame.image;
        let off = whole(&file).max_difference(&picture);
        assert!(1 < scene.n_boxes() && off < ROUNDED_TWICE, "{} boxes: {off}", scene.n_boxes());
    });
    let folder = tempfile::tempdir().unwrap();
    let grid = Grid::with_spacing([300, 290, 280], [1.0; 3]).unwrap();
    let samples: Vec<u8> = (0..grid.n_voxels()).map(|idx| (idx % 251) as u8).collect();
    let n_bytes = samples.len();
    let volume = Volume::new(grid, samples.into(), Scaling::IDENTITY).unwrap();
    io::write_volume(folder.path().join("volume.nrrd"), &volume).unwrap();
    drop(volume);
    let text = scene_text(&mut Rng::with_seed(1), 0.3, "tolerance = 0.0");
    let mut file = opened(folder.path(), &text.replace("volume.nhdr", "volume.nrrd"));
    file.layers.push(file.layers[0].clone());
    let profiler = dhat::Profiler::builder().testing().build();
    let n_told = Arc::new(AtomicUsize::new(0));
    let counted = n_told.clone();
    let scratch = io::ScratchDesc::default().folder(folder.path()).on_use(move |of| {
        counted.fetch_add(of.n_bytes as usize, Ordering::Relaxed);
    });
    let desc = DividedDesc::new(1 << 30).scratch(scratch);
    let scene = DividedScene::open_framed(&file, &desc, |opened, file| {
        opened.frame(file, &slabsplat::Aim::default())
    });
    let scene = scene.unwrap();
    let most = dhat::HeapStats::get().max_bytes;
    println!("{most} bytes on the heap, of a volume of {n_bytes}");
    assert!(most < n_bytes / 2, "{most} of {n_bytes}");
    assert_eq!(n_told.load(Ordering::Relaxed), n_bytes);
    assert_eq!(scene.sources()[1].scratch().map(|of| of.n_bytes), Some(n_bytes as u64));
    drop((scene, profiler));
}

/// By how much pixels differ, in the mean of all channels.
fn mean_difference(a: &Image, b: &Image) -> f64 {
    let pairs = a.pixels().iter().flatten().zip(b.pixels().iter().flatten());
    let sum: f64 = pairs.map(|(a, b)| f64::from((a - b).abs())).sum();
    sum / (4 * a.pixels().len()) as f64
}

/// As large as it needs to be to be shown while it is drawn, and to have boxes of so many bytes.
fn refined(file: &io::SceneFile, of_boxes: u64) -> DividedScene {
    let open = |memory_bytes| {
        let desc = DividedDesc::new(memory_bytes).refined();
        DividedScene::open_framed(file, &desc, |opened, file| {
            opened.frame(file, &slabsplat::Aim::default())
        })
    };
    let Err(DividedError::NoRoom(no_room)) = open(1) else { panic!("a byte is too little") };
    open(no_room.needed_bytes + of_boxes).unwrap()
}

/// Pictures come nearer to the last one, which is the one that is not refined, to the bit.
#[test]
fn out_of_core_is_refined() {
    let _alone = alone();
    for_each_seed(4, |mut rng| {
        let folder = tempfile::tempdir().unwrap();
        write_volume(folder.path(), [197, 170, 161], &mut rng);
        let opacity = [0.02, 0.3, 0.95][rng.usize(..3)];
        let text = scene_text(&mut rng, opacity, "tolerance = 0.0\nopacity_cutoff = 1.0");
        let file = opened(folder.path(), &text);
        let scene = refined(&file, 1 << 20);
        let (mut shares, mut shown) = (Vec::new(), Vec::new());
        let picture = scene.refined(&slabsplat::FrameHandle::new(), &mut |of| {
            shares.push(of.share());
            shown.push(of.picture().frame.image);
        });
        let image = picture.unwrap().frame.image;
        assert!(image == scene.picture(&slabsplat::FrameHandle::new()).unwrap().frame.image);
        let off: Vec<f64> = shown.iter().map(|shown| mean_difference(shown, &image)).collect();
        println!("{} boxes, at {shares:?}: off by {off:?}", scene.n_boxes());
        // Where hardly a box is seen there is hardly a picture.
        assert!((1..=8).contains(&shares.len()) && shares[0] == 0.0, "{shares:?}");
        assert!(shares.is_sorted() && shares[shares.len() - 1] < 1.0, "{shares:?}");
        assert!(off[0] < COARSE && off[off.len() - 1] <= off[0] + OF_BYTES, "{off:?}");
    });
    let folder = tempfile::tempdir().unwrap();
    write_volume(folder.path(), [40, 40, 40], &mut Rng::with_seed(1));
    let text = scene_text(&mut Rng::with_seed(1), 0.3, "tolerance = 0.0");
    let scene = divided(&opened(folder.path(), &text), 12 << 20);
    let error = scene.refined(&slabsplat::FrameHandle::new(), &mut |_| {}).unwrap_err();
    assert!(matches!(error, DividedError::NotRefined), "{error}");
}

/// Who hears of a picture may cancel the frame, which leaves no trace in the next one; and so may others
/// while a single box is drawn.
#[test]
fn out_of_core_is_cancelled() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let mut rng = Rng::with_seed(12);
    write_volume(folder.path(), [197, 170, 161], &mut rng);
    let text = scene_text(&mut rng, 0.02, "tolerance = 0.0");
    let file = opened(folder.path(), &text.replace("height = 60", "height = 600"));
    let scene = refined(&file, 1 << 20);
    let expected = scene.picture(&slabsplat::FrameHandle::new()).unwrap().frame.image;
    let is_cancelled = |error: &DividedError| error.to_string().contains("the frame was cancelled");
    for n_heard_at_most in 1..4 {
        let frame = slabsplat::FrameHandle::new();
        let mut n_heard = 0;
        let drawn = scene.refined(&frame, &mut |_| {
            n_heard += 1;
            if n_heard == n_heard_at_most {
                frame.cancel();
            }
        });
        assert!(is_cancelled(&drawn.unwrap_err()));
        assert_eq!(n_heard, n_heard_at_most);
    }
    assert!(expected == scene.picture(&slabsplat::FrameHandle::new()).unwrap().frame.image);
    let whole = refined(&file, 2 << 30);
    assert_eq!(whole.n_boxes(), 1);
    let frame = slabsplat::FrameHandle::new();
    let drawn = std::thread::scope(|threads| {
        let drawing = threads.spawn(|| whole.picture(&frame));
        while frame.progress() == 0.0 && !drawing.is_finished() {
            std::thread::yield_now();
        }
        frame.cancel();
        drawing.join().unwrap()
    });
    assert!(is_cancelled(&drawn.unwrap_err()), "at {}", frame.progress());
    assert!(frame.progress() < 1.0);
}

/// Two layers, cut by regions, of which one counts voxels of its grid; samples of a pixel, and a gradient.
#[test]
fn out_of_core_draws_layers_and_regions() {
    let _alone = alone();
    for_each_seed(2, |mut rng| {
        let folder = tempfile::tempdir().unwrap();
        write_volume(folder.path(), [57, 70, 61], &mut rng);
        for name in ["volume.nhdr", "volume.raw"] {
            let other = name.replace("volume", "other");
            let bytes = fs::read(folder.path().join(name)).unwrap();
            let bytes = if name == "volume.nhdr" {
                let header = String::from_utf8(bytes).unwrap().replace("volume.raw", "other.raw");
                header.replace("1 1.3 0.8", "1.4 1.1 0.7").into_bytes()
            } else {
                bytes
            };
            fs::write(folder.path().join(other), bytes).unwrap();
        }
        let text = scene_text(&mut rng, 0.2, "tolerance = 0.0\nopacity_cutoff = 1.0");
        let (_, behind) = text.split_once("[camera]").unwrap();
        let layer = |file: &str, opacity: f64, region: &str| {
            format!(
                "[[layers]]\n[layers.volume]\npath = \"{file}.nhdr\"\n[layers.classify]\n\
                 opacity = [[90.0, 0.0], [220.0, {opacity}]]\ncolor = [[90.0, 1.0, 0.2, 0.1]]\n{region}\n"
            )
        };
        let layers = [
            layer(
                "volume",
                0.3,
                "[layers.region]\nbox = [[0.0, 5.0, 3.0], [40.0, 60.0, 44.0]]\nindex = true\nlit = true",
            ),
            layer(
                "other",
                0.05,
                "[layers.region]\nplanes = [[0.6, 0.8, 0.1, 60.0]]\ninvert = true",
            ),
        ];
        let text = format!(
            "{}[camera]{}",
            layers.concat(),
            behind.replace("height = 60", "height = 60\nsamples = 4")
        );
        let file = opened(folder.path(), &text);
        let scene = divided(&file, 24 << 20);
        let picture = scene.picture(&slabsplat::FrameHandle::new()).unwrap().frame.image;
        let off = whole(&file).max_difference(&picture);
        assert!(1 < scene.n_boxes() && off < ROUNDED_TWICE, "{} boxes: {off}", scene.n_boxes());
    });
}

/// Everything is relevant, and faint.
fn check_memory() {
    let folder = tempfile::tempdir().unwrap();
    let mut rng = Rng::with_seed(3);
    write_volume(folder.path(), [190, 180, 170], &mut rng);
    let volume = io::read_volume(folder.path().join("volume.nhdr")).unwrap().volume;
    io::write_volume(folder.path().join("volume.zarr"), &volume).unwrap();
    drop(volume);
    let text = "[volume]\npath = \"volume.nhdr\"\n[classify]\nopacity = [[0.0, 0.01], [255.0, 0.02]]\n\
                color = [[0.0, 1.0, 0.2, 0.1]]\n[camera]\neye = [400.0, 300.0, 200.0]\n\
                target = [95.0, 117.0, 68.0]\nup = [0.0, 0.0, 1.0]\nprojection = \"orthographic\"\n\
                view_height = 280.0\n[image]\nwidth = 400\nheight = 400\n";
    for name in ["volume.nhdr", "volume.zarr"] {
        let file = opened(folder.path(), &text.replace("volume.nhdr", name));
        let profiler = dhat::Profiler::builder().testing().build();
        for of_boxes in [16_u64 << 20, 40 << 20] {
            let scene = divided(&file, of_boxes);
            assert_eq!(scene.n_threads(), 1);
            let memory = scene.memory_bytes();
            let before = dhat::HeapStats::get();
            scene.picture(&slabsplat::FrameHandle::new()).unwrap();
            let after = dhat::HeapStats::get();
            let most = after.max_bytes as u64;
            let chunks = scene.sources()[0].chunk_counts();
            let n_boxes = scene.n_boxes();
            println!("{name}, {n_boxes} boxes: {most} bytes, {memory} granted; chunks {chunks:?}");
            assert!(before.curr_bytes < after.max_bytes);
            assert!(most + BESIDE_HEAP <= memory, "{most} of {memory}");
        }
        let scene = refined(&file, 1 << 20);
        let memory = scene.memory_bytes();
        scene.refined(&slabsplat::FrameHandle::new(), &mut |of| drop(of.picture())).unwrap();
        let most = dhat::HeapStats::get().max_bytes as u64;
        println!("{name}, refined in {} boxes: {most} bytes, {memory} granted", scene.n_boxes());
        assert!(most + BESIDE_HEAP <= memory, "{most} of {memory}");
        drop(profiler);
    }
}

/// A thread counts for 16 MiB, and one in any case; boxes have at least as much as all of them.
#[test]
fn out_of_core_has_the_threads_that_memory_pays_for() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let mut rng = Rng::with_seed(9);
    write_volume(folder.path(), [97, 70, 101], &mut rng);
    let text = scene_text(&mut rng, 0.02, "tolerance = 0.0\nopacity_cutoff = 1.0");
    let file = opened(folder.path(), &text);
    let expected = whole(&file);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(16).build().unwrap();
    for (of_boxes, n_threads) in [(12 << 20, 1), (112 << 20, 4), (1 << 30, 16)] {
        let profiler = dhat::Profiler::builder().testing().build();
        let scene = pool.install(|| divided(&file, of_boxes));
        assert_eq!(scene.n_threads(), n_threads);
        let frame = slabsplat::FrameHandle::new();
        let picture = pool.install(|| scene.picture(&frame)).unwrap().frame.image;
        let (most, memory) = (dhat::HeapStats::get().max_bytes as u64, scene.memory_bytes());
        assert!(most + BESIDE_HEAP <= memory, "{n_threads} threads: {most} of {memory}");
        let off = expected.max_difference(&picture);
        assert!(off < ROUNDED_TWICE, "{n_threads} threads: {off}, {text}");
        drop(profiler);
    }
}

/// Files of an array in a folder, and chunks among them.
fn zarr_of(folder: &Path, rng: &mut Rng) -> (io::SceneFile, Vec<PathBuf>) {
    write_volume(folder, [97, 70, 101], rng);
    let volume = io::read_volume(folder.join("volume.nhdr")).unwrap().volume;
    io::write_volume(folder.join("volume.zarr"), &volume).unwrap();
    let text = scene_text(rng, 0.3, "tolerance = 0.0\nopacity_cutoff = 1.0");
    let file = opened(folder, &text.replace("volume.nhdr", "volume.zarr"));
    let entries = fs::read_dir(folder.join("volume.zarr/0")).unwrap();
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    let mut chunks = Vec::new();
    while let Some(path) = paths.pop() {
        if path.is_dir() {
            paths.extend(fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path()));
        } else if path.file_name().unwrap() != ".zarray" {
            chunks.push(path);
        }
    }
    chunks.sort();
    (file, chunks)
}

/// Chunks that are not there have the fill value, which shows.
#[test]
fn out_of_core_fills_missing_chunks() {
    let _alone = alone();
    for_each_seed(2, |mut rng| {
        let folder = tempfile::tempdir().unwrap();
        let (file, chunks) = zarr_of(folder.path(), &mut rng);
        let meta = folder.path().join("volume.zarr/0/.zarray");
        let text = fs::read_to_string(&meta).unwrap();
        assert!(text.contains("\"fill_value\": 0"), "{text}");
        fs::write(&meta, text.replace("\"fill_value\": 0", "\"fill_value\": 130")).unwrap();
        let all = whole(&file);
        for path in chunks.iter().filter(|_| rng.bool()) {
            fs::remove_file(path).unwrap();
        }
        let expected = whole(&file);
        let scene = divided(&file, 12 << 20);
        let picture = scene.picture(&slabsplat::FrameHandle::new()).unwrap().frame.image;
        let off = expected.max_difference(&picture);
        assert!(1 < scene.n_boxes() && off < ROUNDED_TWICE, "{} boxes: {off}", scene.n_boxes());
        assert!(0.01 < expected.max_difference(&all), "nothing is missing");
    });
}

/// What was whole when the scene was opened, and is not when it is drawn: the error names the file.
#[test]
fn out_of_core_names_damaged_files() {
    let _alone = alone();
    let mut rng = Rng::with_seed(8);
    let folder = tempfile::tempdir().unwrap();
    let (file, chunks) = zarr_of(folder.path(), &mut rng);
    let scene = divided(&file, 12 << 20);
    let middle = &chunks[chunks.len() / 2];
    let bytes = fs::read(middle).unwrap();
    let flipped: Vec<u8> = bytes.iter().map(|byte| byte ^ 0x5a).collect();
    let cut_off = &bytes[..bytes.len() / 2];
    let name = middle.strip_prefix(folder.path()).unwrap().to_str().unwrap();
    for damaged in [&flipped[..], cut_off, &[]] {
        fs::write(middle, damaged).unwrap();
        // Those that are retained are whole.
        scene.sources()[0].retain_chunks(0);
        let drawn = scene.picture(&slabsplat::FrameHandle::new()).unwrap_err().to_string();
        assert!(drawn.contains(name) && drawn.contains("a chunk"), "{drawn}");
        let opened = DividedScene::open(&file, 1 << 30).unwrap_err().to_string();
        assert!(opened.contains(name) && !opened.contains('\n'), "{opened}");
    }
    fs::write(middle, &bytes).unwrap();
    scene.picture(&slabsplat::FrameHandle::new()).unwrap();
    let raw = opened(folder.path(), &scene_text(&mut rng, 0.3, "tolerance = 0.0"));
    let scene = divided(&raw, 12 << 20);
    let path = folder.path().join("volume.raw");
    let bytes = fs::read(&path).unwrap();
    for n_left in [0, bytes.len() / 2, bytes.len() - 1] {
        fs::write(&path, &bytes[..n_left]).unwrap();
        let drawn = scene.picture(&slabsplat::FrameHandle::new()).unwrap_err().to_string();
        let expected = format!("volume.raw: needs {} bytes of data, has {n_left}", bytes.len());
        assert!(drawn.contains(&expected), "{drawn}");
    }
    fs::remove_file(&path).unwrap();
    let drawn = scene.picture(&slabsplat::FrameHandle::new()).unwrap_err().to_string();
    assert!(drawn.contains("cannot read") && drawn.contains("volume.raw"), "{drawn}");
}

/// Of 5·10⁹ voxels those in the middle, which a file of their own has, too; all others are a hole in the
/// file.
#[test]
fn out_of_core_of_more_voxels_than_32_bits() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let dims: [u64; 3] = [2048, 2048, 1200];
    let side = 128;
    let first = dims.map(|n| (n - side) / 2);
    let raw = |name: &str| fs::File::create(folder.path().join(name)).unwrap();
    let [large, small] = ["large.raw", "small.raw"].map(raw);
    large.set_len(dims.iter().product()).unwrap();
    small.set_len(side * side * side).unwrap();
    let mut rng = Rng::with_seed(9);
    let write = |mut file: &fs::File, at: u64, bytes: &[u8]| {
        file.seek(SeekFrom::Start(at)).unwrap();
        file.write_all(bytes).unwrap();
    };
    for (k, j) in (0..side).flat_map(|k| (0..side).map(move |j| (k, j))) {
        let row: Vec<u8> = (0..side)
            .map(|i| {
                let from = [i, j, k].map(|c| c as f64 - 63.5);
                let radius = from.iter().map(|c| c * c).sum::<f64>().sqrt();
                if radius < 40.0 { (200.0 - 2.0 * radius) as u8 + rng.u8(..40) } else { 0 }
            })
            .collect();
        let at = ((first[2] + k) * dims[1] + first[1] + j) * dims[0] + first[0];
        write(&large, at, &row);
        write(&small, (k * side + j) * side, &row);
    }
    let header = |name: &str, [x, y, z]: [u64; 3], [i, j, k]: [u64; 3]| {
        let text = format!(
            "NRRD0004\ntype: uint8\ndimension: 3\nspace dimension: 3\nsizes: {x} {y} {z}\n\
             space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: ({i},{j},{k})\n\
             encoding: raw\ndata file: {name}.raw\n"
        );
        fs::write(folder.path().join(format!("{name}.nhdr")), text).unwrap();
    };
    header("large", dims, [0; 3]);
    header("small", [side; 3], first);
    let middle = dims.map(|n| (n as f64 - 1.0) / 2.0);
    let eye = [middle[0] + 300.0, middle[1] + 120.0, middle[2] + 210.0];
    let scene = |name: &str| {
        let text = format!(
            "[volume]\npath = \"{name}.nhdr\"\n[classify]\nopacity = [[60.0, 0.0], [200.0, 0.2]]\n\
             color = [[60.0, 1.0, 0.2, 0.1], [200.0, 0.3, 0.9, 1.0]]\n[camera]\neye = {eye:?}\n\
             target = {middle:?}\nup = [0.1, 0.2, 1.0]\nprojection = \"orthographic\"\n\
             view_height = 90.0\n[image]\nwidth = 72\nheight = 60\n[render]\ntolerance = 0.0\n\
             opacity_cutoff = 1.0\n"
        );
        opened(folder.path(), &text)
    };
    let expected = whole(&scene("small"));
    let scene = scene("large");
    let error = OpenScene::open(&scene).unwrap_err().to_string();
    assert!(error.contains("too many voxels"), "{error}");
    let divided = divided(&scene, 64 << 20);
    let picture = divided.picture(&slabsplat::FrameHandle::new()).unwrap().frame.image;
    let off = expected.max_difference(&picture);
    println!("{} boxes: off by {off}", divided.n_boxes());
    assert!(off < ROUNDED_TWICE && 0.1 < expected.pixels()[30 * 72 + 36][3], "{off}");
}

#[test]
fn out_of_core_says_what_it_cannot() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let mut rng = Rng::with_seed(5);
    write_volume(folder.path(), [20, 20, 20], &mut rng);
    let text = scene_text(&mut rng, 0.5, "tolerance = 0.0");
    let error = |text: &str, memory| {
        let file = opened(folder.path(), text);
        DividedScene::open(&file, memory).unwrap_err().to_string()
    };
    let check = |found: String, expected: &str| assert!(found.contains(expected), "{found}");
    check(error(&text, 1 << 20), "too few");
    let method = text.replace("tolerance", "method = \"post-classified\"\ntolerance");
    check(error(&method, 1 << 30), "not the method post-classified");
    let mode = text.replace("tolerance", "mode = \"maximum\"\ntolerance");
    check(error(&mode, 1 << 30), "not the mode maximum");
    let builtin = text.replace("path = \"volume.nhdr\"", "generate = \"cube\"");
    check(error(&builtin, 1 << 30), "made whole");
    fs::write(folder.path().join("volume.raw"), [0; 7999]).unwrap();
    check(error(&text, 1 << 30), "cut off");
}
