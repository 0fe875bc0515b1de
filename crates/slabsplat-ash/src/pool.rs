//! Buffers between processor and device, used again and again.

use crate::error::Fault;
use crate::memory::{Buffer, BufferDesc, Memory};
use ash::vk;
use gpu_allocator::MemoryLocation;
use std::sync::Arc;

/// No buffer is smaller.
const MIN_BYTES: u64 = 64 << 10;
/// Up to here, sizes are powers of two; above, multiples of this.
const STEP_BYTES: u64 = 16 << 20;
/// A request is not served with a buffer that is longer by more than this factor: small requests would
/// keep the large ones from large requests.
const MAX_WASTE: u64 = 8;

/// What a pool's buffers are for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PoolDesc {
    pub(crate) label: &'static str,
    pub(crate) usage: vk::BufferUsageFlags,
    pub(crate) location: MemoryLocation,
    /// Most bytes that lie idle, but for the buffer that came back last.
    pub(crate) max_idle_bytes: u64,
}

/// Buffers that nobody uses at the moment.
pub(crate) struct Pool {
    memory: Arc<Memory>,
    desc: PoolDesc,
    /// The longest idle first.
    idle: Vec<Buffer>,
}

impl Pool {
    pub(crate) fn new(memory: &Arc<Memory>, desc: PoolDesc) -> Self {
        Self { memory: Arc::clone(memory), desc, idle: Vec::new() }
    }

    /// A buffer of at least that many bytes.
    pub(crate) fn take(&mut self, n_bytes: u64) -> Result<Buffer, Fault> {
        match self.take_idle(n_bytes) {
            Some(buffer) => Ok(buffer),
            None => self.make(n_bytes),
        }
    }

    /// One of the idle buffers, if one suits: the shortest.
    pub(crate) fn take_idle(&mut self, n_bytes: u64) -> Option<Buffer> {
        let least = size_class(n_bytes);
        let suits = |buffer: &Buffer| least <= buffer.size && buffer.size / MAX_WASTE <= least;
        let suiting = self.idle.iter().enumerate().filter(|(_, buffer)| suits(buffer));
        let (idx, _) = suiting.min_by_key(|(_, buffer)| buffer.size)?;
        Some(self.idle.remove(idx))
    }

    /// A new buffer.
    pub(crate) fn make(&mut self, n_bytes: u64) -> Result<Buffer, Fault> {
        self.memory.buffer(BufferDesc {
            label: self.desc.label,
            size: size_class(n_bytes),
            usage: self.desc.usage,
            location: self.desc.location,
        })
    }

    /// Takes a buffer back that the device is done with.
    pub(crate) fn give_back(&mut self, buffer: Buffer) {
        let room = self.desc.max_idle_bytes.saturating_sub(buffer.size);
        self.shrink_to(room);
        self.idle.push(buffer);
    }

    /// How many buffers lie idle.
    #[cfg(test)]
    pub(crate) fn n_idle(&self) -> usize {
        self.idle.len()
    }

    /// Drops the longest idle buffers until the others have no more than that many bytes.
    pub(crate) fn shrink_to(&mut self, max_bytes: u64) {
        let mut n_bytes: u64 = self.idle.iter().map(|buffer| buffer.size).sum();
        while max_bytes < n_bytes {
            n_bytes -= self.idle.remove(0).size;
        }
    }
}

/// The length of the buffers that serve a request. Few lengths, so that buffers suit each other's use.
pub(crate) fn size_class(n_bytes: u64) -> u64 {
    if n_bytes <= STEP_BYTES {
        return n_bytes.next_power_of_two().max(MIN_BYTES);
    }
    n_bytes.next_multiple_of(STEP_BYTES)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pool_sizes_are_few() {
        assert_eq!(size_class(1), 64 << 10);
        assert_eq!(size_class((64 << 10) + 4), 128 << 10);
        assert_eq!(size_class(16 << 20), 16 << 20);
        assert_eq!(size_class((16 << 20) + 4), 32 << 20);
        assert_eq!(size_class(64 << 20), 64 << 20);
        assert_eq!(size_class((64 << 20) + 4), 80 << 20);
    }
}
