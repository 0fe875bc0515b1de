//! Writes of any length through a bounded amount of staging memory.
//!
//! wgpu copies what is written to staging memory of its own, which it holds until the submission after
//! it is executed. A volume of gigabytes would be in memory twice; so long writes go in pieces, each
//! submitted by itself, and no more than two are under way.

use crate::gpu::Gpu;
use slabsplat_gpu::Write;
use std::collections::VecDeque;

/// Large enough for the cost of a submission not to show, and small enough to come from memory that
/// wgpu keeps, instead of from the driver each time.
pub(crate) const PIECE_BYTES: usize = 16 << 20;

/// How much is on its way to the device.
#[derive(Debug, Default)]
pub(crate) struct Uploads {
    n_unsubmitted_bytes: usize,
    pieces: VecDeque<wgpu::SubmissionIndex>,
}

impl Uploads {
    /// Writes before anything that is submitted from now on.
    pub(crate) fn write(&mut self, gpu: &Gpu, buffer: &wgpu::Buffer, write: &Write<'_>) {
        let mut offset = write.offset;
        for piece in write.bytes.chunks(PIECE_BYTES) {
            if PIECE_BYTES < self.n_unsubmitted_bytes + piece.len() {
                self.submit_piece(gpu);
            }
            gpu.noting(|| gpu.queue.write_buffer(buffer, offset, piece));
            offset += piece.len() as u64;
            self.n_unsubmitted_bytes += piece.len();
        }
    }

    /// To be called when work was submitted, which took along all that had been written.
    pub(crate) fn submitted(&mut self) {
        self.n_unsubmitted_bytes = 0;
        self.pieces.clear();
    }

    fn submit_piece(&mut self, gpu: &Gpu) {
        self.pieces.push_back(gpu.noting(|| gpu.queue.submit([])));
        self.n_unsubmitted_bytes = 0;
        if 2 <= self.pieces.len()
            && let Some(oldest) = self.pieces.pop_front()
        {
            gpu.wait(oldest);
        }
    }
}
