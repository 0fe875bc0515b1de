//! What every backend must pass, whatever it runs on. A backend's own tests call [`check`].
//!
//! These are the promises of the contract that need no judge: errors, determinism, empty and full
//! frames. That the pictures are right is checked against the float64 reference in the
//! repository's `tests/`.

use crate::{Backend, BackendError, Frame, FrameStats, Planner};
use slabsplat_core::glam::DVec3;
use slabsplat_core::{
    Camera, Cancelled, Compositing, FrameHandle, Grid, ImageDesc, Layer, Method, Plane, Projection,
    Region, RenderSettings, Scaling, Scene, Shading, TransferFunction, Volume,
};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::task::{Poll, Wake};

/// Runs all checks on `backend`.
///
/// # Panics
/// If a check fails.
pub fn check(backend: &mut dyn Backend) {
    empty_plan_gives_background(backend);
    one_voxel_is_a_round_spot(backend);
    opaque_voxel_hides_the_one_behind(backend);
    same_plan_gives_same_bits(backend);
    volumes_take_turns(backend);
    frames_can_be_taken_once(backend);
    frames_can_be_awaited(backend);
    unknown_frame_is_an_error(backend);
    cancelled_frames_are_dropped(backend);
    methods_are_those_told(backend);
    order_of_layers_changes_no_bit(backend);
    layers_are_summed(backend);
    regions_cut(backend);
}

fn empty_plan_gives_background(backend: &mut dyn Backend) {
    for &method in backend.caps().methods {
        let mut scene = scene(&volume([1, 1, 1]), method, Compositing::Extinction);
        scene.image.background = [1.0, 0.5, 0.0, 0.5];
        scene.layers[0].transfer = transfer(0.0);
        let frame = render(backend, &scene);
        let is_background = |&pixel: &[f32; 4]| pixel == [0.5, 0.25, 0.0, 0.5];
        assert!(frame.image.pixels().iter().all(is_background), "{method}");
        assert_eq!(frame.stats, FrameStats::default(), "{method}");
    }
}

fn one_voxel_is_a_round_spot(backend: &mut dyn Backend) {
    for &method in backend.caps().methods {
        for &compositing in Compositing::ALL {
            let mut scene = scene(&volume([1, 1, 1]), method, compositing);
            scene.settings.tolerance = 0.0;
            let image = render(backend, &scene).image;
            let side = image.width();
            assert!(0.01 < image.pixel(side / 2, side / 2)[3], "{method} {compositing}");
            assert_eq!(image.pixel(0, 0), [0.0; 4], "beyond the kernel's radius");
            for y in 0..side {
                for x in 0..side {
                    let spot = image.pixel(x, y);
                    for mirrored in [image.pixel(side - 1 - x, y), image.pixel(y, x)] {
                        let close = |(a, b): (&f32, &f32)| (a - b).abs() < 1e-5;
                        let is_round = spot.iter().zip(&mirrored).all(close);
                        assert!(is_round, "{method} {compositing}: {spot:?} {mirrored:?}");
                    }
                }
            }
        }
    }
}

/// The voxel with value 1 is green and stands before the one with value 0, which is red.
fn opaque_voxel_hides_the_one_behind(backend: &mut dyn Backend) {
    for &method in backend.caps().methods {
        let mut scene = scene(&volume([1, 1, 9]), method, Compositing::Extinction);
        scene.layers[0].transfer = TransferFunction::new(
            vec![(0.0, [1.0])],
            vec![(0.0, [1.0, 0.0, 0.0]), (1.0, [0.0, 1.0, 0.0])],
        )
        .expect("the points are sorted");
        let image = render(backend, &scene).image;
        let [red, green, ..] = image.pixel(image.width() / 2, image.height() / 2);
        assert!(10.0 * red < green, "{method}: red {red}, green {green}");
    }
}

fn same_plan_gives_same_bits(backend: &mut dyn Backend) {
    for &method in backend.caps().methods {
        let scene = scene(&volume([5, 4, 3]), method, Compositing::Separate);
        let first = render(backend, &scene);
        let second = render(backend, &scene);
        assert!(second.image == first.image, "{method}");
        assert_eq!(second.stats, first.stats, "{method}");
    }
}

/// What is cached of one volume or transfer function must not show in the next frame.
fn volumes_take_turns(backend: &mut dyn Backend) {
    for &method in backend.caps().methods {
        let [long, wide] = [volume([1, 1, 9]), volume([5, 4, 3])];
        let turns = [(&long, 0.5), (&wide, 0.5), (&wide, 0.1), (&long, 0.1)];
        let scenes = turns.map(|(volume, opacity)| {
            let mut scene = scene(volume, method, Compositing::Extinction);
            scene.layers[0].transfer = transfer(opacity);
            scene
        });
        let first = scenes.each_ref().map(|scene| render(backend, scene).image);
        for (turn, scene) in scenes.iter().enumerate().rev() {
            let again = render(backend, scene).image;
            assert!(again == first[turn], "{method}, turn {turn}");
        }
    }
}

