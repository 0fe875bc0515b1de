//! Frames on devices under observation: how tests of what only backends on a GPU can get wrong run, and
//! their scenes.

use crate::exact_settings;
use crate::render::{n_devices, shared_device, validation_messages};
use crate::spy_device::{Orders, SpyDevice};
use slabsplat::glam::{DAffine3, DVec3};
use slabsplat::{
    Backend, BackendError, Camera, Frame, FrameHandle, FramePlan, Grid, ImageDesc, LabelMap,
    LabelStyle, Labels, Layer, Method, Mode, PiecewiseLinear, Plane, Planner, Projection, Region,
    Scaling, Scene, TransferFunction, Volume,
};
use slabsplat_gpu::{DeviceInfo, DeviceKind, GpuBackend};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A ball of waves in 64-bit floats.
///
/// # Panics
/// If there are no voxels.
pub fn volume(dims: [usize; 3]) -> Arc<Volume> {
    let grid = Grid::with_spacing(dims, [1.0, 1.2, 0.9]).expect("the spacing is positive");
    let center = grid.center_in_index();
    let value = |voxel_idx: usize| {
        let at = DVec3::from_array(grid.voxel_coords(voxel_idx).map(|c| c as f64));
        let r = at.distance(center) / center.length();
        (1.0 - r) * (0.7 + 0.3 * (at.x * 0.7 + at.y * 0.3).sin() * (0.5 * at.z).cos())
    };
    let samples: Vec<f64> = (0..grid.n_voxels()).map(value).collect();
    Arc::new(Volume::new(grid, samples.into(), Scaling::IDENTITY).expect("one sample a voxel"))
}

/// The whole of `volume`, on an image of that many columns.
///
/// # Panics
/// Never: the camera is one of our own.
pub fn scene(volume: &Arc<Volume>, width: u32, method: Method) -> Scene {
    let target = volume.grid().center_in_world();
    let size = volume.grid().dims().into_iter().max().expect("there are three") as f64;
    let projection = Projection::Orthographic { view_height: 1.4 * size };
    let eye = target + DVec3::new(3.0, 2.0, -2.5) * size;
    let camera = Camera::new(eye, target, DVec3::Y, projection).expect("up is not forward");
    Scene::new(Layer::new(volume.clone(), transfer(0.3)), camera)
        .image(ImageDesc::new(width, width * 3 / 4).background([0.1, 0.2, 0.3, 0.4]))
        .settings(exact_settings().method(method).mode(Mode::Extinction))
}

/// A ramp up to that opacity.
///
/// # Panics
/// If it is not one.
pub fn transfer(opacity: f64) -> TransferFunction {
    let opacities = vec![(0.1, [0.0]), (0.8, [opacity])];
    let colors = vec![(0.0, [1.0, 0.3, 0.1]), (1.0, [0.2, 0.9, 1.0])];
    TransferFunction::new(opacities, colors).expect("the points are sorted")
}

/// Submits a frame.
///
/// # Errors
/// If the backend refuses it.
///
/// # Panics
/// If the scene is not valid.
pub fn submit(backend: &mut dyn Backend, scene: &Scene) -> Result<FrameHandle, BackendError> {
    submit_plan(backend, &Planner::default().plan(scene).expect("the scene is valid"))
}

/// The same of a frame that is planned.
///
/// # Errors
/// If the backend refuses it.
pub fn submit_plan(
    backend: &mut dyn Backend,
    plan: &FramePlan<'_>,
) -> Result<FrameHandle, BackendError> {
    let frame = FrameHandle::new();
    backend.submit(plan, &frame)?;
    Ok(frame)
}

/// Waits for a frame.
///
/// # Errors
/// If there is none.
///
/// # Panics
/// If the validation of a graphics interface has found fault with anything so far.
pub fn take(backend: &mut dyn Backend, frame: &FrameHandle) -> Result<Frame, BackendError> {
    let taken = backend.wait_image(frame)?;
    let messages = validation_messages();
    assert!(messages.is_empty(), "validation: {}", messages.join("\n"));
    Ok(taken)
}

/// Submits a frame and waits for it.
///
/// # Errors
/// If the backend refuses it, or there is none.
///
/// # Panics
/// As both.
pub fn render(backend: &mut dyn Backend, scene: &Scene) -> Result<Frame, BackendError> {
    let frame = submit(backend, scene)?;
    take(backend, &frame)
}

