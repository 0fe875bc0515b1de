//! Every backend against the float64 reference, on scenes at random: the tolerances of SPEC §9.

use slabsplat_tests::random_scene::{SceneKind, random_scene};
use slabsplat_tests::reference;
use slabsplat_tests::render::{BACKENDS, render};

/// What a pixel may differ from the reference at most, and on average over a picture.
const MAX_DIFFERENCE: f64 = 1e-3;
const MEAN_DIFFERENCE: f64 = 1e-4;

/// Every method × kernel × compositing × normalisation × projection × grid.
#[test]
fn parity_on_random_scenes() {
    let seed = std::env::var("SLABSPLAT_SEED").ok().and_then(|s| s.parse().ok());
    let seed = seed.unwrap_or_else(|| fastrand::u64(..));
    println!("SLABSPLAT_SEED={seed}");
    let mut rng = fastrand::Rng::with_seed(seed);
    let mut differences = Vec::new();
    for kind in SceneKind::all() {
        let (volume, scene) = random_scene(&mut rng, &kind);
        let expected = reference::render(&volume, &scene);
        for backend in BACKENDS {
            let difference = expected.compare(&render(backend, &volume, &scene));
            differences.push((difference.max, difference.mean, kind, scene.clone()));
        }
    }
    differences.sort_by(|a, b| b.0.total_cmp(&a.0));
    for (max, mean, kind, scene) in differences.iter().take(5) {
        println!("{max:.1e} (mean {mean:.1e}) {kind:?} w {}", scene.settings.slab_width);
    }
    let (max, mean) = (differences[0].0, differences.iter().map(|d| d.1).fold(0.0, f64::max));
    println!("largest difference {max:.1e}, largest mean difference {mean:.1e}");
    assert!(max < MAX_DIFFERENCE, "a pixel is off by {max}");
    assert!(mean < MEAN_DIFFERENCE, "a picture is off by {mean} on average");
}
