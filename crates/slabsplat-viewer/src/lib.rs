//! A viewer of volumes, drawn by slabsplat.
//!
//! [`show`] opens a window of the desktop; [`Viewer`] is the same as an app of eframe's, for programs that
//! have a window of their own. Frames come from a [`FrameSource`]: here a renderer on a thread, so that the
//! window never waits. While something moves pictures are as small as a frame's budget of time asks for; at
//! rest they are whole, to the pixel what `slabsplat render` makes of the same scene.
//!
//! ```no_run
//! use slabsplat_viewer::{Start, show};
//! use slabsplat::io::{SceneFile, VolumeSource};
//! use std::path::Path;
//! use std::sync::Arc;
//!
//! let opener = |path: &Path| Ok(SceneFile::of_volume(VolumeSource::File(path.to_owned())));
//! show(Start::new(Arc::new(opener)))?;
//! # Ok::<(), slabsplat_viewer::WindowError>(())
//! ```
//!
//! Reading order: `state` (what is open, without a window), `frames` (where pictures come from), `jobs`,
//! `ui`, `app` (all of it), `window`; in a browser `page`, `handed`,
//! `read_elsewhere` and `received`.

pub mod state;

mod frames;

#[cfg(any(target_arch = "wasm32", test))]
mod handed;
mod jobs;
#[cfg(target_arch = "wasm32")]
mod page;
#[cfg(any(target_arch = "wasm32", test))]
mod read_elsewhere;
#[cfg(any(target_arch = "wasm32", test))]
mod received;
#[cfg(not(target_arch = "wasm32"))]
mod recent;

mod ui;

mod app;

#[cfg(not(target_arch = "wasm32"))]
mod window;

pub use app::Viewer;
pub use frames::{
    Drawn, DrawnInTexture, Event, FrameSource, Request, Urgency, Wake, WindowTexture,
};
#[cfg(not(target_arch = "wasm32"))]
pub use frames::{RenderingThread, WindowDevice};
pub use jobs::{Opener, Opening};
#[cfg(target_arch = "wasm32")]
pub use page::{show_in_page, work_for_page};
#[cfg(not(target_arch = "wasm32"))]
pub use window::{Start, WindowError, show};
