//! Work that was submitted and not taken yet.

use crate::gpu::Gpu;
use crate::read_back::{ReadBack, Signal};
use crate::timer::Timer;
use slabsplat_gpu::WorkId;
use std::collections::{HashMap, VecDeque};
use std::task::Waker;

/// Most submissions that are not executed yet. A caller who is further ahead waits, or else the staging
/// memory of its writes would have no bound.
const MOST_RUNNING: usize = 4;

/// Work in flight.
#[derive(Debug, Default)]
pub(crate) struct InFlight {
    by_id: HashMap<WorkId, Flight>,
    n_submitted: u64,
    running: VecDeque<wgpu::SubmissionIndex>,
}

/// What is needed to finish work.
#[derive(Debug)]
pub(crate) struct Flight {
    pub(crate) submission: wgpu::SubmissionIndex,
    pub(crate) signal: Signal,
    pub(crate) read_back: Option<ReadBack>,
    pub(crate) n_read_bytes: u64,
    pub(crate) read_sizes: Vec<u64>,
    pub(crate) timer: Option<Timer>,
    pub(crate) stages: Vec<&'static str>,
}

impl InFlight {
    /// Waits for the oldest submission if there are too many.
    pub(crate) fn make_room(&mut self, gpu: &Gpu) {
        if self.running.len() == MOST_RUNNING
            && let Some(oldest) = self.running.pop_front()
        {
            gpu.wait(oldest);
        }
    }

    pub(crate) fn add(&mut self, flight: Flight) -> WorkId {
        let id = WorkId(self.n_submitted);
        self.n_submitted += 1;
        self.running.push_back(flight.submission.clone());
        self.by_id.insert(id, flight);
        id
    }

    /// The submission that work is part of, unless it was taken.
    pub(crate) fn submission(&self, id: WorkId) -> Option<wgpu::SubmissionIndex> {
        self.by_id.get(&id).map(|flight| flight.submission.clone())
    }

    pub(crate) fn is_pending(&self, id: WorkId) -> bool {
        self.by_id.get(&id).is_some_and(|flight| flight.signal.is_pending())
    }

    /// Wakes when work is done, or now if it is, or is none.
    pub(crate) fn wake_when_done(&self, id: WorkId, waker: &Waker) {
        match self.by_id.get(&id) {
            Some(flight) => flight.signal.wake_when_set(waker),
            None => waker.wake_by_ref(),
        }
    }

    pub(crate) fn take(&mut self, id: WorkId) -> Flight {
        let flight = self.by_id.remove(&id);
        flight.unwrap_or_else(|| panic!("{id:?} is not work of this device, or was taken already"))
    }
}
