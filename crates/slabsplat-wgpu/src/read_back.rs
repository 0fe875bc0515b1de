//! Buffers that the device copies to and the program reads from. They are used again when they have
//! been read.

use crate::buffers;
use crate::gpu::Gpu;
use slabsplat_gpu::DeviceError;
use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::Waker;

/// Sizes are rounded up to this, so that one buffer serves frames of about one size.
const GRAIN_BYTES: u64 = 64 << 10;

/// Buffers that are retained: as many as there can be works in flight, and some that wait to be taken.
const MOST_FREE: usize = 8;

/// Read-back buffers that no work uses.
#[derive(Debug, Default)]
pub(crate) struct ReadBacks {
    free: Vec<ReadBack>,
}

/// A buffer to read back through.
#[derive(Debug)]
pub(crate) struct ReadBack {
    pub(crate) buffer: wgpu::Buffer,
}

impl ReadBacks {
    /// A buffer for so many bytes, if there are any.
    pub(crate) fn take(
        &mut self,
        gpu: &Gpu,
        n_bytes: u64,
    ) -> Result<Option<ReadBack>, DeviceError> {
        if n_bytes == 0 {
            return Ok(None);
        }
        let size =
            n_bytes.next_multiple_of(GRAIN_BYTES).min(gpu.info.max_buffer_bytes.max(n_bytes));
        // Not one that is much larger: mapping may cost by size, and large ones are wanted elsewhere.
        let fits = |free: &ReadBack| (size..=4 * size).contains(&free.buffer.size());
        if let Some(found) = self.free.iter().position(fits) {
            return Ok(Some(self.free.swap_remove(found)));
        }
        let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let buffer = buffers::make(gpu, "read back", size, usage)?;
        Ok(Some(ReadBack { buffer }))
    }

    /// Takes back a buffer that has been read.
    pub(crate) fn give_back(&mut self, gpu: &Gpu, read_back: ReadBack) {
        gpu.noting(|| read_back.buffer.unmap());
        if self.free.len() == MOST_FREE {
            // The oldest goes: it may be of a size that nobody asks for any more.
            self.free.remove(0);
        }
        self.free.push(read_back);
    }

    #[cfg(test)]
    pub(crate) fn n_free(&self) -> usize {
        self.free.len()
    }
}

impl ReadBack {
    /// Signals when the submissions so far are executed and the bytes are here.
    pub(crate) fn map(&self, n_bytes: u64, signal: &Signal) {
        let signal = signal.clone();
        let slice = self.buffer.slice(..n_bytes);
        slice.map_async(wgpu::MapMode::Read, move |mapped| signal.set(mapped.is_ok()));
    }

    /// The bytes, once the signal is there; none if it reports a failure.
    pub(crate) fn bytes(&self, n_bytes: u64, signal: &Signal) -> Option<wgpu::BufferView> {
        if !signal.is_good() {
            return None;
        }
        self.buffer.slice(..n_bytes).get_mapped_range().ok()
    }
}

/// Whether wgpu has called back: it may do so on any thread, whenever it is polled, or in a browser from the
/// page's own loop.
#[derive(Clone, Debug, Default)]
pub(crate) struct Signal(Arc<State>);

#[derive(Debug, Default)]
struct State {
    is_set: AtomicU8,
    /// Who is to be woken then.
    waker: Mutex<Option<Waker>>,
}

const PENDING: u8 = 0;
const GOOD: u8 = 1;
const BAD: u8 = 2;

impl Signal {
    /// Signals when the submissions so far are executed.
    pub(crate) fn when_done(&self, queue: &wgpu::Queue) {
        let signal = self.clone();
        queue.on_submitted_work_done(move || signal.set(true));
    }

    pub(crate) fn is_pending(&self) -> bool {
        self.0.is_set.load(Ordering::Acquire) == PENDING
    }

    /// Wakes when it is set, or now if it is. The last who asks is the one who is woken.
    pub(crate) fn wake_when_set(&self, waker: &Waker) {
        let mut waiting = self.waiting();
        if self.is_pending() {
            *waiting = Some(waker.clone());
        } else {
            drop(waiting);
            waker.wake_by_ref();
        }
    }

    fn is_good(&self) -> bool {
        self.0.is_set.load(Ordering::Acquire) == GOOD
    }

    fn set(&self, is_good: bool) {
        self.0.is_set.store(if is_good { GOOD } else { BAD }, Ordering::Release);
        let waker = self.waiting().take();
        if let Some(waker) = waker {
            waker.wake();
        }
    }

    fn waiting(&self) -> MutexGuard<'_, Option<Waker>> {
        self.0.waker.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicUsize;
    use std::task::Wake;

    #[derive(Default)]
    struct Count(AtomicUsize);

    impl Wake for Count {
        fn wake(self: Arc<Self>) {
            self.0.fetch_add(1, Ordering::Relaxed);
        }
    }

    #[test]
    fn signal_wakes_once_it_is_set() {
        let (signal, count) = (Signal::default(), Arc::new(Count::default()));
        let waker = Waker::from(count.clone());
        let n_woken = || count.0.load(Ordering::Relaxed);
        signal.wake_when_set(&waker);
        assert_eq!((signal.is_pending(), n_woken()), (true, 0));
        signal.clone().set(true);
        assert_eq!((signal.is_good(), n_woken()), (true, 1));
        signal.wake_when_set(&waker);
        assert_eq!(n_woken(), 2, "it is set already");
    }
}
