//! How work becomes submissions: one as a rule, more if it writes more than a piece of staging memory.

use crate::check;
use crate::commands::{Barrier, Commands};
use crate::device::AshDevice;
use crate::error::Fault;
use crate::in_flight::{Batch, InFlight};
use crate::memory::Buffer;
use crate::pool::size_class;
use crate::readback::{self, Readback};
use crate::recordings::{RecordingIdx, Sources};
use crate::uploads::{self, Chunk, pieces};
use ash::vk;
use slabsplat_gpu::{Pass, Slice, Work, WorkId};

/// Submissions that the device has at most; a further one waits for the oldest.
pub(crate) const MAX_IN_FLIGHT: usize = 8;
/// Bytes that go to the device in one submission.
pub(crate) const PIECE_BYTES: u64 = 64 << 20;
/// Host memory for bytes on their way: two pieces, so that one is filled while one is copied.
pub(crate) const MAX_STAGING_BYTES: u64 = 2 * PIECE_BYTES;

impl AshDevice {
    /// Begins work. If memory runs out, nothing of it has begun.
    pub(crate) fn begin(&mut self, work: &Work<'_>) -> Result<WorkId, Fault> {
        self.check(work);
        self.retire()?;
        self.limit_in_flight()?;
        // What asks for memory comes first.
        let recording = self.recording(&work.passes)?;
        let readback = self.readback(&work.reads)?;
        let mut pieces = pieces(&work.writes, PIECE_BYTES as usize);
        let last = pieces.pop().unwrap_or_default();
        if !pieces.is_empty() {
            self.reserve_staging()?;
        }
        for (nth, piece) in pieces.iter().enumerate() {
            let launched = self.launch(Batch::default(), piece, PIECE_BYTES);
            if let Err(fault) = launched {
                return Err(if nth == 0 { fault } else { fault.halfway() });
            }
        }
        let batch = Batch { recording, readback, ..Batch::default() };
        if pieces.is_empty() {
            return Ok(WorkId(self.launch(batch, &last, uploads::n_bytes(&last))?));
        }
        // Staging memory for whole pieces is there; another size might not be.
        Ok(WorkId(self.launch(batch, &last, PIECE_BYTES).map_err(Fault::halfway)?))
    }

    /// Passes are checked when they are recorded.
    fn check(&self, work: &Work<'_>) {
        for write in &work.writes {
            check::write(write, self.buffers.get(write.buffer));
        }
        for slice in &work.reads {
            check::read(slice, self.buffers.get(slice.buffer));
        }
    }

    fn recording(&mut self, passes: &[Pass]) -> Result<Option<RecordingIdx>, Fault> {
        if passes.is_empty() {
            return Ok(None);
        }
        let sources = Sources {
            buffers: &self.buffers,
            pipelines: &mut self.pipelines,
            sets: &mut self.sets,
        };
        self.recordings.get(passes, sources).map(Some)
    }

    fn readback(&mut self, reads: &[Slice]) -> Result<Option<Readback>, Fault> {
        if reads.is_empty() {
            return Ok(None);
        }
        let buffer = self.readback.take(readback::n_bytes(reads))?;
        Ok(Some(Readback::new(buffer, reads)))
    }

    /// One submission: zeros, bytes, then what the batch has already.
    fn launch(
        &mut self,
        mut batch: Batch,
        chunks: &[Chunk<'_>],
        staging_bytes: u64,
    ) -> Result<u64, Fault> {
        self.limit_in_flight()?;
        if !chunks.is_empty() {
            batch.staging = Some(self.staging_buffer(staging_bytes)?);
        }
        if !chunks.is_empty() || 0 < self.buffers.uncleared().len() {
            batch.copies_in = Some(self.copies_in(&mut batch, chunks)?);
        }
        if let Some(readback) = &batch.readback {
            batch.copies_out = Some(self.copies_out(readback)?);
        }
        let number = self.timeline.submit(&batch.lists(&self.recordings))?;
        self.buffers.note_cleared();
        if let Some(recording) = batch.recording {
            self.recordings.note_submitted(recording);
        }
        self.in_flight.push_back(InFlight { number, batch });
        Ok(number)
    }

    fn copies_in(&mut self, batch: &mut Batch, chunks: &[Chunk<'_>]) -> Result<Commands, Fault> {
        let mut commands = self.begun_list()?;
        commands.barrier(Barrier::BEFORE_COPIES);
        for buffer in self.buffers.uncleared() {
            commands.clear(buffer);
        }
        if let Some(staging) = &mut batch.staging {
            if 0 < self.buffers.uncleared().len() {
                commands.barrier(Barrier::BETWEEN_COPIES);
            }
            uploads::record(&mut commands, staging, chunks, &self.buffers);
        }
        commands.end()?;
        Ok(commands)
    }

    fn copies_out(&mut self, readback: &Readback) -> Result<Commands, Fault> {
        let mut commands = self.begun_list()?;
        readback.record(&mut commands, &self.buffers);
        commands.end()?;
        Ok(commands)
    }

    fn begun_list(&mut self) -> Result<Commands, Fault> {
        let mut commands = match self.spare_lists.pop() {
            Some(commands) => commands,
            None => Commands::new(&self.context)?,
        };
        commands.begin(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT)?;
        Ok(commands)
    }

    /// Waits until one more submission is allowed.
    fn limit_in_flight(&mut self) -> Result<(), Fault> {
        if self.in_flight.len() < MAX_IN_FLIGHT {
            return Ok(());
        }
        self.wait_for(self.in_flight[0].number)
    }

    /// A buffer for bytes on their way; waits for earlier ones if all of them would take too much.
    fn staging_buffer(&mut self, n_bytes: u64) -> Result<Buffer, Fault> {
        loop {
            if let Some(buffer) = self.staging.take_idle(n_bytes) {
                return Ok(buffer);
            }
            let on_their_way: u64 = self.in_flight.iter().map(InFlight::staging_bytes).sum();
            let all = on_their_way + size_class(n_bytes);
            if all <= MAX_STAGING_BYTES {
                self.staging.shrink_to(MAX_STAGING_BYTES - all);
                return self.staging.make(n_bytes);
            }
            self.wait_for_staging()?;
        }
    }

    /// Sees to it that whole pieces are there, so that an upload that began can go on.
    fn reserve_staging(&mut self) -> Result<(), Fault> {
        while self.in_flight.iter().any(|one| 0 < one.staging_bytes()) {
            self.wait_for_staging()?;
        }
        let first = self.staging.take(PIECE_BYTES)?;
        let second = self.staging.take(PIECE_BYTES)?;
        self.staging.shrink_to(0);
        self.staging.give_back(first);
        self.staging.give_back(second);
        Ok(())
    }

    /// Waits for the oldest submission that holds staging memory.
    fn wait_for_staging(&mut self) -> Result<(), Fault> {
        let oldest = self.in_flight.iter().find(|one| 0 < one.staging_bytes());
        let oldest = oldest.expect("a piece alone does not take too much");
        self.wait_for(oldest.number)
    }

    fn wait_for(&mut self, number: u64) -> Result<(), Fault> {
        self.timeline.wait(number)?;
        self.retire()?;
        Ok(())
    }
}
