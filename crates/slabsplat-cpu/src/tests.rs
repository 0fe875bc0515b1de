//! The contract, and every set of instructions against that which all computers of an architecture have.

use super::*;
use crate::voxels::relevant::Budget;
use fearless_simd::Level;
use slabsplat_backend::Planner;
use slabsplat_core::glam::DVec3;
use slabsplat_core::{
    Camera, Compositing, FrameHandle, Grid, Image, ImageDesc, KernelName, Layer, Method,
    Projection, RenderSettings, Scaling, Scene, Shading, TransferFunction, Volume,
};
use slabsplat_seeds::for_each_seed;
use std::sync::Arc;

#[test]
fn cpu_conforms() {
    slabsplat_backend::conformance::check(&mut CpuBackend::new());
}

#[test]
fn cpu_conforms_on_one_thread() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    pool.install(|| slabsplat_backend::conformance::check(&mut CpuBackend::new()));
}

/// The sets of instructions that this machine has, but for the least of them.
#[cfg(not(slabsplat_scalar))]
pub(crate) fn levels() -> Vec<(&'static str, Level)> {
    let best = Level::new();
    let mut levels = Vec::new();
    #[cfg(target_arch = "x86_64")]
    {
        levels.extend(best.as_sse4_2().map(|token| ("SSE4.2", Level::Sse4_2(token))));
        levels.extend(best.as_avx2().map(|token| ("AVX2", Level::Avx2(token))));
    }
    levels.push(("the best", best));
    levels
}

/// What computers without vectors do, by `cargo xtask scalar`.
#[cfg(slabsplat_scalar)]
pub(crate) fn levels() -> Vec<(&'static str, Level)> {
    vec![("scalar", Level::fallback())]
}

fn noise(rng: &mut fastrand::Rng, spacing: [f64; 3]) -> Arc<Volume> {
    let grid = Grid::with_spacing([13, 11, 12], spacing).unwrap();
    let samples: Vec<u8> = (0..grid.n_voxels()).map(|_| rng.u8(..)).collect();
    Arc::new(Volume::new(grid, samples.into(), Scaling::IDENTITY).unwrap())
}

fn scene(rng: &mut fastrand::Rng, volume: &Arc<Volume>, settings: RenderSettings) -> Scene {
    let target = volume.grid().center_in_world();
    let eye = target + DVec3::new(rng.f64() - 0.5, rng.f64() - 0.5, 1.0) * 60.0;
    let projection = if rng.bool() {
        Projection::Orthographic { view_height: 8.0 + 30.0 * rng.f64() }
    } else {
        Projection::Perspective { fov_y_radians: 0.1 + 0.4 * rng.f64() }
    };
    let opacity = if rng.bool() { 0.08 } else { 0.9 };
    let color = vec![(0.0, [0.9, 0.3, 0.1]), (255.0, [0.2, 0.9, 1.0])];
    let transfer = TransferFunction::new(vec![(60.0, [0.0]), (255.0, [opacity])], color).unwrap();
    let camera = Camera::new(eye, target, DVec3::Y, projection).unwrap();
    Scene::new(Layer::new(volume.clone(), transfer), camera)
        // The right and lower tiles lie partly outside.
        .image(ImageDesc::new(75, 50))
        .settings(settings)
}

fn render(level: Level, scene: &Scene) -> Image {
    draw(&mut CpuBackend { level, ..CpuBackend::new() }, scene).image
}

fn draw(backend: &mut CpuBackend, scene: &Scene) -> Frame {
    let mut planner = Planner::default();
    let plan = planner.plan(scene).unwrap();
    let frame = FrameHandle::new();
    backend.submit(&plan, &frame).unwrap();
    match backend.poll_image(&frame).unwrap() {
        Poll::Ready(frame) => frame,
        Poll::Pending => panic!("a frame is done when it was submitted"),
    }
}

