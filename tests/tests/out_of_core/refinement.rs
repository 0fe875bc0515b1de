//! Pictures that are shown while boxes come, and frames that are given up.

use super::*;
use slabsplat::glam::{DAffine3, DVec3};

/// By how much pixels differ, in the mean of all channels.
fn mean_difference(a: &Image, b: &Image) -> f64 {
    let pairs = a.pixels().iter().flatten().zip(b.pixels().iter().flatten());
    let sum: f64 = pairs.map(|(a, b)| f64::from((a - b).abs())).sum();
    sum / (4 * a.pixels().len()) as f64
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

/// A volume of as many bytes as there are voxels, as an image of two levels, of which one has means of the
/// other.
fn write_levels(folder: &Path, volume: &Volume) -> Volume {
    let [nx, ny, nz] = volume.grid().dims().map(|n| n / 2);
    let coarse =
        DAffine3::from_translation(DVec3::splat(0.5)) * DAffine3::from_scale(DVec3::splat(2.0));
    let grid = Grid::new([nx, ny, nz], volume.grid().world_from_index() * coarse).unwrap();
    let mean = Volume::from_fn(grid, |[i, j, k]| {
        let of_fine =
            [0, 1, 2, 3, 4, 5, 6, 7].map(|n| [2 * i + n % 2, 2 * j + n / 2 % 2, 2 * k + n / 4]);
        let sum: f64 = of_fine.iter().map(|at| volume.value(volume.grid().voxel_idx(*at))).sum();
        (sum / 8.0).round() as u8
    });
    for (level, volume) in [volume, &mean].into_iter().enumerate() {
        io::write_volume(folder.join(format!("{level}.zarr")), volume).unwrap();
    }
    fs::rename(folder.join("1.zarr/0"), folder.join("0.zarr/1")).unwrap();
    let said = [0, 1].map(|level| {
        let text = fs::read_to_string(folder.join(format!("{level}.zarr/.zattrs"))).unwrap();
        let mut said: serde_json::Value = serde_json::from_str(&text).unwrap();
        said["multiscales"][0]["datasets"][0]["path"] = level.to_string().into();
        said
    });
    let [mut finer, mut coarser] = said;
    let dataset = coarser["multiscales"][0]["datasets"][0].take();
    finer["multiscales"][0]["datasets"].as_array_mut().unwrap().push(dataset);
    fs::write(folder.join("0.zarr/.zattrs"), finer.to_string()).unwrap();
    mean
}

/// What is shown at first is of a coarser level, if the file has one; what is drawn is of the finest.
#[test]
fn out_of_core_is_refined_from_coarser_levels() {
    let _alone = alone();
    for_each_seed(2, |mut rng| {
        let folder = tempfile::tempdir().unwrap();
        write_volume(folder.path(), [197, 170, 161], &mut rng);
        let text = scene_text(&mut rng, 0.3, "tolerance = 0.0\nopacity_cutoff = 1.0");
        let volume =
            OpenScene::open(&opened(folder.path(), &text)).unwrap().scene.layers[0].volume.clone();
        let mean = write_levels(folder.path(), &volume);
        let file = opened(folder.path(), &text.replace("volume.nhdr", "0.zarr"));
        let scene = refined(&file, 1 << 20);
        let shown = &scene.opened().scene.layers[0].volume;
        assert_eq!((shown.grid(), shown.samples()), (mean.grid(), mean.samples()));
        let mut first = None;
        let picture = scene.refined(&slabsplat::FrameHandle::new(), &mut |of| {
            first.get_or_insert_with(|| of.picture().frame.image);
        });
        let (picture, expected) = (picture.unwrap().frame.image, whole(&file));
        let (off, at_first) =
            (expected.max_difference(&picture), mean_difference(&first.unwrap(), &expected));
        println!("{} boxes: {off}, at first {at_first} in the mean", scene.n_boxes());
        assert!(1 < scene.n_boxes() && off < ROUNDED_TWICE, "{off}");
        assert!(at_first < COARSE, "{at_first}");
    });
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
