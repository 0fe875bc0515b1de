//! The contract between slabsplat and what executes its frames.
//!
//! Everything that decides a pixel is decided before a backend sees it, in a [`FramePlan`]: which
//! values, which tables, matrices, slabs, colours. A [`Backend`] executes the plan. Two backends given
//! one plan give one picture.
//!
//! # The contract
//!
//! - **Who validates.** The plan is valid by construction. A backend does not check it again, and
//!   does not look for a better one.
//! - **What is decided here, and what there.** The plan says by ranges of values which voxels are drawn.
//!   The backend finds them, shades, projects, tosses and splats. It never reads a file, never drops a
//!   relevant voxel (unless it lies behind the plan's opacity cut-off), never changes a method that it
//!   finds slow.
//! - **What is cached.** A backend may cache whatever it made of a volume, a transfer function or a table for
//!   the next plan that holds the same; it holds the volumes of one frame at a time.
//! - **Saturated pixels.** A pixel whose opacity has reached the plan's cut-off may stay as it is: what lies
//!   behind adds at most what the cut-off leaves of 1. How many pixels stop at a time is the backend's own
//!   affair. The CPU stops blocks of 4 × 4, once all of them are saturated, as vectors take four pixels at a
//!   time and voxels are culled by blocks. A GPU stops each pixel by itself, as its threads have no cheaper
//!   way to ask.
//! - **Portability.** Pixels of two backends differ by at most 10⁻³ in every channel, if tables are no
//!   coarser than by default (a row of fewer samples is a polynomial to one and a chain of lines to another),
//!   and beyond that by no more than the plan leaves open: what its opacity cut-off leaves of 1, and the
//!   tolerance of its permissions to merge sections, [`MergedSections`], and to draw cells of voxels,
//!   [`LayerPlan::coarser`], which one may use and the other not. By default that is 0.05 in the worst of
//!   volumes, and in scans 2 of 255 at single pixels.
//! - **Determinism.** The same plan gives the same bits on the same backend and machine, whatever the
//!   number of threads and whatever was rendered before.
//! - **Time.** [`Backend::submit`] may return before the frame is done; [`Backend::poll_image`] never
//!   waits for it, and [`Backend::wait_image`] does, but in a browser, where it is awaited:
//!   [`Backend::wake_when_done`]. Frames finish in the order of submission, and each can be taken once.
//! - **Names.** The caller names a frame by a [`FrameHandle`](slabsplat_core::FrameHandle), a new one for
//!   each. A frame whose handle nobody else has can be taken by nobody, and is dropped.
//! - **Cancelling.** A frame that was cancelled before it was taken is never delivered, but the error
//!   [`BackendError::Cancelled`], by whichever call comes next; the frame is then gone. A backend that draws
//!   within [`Backend::submit`] looks every few milliseconds; one that sends work to a device looks before
//!   each submission, and what is under way there is dropped when it is done. What is cached stays as good as
//!   it was: the next frame has the bits that it would have had.
//! - **Progress.** A backend says how much of a frame is drawn, by slabs, as far as it knows: it calls
//!   [`reach`](slabsplat_core::FrameHandle::reach).
//! - **Methods.** [`Caps::methods`] says which methods a backend has. It refuses plans of the others in
//!   [`Backend::submit`], as [`BackendError::Unable`], and never draws by another. The CPU backend has them
//!   all.
//! - **Layers.** Every backend draws several layers of colours, and regions, as far as [`FramePlan`] allows
//!   them; how many layers, may have a limit. One that draws densities may refuse more than one layer of
//!   them.
//! - **Parts.** A backend that [draws parts](Caps::draws_parts) of a scene shows the same of each as it would
//!   of the whole, so that their pictures, laid over each other, are that of the whole up to rounding, and
//!   begins with what lies in front. The others refuse such plans, as [`BackendError::Unable`].
//! - **Errors.** [`BackendError`] is what a caller can act on. After an error the frame is gone and the
//!   backend can still be used, unless it is [`BackendError::DeviceLost`]. A wrong picture is never
//!   an acceptable answer.
//! - **Bugs.** Taking a frame that was never submitted is the caller's bug and an error, not a panic. So is
//!   to submit two by one handle; which of them is then taken is left open.
//!
//! # Features
//!
//! - `conformance`: the tests that every backend must pass, to be called from its own.
//!
//! # Reading order
//!
//! `plan`, `slabs`, `cached`, `tables`; `plan_error`, `scene_checks`, `layer_order`, `shown_values`,
//! `meshes`, `seen_layer`, `layer_to_plan`, `part_support`, `planner`; `densities`; `contract`,
//! `conformance`.

#![cfg_attr(docsrs, feature(doc_cfg))]
#![deny(clippy::exhaustive_enums, clippy::exhaustive_structs)]

mod cached;
mod contract;
mod layer_order;
mod layer_to_plan;
mod meshes;
mod part_support;
mod plan;
mod plan_error;
mod planner;
mod polynomial_pair;
mod scene_checks;
mod seen_layer;
mod shown_values;
mod slabs;
mod tables;
mod work;

pub mod densities;

#[cfg(feature = "conformance")]
pub mod conformance;

pub use cached::{ByIdentity, Cached};
pub use contract::{Backend, BackendError, Caps, Frame, FrameCost, FrameStats, StageTime};
pub use part_support::SceneInParts;
pub use plan::{
    CellsPlan, ColorSplats, DensitySplats, FramePlan, LayerPlan, MergedSections, MeshPlan,
    MeshesPlan, SectionSplats, SeparableDensities, ShownDensities, SmoothSections, Splats,
};
pub use plan_error::PlanError;
pub use planner::Planner;
pub use polynomial_pair::PolynomialPair;
pub use scene_checks::check_parts;
pub use slabs::Slabs;
