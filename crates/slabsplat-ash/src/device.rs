//! The device as its callers see it, and what happens when work is done.

use crate::buffers::Buffers;
use crate::check;
use crate::choose::candidates;
use crate::commands::Commands;
use crate::context::Context;
use crate::error::Fault;
use crate::in_flight::InFlight;
use crate::instance::Instance;
use crate::memory::Memory;
use crate::pipelines::Pipelines;
use crate::pool::{Pool, PoolDesc};
use crate::readback;
use crate::recordings::Recordings;
use crate::sets::Sets;
use crate::submit::{MAX_IN_FLIGHT, MAX_STAGING_BYTES};
use crate::timeline::Timeline;
use ash::vk;
use gpu_allocator::MemoryLocation;
use slabsplat_gpu::{
    BufferId, Device, DeviceError, DeviceInfo, Done, OpenOptions, Unavailable, Work, WorkId,
};
use std::collections::{HashMap, VecDeque};
use std::fmt;
use std::sync::Arc;
use std::task::Poll;
use std::time::Duration;

/// Recordings beyond those that are in flight: of other lists of passes that may come back.
const N_SPARE_RECORDINGS: usize = 4;

const STAGING: PoolDesc = PoolDesc {
    label: "staging",
    usage: vk::BufferUsageFlags::TRANSFER_SRC,
    location: MemoryLocation::CpuToGpu,
    max_idle_bytes: MAX_STAGING_BYTES,
};
const READBACK: PoolDesc = PoolDesc {
    label: "readback",
    usage: vk::BufferUsageFlags::TRANSFER_DST,
    location: MemoryLocation::GpuToCpu,
    max_idle_bytes: 128 << 20,
};

/// A device that is driven through Vulkan.
pub struct AshDevice {
    /// Why it was lost, if it was.
    lost: Option<String>,
    pub(crate) in_flight: VecDeque<InFlight>,
    /// What work has brought that nobody took so far, by number.
    finished: HashMap<u64, Done>,
    pub(crate) spare_lists: Vec<Commands>,
    pub(crate) recordings: Recordings,
    pub(crate) sets: Sets,
    pub(crate) pipelines: Pipelines,
    pub(crate) staging: Pool,
    pub(crate) readback: Pool,
    pub(crate) buffers: Buffers,
    pub(crate) timeline: Timeline,
    pub(crate) context: Arc<Context>,
}

impl fmt::Debug for AshDevice {
    /// What it is, and nothing of what it holds.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("AshDevice").field("info", self.info()).finish_non_exhaustive()
    }
}

impl AshDevice {
    /// Opens the best device.
    pub(crate) fn open(options: &OpenOptions) -> Result<Self, Unavailable> {
        let instance = Instance::new(options.validation)?;
        let best = candidates(&instance)?.swap_remove(0);
        let name = best.info.name.clone();
        let context = Arc::new(Context::new(instance, best)?);
        Self::with(context).map_err(|fault| {
            let reason = match fault {
                Fault::OutOfMemory => "there is no memory".to_owned(),
                Fault::Driver(reason) => reason,
            };
            Unavailable { reason: format!("{name} could not be opened: {reason}") }
        })
    }

    fn with(context: Arc<Context>) -> Result<Self, Fault> {
        let memory = Memory::new(&context)?;
        Ok(Self {
            lost: None,
            in_flight: VecDeque::new(),
            finished: HashMap::new(),
            spare_lists: Vec::new(),
            recordings: Recordings::new(&context, MAX_IN_FLIGHT + N_SPARE_RECORDINGS),
            sets: Sets::new(&context),
            pipelines: Pipelines::new(&context)?,
            staging: Pool::new(&memory, STAGING),
            readback: Pool::new(&memory, READBACK),
            buffers: Buffers::new(&memory),
            timeline: Timeline::new(&context)?,
            context,
        })
    }

    /// Collects what is done by now, without waiting.
    pub(crate) fn retire(&mut self) -> Result<u64, Fault> {
        let done = self.timeline.done()?;
        while self.in_flight.front().is_some_and(|first| first.number <= done)
            && let Some(in_flight) = self.in_flight.pop_front()
        {
            self.finish(in_flight)?;
        }
        while let Some((id, buffer)) = self.buffers.next_gone(done) {
            // No recording has sets of it any more: all that were in flight are done.
            self.sets.forget(id);
            drop(buffer);
        }
        Ok(done)
    }

