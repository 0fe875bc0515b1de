//! The trait, and what goes through it. The crate's documentation is the contract.

use crate::FramePlan;
use slabsplat_core::{Cancelled, FrameHandle, Image, Method, StageError};
use std::task::{Poll, Waker};
use std::time::Duration;
use thiserror::Error;

/// Executes frame plans. Object-safe: the facade holds a `Box<dyn Backend>`.
pub trait Backend: Send {
    /// What it is and what it can do.
    fn caps(&self) -> &Caps;

    /// Begins a frame, which `frame` names from then on; the plan need not live longer than the call.
    ///
    /// # Errors
    /// If the frame does not fit the device, was cancelled, or the device is gone.
    fn submit(&mut self, plan: &FramePlan<'_>, frame: &FrameHandle) -> Result<(), BackendError>;

    /// Takes a frame if it is done, without waiting.
    ///
    /// # Errors
    /// If the frame failed, was cancelled, was never submitted, or was taken already.
    fn poll_image(&mut self, frame: &FrameHandle) -> Result<Poll<Frame>, BackendError>;

    /// Takes a frame as soon as it is done, and sleeps until then. A backend whose frames are not done when
    /// they are submitted should know better than to look every millisecond.
    ///
    /// # Errors
    /// If the frame failed, was cancelled, was never submitted, or was taken already; in a browser, if it is
    /// not done ([`BackendError::CannotWait`]).
    fn wait_image(&mut self, frame: &FrameHandle) -> Result<Frame, BackendError> {
        loop {
            match self.poll_image(frame)? {
                Poll::Ready(frame) => return Ok(frame),
                Poll::Pending => doze()?,
            }
        }
    }

    /// Sees to it that `waker` is woken once it is worth to call [`poll_image`](Self::poll_image) again for a
    /// frame that was pending: that may be before the frame is done. So frames are awaited.
    ///
    /// By default that is a millisecond later, or at once in a browser. Nothing else happens there until who
    /// was woken rests: a backend whose frames are not done when they are submitted must do better there.
    fn wake_when_done(&mut self, frame: &FrameHandle, waker: &Waker) {
        let _ = frame;
        // It need not have slept.
        let _ = doze();
        waker.wake_by_ref();
    }
}

/// Sleeps for a millisecond, where that is allowed.
fn doze() -> Result<(), BackendError> {
    if cfg!(target_family = "wasm") {
        return Err(BackendError::CannotWait);
    }
    std::thread::sleep(Duration::from_millis(1));
    Ok(())
}

/// What a backend is and what it can do.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Caps {
    /// The name that scene files and flags use.
    pub name: &'static str,
    /// What executes the frames, for people.
    pub device: String,
    /// The methods that it has; it refuses the others.
    pub methods: &'static [Method],
    /// Whether it ever draws cells instead of voxels ([`LayerPlan::coarser`]); if not, none need be planned.
    ///
    /// [`LayerPlan::coarser`]: crate::LayerPlan::coarser
    pub draws_cells: bool,
    /// Whether it draws parts of a scene ([`FramePlan::part`]); if not, it refuses their plans.
    pub draws_parts: bool,
}

impl Caps {
    /// Those of a backend that draws voxels.
    pub fn new(name: &'static str, device: impl Into<String>, methods: &'static [Method]) -> Self {
        Self { name, device: device.into(), methods, draws_cells: false, draws_parts: false }
    }

    /// The same of one that draws cells of them, too.
    #[must_use]
    pub fn with_cells(self) -> Self {
        Self { draws_cells: true, ..self }
    }

    /// The same of one that draws parts of a scene, too.
    #[must_use]
    pub fn with_parts(self) -> Self {
        Self { draws_parts: true, ..self }
    }
}

/// A finished frame.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Frame {
    /// The picture, background included.
    pub image: Image,
    /// What was drawn.
    pub stats: FrameStats,
    /// What it cost.
    pub cost: FrameCost,
}

impl Frame {
    /// A frame that has drawn, and cost, what is said of it.
    pub fn new(image: Image, stats: FrameStats, cost: FrameCost) -> Self {
        Self { image, stats, cost }
    }
}

