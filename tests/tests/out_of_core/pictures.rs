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
        for of_boxes in [8 << 20, 12 << 20] {
            let scene = divided(&file, of_boxes);
            let picture = scene.picture(&slabsplat::FrameHandle::new()).unwrap().frame.image;
            let off = expected.max_difference(&picture);
            assert!(off < ROUNDED_TWICE, "{} boxes: {off}, {text}", scene.n_boxes());
            assert!(1 < scene.n_boxes(), "{} boxes", scene.n_boxes());
        }
        // By default rays end at an opacity, which may be in another slab.
        let text = text.replace("opacity_cutoff = 1.0", "opacity_cutoff = 0.998");
        let file = opened(folder.path(), &text);
        let scene = divided(&file, 8 << 20);
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
        let text = text.replace("volume.nhdr", name);
        let file = opened(folder.path(), &text);
        // Of which a pixel covers three voxels, and fourteen, with cells and without.
        let smaller = |n_pixels: u32, tolerance: f64| {
            let size = format!("width = {n_pixels}\nheight = {n_pixels}");
            let text = text.replace("width = 400\nheight = 400", &size);
            opened(folder.path(), &format!("{text}[render]\ntolerance = {tolerance}\n"))
        };
        let (coarse, exact) = (smaller(100, 0.0041), smaller(100, 0.0));
        let (coarsest, exactest) = (smaller(20, 0.0041), smaller(20, 0.0));
        let of_boxes = [
            (&file, 16_u64),
            (&file, 40),
            (&coarse, 40),
            (&coarse, 90),
            (&exact, 40),
            (&coarsest, 160),
            (&exactest, 160),
        ];
        let n_files = if name == "volume.nhdr" { of_boxes.len() } else { 5 };
        for (file, of_boxes) in of_boxes.into_iter().take(n_files) {
            let profiler = dhat::Profiler::builder().testing().build();
            let scene = divided(file, of_boxes << 20);
            assert!(scene.n_threads() <= 2, "more have more beside the heap");
            let memory = scene.memory_bytes();
            let before = dhat::HeapStats::get();
            let picture = scene.picture(&slabsplat::FrameHandle::new()).unwrap();
            let after = dhat::HeapStats::get();
            let most = after.max_bytes as u64;
            let chunks = scene.sources()[0].chunk_counts();
            let (n_boxes, n_splats) = (scene.n_boxes(), picture.frame.stats.n_splats);
            println!("{name}, {n_boxes} boxes: {most} bytes, {memory} granted; chunks {chunks:?}");
            println!("{n_splats} splats");
            assert!(before.curr_bytes < after.max_bytes);
            assert!(most + BESIDE_HEAP <= memory, "{most} of {memory}");
            drop(profiler);
        }
        let profiler = dhat::Profiler::builder().testing().build();
        let scene = refined(&file, 1 << 20);
        let memory = scene.memory_bytes();
        scene.refined(&slabsplat::FrameHandle::new(), &mut |of| drop(of.picture())).unwrap();
        let most = dhat::HeapStats::get().max_bytes as u64;
        println!("{name}, refined in {} boxes: {most} bytes, {memory} granted", scene.n_boxes());
        assert!(most + BESIDE_HEAP <= memory, "{most} of {memory}");
        drop(profiler);
    }
}

/// With a tolerance or without.
fn render_text(rng: &mut Rng) -> String {
    format!("tolerance = {}\nopacity_cutoff = 1.0", [0.0, 0.05][rng.usize(..2)])
}

