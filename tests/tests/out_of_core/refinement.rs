//! Pictures that are shown while boxes come, and frames that are given up.

use super::*;

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
