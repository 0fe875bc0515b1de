//! What a frame takes from the heap once its buffers are warm: the picture, which is the caller's.
//!
//! It is on its own, as the heap is counted for the whole process.

use slabsplat::glam::DVec3;
use slabsplat::{
    Automatic, ImageDesc, Isosurface, Mesh, MeshLayer, MeshParts, Method, Mode, RenderSettings,
    Renderer, backend_named, io,
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
    let image = ImageDesc::new(width, height);
    let by_method = |method: &Method| RenderSettings::default().method(*method);
    let surfaces = RenderSettings::default().mode(Mode::Isosurfaces);
    let without_meshes = Method::ALL.iter().map(by_method).chain([surfaces]);
    let with_meshes = [Method::ImageAligned, Method::PostClassified];
    let with_meshes = with_meshes.iter().map(|method| (by_method(method), vec![cross()]));
    for (settings, meshes) in without_meshes.map(|settings| (settings, vec![])).chain(with_meshes) {
        let what = format!("{} {}, {} meshes", settings.method, settings.mode, meshes.len());
        // A plan has a list of its meshes, and the lights that each is seen in.
        let max_blocks = 20 + 2 * meshes.len() as u64;
        let mut scene = automatic.scene(image, settings).meshes(meshes);
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
            assert!(
                n_bytes < PICTURE + 8192 && n_blocks < max_blocks,
                "{what}: {n_bytes} in {n_blocks}"
            );
        }
    }
}

/// Two squares through the middle of the volume, across each other.
fn cross() -> MeshLayer {
    let corner = |x: f64, y: f64, z: f64| 25.0 * DVec3::new(x, y, z);
    let square = |turn: fn(f64, f64) -> [f64; 3]| {
        [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[a, b]| turn(a, b))
    };
    let corners = [square(|a, b| [a, b, 0.0]), square(|a, b| [a, 0.0, b])].concat();
    let positions = corners.into_iter().map(|[x, y, z]| corner(x, y, z)).collect();
    let triangles = vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
    let parts = MeshParts::new(positions).triangles(triangles);
    MeshLayer::new(Mesh::new(parts).expect("it has neither normals nor colours"))
}