/// However small boxes are, they have the cells that are drawn in core.
#[test]
fn out_of_core_by_cells_is_in_core() {
    let _alone = alone();
    let (mut n_by_cells, mut worst) = (0, 0.0_f32);
    for_each_seed(4, |mut rng| {
        let folder = tempfile::tempdir().unwrap();
        write_volume(folder.path(), [171, 160, 190], &mut rng);
        let opacity = [0.02, 0.1, 0.5][rng.usize(..3)];
        let tolerance = [0.0041, 0.05, 0.2][rng.usize(..3)];
        let render = format!("tolerance = {tolerance}\nopacity_cutoff = 1.0");
        let height = rng.u32(20..70);
        let text = scene_text(&mut rng, opacity, &render)
            .replace("view_height = 140.0", "view_height = 170.0")
            .replace("height = 60", &format!("height = {height}"));
        let file = opened(folder.path(), &text);
        let expected = whole(&file);
        for of_boxes in [80_u64, 40] {
            let scene = divided(&file, of_boxes << 20);
            let (n_boxes, level) = (scene.n_boxes(), scene.coarsest_cells());
            let picture = scene.picture(&slabsplat::FrameHandle::new()).unwrap().frame.image;
            let off = expected.max_difference(&picture);
            println!("{n_boxes} boxes of level {level}: {off}");
            assert!(off < ROUNDED_TWICE, "{n_boxes} boxes of level {level}: {off}, {text}");
            n_by_cells += usize::from(0 < level && 1 < n_boxes);
            worst = worst.max(off);
        }
    });
    println!("{n_by_cells} by cells, off by {worst} at most");
    assert!(0 < n_by_cells);
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
        let render = render_text(&mut rng);
        let text = scene_text(&mut rng, 0.2, &render);
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
        let height = [30, 60][rng.usize(..2)];
        let text = format!(
            "{}[camera]{}",
            layers.concat(),
            behind.replace("height = 60", &format!("height = {height}\nsamples = 4"))
        );
        let file = opened(folder.path(), &text);
        let scene = in_smallest_boxes(&file);
        let picture = scene.picture(&slabsplat::FrameHandle::new()).unwrap().frame.image;
        let off = whole(&file).max_difference(&picture);
        assert!(1 < scene.n_boxes() && off < ROUNDED_TWICE, "{} boxes: {off}", scene.n_boxes());
    });
}

/// Frames of a film that changes all that a film can; where there is room for boxes, each is read once.
#[test]
fn out_of_core_films_as_in_core() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let mut rng = Rng::with_seed(21);
    write_volume(folder.path(), [57, 70, 61], &mut rng);
    let text = scene_text(&mut rng, 0.3, "tolerance = 0.0\nopacity_cutoff = 1.0");
    let film = "[film]\nseconds = 4\n[[film.keys]]\nat = 2\nazimuth = 50\nslab_width = 0.7\n\
                region = { box = [[4, 5, 6], [50, 60, 50]], index = true }\nopacity_scale = 0.5\n\
                [[film.keys]]\nat = 4\nazimuth = 60\nclassify = { opacity = [[50, 0.0], [180, 0.2]] }\n";
    let file = opened(folder.path(), &format!("{text}{film}"));
    let core = OpenScene::open(&file).unwrap();
    let mut renderer = Renderer::new(backend_named("cpu").unwrap());
    for of_boxes in [8 << 20, 64 << 20] {
        let scene = divided(&file, of_boxes);
        let films = [core.film().unwrap().unwrap(), scene.film().unwrap().unwrap()];
        for seconds in [0.0, 1.0, 3.9] {
            let [whole, parts] = films.each_ref().map(|film| film.scene_at(seconds).unwrap());
            let whole = renderer.picture(&whole, core.acquisition).unwrap().frame.image;
            let parts =
                scene.picture_of(&parts, &slabsplat::FrameHandle::new()).unwrap().frame.image;
            let off = whole.max_difference(&parts);
            assert!(off < ROUNDED_TWICE, "{seconds} s: {off}");
        }
        let [n_read, n_retained] = scene.box_counts();
        assert_eq!(n_read == 1, scene.n_boxes() == 1, "{n_read} read");
        assert!(0 < n_retained || 1 < scene.n_boxes(), "{n_retained} retained");
        println!("{} boxes: {n_read} read, {n_retained} retained", scene.n_boxes());
    }
}

