//! Volume rendering by splatting: a scalar volume goes in, a picture comes out.
//!
//! slabsplat implements Mueller & Crawfis, "Eliminating Popping Artifacts in Sheet Buffer-Based
//! Splatting" (IEEE Visualization '98). Each voxel is a 3D kernel; slabs parallel to the image cut it into
//! sections; a slab's sections are summed into a sheet, and sheets are composited front to back. So
//! the picture does not pop when the camera turns. The two methods which that one replaces are here
//! too, and one that sums densities and classifies pixels ([`Method`]).
//!
//! A [`Scene`] shows volumes, each a [`Layer`]. A [`Renderer`] holds a backend and makes a [`Frame`] of a
//! scene. It keeps what does not change between frames: the values of bricks, the relevant voxels with their
//! normals, the tables.
//!
//! ```
//! use slabsplat::{Automatic, ImageDesc, RenderSettings, Renderer};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let volume = slabsplat::io::builtin_volume("sphere", Some(16))?;
//! let automatic = Automatic::new(volume);
//! let image = ImageDesc::new(32, 32);
//! let scene = automatic.scene(image, RenderSettings::default());
//!
//! let mut renderer = Renderer::open("auto", |note| eprintln!("{note}"))?;
//! let frame = renderer.render(&scene)?;
//! assert!(0.9 < frame.image.pixel(16, 16)[3], "the middle of the ball is opaque");
//! # Ok(())
//! # }
//! ```
//!
//! # Features
//!
//! - `cpu` (default): the CPU backend.
//! - `wgpu`, `ash`: the GPU backend on wgpu, and on raw Vulkan. Neither is needed to build or to run: where
//!   there is no driver, [`found_backends`] says so, and `auto` takes the CPU.
//! - `files` (default): reading volumes and scenes, writing pictures, built-in volumes ([`io`]).
//! - `film`: films of scenes ([`film`]).
//! - `annotations`: text and other things drawn onto pictures ([`annotations`]).
//! - `exr`, `webp`: pictures as OpenEXR and as WebP, too.
//! - `hdf5`: volumes in HDF5 files, too.
//! - `serde`: what scenes are made of, read and written with the keys of scene files.
//! - `image`: pictures as images of the crate `image` ([`Image::to_rgba8`] needs none).
//! - `ndarray`: volumes of arrays of the crate `ndarray`.
//!
//! # Of one's own
//!
//! - A reconstruction kernel implements [`Kernel`], and [`Renderer::add_kernel`] gives it a name.
//! - A backend implements [`Backend`]; [`backend`] has all that it is given, and [`Renderer::new`] takes it.
//!
//! # In a browser
//!
//! All but `ash` builds for `wasm32-unknown-unknown`, also with `-Ctarget-feature=+simd128`. The CPU
//! backend needs nothing of the page and has one thread there; without a clock, frames have no times.
//! [`Renderer::open_async`] opens a graphics card, and [`Renderer::render_async`] draws with it, futures that
//! any executor drives; [`Renderer::render`] would wait for a page that waits for it, and returns
//! [`BackendError::CannotWait`]. With `files`, volumes and meshes are read from bytes, by
//! [`io::FilesInMemory`], and pictures become bytes.
//!
//! # In a window of one's own
//!
//! A program that has a device of wgpu's, as windows of egui and bevy have, shares it (feature `wgpu`). A
//! [`TextureRenderer`] draws on that device into the program's textures, and no picture is read back;
//! [`Renderer::on_wgpu`] reads back as any renderer does. [`device_descriptor`] adds to the program's request
//! of a device what frames need; the re-export [`wgpu`] is of the right version.
//!
//! # What a pixel is
//!
//! The page [`model`] defines it; "model §3" is its third section, wherever that is cited. "The paper" is
//! Mueller & Crawfis 1998.
//!
//! # Reading order
//!
//! `renderer`, `picture`, `backends`; `pending_frame`, `render_thread`; `texture_renderer`; `small_samples`,
//! `automatic`, `framing`, `otsu`, `transfer`, `scene_file`, `scene_changes`, `scene_layers`, `scene_film`,
//! `divided`; `popping`, `comparison`; [`paper`].

