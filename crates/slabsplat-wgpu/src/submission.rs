//! From work to a submission, and from a finished submission to what it brought.

use crate::WgpuDevice;
use crate::encode::{self, Prepared};
use crate::in_flight::Flight;
use crate::read_back::Signal;
use slabsplat_gpu::{DeviceError, Done, Pass, Work, WorkId};
use std::task::Poll;

impl WgpuDevice {
    /// Begins work.
    pub(crate) fn execute(&mut self, work: &Work<'_>) -> Result<WorkId, DeviceError> {
        self.in_flight.make_room(&self.gpu);
        // All that may find no memory comes before the first write, so that the buffers are then untouched.
        let prepared = self.prepare(work)?;
        for write in &work.writes {
            self.uploads.write(&self.gpu, self.buffers.get(write.buffer), write);
        }
        let signal = Signal::default();
        let submission = self.gpu.noting(|| {
            let commands = encode::record(&self.gpu.device, &self.buffers, work, &prepared);
            let submission = self.gpu.queue.submit([commands]);
            match &prepared.read_back {
                Some(read_back) => read_back.map(prepared.n_read_bytes, &signal),
                None => signal.when_done(&self.gpu.queue),
            }
            submission
        });
        self.uploads.submitted();
        self.gpu
            .faults
            .check_made(work.writes.iter().map(|write| write.bytes.len() as u64).sum())?;
        let flight = Flight {
            submission,
            signal,
            read_back: prepared.read_back,
            n_read_bytes: prepared.n_read_bytes,
            read_sizes: work.reads.iter().map(|slice| slice.size).collect(),
            timer: prepared.timer,
            stages: prepared.stages,
        };
        Ok(self.in_flight.add(flight))
    }

    fn prepare(&mut self, work: &Work<'_>) -> Result<Prepared, DeviceError> {
        let Self { gpu, buffers, pipelines, bind_groups, timers, .. } = self;
        let device = &gpu.device;
        let stages = encode::stages(&work.passes);
        let (dispatches, timer) = gpu.noting(|| {
            let dispatch = |pass: &Pass| {
                let pipeline = pipelines.get(device, pass.shader);
                let (name, layout) = (pass.shader.name, &pipeline.layout);
                let group = bind_groups.get(device, buffers, (name, layout), &pass.bindings);
                (pipeline.pipeline.clone(), group)
            };
            let dispatches = work.passes.iter().map(dispatch).collect();
            (dispatches, timers.take(gpu, stages.len()))
        });
        let n_times = if timer.is_some() { stages.len() } else { 0 };
        let n_read_bytes = work.reads.iter().map(|slice| slice.size).sum::<u64>()
            + encode::BYTES_OF_STAGE * n_times as u64;
        let read_back = self.read_backs.take(&self.gpu, n_read_bytes)?;
        self.gpu.faults.check_made(n_read_bytes)?;
        Ok(Prepared { dispatches, stages, timer, read_back, n_read_bytes })
    }

    /// What work has brought, if it is done.
    pub(crate) fn collect(&mut self, work: WorkId) -> Result<Poll<Done>, DeviceError> {
        if self.in_flight.is_pending(work) {
            return Ok(Poll::Pending);
        }
        let flight = self.in_flight.take(work);
        let mut done = Done::default();
        if let Some(read_back) = flight.read_back {
            let Some(bytes) = read_back.bytes(flight.n_read_bytes, &flight.signal) else {
                return Err(self.gpu.faults.lose("what it computed cannot be read"));
            };
            let mut rest = &bytes[..];
            for size in flight.read_sizes {
                let (read, after) = rest.split_at(usize::try_from(size).unwrap_or(usize::MAX));
                done.reads.push(bytemuck::cast_slice(read).to_vec());
                rest = after;
            }
            if let Some(timer) = flight.timer {
                let period_ns = self.gpu.queue.get_timestamp_period();
                done.stage_ms = encode::stage_ms(&flight.stages, rest, period_ns);
                self.timers.give_back(timer);
            }
            drop(bytes);
            self.read_backs.give_back(&self.gpu, read_back);
        }
        Ok(Poll::Ready(done))
    }
}
