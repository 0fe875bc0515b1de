//! Executes slabsplat's GPU frames on wgpu: Vulkan natively, and what else wgpu is built with.
//!
//! # How work is executed
//!
//! 1. What the work needs is made, or taken from what earlier work left: pipelines, bind groups, a buffer
//!    to read back through, queries for the time. If there is no memory for it, nothing has begun yet.
//! 2. The writes go to wgpu's queue, long ones in pieces.
//! 3. The passes are recorded, one compute pass a stage with a timestamp at either end; then the copies
//!    to the read-back buffer. All of it is submitted as one command buffer.
//! 4. The read-back buffer is mapped. [`poll`](Device::poll) looks whether wgpu has called back, copies the
//!    bytes out, and puts the buffer and the queries where the next work finds them.
//!
//! So frames that resemble each other make no new objects of wgpu's, but for its own staging memory.
//! No call waits for the work that it is about, except that writes of many megabytes wait until their first
//! pieces are copied. Nothing panics if the device fails: wgpu's errors are noted where they arise, and
//! every later call returns [`DeviceError::Lost`].
//!
//! # On a device of the caller's
//!
//! [`on`] takes a device and a queue that the caller has, [`device_descriptor`] says how they are asked for,
//! and a [`TextureTarget`] is a texture of the caller's that frames are left in: drawn there by the device,
//! in the order of the queue, so that whatever the caller submits after a frame sees it. Nothing is read back
//! but the counts. A picture that the CPU has made is [written](TextureTarget::write) there.
//!
//! # Reading order
//!
//! `open`, `needs`, `ready`; `gpu`, `faults`; `buffers`, `pipelines`, `bind_groups`; `submission`, `upload`,
//! `encode`; `timer`, `read_back`, `in_flight`; `target`, `present`.
//!
//! ```
//! use slabsplat_gpu::{Device, OpenOptions};
//!
//! match slabsplat_wgpu::open(&OpenOptions::default()) {
//!     Ok(mut device) => {
//!         println!("{:?}", device.info());
//!         let buffer = device.create_buffer("example", 1024)?;
//!         device.destroy_buffer(buffer);
//!     }
//!     Err(unavailable) => println!("no device: {unavailable}"),
//! }
//! # Ok::<(), slabsplat_gpu::DeviceError>(())
//! ```

mod needs;
mod open;
mod ready;

mod faults;
mod gpu;

mod bind_groups;
mod buffers;
mod pipelines;

mod encode;
mod submission;
mod upload;

mod in_flight;
mod read_back;
mod timer;

mod present;
mod target;

#[cfg(test)]
mod tests;

pub use needs::device_descriptor;
pub use open::{devices, on, open, open_async};
pub use target::{TargetError, TextureTarget};
/// The wgpu that devices and textures are of: a caller's must be of this version.
pub use wgpu;

use slabsplat_gpu::{BufferId, Device, DeviceError, DeviceInfo, Done, Work, WorkId};
use std::task::{Poll, Waker};
use std::time::Duration;

/// A device of wgpu's, opened here or by the caller.
///
/// # Panics
/// If the caller names a buffer or work that is not there: one that was destroyed or taken already, or
/// comes from another device.
#[derive(Debug)]
pub struct WgpuDevice {
    gpu: gpu::Gpu,
    buffers: buffers::Buffers,
    pipelines: pipelines::Pipelines,
    bind_groups: bind_groups::BindGroups,
    uploads: upload::Uploads,
    timers: timer::Timers,
    read_backs: read_back::ReadBacks,
    in_flight: in_flight::InFlight,
    presenter: present::Presenter,
}

/// How long an executor's thread is held up by a frame that it awaits.
const WAIT_BEFORE_WAKING: Duration = Duration::from_millis(5);

impl WgpuDevice {
    fn new(gpu: gpu::Gpu) -> Self {
        Self {
            gpu,
            buffers: buffers::Buffers::default(),
            pipelines: pipelines::Pipelines::default(),
            bind_groups: bind_groups::BindGroups::default(),
            uploads: upload::Uploads::default(),
            timers: timer::Timers::default(),
            read_backs: read_back::ReadBacks::default(),
            in_flight: in_flight::InFlight::default(),
            presenter: present::Presenter::default(),
        }
    }
}

impl Device for WgpuDevice {
    fn info(&self) -> &DeviceInfo {
        &self.gpu.info
    }

    fn create_buffer(&mut self, label: &'static str, size: u64) -> Result<BufferId, DeviceError> {
        self.gpu.look_around()?;
        self.buffers.create(&self.gpu, label, size)
    }

    fn destroy_buffer(&mut self, buffer: BufferId) {
        // A bind group keeps the memory of what it names.
        self.bind_groups.forget(buffer);
        self.buffers.destroy(buffer);
    }

    fn submit(&mut self, work: &Work<'_>) -> Result<WorkId, DeviceError> {
        self.gpu.look_around()?;
        self.execute(work)
    }

    fn poll(&mut self, work: WorkId) -> Result<Poll<Done>, DeviceError> {
        self.gpu.look_around()?;
        self.collect(work)
    }

    fn wait(&mut self, work: WorkId, at_most: Duration) {
        let submission = self.in_flight.submission(work);
        if let (Some(submission), Ok(())) = (submission, self.gpu.look_around()) {
            self.gpu.wait_at_most(submission, at_most);
        }
    }

    fn wake_when_done(&mut self, work: WorkId, waker: &Waker) {
        self.in_flight.wake_when_done(work, waker);
        // A browser calls back by itself, and lets nobody wait. Elsewhere wgpu calls back when it is asked.
        if cfg!(not(target_family = "wasm")) {
            self.wait(work, WAIT_BEFORE_WAKING);
            waker.wake_by_ref();
        }
    }
}