#![cfg_attr(docsrs, feature(doc_cfg))]
#![deny(clippy::exhaustive_enums, clippy::exhaustive_structs)]

mod backends;
mod picture;
mod renderer;

#[cfg(not(target_arch = "wasm32"))]
mod pending_frame;
#[cfg(not(target_arch = "wasm32"))]
mod render_thread;

#[cfg(feature = "wgpu")]
mod texture_renderer;

mod automatic;
#[cfg(feature = "files")]
mod divided;
mod framing;
mod otsu;
#[cfg(feature = "files")]
mod scene_changes;
#[cfg(feature = "files")]
mod scene_file;
#[cfg(all(feature = "files", feature = "film"))]
mod scene_film;
#[cfg(feature = "files")]
mod scene_layers;
mod small_samples;
mod transfer;
#[cfg(feature = "files")]
mod volume_facts;

mod comparison;
mod popping;

pub mod paper;

pub use automatic::{Automatic, DataKind};
pub use backends::{
    BACKEND_NAMES, Choice, FoundBackend, FoundDevice, NoBackend, backend_named, choose_backend,
    choose_backend_async, found_backends,
};
pub use comparison::{
    MAX_VARIANTS, Variant, Vary, VaryError, difference_picture, gain_for, variants,
};
#[cfg(feature = "annotations")]
pub use comparison::{Pane, Sheet, SheetDesc};
#[cfg(feature = "files")]
pub use divided::{
    DividedDesc, DividedError, DividedScene, Exchange, NoRoom, Refinement, ShareCost, SharedDesc,
    SharedScene,
};
pub use framing::{Aim, AimError, Facing, Framing};
#[cfg(not(target_arch = "wasm32"))]
pub use pending_frame::PendingFrame;
pub use picture::{Picture, finished, frame_scene};
pub use popping::{Motion, PoppingError, PoppingReport, Sweep, SweepError, measure_popping};
#[cfg(not(target_arch = "wasm32"))]
pub use render_thread::RenderThread;
pub use renderer::{RenderError, Renderer};
#[cfg(feature = "files")]
pub use scene_file::{OpenError, OpenScene, open_layer};
pub use transfer::{ValueCounts, plot_transfer, plotted_range};

#[cfg(feature = "wgpu")]
pub use texture_renderer::{Drawn, TextureRenderer};

/// The wgpu that slabsplat draws with. Types of two versions of wgpu are two types, so whoever gives devices
/// and textures to slabsplat has the version that is here: wgpu 30, as egui 0.37 does.
#[cfg(feature = "wgpu")]
pub use slabsplat_wgpu::wgpu;
#[cfg(feature = "wgpu")]
pub use slabsplat_wgpu::{TargetError, TextureTarget, device_descriptor};

/// What a [`Backend`] of one's own is given and gives back: all that a [`FramePlan`] is made of.
pub use slabsplat_backend as backend;
/// Kernels, their sections, and tables of these.
pub use slabsplat_kernel as kernel;

pub use slabsplat_backend::{
    Backend, BackendError, Caps, Frame, FrameCost, FramePlan, FrameStats, PlanError, Planner,
    StageTime,
};
pub use slabsplat_core::*;
pub use slabsplat_kernel::{KERNEL_NAMES, Kernel, KernelError, MAX_RADIUS, UnknownKernel};

/// Films: scenes between key frames, a camera that goes around, and frames as files that move.
#[cfg(feature = "film")]
pub use slabsplat_film as film;

/// Text and other things that are drawn onto pictures.
#[cfg(feature = "annotations")]
pub use slabsplat_annotations as annotations;

/// Volume, scene and picture files, and built-in volumes.
#[cfg(feature = "files")]
pub use slabsplat_io as io;

#[cfg(all(doctest, feature = "files"))]
#[doc = include_str!("../README.md")]
struct Readme;
