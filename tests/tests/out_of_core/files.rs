//! Files of which boxes are read: packed, in chunks, damaged, huge, and what is refused.

use super::*;

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
    let scene = DividedScene::open_as(&file, &desc).unwrap();
    let most = dhat::HeapStats::get().max_bytes;
    println!("{most} bytes on the heap, of a volume of {n_bytes}");
    assert!(most < n_bytes / 2, "{most} of {n_bytes}");
    assert_eq!(n_told.load(Ordering::Relaxed), n_bytes);
    assert_eq!(scene.sources()[1].scratch().map(|of| of.n_bytes), Some(n_bytes as u64));
    drop((scene, profiler));
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
