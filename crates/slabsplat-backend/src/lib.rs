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
//! - **What is kept.** A backend may keep whatever it made of a volume, a transfer function or a table for
//!   the next plan that holds the same; it holds one volume at a time.
//! - **Portability.** Pixels of two backends differ by at most 10⁻³ in every channel, or by what the plan's
//!   opacity cut-off leaves of 1, where that is more.
//! - **Determinism.** The same plan gives the same bits on the same backend and machine, whatever the
//!   number of threads and whatever was rendered before.
//! - **Time.** [`Backend::submit`] may return before the frame is done; [`Backend::poll_image`] never
//!   waits for it. Frames finish in the order of submission, and each can be taken once.
//! - **Methods.** A backend that lacks a method refuses its plans in [`Backend::submit`], as
//!   [`BackendError::Unable`]; it never draws by another. The CPU backend has them all.
//! - **Errors.** [`BackendError`] is what a caller can act on. After an error the frame is gone and the
//!   backend can be used on, unless it is [`BackendError::DeviceLost`]. A wrong picture is never
//!   an acceptable answer.
//! - **Bugs.** Taking a frame that was never submitted is the caller's bug and an error, not a panic.
//!
//! # Features
//!
//! - `conformance`: the tests that every backend must pass, to be called from its own.
//!
//! # Reading order
//!
//! `plan`, `planner`, `contract`, `conformance`.

mod contract;
mod plan;
mod planner;

#[cfg(feature = "conformance")]
pub mod conformance;

pub use contract::{Backend, BackendError, Caps, Frame, FrameCost, FrameId, FrameStats, StageTime};
pub use plan::{FewerSections, FramePlan, Splats};
pub use planner::{PlanError, Planner};
