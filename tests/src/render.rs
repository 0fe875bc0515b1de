//! A picture by a backend of the project, for tests that judge it.
//!
//! The GPU backends are opened with the validation of their graphics interface on, where it is installed,
//! and a test that makes it speak fails: a driver may forgive what the next one does not.

use crate::lent_device::{Lender, LentDevice};
use slabsplat::{Backend, Image, Method, Renderer, Scene, backend_named};
use slabsplat_gpu::{Device, GpuBackend, OpenOptions, Unavailable};
use std::collections::BTreeMap;
use std::io::Write;
use std::sync::{LazyLock, Mutex, MutexGuard, Once, PoisonError};

/// Set to anything, it makes the want of a device for the GPU backends a failure.
const REQUIRE_GPU: &str = "SLABSPLAT_REQUIRE_GPU";

/// The names of the backends that every test runs on: `cpu`, and those on a GPU that this machine has
/// something for, be it a driver that plays one. What is left out is said on stderr.
///
/// # Panics
/// If something is left out, and the environment says that it must not be.
pub fn backends() -> &'static [&'static str] {
    static NAMES: LazyLock<Vec<&str>> = LazyLock::new(|| {
        let opened = RENDERERS.iter().filter(|(name, opened)| is_there(name, opened));
        std::iter::once("cpu").chain(opened.map(|(name, _)| *name)).collect()
    });
    if std::env::var_os(REQUIRE_GPU).is_some() {
        for (name, opened) in &*RENDERERS {
            let reason = opened.as_ref().err();
            assert!(reason.is_none(), "{REQUIRE_GPU} is set, but there is no {name}: {reason:?}");
        }
    }
    &NAMES
}

/// Those of [`backends`] that have a method.
pub fn backends_with(method: Method) -> impl Iterator<Item = &'static str> {
    let has_it = move |name: &&str| METHODS[name].contains(&method);
    backends().iter().copied().filter(has_it)
}

/// The CPU and one of the other backends that have a method, which take turns by `number`. They share their
/// shaders, so that a test of many scenes shows what is wrong with either, and drivers that only play a
/// device take longer than all else.
pub fn backends_in_turn(method: Method, number: usize) -> impl Iterator<Item = &'static str> {
    let (cpu, others): (Vec<_>, Vec<_>) = backends_with(method).partition(|name| *name == "cpu");
    let n_others = others.len().max(1);
    cpu.into_iter().chain(others.into_iter().skip(number % n_others).take(1))
}

/// The pictures of a scene by some backends, each by its name. The CPU's, which others are compared with,
/// comes first, and is drawn once.
///
/// # Panics
/// As [`render`].
pub fn pictures(
    backends: impl IntoIterator<Item = &'static str>,
    scene: &Scene,
) -> Vec<(&'static str, Image)> {
    let others = backends.into_iter().filter(|backend| *backend != "cpu");
    std::iter::once("cpu").chain(others).map(|name| (name, render(name, scene))).collect()
}

/// What the backends say that they have, each asked once.
static METHODS: LazyLock<BTreeMap<&str, &[Method]>> =
    LazyLock::new(|| backends().iter().map(|name| (*name, open(name).caps().methods)).collect());

/// Renders a frame.
///
/// # Panics
/// If there is no such backend, the scene is not valid, or the validation of a graphics interface has
/// found fault with anything so far.
pub fn render(backend: &str, scene: &Scene) -> Image {
    if backend == "cpu" {
        return image(&mut Renderer::new(open(backend)), scene);
    }
    let opened = RENDERERS.get(backend).expect("tests only name backends that there are");
    let renderer = opened.as_ref().expect("tests only name backends that have opened");
    // A test that failed in here has broken its own picture only.
    let mut renderer = renderer.lock().unwrap_or_else(PoisonError::into_inner);
    let image = image(&mut renderer, scene);
    let messages = validation_messages();
    assert!(messages.is_empty(), "validation: {}", messages.join("\n"));
    image
}

/// A backend of its own, which has drawn nothing yet; its device may have, for others.
///
/// # Panics
/// If there is no such backend.
pub fn open(backend: &str) -> Box<dyn Backend> {
    let Some(gpu) = GPUS.iter().position(|(name, _)| *name == backend) else {
        return backend_named(backend).expect("tests only name backends that there are");
    };
    let (name, device) = lent_device(gpu);
    Box::new(GpuBackend::new(name, device))
}