/// Every method, kernel and compositing, on grids whose footprints are circles, sheared ellipses, and cut at
/// a slant.
#[test]
fn cpu_levels_agree() {
    for_each_seed(1, |mut rng| {
        let mut worst = 0.0_f32;
        for &method in Method::ALL {
            for &compositing in Compositing::ALL {
                for kernel in ["gaussian", "crawfis-max"] {
                    let spacing = if rng.bool() { [1.0; 3] } else { [1.0, 1.4, 2.1] };
                    let settings = RenderSettings::default()
                        .method(method)
                        .mode(compositing.into())
                        .kernel(KernelName(kernel.into()))
                        .slab_width([0.5, 1.0, 2.3][rng.usize(..3)])
                        .tolerance([0.0, 0.05][rng.usize(..2)]);
                    let volume = noise(&mut rng, spacing);
                    let scene = scene(&mut rng, &volume, settings);
                    let expected = render(Level::baseline(), &scene);
                    for (name, level) in levels() {
                        let image = render(level, &scene);
                        let difference = image.max_difference(&expected);
                        // Levels differ in whether a multiply-add rounds once or twice.
                        assert!(difference < 2e-4, "{name}: {difference} {:?}", scene.settings);
                        worst = worst.max(difference);
                    }
                }
            }
        }
        println!("at most {worst:.1e}");
    });
}

/// Merging moves extinction in depth and loses none of it, also where a voxel goes to a slab before all that
/// its kernel meets, which may lie in the range of depth before: so it is with slabs thicker than half a
/// kernel.
#[test]
fn cpu_keeps_the_opacity_of_faint_voxels() {
    // Of many numbers of slices some have a brick at the front of a range and behind the front of its slab.
    let with_widths = |n_slices| [1.0, 3.0, 5.0].map(move |width| (n_slices, width));
    for (n_slices, slab_width) in (70..110).flat_map(with_widths) {
        let grid = Grid::with_spacing([8, 8, n_slices], [1.0; 3]).unwrap();
        let volume = Arc::new(
            Volume::new(grid, vec![1_u8; grid.n_voxels()].into(), Scaling::IDENTITY).unwrap(),
        );
        let target = grid.center_in_world();
        let projection = Projection::Orthographic { view_height: 4.0 };
        let eye = target - DVec3::Z * 200.0;
        let of_tolerance = |opacity: f64, tolerance: f64| {
            let opacity = vec![(0.0, [opacity])];
            let transfer = TransferFunction::new(opacity, vec![(0.0, [1.0; 3])]).unwrap();
            let camera = Camera::new(eye, target, DVec3::Y, projection).unwrap();
            let layer = Layer::new(volume.clone(), transfer).shading(Shading::None);
            let scene = Scene::new(layer, camera)
                .image(ImageDesc::new(32, 32))
                .settings(RenderSettings::default().tolerance(tolerance).slab_width(slab_width));
            render(Level::new(), &scene)
        };
        for opacity in [0.001, 0.004, 0.01] {
            let difference =
                of_tolerance(opacity, 0.05).max_difference(&of_tolerance(opacity, 0.0));
            let what = format!("{n_slices} slices, slabs of {slab_width}, {opacity}");
            assert!(difference < 1e-3, "{what}: {difference}");
        }
    }
}

/// Frames that were drawn before find all the memory that they need. On one thread: which tile falls to which
/// one is chance, and each has a workspace.
#[test]
fn cpu_buffers_do_not_grow_once_warm() {
    for_each_seed(1, |mut rng| {
        let volume = noise(&mut rng, [1.0; 3]);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        for &method in Method::ALL {
            let settings = RenderSettings::default().method(method);
            let mut scenes: Vec<Scene> =
                (0..4).map(|_| scene(&mut rng, &volume, settings.clone())).collect();
            let transfer = scenes[0].layers[0].transfer.clone();
            scenes.iter_mut().for_each(|scene| scene.layers[0].transfer = transfer.clone());
            let (mut planner, mut backend) = (Planner::default(), CpuBackend::new());
            let mut resident_bytes = |scene| {
                let plan = planner.plan(scene).unwrap();
                let frame = FrameHandle::new();
                backend.submit(&plan, &frame).unwrap();
                match backend.poll_image(&frame).unwrap() {
                    Poll::Ready(frame) => frame.cost.resident_bytes,
                    Poll::Pending => panic!("a frame is done when it was submitted"),
                }
            };
            let mut turn = || -> Vec<u64> {
                pool.install(|| scenes.iter().map(&mut resident_bytes).collect())
            };
            let warm = turn()[3];
            assert_eq!(turn(), [warm; 4], "{method:?}");
        }
    });
}

