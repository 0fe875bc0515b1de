//! What a large volume takes beside itself while it is drawn: never a list of all of its relevant voxels.
//!
//! It is on its own, as the heap is counted for the whole process.

use slabsplat::glam::DVec3;
use slabsplat::{
    Camera, Grid, ImageDesc, Layer, Method, Projection, RenderSettings, Renderer, Scene, Shading,
    TransferFunction, Volume, backend_named,
};

#[global_allocator]
static HEAP: dhat::Alloc = dhat::Alloc;

/// Voxels along every axis.
const SIDE: usize = 440;

#[test]
fn memory_of_an_opaque_volume_is_that_of_what_is_seen() {
    let _profiler = dhat::Profiler::builder().testing().build();
    let grid = Grid::centered([SIDE; 3], [1.0; 3]).expect("it is a grid");
    let middle = (SIDE - 1) as i64 / 2;
    let volume = Volume::from_fn(grid, |at| {
        let from_middle = at.map(|c| (c as i64 - middle).pow(2));
        u8::from(from_middle.iter().sum::<i64>() < middle * middle)
    });
    let of_volume = dhat::HeapStats::get().curr_bytes;
    let n_relevant = 4.0 / 3.0 * std::f64::consts::PI * (middle as f64).powi(3);
    let of_list = 8 * n_relevant as usize;

    // A voxel a pixel: nothing is drawn by cells.
    let view_height = 256.0;
    let opacity = vec![(0.0, [0.0]), (1.0, [0.9])];
    let transfer = TransferFunction::new(opacity, vec![(0.0, [1.0; 3])]).expect("the points rise");
    let layer = Layer::new(volume, transfer).shading(Shading::None);
    let projection = Projection::Orthographic { view_height };
    // Each thread has room of its own.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("threads start");
    let mut renderer = Renderer::new(backend_named("cpu").expect("the CPU is there"));
    for (eye, tolerance) in [([900.0, 0.0, 0.0], 0.05), ([600.0, 500.0, 400.0], 0.0)] {
        let camera = Camera::new(eye, DVec3::ZERO, DVec3::Z, projection).expect("it sees the ball");
        let scene = Scene::new(layer.clone(), camera)
            .image(ImageDesc::new(256, 256))
            .settings(RenderSettings::default().method(Method::ImageAligned).tolerance(tolerance));
        let frame = pool.install(|| renderer.render(&scene).expect("the scene is valid"));
        let beside = dhat::HeapStats::get().max_bytes - of_volume;
        println!(
            "{} of {} voxels occluded; {} MB beside {} MB at most, where a list takes {} MB",
            frame.stats.n_occluded,
            frame.stats.n_voxels,
            beside >> 20,
            of_volume >> 20,
            of_list >> 20
        );
        assert!(frame.stats.n_voxels as f64 > 0.99 * n_relevant, "the ball is relevant");
        assert!(beside < of_list / 2, "{beside} bytes");
    }
}
