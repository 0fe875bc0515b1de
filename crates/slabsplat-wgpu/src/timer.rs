//! Timestamps at the ends of stages: queries, which are used again when their work is done.

use crate::encode::BYTES_OF_STAGE;
use crate::gpu::Gpu;

/// As many as the largest query set has room for.
const MOST_STAGES: usize = wgpu::QUERY_SET_MAX_QUERIES as usize / 2;

/// Timers that are retained: as many as there can be works in flight, and some that wait to be taken.
const MOST_FREE: usize = 8;

/// Timers that no work uses.
#[derive(Debug, Default)]
pub(crate) struct Timers {
    free: Vec<Timer>,
}

/// Two queries a stage, and where their results go: not a buffer that can be mapped, so that they are
/// copied once more.
#[derive(Debug)]
pub(crate) struct Timer {
    queries: wgpu::QuerySet,
    results: wgpu::Buffer,
    n_stages: usize,
}

impl Timers {
    /// A timer for so many stages, if they can be timed.
    pub(crate) fn take(&mut self, gpu: &Gpu, n_stages: usize) -> Option<Timer> {
        if !gpu.info.has_timestamps || n_stages == 0 || MOST_STAGES < n_stages {
            return None;
        }
        match self.free.iter().position(|timer| n_stages <= timer.n_stages) {
            Some(found) => Some(self.free.swap_remove(found)),
            // Frames have some stages more or less: one size for all of them.
            None => Some(Timer::new(gpu, n_stages.next_power_of_two().max(16))),
        }
    }

    /// Takes back a timer whose work is done.
    pub(crate) fn give_back(&mut self, timer: Timer) {
        if self.free.len() == MOST_FREE {
            // The oldest goes: it may be one that has become too small.
            self.free.remove(0);
        }
        self.free.push(timer);
    }

    #[cfg(test)]
    pub(crate) fn n_free(&self) -> usize {
        self.free.len()
    }
}

impl Timer {
    fn new(gpu: &Gpu, n_stages: usize) -> Self {
        let n_stages = n_stages.min(MOST_STAGES);
        let queries = gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("stage times"),
            ty: wgpu::QueryType::Timestamp,
            count: 2 * n_stages as u32,
        });
        let results = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("stage times"),
            size: BYTES_OF_STAGE * n_stages as u64,
            usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        Self { queries, results, n_stages }
    }

    /// The timestamps of a compute pass.
    pub(crate) fn around_stage(&self, stage: usize) -> wgpu::ComputePassTimestampWrites<'_> {
        let begin = 2 * stage as u32;
        wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(begin),
            end_of_pass_write_index: Some(begin + 1),
        }
    }

    /// Copies the timestamps of the first stages to `to`.
    pub(crate) fn resolve(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        n_stages: usize,
        to: &wgpu::Buffer,
        offset: u64,
    ) {
        encoder.resolve_query_set(&self.queries, 0..2 * n_stages as u32, &self.results, 0);
        let size = BYTES_OF_STAGE * n_stages as u64;
        encoder.copy_buffer_to_buffer(&self.results, 0, to, offset, size);
    }
}