/// Colours with alpha and without, and integers of 64 bits: the scene that is found, and its picture.
#[test]
fn out_of_core_draws_colors_and_wide_integers() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let mut rng = Rng::with_seed(23);
    write_volume(folder.path(), [57, 70, 61], &mut rng);
    let bytes = fs::read(folder.path().join("volume.raw")).unwrap();
    let colors = |n: usize| -> Vec<u8> {
        let of = |v: u8| [v, 255 - v, v / 2 + 40, v];
        bytes.iter().flat_map(|v| of(*v).into_iter().take(n)).collect()
    };
    let wide: Vec<u8> = bytes.iter().flat_map(|v| (i64::from(*v) - 3).to_le_bytes()).collect();
    for (file, kind, data) in [
        ("rgb", "type: uint8\ndimension: 4\nsizes: 3 57 70 61\nkinds: RGB-color", colors(3)),
        ("rgba", "type: uint8\ndimension: 4\nsizes: 4 57 70 61\nkinds: RGBA-color", colors(4)),
        ("wide", "type: int64\ndimension: 3\nsizes: 57 70 61\nkinds:", wide),
    ] {
        let header =
            format!("NRRD0004\n{kind} space space space\nendian: little\nencoding: raw\n\n");
        fs::write(folder.path().join(format!("{file}.nrrd")), [header.as_bytes(), &data].concat())
            .unwrap();
        let render = render_text(&mut rng);
        let text = scene_text(&mut rng, 0.3, &render);
        let text = text.replace("height = 60", &format!("height = {}", [40, 60][rng.usize(..2)]));
        let file = opened(folder.path(), &text.replace("volume.nhdr", &format!("{file}.nrrd")));
        let scene = in_smallest_boxes(&file);
        let picture = scene.picture(&slabsplat::FrameHandle::new()).unwrap().frame.image;
        let off = whole(&file).max_difference(&picture);
        assert!(1 < scene.n_boxes() && off < ROUNDED_TWICE, "{} boxes: {off}", scene.n_boxes());
        let alone = io::SceneFile::of_volume(file.layers[0].volume.clone());
        scenes::check("a volume alone", &alone);
    }
}

/// Labels on a grid of their own, some of which are invisible, packed, and found by themselves; the camera
/// that is found sees what they show. Their looks change with a film's opacities.
#[test]
fn out_of_core_draws_labels() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let mut rng = Rng::with_seed(25);
    write_volume(folder.path(), [57, 70, 61], &mut rng);
    let grid = Grid::with_spacing([20, 33, 18], [2.7, 2.9, 2.6]).unwrap();
    let labels = Volume::from_fn(grid, |[i, j, k]| ((i / 5 + 2 * (j / 9) + k / 7) % 5) as i16 - 1);
    io::write_volume(folder.path().join("labels.nii.gz"), &labels).unwrap();
    let labels = "[labels]\npath = \"labels.nii.gz\"\nonly = [0, 1, 3]\n[[labels.styles]]\nof = [1]\n\
                  color = [0.1, 0.9, 0.2]\nopacity = 0.7\n";
    let text = scene_text(&mut rng, 0.3, "tolerance = 0.05\nopacity_cutoff = 1.0");
    let text = text.replace("height = 60", "height = 40");
    let text = text.replace("[camera]", &format!("{labels}[camera]"));
    let film = "[film]\nseconds = 2\n[[film.keys]]\nat = 2\nopacity_scale = 0.5\n";
    let file = opened(folder.path(), &format!("{text}{film}"));
    let scene = in_smallest_boxes(&file);
    let picture = scene.picture(&slabsplat::FrameHandle::new()).unwrap().frame.image;
    let off = whole(&file).max_difference(&picture);
    assert!(1 < scene.n_boxes() && off < ROUNDED_TWICE, "{} boxes: {off}", scene.n_boxes());
    let core = OpenScene::open(&file).unwrap();
    let films = [core.film().unwrap().unwrap(), scene.film().unwrap().unwrap()];
    let [expected, found] = films.map(|film| film.scene_at(1.0).unwrap());
    let expected = Renderer::new(backend_named("cpu").unwrap()).render(&expected).unwrap().image;
    let found = scene.picture_of(&found, &slabsplat::FrameHandle::new()).unwrap().frame.image;
    assert!(expected.max_difference(&found) < ROUNDED_TWICE);
    let (before, _) = text.split_once("[camera]").unwrap();
    scenes::check("labels", &opened(folder.path(), before));
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
