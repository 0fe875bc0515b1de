//! A device that does what another does, counts what goes through it, and fails on demand.

use slabsplat_gpu::{BufferId, Device, DeviceError, DeviceInfo, Done, Work, WorkId};
use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::Poll;
use std::time::Duration;

/// What goes through a device, and what shall go wrong.
#[derive(Debug, Default)]
pub struct Orders {
    /// Bytes written since someone set this to 0.
    pub bytes_written: usize,
    /// Bytes asked for since someone set this to 0.
    pub bytes_read: u64,
    /// Works submitted since someone set this to 0.
    pub n_submitted: usize,
    /// After how many more buffers there is no memory for one; for one only.
    pub buffers_left: Option<usize>,
    /// After how many more works there is no memory for one; for one only.
    pub works_left: Option<usize>,
    /// Why the device is lost from now on.
    pub lost: Option<&'static str>,
}

/// A device under observation.
pub struct SpyDevice {
    inner: Box<dyn Device>,
    info: DeviceInfo,
    orders: Arc<Mutex<Orders>>,
}

impl fmt::Debug for SpyDevice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SpyDevice").field("info", &self.info).finish_non_exhaustive()
    }
}

impl SpyDevice {
    /// Passes everything on to `inner`, but for what `change` makes of its limits.
    pub fn new(inner: Box<dyn Device>, change: impl FnOnce(&mut DeviceInfo)) -> Self {
        let mut info = inner.info().clone();
        change(&mut info);
        Self { inner, info, orders: Arc::default() }
    }

    /// What to watch and to order, when the device has gone into a backend.
    pub fn orders(&self) -> Arc<Mutex<Orders>> {
        self.orders.clone()
    }

    fn now(&self) -> Result<MutexGuard<'_, Orders>, DeviceError> {
        let orders = locked(&self.orders);
        match orders.lost {
            Some(reason) => Err(DeviceError::Lost { reason: reason.to_owned() }),
            None => Ok(orders),
        }
    }
}

/// The orders, even if a test that held them has failed.
pub fn locked(orders: &Mutex<Orders>) -> MutexGuard<'_, Orders> {
    orders.lock().unwrap_or_else(PoisonError::into_inner)
}

/// One less is left, or there is no memory for what takes so many bytes.
fn take_one(left: &mut Option<usize>, bytes: u64) -> Result<(), DeviceError> {
    let was_last = *left == Some(0);
    *left = left.and_then(|left| left.checked_sub(1));
    if was_last { Err(DeviceError::OutOfMemory { bytes }) } else { Ok(()) }
}

impl Device for SpyDevice {
    fn info(&self) -> &DeviceInfo {
        &self.info
    }

    fn create_buffer(&mut self, label: &'static str, size: u64) -> Result<BufferId, DeviceError> {
        let mut orders = self.now()?;
        take_one(&mut orders.buffers_left, size)?;
        drop(orders);
        assert!(size <= self.info.max_buffer_bytes, "{label}: {size} bytes");
        self.inner.create_buffer(label, size)
    }

    fn destroy_buffer(&mut self, buffer: BufferId) {
        self.inner.destroy_buffer(buffer);
    }

    fn submit(&mut self, work: &Work<'_>) -> Result<WorkId, DeviceError> {
        let mut orders = self.now()?;
        let n_bytes = work.writes.iter().map(|write| write.bytes.len()).sum::<usize>();
        take_one(&mut orders.works_left, n_bytes as u64)?;
        orders.n_submitted += 1;
        orders.bytes_written += n_bytes;
        orders.bytes_read += work.reads.iter().map(|slice| slice.size).sum::<u64>();
        drop(orders);
        for slice in work.passes.iter().flat_map(|pass| &pass.bindings) {
            assert!(slice.size <= self.info.max_binding_bytes, "{slice:?} is too large to bind");
        }
        self.inner.submit(work)
    }

    fn poll(&mut self, work: WorkId) -> Result<Poll<Done>, DeviceError> {
        drop(self.now()?);
        self.inner.poll(work)
    }

    fn wait(&mut self, work: WorkId, at_most: Duration) {
        self.inner.wait(work, at_most);
    }
}
