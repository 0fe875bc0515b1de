//! What a graphics interface must be able to do: keep buffers, run compute shaders on them in order,
//! and hand bytes back later. That is all that a new backend has to write.

use slabsplat_shaders::Shader;
use std::borrow::Cow;
use std::task::{Poll, Waker};
use std::time::Duration;
use thiserror::Error;

/// A device that executes [`Work`], opened through one graphics interface.
///
/// Work is executed in the order of submission, and within one submission in the order of the lists:
/// all writes, then all passes, then all reads. Each step sees what every step before it wrote.
pub trait Device: Send {
    /// What it is, and its limits.
    fn info(&self) -> &DeviceInfo;

    /// Makes a buffer of `size` bytes (a multiple of 4, above 0), filled with zeros. It can be written,
    /// read back, and bound as storage or uniform.
    ///
    /// # Errors
    /// If there is no memory for it, or the device is lost.
    fn create_buffer(&mut self, label: &'static str, size: u64) -> Result<BufferId, DeviceError>;

    /// Gives a buffer back, once the work submitted so far is done with it. The id is not used again.
    fn destroy_buffer(&mut self, buffer: BufferId);

    /// Begins work. It may wait for earlier work, and while it sends long writes; never for passes or
    /// reads of this work.
    ///
    /// # Errors
    /// If there is no memory for it, or the device is lost.
    fn submit(&mut self, work: &Work<'_>) -> Result<WorkId, DeviceError>;

    /// What work has brought, if it is done, without waiting. Each can be taken once.
    ///
    /// # Errors
    /// If the device was lost.
    ///
    /// # Panics
    /// It may, if there is no such work or it was taken: that is the caller's bug.
    fn poll(&mut self, work: WorkId) -> Result<Poll<Done>, DeviceError>;

    /// Sleeps until work is done, but no longer than `at_most`. It may return before: where nobody is allowed
    /// to wait, as in a browser, or if the device was lost, as the next [`poll`](Self::poll) reports.
    fn wait(&mut self, work: WorkId, at_most: Duration);

    /// Sees to it that `waker` is woken once it is worth to [`poll`](Self::poll) work that was pending: when
    /// it is done, or before. By default it is woken now, after a [`wait`](Self::wait) of 5 ms at most; where
    /// that does not sleep a device must do better.
    fn wake_when_done(&mut self, work: WorkId, waker: &Waker) {
        self.wait(work, LOOK_EVERY);
        waker.wake_by_ref();
    }
}

/// How long nobody looks whether a frame that is waited for was cancelled.
pub(crate) const LOOK_EVERY: Duration = Duration::from_millis(5);

/// A device and what it can hold.
#[derive(Clone, Debug, PartialEq)]
#[expect(clippy::exhaustive_structs, reason = "a device says all that frames depend on")]
pub struct DeviceInfo {
    /// The device's name, as its driver says it.
    pub name: String,
    /// The driver's name and version.
    pub driver: String,
    /// What sort of device it is.
    pub kind: DeviceKind,
    /// Most bytes of a buffer that a shader sees at once: a multiple of 4.
    pub max_binding_bytes: u64,
    /// Most bytes of a buffer.
    pub max_buffer_bytes: u64,
    /// Bytes that a slice's offset must be a multiple of; a power of two, at most 256.
    pub offset_alignment: u64,
    /// Bytes of memory that buffers can be in, if the interface reports them.
    pub memory_bytes: Option<u64>,
    /// Whether passes can be timed.
    pub has_timestamps: bool,
}

/// What sort of device it is, from the fastest to the slowest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[expect(clippy::exhaustive_enums, reason = "who chooses a device has to know each")]
pub enum DeviceKind {
    /// A graphics card with memory of its own.
    Discrete,
    /// A part of the processor.
    Integrated,
    /// A share of a graphics card.
    Virtual,
    /// The driver does not tell.
    Other,
    /// A program that plays a graphics card; slower than the CPU backend.
    Software,
}

/// Names a buffer of a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[expect(clippy::exhaustive_structs, reason = "a number names it")]
pub struct BufferId(pub u32);

/// Names submitted work.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[expect(clippy::exhaustive_structs, reason = "a number names it")]
pub struct WorkId(pub u64);

/// Part of a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[expect(clippy::exhaustive_structs, reason = "a device takes all of it or draws wrongly")]
pub struct Slice {
    /// Which buffer.
    pub buffer: BufferId,
    /// Its first byte, a multiple of the device's alignment if it is bound and of 4 otherwise.
    pub offset: u64,
    /// Bytes, a multiple of 4, above 0.
    pub size: u64,
}

/// What a device does at a time.
#[derive(Clone, Debug, Default)]
#[expect(clippy::exhaustive_structs, reason = "a device takes all of it or draws wrongly")]
pub struct Work<'a> {
    /// Bytes that go to buffers first. Of any length; taken before `submit` returns.
    pub writes: Vec<Write<'a>>,
    /// Then the shaders that run. Often the same list as the last time, so that what was prepared for
    /// it can be used again.
    pub passes: Cow<'a, [Pass]>,
    /// Then what is read back.
    pub reads: Vec<Slice>,
}

/// Bytes for a buffer.
#[derive(Clone, Debug)]
#[expect(clippy::exhaustive_structs, reason = "a device takes all of it or draws wrongly")]
pub struct Write<'a> {
    /// Which buffer.
    pub buffer: BufferId,
    /// Where they go: a multiple of 4.
    pub offset: u64,
    /// As many as a multiple of 4.
    pub bytes: Cow<'a, [u8]>,
}

