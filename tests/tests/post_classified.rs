//! `post-classified` against the float64 reference and against what is known without one.

use slabsplat::Method;
use slabsplat_tests::random_scene::{SceneKind, random_scene};
use slabsplat_tests::reference;
use slabsplat_tests::render::render;

/// What a pixel may differ from the reference at most, and on average over a picture.
const MAX_DIFFERENCE: f64 = 1e-3;
const MEAN_DIFFERENCE: f64 = 1e-4;

fn seeded() -> fastrand::Rng {
    let seed = std::env::var("SLABSPLAT_SEED").ok().and_then(|s| s.parse().ok());
    let seed = seed.unwrap_or_else(|| fastrand::u64(..));
    println!("SLABSPLAT_SEED={seed}");
    fastrand::Rng::with_seed(seed)
}

fn kinds() -> impl Iterator<Item = SceneKind> {
    SceneKind::all().into_iter().filter(|kind| kind.method == Method::PostClassified)
}

#[test]
fn parity_of_densities() {
    let mut rng = seeded();
    let n_rounds = std::env::var("SLABSPLAT_ROUNDS").ok().and_then(|s| s.parse().ok()).unwrap_or(1);
    let mut differences = Vec::new();
    for kind in (0..n_rounds).flat_map(|_| kinds()) {
        let (volume, scene) = random_scene(&mut rng, &kind);
        let expected = reference::render(&volume, &scene);
        let difference = expected.compare(&render("cpu", &volume, &scene));
        differences.push((difference, kind, scene, volume));
    }
    differences.sort_by(|a, b| b.0.max.total_cmp(&a.0.max));
    for (difference, kind, scene, volume) in differences.iter().take(8) {
        println!(
            "{difference:?} {kind:?} w {} {:?} {:?} {:?} {:?} {:?}",
            scene.settings.slab_width,
            scene.shading,
            scene.camera.projection(),
            scene.transfer,
            volume.summary(),
            volume.grid().unit()
        );
    }
    let mean = differences.iter().map(|d| d.0.mean).fold(0.0, f64::max);
    println!(
        "{} scenes: max {:.1e}, mean at most {mean:.1e}",
        differences.len(),
        differences[0].0.max
    );
    assert!(differences[0].0.max < MAX_DIFFERENCE);
    assert!(mean < MEAN_DIFFERENCE);
}