fn frames_can_be_taken_once(backend: &mut dyn Backend) {
    let scene = scene(&volume([2, 1, 1]), Method::ImageAligned, Compositing::Associated);
    let plan = Planner::default().plan(&scene).expect("the scene is valid");
    let frames = [0, 1, 2].map(|_| FrameHandle::new());
    for frame in &frames {
        backend.submit(&plan, frame).expect("a tiny frame fits");
    }
    for frame in &frames[..2] {
        let taken = poll_until_ready(backend, frame);
        assert_eq!(taken.image.width(), scene.image.width);
        assert_eq!(backend.poll_image(frame), Err(BackendError::UnknownFrame));
        assert!(frame.progress() == 1.0, "{}", frame.progress());
    }
    backend.wait_image(&frames[2]).expect("the frame was submitted");
    assert_eq!(backend.wait_image(&frames[2]), Err(BackendError::UnknownFrame));
}

/// Who is pending is woken, by whichever thread, until the frame is there.
fn frames_can_be_awaited(backend: &mut dyn Backend) {
    let scene = scene(&volume([5, 4, 3]), Method::ImageAligned, Compositing::Associated);
    let expected = render(backend, &scene);
    let plan = Planner::default().plan(&scene).expect("the scene is valid");
    let frame = FrameHandle::new();
    backend.submit(&plan, &frame).expect("a tiny frame fits");
    let sleeper = Arc::new(Sleeper::default());
    let awaited = loop {
        match backend.poll_image(&frame).expect("the frame was submitted") {
            Poll::Ready(frame) => break frame,
            Poll::Pending => backend.wake_when_done(&frame, &sleeper.clone().into()),
        }
        sleeper.sleep();
    };
    assert!(awaited.image == expected.image);
}

/// Sleeps until it is woken; a call that comes too early counts.
#[derive(Default)]
struct Sleeper {
    is_awake: Mutex<bool>,
    changed: Condvar,
}

impl Sleeper {
    fn sleep(&self) {
        let is_awake = self.is_awake.lock().unwrap_or_else(PoisonError::into_inner);
        let woken = self.changed.wait_while(is_awake, |is_awake| !*is_awake);
        *woken.unwrap_or_else(PoisonError::into_inner) = false;
    }
}

impl Wake for Sleeper {
    fn wake(self: Arc<Self>) {
        *self.is_awake.lock().unwrap_or_else(PoisonError::into_inner) = true;
        self.changed.notify_one();
    }
}

fn unknown_frame_is_an_error(backend: &mut dyn Backend) {
    let never = FrameHandle::new();
    assert_eq!(backend.poll_image(&never), Err(BackendError::UnknownFrame));
    assert_eq!(backend.wait_image(&never), Err(BackendError::UnknownFrame));
}

/// Whenever a frame is cancelled, it is not delivered, and the next one is as good as ever.
fn cancelled_frames_are_dropped(backend: &mut dyn Backend) {
    const CANCELLED: BackendError = BackendError::Cancelled(Cancelled);
    for &method in backend.caps().methods {
        let scene = scene(&volume([5, 4, 3]), method, Compositing::Separate);
        let expected = render(backend, &scene);
        let plan = Planner::default().plan(&scene).expect("the scene is valid");
        let [before, polled, waited] = [(); 3].map(|()| FrameHandle::new());
        before.cancel();
        if let Err(error) = backend.submit(&plan, &before) {
            assert_eq!(error, CANCELLED, "{method}");
        } else {
            assert_eq!(backend.poll_image(&before), Err(CANCELLED), "{method}");
        }
        for frame in [&polled, &waited] {
            backend.submit(&plan, frame).expect("a tiny frame fits");
            frame.cancel();
        }
        assert_eq!(backend.poll_image(&polled), Err(CANCELLED), "{method}");
        assert_eq!(backend.wait_image(&waited), Err(CANCELLED), "{method}");
        for frame in [&before, &polled, &waited] {
            assert_eq!(backend.poll_image(frame), Err(BackendError::UnknownFrame), "{method}");
        }
        let next = render(backend, &scene);
        assert!(next.image == expected.image, "{method}");
        assert_eq!(next.stats, expected.stats, "{method}");
    }
}

/// What the backend says that it has it draws, and the rest it refuses. `image-aligned` is not for it to
/// lack.
fn methods_are_those_told(backend: &mut dyn Backend) {
    assert!(backend.caps().methods.contains(&Method::ImageAligned));
    let volume = volume([1, 1, 1]);
    for method in Method::ALL {
        let scene = scene(&volume, *method, Compositing::Extinction);
        let plan = Planner::default().plan(&scene).expect("the scene is valid");
        let has_it = backend.caps().methods.contains(method);
        let frame = FrameHandle::new();
        match backend.submit(&plan, &frame) {
            Ok(()) if has_it => drop(backend.wait_image(&frame)),
            Err(BackendError::Unable { .. }) if !has_it => {}
            other => panic!("{method}, reported as {has_it}: {other:?}"),
        }
    }
}