/// One run of a shader.
#[derive(Clone, Debug, PartialEq)]
#[expect(clippy::exhaustive_structs, reason = "a device takes all of it or draws wrongly")]
pub struct Pass {
    /// The shader.
    pub shader: &'static Shader,
    /// The stage of the frame that it belongs to, for timing and for debuggers. Passes of one stage follow
    /// on each other.
    pub stage: &'static str,
    /// What it sees, one slice for each of its bindings. A buffer that it may write (by
    /// `BindingKind::Written`) is bound once, and not in another way besides. Uniforms take up to 64 KiB.
    pub bindings: Vec<Slice>,
    /// Workgroups along x, y, z; each from 1 to 65535.
    pub groups: [u32; 3],
}

/// What work has brought.
#[derive(Clone, Debug, Default, PartialEq)]
#[expect(clippy::exhaustive_structs, reason = "frames need all of it of a device")]
pub struct Done {
    /// The words of each slice that was read, so that pixels can be taken as they are.
    pub reads: Vec<Vec<u32>>,
    /// How long each stage of the passes took on the device, in milliseconds, in their order; empty
    /// if the device has no timestamps.
    pub stage_ms: Vec<(&'static str, f64)>,
}

/// Why a device failed.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum DeviceError {
    /// There is no memory for that many bytes. The device can be used on.
    #[error("there is no memory for {bytes} bytes")]
    OutOfMemory {
        /// Bytes asked for.
        bytes: u64,
    },
    /// It takes no such thing of its owner's. The device can be used on.
    #[error("it refuses what it was given: {reason}")]
    Refused {
        /// What the driver says.
        reason: String,
    },
    /// The device is gone, or its driver failed. It cannot be used again.
    #[error("the device was lost: {reason}")]
    Lost {
        /// What the driver says.
        reason: String,
    },
}

/// How a device is opened.
#[derive(Clone, Copy, Debug, Default)]
#[non_exhaustive]
pub struct OpenOptions {
    /// Switches the interface's validation layers on, if they are installed; called with every message
    /// of theirs, from any thread.
    pub validation: Option<fn(&str)>,
}

impl OpenOptions {
    /// The same with validation whose messages that function gets.
    #[must_use]
    pub fn validation(self, message: fn(&str)) -> Self {
        Self { validation: Some(message) }
    }
}

/// Why a graphics interface has no device to offer.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{reason}")]
#[expect(clippy::exhaustive_structs, reason = "a reason is a sentence")]
pub struct Unavailable {
    /// One sentence, lower case, without a full stop.
    pub reason: String,
}

impl<D: Device + ?Sized> Device for Box<D> {
    fn info(&self) -> &DeviceInfo {
        (**self).info()
    }

    fn create_buffer(&mut self, label: &'static str, size: u64) -> Result<BufferId, DeviceError> {
        (**self).create_buffer(label, size)
    }

    fn destroy_buffer(&mut self, buffer: BufferId) {
        (**self).destroy_buffer(buffer);
    }

    fn submit(&mut self, work: &Work<'_>) -> Result<WorkId, DeviceError> {
        (**self).submit(work)
    }

    fn poll(&mut self, work: WorkId) -> Result<Poll<Done>, DeviceError> {
        (**self).poll(work)
    }

    fn wait(&mut self, work: WorkId, at_most: Duration) {
        (**self).wait(work, at_most);
    }

    fn wake_when_done(&mut self, work: WorkId, waker: &Waker) {
        (**self).wake_when_done(work, waker);
    }
}