/// What the validation of the graphics interfaces has said in this process.
pub fn validation_messages() -> Vec<String> {
    messages().clone()
}

/// The devices of the GPU backends that there are, newly opened.
///
/// # Panics
/// If one has opened before and does not now.
pub fn devices() -> Vec<(&'static str, Box<dyn Device>)> {
    let is_there = |(name, _): &&(&str, Open)| backends().contains(name);
    let opened = |(name, open): &(&'static str, Open)| (*name, open().expect("it opened before"));
    GPUS.iter().filter(is_there).map(opened).collect()
}

/// How many there are.
pub fn n_devices() -> usize {
    backends().len() - 1
}

/// One of those devices by its number, as others have left it: opened before, if nobody has it, with
/// pipelines but without buffers.
///
/// # Panics
/// If there is no such device, or one has opened before and does not now.
pub fn shared_device(number: usize) -> (&'static str, Box<dyn Device>) {
    let is_there = |gpu: &usize| backends().contains(&GPUS[*gpu].0);
    let gpu = (0..GPUS.len()).filter(is_there).nth(number).expect("a number of a device");
    let (name, device) = lent_device(gpu);
    (name, Box::new(device))
}

fn lent_device(gpu: usize) -> (&'static str, LentDevice) {
    static LENDERS: LazyLock<[Lender; GPUS.len()]> = LazyLock::new(Default::default);
    let (name, open) = GPUS[gpu];
    (name, LENDERS[gpu].lend(|| open().expect("it opened before")))
}

type Open = fn() -> Result<Box<dyn Device>, Unavailable>;

const GPUS: [(&str, Open); 2] =
    [("wgpu", || watched(slabsplat_wgpu::open)), ("ash", || watched(slabsplat_ash::open))];

/// One for each GPU backend and for all tests, since opening takes longer than a small frame.
static RENDERERS: LazyLock<BTreeMap<&str, Opened>> = LazyLock::new(|| {
    let shared = |name, device| Mutex::new(Renderer::new(Box::new(GpuBackend::new(name, device))));
    GPUS.iter().map(|(name, open)| (*name, open().map(|device| shared(name, device)))).collect()
});

/// Or why there is none.
type Opened = Result<Mutex<Renderer>, Unavailable>;

fn is_there(name: &str, opened: &Opened) -> bool {
    if let Err(reason) = opened {
        // Not a print macro: those are silent in tests that pass. If nobody reads it, no test is worse.
        let _ = writeln!(std::io::stderr(), "skipped: no tests of {name}: {reason}");
    }
    opened.is_ok()
}

/// Opens a device with the validation of its interface on.
fn watched<D: Device + 'static>(
    open: fn(&OpenOptions) -> Result<D, Unavailable>,
) -> Result<Box<dyn Device>, Unavailable> {
    static LISTENING: Once = Once::new();
    LISTENING.call_once(listen_to_wgpu);
    Ok(Box::new(open(&OpenOptions::default().validation(record))?))
}

fn image(renderer: &mut Renderer, scene: &Scene) -> Image {
    renderer.render(scene).expect("scenes of tests are valid").image
}

fn messages() -> MutexGuard<'static, Vec<String>> {
    static MESSAGES: Mutex<Vec<String>> = Mutex::new(Vec::new());
    MESSAGES.lock().unwrap_or_else(PoisonError::into_inner)
}

fn record(message: &str) {
    messages().push(message.to_owned());
}

/// Older layers do not know WGSL as a language that shaders come from.
const FALSE_ALARMS: &[&str] = &["Invalid source language operand: 10"];

/// wgpu hands on what Vulkan's validation says as warnings and errors of its lowest layer.
struct WgpuLog;

fn listen_to_wgpu() {
    log::set_logger(&WgpuLog).expect("nobody else in the tests listens");
    log::set_max_level(log::LevelFilter::Warn);
}

impl log::Log for WgpuLog {
    fn enabled(&self, metadata: &log::Metadata<'_>) -> bool {
        metadata.level() <= log::Level::Warn && metadata.target().starts_with("wgpu_hal")
    }

    fn log(&self, line: &log::Record<'_>) {
        let text = line.args().to_string();
        // The loader speaks here, too, of drivers that do not suit it.
        let is_ours = self.enabled(line.metadata()) && text.starts_with("VALIDATION");
        if is_ours && !FALSE_ALARMS.iter().any(|alarm| text.contains(alarm)) {
            record(&text);
        }
    }

    fn flush(&self) {}
}