    /// Takes what a submission has brought, and what it held.
    fn finish(&mut self, in_flight: InFlight) -> Result<(), Fault> {
        let InFlight { number, batch } = in_flight;
        let mut done = Done::default();
        if let Some(recording) = batch.recording {
            done.stage_ms = self.recordings.note_done(recording)?;
        }
        if let Some(readback) = batch.readback {
            done.reads = readback.words();
            self.readback.give_back(readback.buffer);
        }
        if let Some(staging) = batch.staging {
            self.staging.give_back(staging);
        }
        self.spare_lists.extend(batch.copies_in.into_iter().chain(batch.copies_out));
        // Most uploads bring nothing, and nobody asks for it.
        if done != Done::default() {
            self.finished.insert(number, done);
        }
        Ok(())
    }

    fn create(&mut self, label: &str, size: u64) -> Result<BufferId, Fault> {
        match self.buffers.create(label, size) {
            Err(Fault::OutOfMemory) => {
                self.make_room()?;
                self.buffers.create(label, size)
            }
            result => result,
        }
    }

    fn begin_or_make_room(&mut self, work: &Work<'_>) -> Result<WorkId, Fault> {
        match self.begin(work) {
            // Then nothing of it has begun.
            Err(Fault::OutOfMemory) => {
                self.make_room()?;
                self.begin(work)
            }
            result => result,
        }
    }

    /// Frees all memory that is not needed: buffers that were given back, after the work that uses them,
    /// and idle ones of our own.
    fn make_room(&mut self) -> Result<(), Fault> {
        if let Some(number) = self.buffers.last_leaves_after() {
            self.timeline.wait(number)?;
        }
        self.retire()?;
        self.staging.shrink_to(0);
        self.readback.shrink_to(0);
        Ok(())
    }

    fn check_is_there(&self) -> Result<(), DeviceError> {
        match &self.lost {
            Some(reason) => Err(DeviceError::Lost { reason: reason.clone() }),
            None => Ok(()),
        }
    }

    /// Reports a fault to the caller; after any but a want of memory the device is not used again.
    fn reported<T>(&mut self, result: Result<T, Fault>, n_bytes: u64) -> Result<T, DeviceError> {
        result.map_err(|fault| {
            if let Fault::Driver(reason) = &fault {
                self.lost = Some(reason.clone());
            }
            fault.asking_for(n_bytes)
        })
    }
}

impl Device for AshDevice {
    fn info(&self) -> &DeviceInfo {
        &self.context.candidate.info
    }

    fn create_buffer(&mut self, label: &'static str, size: u64) -> Result<BufferId, DeviceError> {
        self.check_is_there()?;
        check::size(label, size);
        if self.info().max_buffer_bytes < size {
            return Err(DeviceError::OutOfMemory { bytes: size });
        }
        let created = self.create(label, size);
        self.reported(created, size)
    }

    fn destroy_buffer(&mut self, buffer: BufferId) {
        self.recordings.forget(buffer);
        self.buffers.destroy(buffer, self.timeline.last());
    }

    fn submit(&mut self, work: &Work<'_>) -> Result<WorkId, DeviceError> {
        self.check_is_there()?;
        let written: u64 = work.writes.iter().map(|write| write.bytes.len() as u64).sum();
        let begun = self.begin_or_make_room(work);
        self.reported(begun, written + readback::n_bytes(&work.reads))
    }

    /// Work whose results were taken already, or that brings none, is ready with nothing.
    fn poll(&mut self, work: WorkId) -> Result<Poll<Done>, DeviceError> {
        self.check_is_there()?;
        assert!(work.0 <= self.timeline.last(), "usage: {work:?} was not submitted");
        let retired = self.retire();
        let done = self.reported(retired, 0)?;
        if done < work.0 {
            return Ok(Poll::Pending);
        }
        Ok(Poll::Ready(self.finished.remove(&work.0).unwrap_or_default()))
    }

    fn wait(&mut self, work: WorkId, at_most: Duration) {
        if self.check_is_there().is_ok() && work.0 <= self.timeline.last() {
            let waited = self.timeline.wait_at_most(work.0, at_most);
            // What went wrong is noted, and every later call returns it.
            let _ = self.reported(waited, 0);
        }
    }
}

impl Drop for AshDevice {
    fn drop(&mut self) {
        // The parts go afterwards, and all that the device was doing with them is over.
        self.context.wait_idle();
    }
}
