//! The viewer in a window of the desktop.

use crate::app::Viewer;
use crate::frames::{RenderingThread, Wake};
use crate::jobs::{Opener, Opening};
use std::sync::Arc;
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
    let mut options = eframe::NativeOptions::default();
    let viewport = options.viewport.with_app_id("slabsplat").with_title("slabsplat");
    options.viewport =
        viewport.with_inner_size([1280.0, 800.0]).with_min_inner_size([480.0, 320.0]);
    // Pixels are shown as they were drawn.
    options.dithering = false;
    let create = move |context: &eframe::CreationContext<'_>| {
        let egui = context.egui_ctx.clone();
        let wake: Wake = Arc::new(move || egui.request_repaint());
        let source = RenderingThread::spawn(start.backend, wake.clone())?;
        let mut viewer = Viewer::new(&context.egui_ctx, Box::new(source), start.opener, wake);
        viewer.set_recent(crate::recent::read());
        if let Some((name, opening)) = start.scene {
            viewer.open(name, opening);
        }
        let app: Box<dyn eframe::App> = Box::new(viewer);
        Ok(app)
    };
    let run = eframe::run_native("slabsplat", options, Box::new(create));
    run.map_err(|error| WindowError::NoWindow(error.to_string()))
}
