//! Grids and cameras at the edge of what there may be: a frame is refused in a sentence, or it is a picture.
//! No panic, no pixel that is no number.

use fastrand::Rng;
use slabsplat::glam::{DAffine3, DMat3, DQuat, DVec3};
use slabsplat::{
    Camera, Grid, ImageDesc, Isosurface, KERNEL_NAMES, KernelName, Layer, Light, Method, Mode,
    Projection, RenderSettings, Renderer, Scaling, Scene, TransferFunction, Volume,
};
use slabsplat_seeds::for_each_seed;
use slabsplat_tests::render::open;
use std::sync::Arc;

#[test]
fn extremes_are_drawn_or_refused() {
    let (mut n_drawn, mut n_seen, mut n_refused) = (0, 0, 0);
    for_each_seed(1, |mut rng| {
        for _ in 0..400 {
            let Some(scene) = extreme_scene(&mut rng) else { continue };
            match Renderer::new(open("cpu")).render(&scene) {
                Ok(frame) => {
                    let what = || format!("{scene:?}");
                    let is_pixel = |p: &[f32; 4]| p.iter().all(|c| (-1e-3..=1.001).contains(c));
                    let bad = frame.image.pixels().iter().find(|pixel| !is_pixel(pixel));
                    assert!(bad.is_none(), "{bad:?}: {}", what());
                    n_drawn += 1;
                    n_seen += u32::from(frame.image.pixels().iter().any(|p| 0.0 < p[3]));
                }
                Err(error) => {
                    assert!(!error.to_string().contains('\n'), "{error}");
                    n_refused += 1;
                }
            }
        }
    });
    println!("{n_drawn} drawn, {n_seen} of them not empty, {n_refused} refused");
    assert!(50 < n_seen && 20 < n_refused, "{n_seen} seen, {n_refused} refused");
}

/// Unequal steps seen from so near that a pixel is next to nothing of a voxel: offsets were no numbers, and
/// the row that was read from the table was behind its last.
#[test]
fn close_ups_of_unequal_steps_are_refused() {
    let grid = Grid::with_spacing([4; 3], [1.0, 1.2, 0.7]).expect("no axis is flat");
    let volume = Volume::new(grid, vec![1_u8; 64].into(), Scaling::IDENTITY).expect("64 voxels");
    let volume = Arc::new(volume);
    for (view_height, is_drawn) in [(1e-6, true), (1e-37, false), (1e-100, false), (1e300, false)] {
        let mut rng = Rng::with_seed(1);
        let projection = Projection::Orthographic { view_height };
        let scene = scene(&mut rng, &volume, DVec3::new(5.0, 3.0, 9.0), projection);
        let frame = Renderer::new(open("cpu")).render(&scene.expect("it spans a view"));
        assert_eq!(frame.is_ok(), is_drawn, "{view_height}: {:?}", frame.err());
    }
}

/// Ten to the power of anything up to `most`, or down to its opposite.
fn any_size(rng: &mut Rng, most: f64) -> f64 {
    10_f64.powf((2.0 * rng.f64() - 1.0) * most)
}

fn direction(rng: &mut Rng) -> DVec3 {
    let quarter = [DVec3::X, DVec3::Y, DVec3::Z][rng.usize(..3)];
    let any = DVec3::from_array([0; 3].map(|_| rng.f64() - 0.5)).normalize();
    if rng.u32(..4) == 0 { quarter } else { any }
}

fn extreme_scene(rng: &mut Rng) -> Option<Scene> {
    let dims = [0; 3].map(|_| rng.usize(1..=5));
    let most: f64 = [0.1, 1.0, 3.0, 11.9][rng.usize(..4)];
    let size = if rng.bool() { 1.0 } else { any_size(rng, 11.0 - most.min(10.0)) };
    let steps = DVec3::from_array([0; 3].map(|_| size * any_size(rng, most)));
    let turn = DMat3::from_quat(DQuat::from_axis_angle(direction(rng), 6.3 * rng.f64()));
    let by = if rng.bool() { 0.0 } else { any_size(rng, 5.0) };
    let shear = DMat3::from_cols(DVec3::X, DVec3::new(by, 1.0, 0.0), DVec3::Z);
    let matrix = turn * shear * DMat3::from_diagonal(steps);
    let grid = Grid::new(dims, DAffine3::from_mat3(matrix)).ok()?;
    let samples: Vec<f32> = (0..grid.n_voxels()).map(|_| rng.f32()).collect();
    let volume = Volume::new(grid, samples.into(), Scaling::IDENTITY).ok()?;
    let most = [1.0, 4.0, 12.0][rng.usize(..3)];
    let distance = grid.unit() * any_size(rng, most);
    let eye = grid.center_in_world() + distance * direction(rng);
    let projection = if rng.bool() {
        let most = [1.0, 4.0, 40.0, 300.0][rng.usize(..4)];
        Projection::Orthographic { view_height: grid.unit() * any_size(rng, most) }
    } else {
        let most = [0.1, 6.0, 20.0][rng.usize(..3)];
        Projection::Perspective {
            fov_y_radians: 0.999_999 * std::f64::consts::PI * any_size(rng, most).min(1.0),
        }
    };
    scene(rng, &Arc::new(volume), eye, projection)
}

fn scene(rng: &mut Rng, volume: &Arc<Volume>, eye: DVec3, projection: Projection) -> Option<Scene> {
    let grid = volume.grid();
    let camera = Camera::new(eye, grid.center_in_world(), direction(rng), projection).ok()?;
    let method = Method::ALL[rng.usize(..Method::ALL.len())];
    // A kernel is cut into a few sections, however long it is: a million are right, too, but take a while.
    let longest = grid.spacing().into_iter().fold(0.0, f64::max) / grid.unit();
    let light = if rng.bool() { Light::default() } else { Light::towards(direction(rng)).ok()? };
    let transfer = TransferFunction::new(
        vec![(0.0, [0.0]), (1.0, [[0.02, 0.5, 1.0][rng.usize(..3)]])],
        vec![(0.0, [1.0, 0.5, 0.2]), (1.0, [0.1, 0.9, 1.0])],
    );
    let image = ImageDesc::new(rng.u32(1..=20), rng.u32(1..=20));
    let settings = RenderSettings::default()
        .method(method)
        .kernel(KernelName(KERNEL_NAMES[rng.usize(..KERNEL_NAMES.len())].into()))
        .mode(Mode::ALL[rng.usize(..Mode::ALL.len())])
        .slab_width(longest * [0.1, 1.0, 7.0][rng.usize(..3)])
        .tolerance([0.0, 0.05][rng.usize(..2)])
        .sections(16)
        .radial_samples(32);
    let surface = Isosurface::new(0.5, [0.4, 1.0][rng.usize(..2)], None).ok()?;
    let layer = Layer::new(volume.clone(), transfer.ok()?).isosurfaces(vec![surface]);
    Some(Scene::new(layer, camera).lights(vec![light]).image(image).settings(settings))
}
