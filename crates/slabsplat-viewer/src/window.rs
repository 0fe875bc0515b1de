//! The viewer in a window of the desktop.

use crate::app::Viewer;
use crate::frames::{RenderingThread, Wake, WindowDevice};
use crate::jobs::{Opener, Opening};
use eframe::egui_wgpu::{WgpuSetup, WgpuSetupCreateNew};
use eframe::{CreationContext, NativeOptions, Renderer};
use slabsplat::wgpu::Adapter;
use std::io;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use thiserror::Error;

/// What a window begins with.
#[non_exhaustive]
pub struct Start {
    /// What draws: a name that [`slabsplat::Renderer::open`] knows.
    pub backend: String,
    /// What is opened at once: what it is called, and what opens it.
    pub scene: Option<(String, Opening)>,
    /// What is made of names of files that are opened later.
    pub opener: Opener,
}

impl std::fmt::Debug for Start {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Start").field("backend", &self.backend).finish_non_exhaustive()
    }
}

impl Start {
    /// A window in which nothing is open, on the backend that fits.
    pub fn new(opener: Opener) -> Self {
        Self { backend: "auto".to_owned(), scene: None, opener }
    }
}

/// Why there is no window.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum WindowError {
    /// There is no display, or nothing that draws a window on it.
    #[error("there is no window: {0}; `slabsplat render` needs none")]
    NoWindow(String),
}

/// Opens a window and returns when it is closed.
///
/// # Errors
/// If there is no display, or nothing that draws a window on it.
pub fn show(start: Start) -> Result<(), WindowError> {
    let by_wgpu = start.backend == "wgpu" || has_graphics_card();
    let start = Arc::new(Mutex::new(Some(start)));
    let ways: &[Renderer] =
        if by_wgpu { &[Renderer::Wgpu] } else { &[Renderer::Glow, Renderer::Wgpu] };
    let mut shown = Ok(());
    for way in ways {
        let of_window = start.clone();
        let create = move |context: &CreationContext<'_>| {
            let app: Box<dyn eframe::App> = Box::new(viewer(context, &of_window)?);
            Ok(app)
        };
        shown = eframe::run_native("slabsplat", options(*way), Box::new(create));
        // Nor does another way draw where there is no display; what has been shown is not begun once more.
        let is_over = matches!(shown, Ok(()) | Err(eframe::Error::WinitEventLoop(_)));
        if is_over || start_of(&start).is_none() {
            break;
        }
    }
    shown.map_err(|error| WindowError::NoWindow(error.to_string()))
}

/// Whether windows are drawn by more than a program that plays a graphics card. Such a program takes half the
/// time by OpenGL: egui's shaders for wgpu make it sample each texture five times.
fn has_graphics_card() -> bool {
    let by_wgpu = slabsplat::found_backends().into_iter().find(|found| found.name == "wgpu");
    let devices = by_wgpu.and_then(|found| found.devices.ok());
    devices.is_some_and(|devices| devices.iter().any(|device| device.is_fast))
}

fn options(way: Renderer) -> NativeOptions {
    let mut options = NativeOptions { renderer: way, ..NativeOptions::default() };
    let viewport = options.viewport.with_app_id("slabsplat").with_title("slabsplat");
    options.viewport =
        viewport.with_inner_size([1280.0, 800.0]).with_min_inner_size([480.0, 320.0]);
    // Pixels are shown as they were drawn.
    options.dithering = false;
    options.wgpu_options.wgpu_setup = that_draws_frames();
    options
}

fn start_of(start: &Mutex<Option<Start>>) -> MutexGuard<'_, Option<Start>> {
    start.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What the window shows.
fn viewer(context: &CreationContext<'_>, start: &Mutex<Option<Start>>) -> io::Result<Viewer> {
    let start = start_of(start).take().ok_or_else(|| io::Error::other("there is one already"))?;
    let egui = context.egui_ctx.clone();
    let wake: Wake = Arc::new(move || egui.request_repaint());
    let window = context.wgpu_render_state.as_ref();
    let window = window.map(|own| WindowDevice::new(own.device.clone(), own.queue.clone()));
    let source = RenderingThread::spawn_in_window(start.backend, wake.clone(), window)?;
    let mut viewer = Viewer::new(&context.egui_ctx, Box::new(source), start.opener, wake);
    viewer.set_recent(crate::recent::read());
    if let Some((name, opening)) = start.scene {
        viewer.open(name, opening);
    }
    Ok(viewer)
}

/// egui asks for a device; what frames need is added to that, as far as there is such a device.
fn that_draws_frames() -> WgpuSetup {
    let own = WgpuSetupCreateNew::without_display_handle();
    let of_egui = own.device_descriptor.clone();
    let device_descriptor =
        Arc::new(move |adapter: &Adapter| slabsplat::device_descriptor(adapter, of_egui(adapter)));
    WgpuSetup::CreateNew(WgpuSetupCreateNew { device_descriptor, ..own })
}
