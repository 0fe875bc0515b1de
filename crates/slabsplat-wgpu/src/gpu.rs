//! The device: wgpu's handles, what went wrong with them, and how far it is.

use crate::faults::Faults;
use slabsplat_gpu::{DeviceError, DeviceInfo};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::time::Duration;

/// A device of wgpu, its queue, and what is known of them.
#[derive(Debug)]
pub(crate) struct Gpu {
    pub(crate) info: DeviceInfo,
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    pub(crate) faults: Arc<Faults>,
    /// Whether a handler of ours hears of all errors.
    is_ours: bool,
}

impl Gpu {
    /// A device that nobody else uses.
    pub(crate) fn of_our_own(
        device: wgpu::Device,
        queue: wgpu::Queue,
        info: DeviceInfo,
        on_message: Option<fn(&str)>,
    ) -> Self {
        let faults = Faults::of(&device, on_message);
        Self { info, device, queue, faults, is_ours: true }
    }

    /// A device whose handlers are the caller's.
    pub(crate) fn of_a_caller(device: wgpu::Device, queue: wgpu::Queue, info: DeviceInfo) -> Self {
        Self { info, device, queue, faults: Arc::default(), is_ours: false }
    }

    /// Calls wgpu, and notes what it reports of that.
    pub(crate) fn noting<T>(&self, calls: impl FnOnce() -> T) -> T {
        if self.is_ours {
            return calls();
        }
        let (value, errors) = self.faults.scoped(&self.device, calls);
        errors.iter().for_each(|error| self.faults.note(error, None));
        value
    }

    /// Calls wgpu with something of the caller's, which it may refuse without anything else being wrong.
    pub(crate) fn trying<T>(&self, calls: impl FnOnce() -> T) -> Result<T, DeviceError> {
        let (value, errors) = self.faults.scoped(&self.device, calls);
        match errors.first() {
            None => Ok(value),
            Some(error) => Err(DeviceError::Refused { reason: one_line(&error.to_string()) }),
        }
    }

    /// Lets wgpu call back for whatever is finished, without waiting, and returns whether the device is
    /// still there.
    pub(crate) fn look_around(&self) -> Result<(), DeviceError> {
        // A lost device is left alone: wgpu would only fail again.
        self.faults.check()?;
        self.faults.note_late();
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
        let Err(panic) = polled else { return };
        let message = panic.downcast_ref::<String>().map_or("", String::as_str);
        if message.starts_with(POLL_FAILED) {
            self.faults.lose(&one_line(message));
        } else {
            // A callback of the caller's panicked, who shall know.
            resume_unwind(panic);
        }
    }
}

/// How wgpu 30 begins, when it panics about a device that it cannot poll.
const POLL_FAILED: &str = "Error in Device::poll";

fn one_line(message: &str) -> String {
    message.split_whitespace().collect::<Vec<_>>().join(" ")
}