/// Voxels that are listed when they are seen, with room for some of them or for none, are those of a list of
/// all: the pictures are the same bit for bit, over transfer functions that change.
#[test]
fn cpu_lists_on_demand_what_the_list_has() {
    for_each_seed(1, |mut rng| {
        for spacing in [[1.0; 3], [1.0, 0.6, 2.5]] {
            let volume = noise(&mut rng, spacing);
            let n_bytes = volume.grid().n_voxels() * 8;
            let budgets =
                [usize::MAX, n_bytes / 3, 0].map(|least_bytes| Budget::Quarter { least_bytes });
            let new = |budget| CpuBackend {
                buffers: frame::Buffers::with_budget(budget),
                ..CpuBackend::new()
            };
            let mut backends = budgets.map(new);
            for method in [Method::ImageAligned, Method::EverySample, Method::ImageAligned] {
                let tolerance = [0.0, 0.05][rng.usize(..2)];
                let settings = RenderSettings::default().method(method).tolerance(tolerance);
                let scene = scene(&mut rng, &volume, settings);
                let [listed, others @ ..] = &mut backends;
                let expected = draw(listed, &scene);
                for backend in others {
                    let drawn = draw(backend, &scene);
                    assert!(drawn.image == expected.image, "{method} {tolerance}");
                    assert_eq!(drawn.stats, expected.stats);
                }
            }
        }
    });
}

/// What is retained of voxels that are listed when they are seen is within the budget, and less than a list
/// takes.
#[test]
fn cpu_lists_on_demand_within_a_budget() {
    let grid = Grid::with_spacing([70, 60, 50], [1.0; 3]).unwrap();
    let samples: Vec<u8> = (0..grid.n_voxels()).map(|idx| (idx % 251) as u8).collect();
    let volume = Arc::new(Volume::new(grid, samples.into(), Scaling::IDENTITY).unwrap());
    // On one thread: which brick falls to which one is chance, and each has buffers.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let resident = [usize::MAX, 1 << 18, 0].map(|least_bytes| {
        let buffers = frame::Buffers::with_budget(Budget::Quarter { least_bytes });
        let mut backend = CpuBackend { buffers, ..CpuBackend::new() };
        let mut rng = fastrand::Rng::with_seed(1);
        let settings = RenderSettings::default().tolerance(0.0);
        let scene = scene(&mut rng, &volume, settings);
        let mut resident = || pool.install(|| draw(&mut backend, &scene).cost.resident_bytes);
        [resident(), resident(), resident()].into_iter().max().unwrap()
    });
    let of_list = 8 * volume.grid().n_voxels() as u64 * 3 / 4;
    let [listed, some, least] = resident;
    println!("{listed}, {some} and {least} bytes of a list of {of_list}");
    // A quarter of the volume may be retained in any case.
    let of_volume = volume.grid().n_voxels() as u64 / 4;
    assert!(least + of_list - of_volume < listed + (1 << 17), "{least} of {listed}");
    assert!(some < least + (1 << 18), "{some}, {least}");
}

/// Each method may hold all voxels, and a method that is not drawn any more holds none.
#[test]
fn cpu_keeps_nothing_for_other_methods() {
    for_each_seed(1, |mut rng| {
        let volume = noise(&mut rng, [1.0; 3]);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let first = scene(&mut rng, &volume, RenderSettings::default());
        let resident_bytes = |methods: &[Method]| {
            let (mut planner, mut backend) = (Planner::default(), CpuBackend::new());
            let mut bytes = 0;
            for &method in methods {
                let settings = RenderSettings::default().method(method);
                let scene = first.clone().settings(settings);
                let plan = planner.plan(&scene).unwrap();
                let frame = FrameHandle::new();
                pool.install(|| backend.submit(&plan, &frame)).unwrap();
                if let Poll::Ready(frame) = backend.poll_image(&frame).unwrap() {
                    bytes = frame.cost.resident_bytes;
                }
            }
            bytes
        };
        let alone = resident_bytes(&[Method::EverySample]);
        assert_eq!(resident_bytes(&[Method::AxisAligned, Method::EverySample]), alone);
        assert_eq!(resident_bytes(&[Method::ImageAligned, Method::EverySample]), alone);
        // The list of relevant voxels stays, which densities have no use for.
        let list_kept = resident_bytes(&[Method::EverySample, Method::PostClassified]);
        let without = resident_bytes(&[Method::ImageAligned, Method::PostClassified]);
        assert_eq!(list_kept, without);
    });
}
