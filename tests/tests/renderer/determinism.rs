//! The same picture, however it is made: any number of threads, any storage of the voxels, any frame
//! before it.

use slabsplat::glam::{DAffine3, DMat3, DVec3};
use slabsplat::paper::{CubeView, cube};
use slabsplat::{
    Compositing, Grid, Image, ImageDesc, Method, RenderSettings, Renderer, Samples, Scaling, Scene,
    Volume,
};
use slabsplat_seeds::for_each_seed;
use slabsplat_tests::random_scene::{SceneKind, random_scene};
use slabsplat_tests::render::{backends, backends_in_turn, backends_with, open, render};

/// Sums of 32-bit floats in another order; a pixel sums some hundred sections.
const REORDERED_SUM: f32 = 2e-5;

#[test]
fn threads_do_not_change_a_bit() {
    for_each_seed(1, |mut rng| {
        for kind in SceneKind::all().into_iter().step_by(7) {
            let scene = random_scene(&mut rng, &kind);
            let with_threads = |n: usize| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build();
                pool.expect("threads can be started").install(|| render("cpu", &scene))
            };
            let one = with_threads(1);
            for n in [2, 5, 16] {
                assert!(with_threads(n) == one, "{n} threads: {kind:?}");
            }
        }
    });
}

/// A renderer that drew other scenes before draws the same bits as a fresh one, or one with another past.
#[test]
fn frames_before_do_not_change_a_bit() {
    for_each_seed(1, |mut rng| {
        for &name in backends() {
            let has_method = |kind: &SceneKind| backends_with(kind.method).any(|with| with == name);
            let kinds: Vec<SceneKind> = SceneKind::all().into_iter().filter(has_method).collect();
            let mut scene = random_scene(&mut rng, &kinds[0]);
            let mut renderer = Renderer::new(open(name));
            for step in 0..12 {
                let other = random_scene(&mut rng, &kinds[step * 25]);
                scene.layers[0].transfer = other.layers[0].transfer.clone();
                scene.settings = other.settings;
                scene.camera = scene.camera.orbited(0.4);
                let frame = renderer.render(&scene).expect("the scene is valid").image;
                assert!(frame == render(name, &scene), "{name}, frame {step}");
            }
        }
    });
}

/// Pixels along a side of what a GPU draws of the cube, and how wide its slabs are. Drivers that only play a
/// device take seconds for a frame if more splats crowd a tile.
const SIDE_ON_GPU: u32 = 64;
const SLAB_WIDTH_ON_GPU: f64 = 2.5;

/// The same voxels at the same positions, stored with axes permuted and reversed.
#[test]
fn storage_order_does_not_change_the_picture() {
    for_each_seed(1, |mut rng| {
        let mut number = 0;
        for &method in Method::ALL {
            for &compositing in Compositing::ALL {
                // At 45° whole columns of voxels are equally deep.
                let settings = RenderSettings::default()
                    .method(method)
                    .mode(compositing.into())
                    .slab_width(0.8);
                let angle_degrees = if method == Method::AxisAligned { 33.0 } else { 45.0 };
                let view = CubeView { angle_degrees, opacity: 0.7, ambient: 0.1, settings };
                let mut scene = cube(&view);
                number += 1;
                for name in backends_in_turn(method, number) {
                    // Drivers that only play a device take longer than all else.
                    let n_restored = if name == "cpu" { 3 } else { 1 };
                    if name != "cpu" {
                        scene.image = ImageDesc::new(SIDE_ON_GPU, SIDE_ON_GPU);
                        scene.settings.slab_width = SLAB_WIDTH_ON_GPU;
                    }
                    let image = render(name, &scene);
                    for _ in 0..n_restored {
                        check_restored(name, &mut rng, &scene, &image);
                    }
                }
            }
        }
    });
}

fn check_restored(name: &str, rng: &mut fastrand::Rng, scene: &Scene, image: &Image) {
    let mut axes = [0, 1, 2];
    rng.shuffle(&mut axes);
    let flips = [rng.bool(), rng.bool(), rng.bool()];
    let mut restored = scene.clone();
    restored.layers[0].volume = restored_volume(&scene.layers[0].volume, axes, flips).into();
    let difference = render(name, &restored).max_difference(image);
    let method = scene.settings.method;
    assert!(difference < REORDERED_SUM, "{method}, axes {axes:?}, flips {flips:?}: {difference}");
}

/// Axis `a` of the result is axis `axes[a]` of `volume`, reversed if `flips[a]`.
fn restored_volume(volume: &Volume, axes: [usize; 3], flips: [bool; 3]) -> Volume {
    let old = *volume.grid();
    let dims = axes.map(|axis| old.dims()[axis]);
    let old_coords = |new: [usize; 3]| {
        let mut coords = [0; 3];
        for a in 0..3 {
            coords[axes[a]] = if flips[a] { dims[a] - 1 - new[a] } else { new[a] };
        }
        coords
    };
    let at = |new| {
        let coords = old_coords(new).map(|c| c as f64);
        old.world_from_index().transform_point3(DVec3::from_array(coords))
    };
    let origin = at([0; 3]);
    let columns =
        DMat3::from_cols(at([1, 0, 0]) - origin, at([0, 1, 0]) - origin, at([0, 0, 1]) - origin);
    let grid = Grid::new(dims, DAffine3::from_mat3_translation(columns, origin))
        .expect("a permuted grid can be inverted");
    let samples: Vec<f64> = (0..grid.n_voxels())
        .map(|idx| volume.value(old.voxel_idx(old_coords(grid.voxel_coords(idx)))))
        .collect();
    Volume::new(grid, Samples::F64(samples), Scaling::IDENTITY).expect("one sample a voxel")
}