/// Two volumes that interleave, on grids of different steps, each in a region of its own.
///
/// # Panics
/// Never, for volumes of these tests.
pub fn layered_scene(volumes: [&Arc<Volume>; 2], width: u32) -> Scene {
    let mut scene = scene(volumes[0], width, Method::ImageAligned);
    let center = volumes[0].grid().center_in_world();
    let cut = |normal: DVec3| Plane::new(normal, normal.dot(center)).expect("it is not zero");
    scene.layers[0].region = Region::new(vec![cut(DVec3::X), cut(DVec3::Y)]).inverted().lit();
    let colors = vec![(0.0, [0.1, 0.9, 0.2]), (1.0, [0.9, 0.9, 0.2])];
    let transfer = TransferFunction::new(vec![(0.1, [0.0]), (0.9, [0.4])], colors);
    let second = Layer::new(volumes[1].clone(), transfer.expect("the points are sorted"));
    scene.layers.push(second.region(Region::new(vec![cut(DVec3::new(0.3, 1.0, 0.2))])));
    scene
}

/// The layer with voxels that look otherwise by label and gradient, so that the host lists them.
///
/// # Panics
/// Never, for volumes of these tests.
pub fn listed_by_host(layer: Layer) -> Layer {
    let grid = *layer.volume.grid();
    let labels: Vec<u8> = (0..grid.n_voxels()).map(|idx| (idx / 5 % 4) as u8).collect();
    let labels = Volume::new(grid, labels.into(), Scaling::IDENTITY).expect("one a voxel");
    let map = LabelMap::new(&labels, &grid).expect("labels are whole numbers");
    let green = LabelStyle::default().color([0.2, 1.0, 0.3]).opacity(0.7);
    let own = LabelStyle::default().transfer(transfer(0.5));
    let invisible = LabelStyle::default().opacity(0.0);
    let labels = Labels::new(map, [(1, green), (2, own), (3, invisible)]);
    let factor = PiecewiseLinear::new("factor", vec![(0.0, [0.3]), (0.4, [1.0])]);
    layer
        .labels(labels.expect("opacities are from 0 to 1"))
        .gradient_opacity(factor.expect("so are these"))
}

/// The scene with its first layer [listed by the host](listed_by_host).
pub fn with_host_list(mut scene: Scene) -> Scene {
    scene.layers[0] = listed_by_host(scene.layers[0].clone());
    scene
}

/// The same values on a grid with steps of another length, about the same centre.
///
/// # Panics
/// Never, for volumes of these tests.
pub fn stretched(volume: &Arc<Volume>, by: f64) -> Arc<Volume> {
    let old = volume.grid();
    let old_world_from_index = old.world_from_index();
    let center = old.center_in_world();
    let origin = center + by * (old_world_from_index.translation - center);
    let world_from_index =
        DAffine3::from_mat3_translation(old_world_from_index.matrix3 * by, origin);
    let grid = Grid::new(old.dims(), world_from_index).expect("it can be inverted as before");
    let volume = Volume::new(grid, volume.samples().clone(), volume.scaling());
    Arc::new(volume.expect("there are as many samples"))
}

/// Runs a test on every device, with limits as `change` leaves them, each by a backend that is new.
pub fn on_devices(
    change: impl Fn(&mut DeviceInfo),
    test: impl Fn(&str, &mut dyn Backend, &Mutex<Orders>),
) {
    (0..n_devices()).for_each(|number| on_device(number, &change, &test));
}

/// Runs it on one of them, in turn by `number`: enough of a test that has many cases, or that no device
/// decides.
pub fn on_a_device(
    number: usize,
    change: impl Fn(&mut DeviceInfo),
    test: impl Fn(&str, &mut dyn Backend, &Mutex<Orders>),
) {
    if 0 < n_devices() {
        on_device(number % n_devices(), &change, &test);
    }
}

fn on_device(
    number: usize,
    change: &impl Fn(&mut DeviceInfo),
    test: &impl Fn(&str, &mut dyn Backend, &Mutex<Orders>),
) {
    let (name, device) = shared_device(number);
    let spy = SpyDevice::new(device, change);
    let orders = spy.orders();
    test(name, &mut GpuBackend::new(name, spy), &orders);
}

/// Leaves limits as they are.
pub fn as_it_is(_: &mut DeviceInfo) {}

/// Lets dispatches take on as few splats as those of drivers that play a card, as a card may well be done
/// with all of them at once.
pub fn in_rounds(info: &mut DeviceInfo) {
    info.kind = DeviceKind::Software;
}

/// To be held by a test, so that one is run at a time: together they would open dozens of devices at once,
/// which Mesa's software driver has been seen to crash under, and NVIDIA's to hang.
pub fn alone() -> MutexGuard<'static, ()> {
    static ONE: Mutex<()> = Mutex::new(());
    ONE.lock().unwrap_or_else(PoisonError::into_inner)
}