fn order_of_layers_changes_no_bit(backend: &mut dyn Backend) {
    let volume = volume([5, 4, 3]);
    let mut scene = scene(&volume, Method::ImageAligned, Compositing::Extinction);
    scene.layers.push(scene.layers[0].clone());
    scene.layers[1].transfer = transfer(0.2);
    let first = render(backend, &scene);
    scene.layers.swap(0, 1);
    let swapped = render(backend, &scene);
    assert!(swapped.image == first.image, "the planner puts layers into one order");
    assert_eq!(swapped.stats, first.stats);
    assert_eq!(first.stats.n_voxels, 120, "of both layers");
}

/// Two layers of the same voxels are one of twice the extinction, whatever a third one does not show.
fn layers_are_summed(backend: &mut dyn Backend) {
    let volume = volume([5, 4, 3]);
    let mut scene = scene(&volume, Method::ImageAligned, Compositing::Extinction);
    scene.settings.tolerance = 0.0;
    scene.layers[0].transfer = transfer(0.75);
    let whole = render(backend, &scene).image;
    scene.layers[0].transfer = transfer(0.5);
    scene.layers.push(scene.layers[0].clone());
    scene.layers.push(scene.layers[0].clone());
    scene.layers[2].transfer = transfer(0.0);
    let difference = render(backend, &scene).image.max_difference(&whole);
    assert!(difference < 1e-4, "{difference}");
}

/// A region of everything cuts nothing, its complement all, and halves are a whole.
fn regions_cut(backend: &mut dyn Backend) {
    let volume = volume([5, 4, 3]);
    for &compositing in Compositing::ALL {
        let mut scene = scene(&volume, Method::ImageAligned, compositing);
        scene.settings.tolerance = 0.0;
        let whole = render(backend, &scene).image;
        let behind = |x: f64| Region::new(vec![Plane::new(DVec3::X, x).expect("it is not zero")]);
        let mut cut = |regions: &[Region]| {
            let layer = &scene.layers[0];
            let layers = regions.iter().map(|region| layer.clone().region(region.clone()));
            render(backend, &scene.clone().layers(layers.collect())).image
        };
        let difference = cut(&[behind(99.0)]).max_difference(&whole);
        assert!(difference < 1e-5, "{compositing}: {difference}");
        let nothing = cut(&[behind(99.0).inverted()]);
        assert!(nothing.pixels().iter().all(|&pixel| pixel == [0.0; 4]), "{compositing}");
        let halves = [behind(0.3), behind(0.3).inverted()];
        let difference = cut(&halves).max_difference(&whole);
        assert!(difference < 1e-4, "{compositing}: {difference}");
        assert!(1e-3 < cut(&halves[..1]).max_difference(&whole), "{compositing}");
    }
}

/// Plans and renders a frame.
fn render(backend: &mut dyn Backend, scene: &Scene) -> Frame {
    let plan = Planner::default().plan(scene).expect("the scene is valid");
    let frame = FrameHandle::new();
    backend.submit(&plan, &frame).expect("a tiny frame fits");
    backend.wait_image(&frame).expect("the frame was submitted")
}

fn poll_until_ready(backend: &mut dyn Backend, frame: &FrameHandle) -> Frame {
    loop {
        match backend.poll_image(frame).expect("the frame was submitted") {
            Poll::Ready(frame) => return frame,
            Poll::Pending => std::thread::yield_now(),
        }
    }
}

/// Voxels of value 0, but for one: the one at the far end of z has value 1.
fn volume(dims: [usize; 3]) -> Arc<Volume> {
    let grid = Grid::with_spacing(dims, [1.0; 3]).expect("the spacing is positive");
    let mut samples = vec![0_u8; grid.n_voxels()];
    if 1 < samples.len() {
        samples[grid.n_voxels() - 1] = 1;
    }
    let volume = Volume::new(grid, samples.into(), Scaling::IDENTITY);
    Arc::new(volume.expect("there is a sample for every voxel"))
}

fn transfer(opacity: f64) -> TransferFunction {
    TransferFunction::new(vec![(0.0, [opacity])], vec![(0.0, [0.9, 0.6, 0.3])])
        .expect("the points are finite")
}

/// Looks down z at voxel (0, 0, ·), 6 pixels a voxel, everything visible.
fn scene(volume: &Arc<Volume>, method: Method, compositing: Compositing) -> Scene {
    let projection = Projection::Orthographic { view_height: 6.0 };
    let camera = Camera::new(DVec3::Z * 50.0, DVec3::ZERO, DVec3::Y, projection)
        .expect("the camera looks down z");
    let layer = Layer::new(volume.clone(), transfer(0.5)).shading(Shading::None);
    Scene::new(layer, camera)
        .image(ImageDesc::new(36, 36))
        .settings(RenderSettings::default().method(method).mode(compositing.into()))
}
