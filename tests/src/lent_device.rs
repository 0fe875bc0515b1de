//! Devices that many backends of tests have, one after the other: to open one and to make its pipelines takes
//! longer than most frames of tests.

use slabsplat_gpu::{BufferId, Device, DeviceError, DeviceInfo, Done, Work, WorkId};
use std::collections::BTreeSet;
use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Poll, Waker};
use std::time::Duration;

/// Devices of one graphics interface that nobody has at the moment.
#[derive(Default)]
pub(crate) struct Lender {
    devices: Arc<Mutex<Vec<Box<dyn Device>>>>,
}

/// Goes back when it is dropped, without the buffers and the work of whoever had it. One that has failed, or
/// whose test has, is closed instead.
pub(crate) struct LentDevice {
    /// There until it is dropped.
    inner: Option<Box<dyn Device>>,
    devices: Arc<Mutex<Vec<Box<dyn Device>>>>,
    buffers: BTreeSet<BufferId>,
    under_way: BTreeSet<WorkId>,
    has_failed: bool,
}

impl Lender {
    /// One that is here, or a new one.
    pub(crate) fn lend(&self, open: impl FnOnce() -> Box<dyn Device>) -> LentDevice {
        let here = locked(&self.devices).pop();
        LentDevice {
            inner: Some(here.unwrap_or_else(open)),
            devices: self.devices.clone(),
            buffers: BTreeSet::new(),
            under_way: BTreeSet::new(),
            has_failed: false,
        }
    }
}

impl fmt::Debug for Lender {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Lender").field("n_devices", &locked(&self.devices).len()).finish()
    }
}

fn locked(devices: &Mutex<Vec<Box<dyn Device>>>) -> MutexGuard<'_, Vec<Box<dyn Device>>> {
    devices.lock().unwrap_or_else(PoisonError::into_inner)
}

impl LentDevice {
    fn inner(&mut self) -> &mut dyn Device {
        &mut **self.inner.as_mut().expect("it is there until it is dropped")
    }

    fn noted<T>(&mut self, result: Result<T, DeviceError>) -> Result<T, DeviceError> {
        self.has_failed |= result.is_err();
        result
    }

    /// Waits for the work that nobody took, and gives buffers back.
    fn clear(&mut self) -> Result<(), DeviceError> {
        while let Some(&work) = self.under_way.first() {
            if self.poll(work)?.is_pending() {
                self.wait(work, Duration::from_millis(100));
            }
        }
        for buffer in std::mem::take(&mut self.buffers) {
            self.inner().destroy_buffer(buffer);
        }
        Ok(())
    }
}

impl Device for LentDevice {
    fn info(&self) -> &DeviceInfo {
        self.inner.as_ref().expect("it is there until it is dropped").info()
    }

    fn create_buffer(&mut self, label: &'static str, size: u64) -> Result<BufferId, DeviceError> {
        let created = self.inner().create_buffer(label, size);
        let buffer = self.noted(created)?;
        self.buffers.insert(buffer);
        Ok(buffer)
    }

    fn destroy_buffer(&mut self, buffer: BufferId) {
        self.buffers.remove(&buffer);
        self.inner().destroy_buffer(buffer);
    }

    fn submit(&mut self, work: &Work<'_>) -> Result<WorkId, DeviceError> {
        let submitted = self.inner().submit(work);
        let work = self.noted(submitted)?;
        self.under_way.insert(work);
        Ok(work)
    }

    fn poll(&mut self, work: WorkId) -> Result<Poll<Done>, DeviceError> {
        let polled = self.inner().poll(work);
        let polled = self.noted(polled)?;
        if polled.is_ready() {
            self.under_way.remove(&work);
        }
        Ok(polled)
    }

    fn wait(&mut self, work: WorkId, at_most: Duration) {
        self.inner().wait(work, at_most);
    }

    fn wake_when_done(&mut self, work: WorkId, waker: &Waker) {
        self.inner().wake_when_done(work, waker);
    }
}

impl Drop for LentDevice {
    fn drop(&mut self) {
        let is_good = !self.has_failed && !std::thread::panicking() && self.clear().is_ok();
        if let Some(inner) = self.inner.take().filter(|_| is_good) {
            locked(&self.devices).push(inner);
        }
    }
}
