//! What a frame takes from the heap once its buffers are warm: the picture, which is the caller's.
//!
//! It is on its own, as the heap is counted for the whole process.

use slabsplat::{
    Automatic, ImageDesc, Isosurface, Method, Mode, RenderSettings, Renderer, backend_named, io,
};

#[global_allocator]
static HEAP: dhat::Alloc = dhat::Alloc;

const SIZE: [u32; 2] = [160, 120];

/// Bytes of the picture.
const PICTURE: u64 = 16 * SIZE[0] as u64 * SIZE[1] as u64;

#[test]
fn allocations_of_a_warm_frame() {
    let _profiler = dhat::Profiler::builder().testing().build();
    // On one thread: which tile falls to which thread is chance, and each has a workspace.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread starts");
    let volume = io::builtin_volume("marschner-lobb", Some(48)).expect("there are waves");
    let automatic = Automatic::new(volume);
    let [width, height] = SIZE;
    let image = ImageDesc { width, height, background: [0.0; 4] };
    let by_method = Method::ALL.iter().map(|&method| RenderSettings::default().method(method));
    let surfaces = RenderSettings::default().mode(Mode::Isosurfaces);
    for settings in by_method.chain([surfaces]) {
        let what = format!("{} {}", settings.method, settings.mode);
        let mut scene = automatic.scene(image, settings);
        let surface = Isosurface::new(0.5, 0.4, None).expect("they are numbers");
        scene.layers[0].isosurfaces = vec![surface];
        let mut renderer = Renderer::new(backend_named("cpu").expect("the CPU is there"));
        let mut taken_by_frame = |step: u32| {
            let scene = scene.clone().camera(scene.camera.orbited(f64::from(step)));
            let before = dhat::HeapStats::get();
            pool.install(|| renderer.render(&scene).expect("the scene is valid"));
            let after = dhat::HeapStats::get();
            [after.total_bytes - before.total_bytes, after.total_blocks - before.total_blocks]
        };
        let mut turn = || [0, 10, 20, 40, 80].map(&mut taken_by_frame);
        let (cold, warm) = (turn(), turn());
        println!("{what}, bytes and blocks: {cold:?} cold, {warm:?} warm");
        for [n_bytes, n_blocks] in warm {
            assert!(n_bytes < PICTURE + 8192 && n_blocks < 20, "{what}: {n_bytes} in {n_blocks}");
        }
    }
}