/// What a frame drew. Counts are exact and the same in every run on one backend; another may cut the
/// image into other tiles, and find other splats occluded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct FrameStats {
    /// Voxels that were relevant.
    pub n_voxels: u64,
    /// Those of them that were culled before anything was done with them, since all that they could touch was
    /// saturated, cut off or outside of the image. A backend that does not cull voxels has none.
    pub n_occluded: u64,
    /// Sections or whole footprints that were splatted, once for every tile that they touch.
    pub n_splats: u64,
    /// Those that were not, since all pixels that they could touch on a tile were saturated. A backend that
    /// does not look at what is hidden counts all sections of a voxel on a tile as one.
    pub n_culled: u64,
    /// Tiles that any splat touches.
    pub n_tiles: u64,
    /// Tiles that were saturated before their last sheet.
    pub n_saturated_tiles: u64,
}

/// What a frame cost; differs from run to run.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct FrameCost {
    /// The stages, in their order, and how long each took where the frame was executed. Empty if the
    /// device cannot tell.
    pub stages: Vec<StageTime>,
    /// Bytes that the backend holds between frames, on its device, beside the volume of the plan; a copy of
    /// the volume on another device counts.
    pub resident_bytes: u64,
    /// Of the splats that were culled, those that the frame did not look at, as they were hidden in the frame
    /// before.
    pub n_hidden: u64,
}

impl FrameCost {
    /// What the stages took, and what stays.
    pub fn new(stages: Vec<StageTime>, resident_bytes: u64) -> Self {
        Self { stages, resident_bytes, n_hidden: 0 }
    }
}

/// How long a stage took.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct StageTime {
    /// Its name.
    pub name: &'static str,
    /// Milliseconds.
    pub ms: f64,
}

impl StageTime {
    /// That of a stage called `name`.
    pub fn new(name: &'static str, ms: f64) -> Self {
        Self { name, ms }
    }
}

/// Why a frame failed.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum BackendError {
    /// The frame needs more memory than there is.
    #[error(
        "the frame needs {needed_bytes} bytes for {what} on {device}, which has {available_bytes}"
    )]
    OutOfMemory {
        /// What the memory is for.
        what: &'static str,
        /// What was asked.
        device: String,
        /// Bytes needed.
        needed_bytes: u64,
        /// Bytes there are.
        available_bytes: u64,
    },
    /// The frame needs more of the host's memory than the system gives.
    #[error("the frame needs {needed_bytes} bytes for {what}, and the system has no room for them")]
    OutOfHostMemory {
        /// What the memory is for.
        what: &'static str,
        /// Bytes needed.
        needed_bytes: u64,
    },
    /// The device is gone; make another backend.
    #[error("{device} was lost: {reason}")]
    DeviceLost {
        /// What was lost.
        device: String,
        /// What the driver says.
        reason: String,
    },
    /// The device is there, and this frame is more than it can do.
    #[error("{device} cannot make this frame: {reason}")]
    Unable {
        /// What was asked.
        device: String,
        /// Why not.
        reason: String,
    },
    /// The frame is not done, and it was to be waited for where nobody may sleep: in a browser. It is still
    /// there to be polled.
    #[error("the frame is not done, and a page in a browser cannot wait for it: await or poll it")]
    CannotWait,
    /// No such frame waits to be taken.
    #[error("the frame was never submitted to this backend, or was taken already")]
    UnknownFrame,
    /// Someone who has its handle cancelled the frame.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl BackendError {
    /// Whether the frame failed because of the device, not because of who asked for it: another backend may
    /// draw it.
    pub fn is_of_device(&self) -> bool {
        match self {
            Self::OutOfMemory { .. } | Self::DeviceLost { .. } | Self::Unable { .. } => true,
            Self::OutOfHostMemory { .. }
            | Self::CannotWait
            | Self::UnknownFrame
            | Self::Cancelled(_) => false,
        }
    }
}

impl From<StageError> for BackendError {
    fn from(error: StageError) -> Self {
        match error {
            StageError::Cancelled(cancelled) => cancelled.into(),
            StageError::OutOfMemory { what, needed_bytes } => {
                Self::OutOfHostMemory { what, needed_bytes }
            }
        }
    }
}
