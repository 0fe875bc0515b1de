//! What is drawn box by box, and what it takes.

use super::*;

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
