//! Bytes on their way back: copied into one buffer that the processor reads when the device is done.

use crate::buffers::Buffers;
use crate::commands::{Barrier, Commands};
use crate::memory::Buffer;
use ash::vk;
use slabsplat_gpu::Slice;

/// What a submission reads, and where it goes.
pub(crate) struct Readback {
    pub(crate) buffer: Buffer,
    slices: Vec<Slice>,
}

/// Bytes that reads take.
pub(crate) fn n_bytes(reads: &[Slice]) -> u64 {
    reads.iter().map(|slice| slice.size).sum()
}

impl Readback {
    /// `buffer` has room for all of them.
    pub(crate) fn new(buffer: Buffer, reads: &[Slice]) -> Self {
        Self { buffer, slices: reads.to_vec() }
    }

    /// Records the copies, and makes them seen by the processor.
    pub(crate) fn record(&self, commands: &mut Commands, buffers: &Buffers) {
        commands.barrier(Barrier::BEFORE_COPIES);
        let mut start = 0;
        for slice in &self.slices {
            let range =
                vk::BufferCopy { src_offset: slice.offset, dst_offset: start, size: slice.size };
            commands.copy(buffers.get(slice.buffer), &self.buffer, &[range]);
            start += slice.size;
        }
        commands.barrier(Barrier::BEFORE_HOST);
    }

    /// The words of each slice. The device must be done with the copies.
    pub(crate) fn words(&self) -> Vec<Vec<u32>> {
        let mut start = 0;
        let take = |slice: &Slice| {
            let words = self.buffer.read(start, slice.size);
            start += slice.size;
            words
        };
        self.slices.iter().map(take).collect()
    }
}
