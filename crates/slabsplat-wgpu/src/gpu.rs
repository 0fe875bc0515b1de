//! The open device: wgpu's handles, what went wrong with them, and how far it is.

use crate::faults::Faults;
use slabsplat_gpu::{DeviceError, DeviceInfo};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::Duration;

/// A device of wgpu, its queue, and what is known of them.
#[derive(Debug)]
pub(crate) struct Gpu {
    pub(crate) info: DeviceInfo,
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    pub(crate) faults: Arc<Faults>,
}

impl Gpu {
    pub(crate) fn new(
        device: wgpu::Device,
        queue: wgpu::Queue,
        info: DeviceInfo,
        on_message: Option<fn(&str)>,
    ) -> Self {
        let faults = Faults::of(&device, on_message);
        Self { info, device, queue, faults }
    }

    /// Lets wgpu call back for whatever is finished, without waiting, and returns whether the device is
    /// still there.
    pub(crate) fn look_around(&self) -> Result<(), DeviceError> {
        // A lost device is left alone: wgpu would only fail again.
        self.faults.check()?;
        self.poll(wgpu::PollType::Poll);
        self.faults.check()
    }

    /// Waits until the submission is executed. Browsers do not let anyone wait; there it returns at once.
    pub(crate) fn wait(&self, submission: wgpu::SubmissionIndex) {
        self.poll(wgpu::PollType::Wait { submission_index: Some(submission), timeout: None });
    }

    /// The same, but no longer than that.
    pub(crate) fn wait_at_most(&self, submission: wgpu::SubmissionIndex, at_most: Duration) {
        let timeout = Some(at_most);
        self.poll(wgpu::PollType::Wait { submission_index: Some(submission), timeout });
    }

    fn poll(&self, how: wgpu::PollType) {
        // If the driver loses the device, wgpu 30 first calls our callback and then panics, holding no lock.
        let polled = catch_unwind(AssertUnwindSafe(|| self.device.poll(how)));
        // The only errors are that time is up and that a submission was none, and then wgpu has reported why.
        if polled.is_err() {
            self.faults.lose("wgpu panicked when asked what is done");
        }
    }
}
