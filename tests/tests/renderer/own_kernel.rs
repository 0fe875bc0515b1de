//! A kernel that slabsplat does not bring, on every backend against the float64 reference.

#[expect(dead_code, reason = "the example's own `main` draws a picture")]
#[path = "../../../crates/slabsplat/examples/own_kernel.rs"]
mod example;

use example::Biweight;
use slabsplat::{KernelName, Renderer};
use slabsplat_seeds::for_each_seed;
use slabsplat_tests::random_scene::{SceneKind, random_scene};
use slabsplat_tests::reference;
use slabsplat_tests::render::{backends_with, open};
use std::sync::Arc;

#[test]
fn own_kernel_parity_on_random_scenes() {
    let kinds = SceneKind::all().into_iter().filter(|kind| kind.kernel == "gaussian");
    let kinds = kinds.collect::<Vec<_>>();
    for_each_seed(4, |mut rng| {
        let kind = rng.choice(&kinds).expect("there are kinds");
        let mut scene = random_scene(&mut rng, kind);
        scene.settings.kernel = KernelName::from("biweight");
        let expected = reference::render(&scene);
        for backend in backends_with(kind.method) {
            let mut renderer = Renderer::new(open(backend));
            renderer.add_kernel(Arc::new(Biweight)).unwrap();
            let off = expected.compare(&renderer.render(&scene).unwrap().image);
            println!("{backend}, {kind:?}: {off:?}");
            assert!(off.max < 1e-3 && off.mean < 1e-4, "{off:?}: {backend}, {kind:?}");
        }
    });
}
