//! The caller's buffers: from their number to the buffer, and how they come and go.

use crate::error::Fault;
use crate::memory::{Buffer, BufferDesc, Memory};
use ash::vk;
use gpu_allocator::MemoryLocation;
use slabsplat_gpu::BufferId;
use std::collections::{HashMap, VecDeque};
use std::sync::Arc;

/// Everything that a caller may do with a buffer.
const ANY_USE: vk::BufferUsageFlags = vk::BufferUsageFlags::from_raw(
    vk::BufferUsageFlags::STORAGE_BUFFER.as_raw()
        | vk::BufferUsageFlags::UNIFORM_BUFFER.as_raw()
        | vk::BufferUsageFlags::TRANSFER_SRC.as_raw()
        | vk::BufferUsageFlags::TRANSFER_DST.as_raw(),
);

/// All buffers of a caller.
pub(crate) struct Buffers {
    live: HashMap<BufferId, Buffer>,
    /// Live ones that are still to be filled with zeros.
    uncleared: Vec<BufferId>,
    /// Given back, with the submission that may use them last, in its order.
    leaving: VecDeque<(u64, BufferId, Buffer)>,
    n_made: u32,
    memory: Arc<Memory>,
}

impl Buffers {
    pub(crate) fn new(memory: &Arc<Memory>) -> Self {
        Self {
            live: HashMap::new(),
            uncleared: Vec::new(),
            leaving: VecDeque::new(),
            n_made: 0,
            memory: Arc::clone(memory),
        }
    }

    /// A new buffer, which the next submission must fill with zeros.
    pub(crate) fn create(&mut self, label: &str, size: u64) -> Result<BufferId, Fault> {
        let location = MemoryLocation::GpuOnly;
        let buffer = self.memory.buffer(BufferDesc { label, size, usage: ANY_USE, location })?;
        let id = BufferId(self.n_made);
        self.n_made = self.n_made.checked_add(1).expect("nobody makes 4 billion buffers");
        self.live.insert(id, buffer);
        self.uncleared.push(id);
        Ok(id)
    }

    /// Takes a buffer back, to be dropped when `last_use` is done.
    pub(crate) fn destroy(&mut self, id: BufferId, last_use: u64) {
        let buffer = self.live.remove(&id);
        let buffer = buffer.unwrap_or_else(|| panic!("usage: {id:?} is destroyed, but not there"));
        self.uncleared.retain(|uncleared| *uncleared != id);
        self.leaving.push_back((last_use, id, buffer));
    }

    pub(crate) fn get(&self, id: BufferId) -> &Buffer {
        self.live.get(&id).unwrap_or_else(|| panic!("usage: {id:?} is used, but not there"))
    }

    /// Those to fill with zeros before anything else happens to them.
    pub(crate) fn uncleared(&self) -> impl ExactSizeIterator<Item = &Buffer> {
        self.uncleared.iter().map(|id| self.get(*id))
    }

    /// Notes that the commands which fill them were submitted.
    pub(crate) fn note_cleared(&mut self) {
        self.uncleared.clear();
    }

    /// The next buffer to be dropped, if the device is done with it.
    pub(crate) fn next_gone(&mut self, done: u64) -> Option<(BufferId, Buffer)> {
        let (last_use, _, _) = self.leaving.front()?;
        if done < *last_use {
            return None;
        }
        self.leaving.pop_front().map(|(_, id, buffer)| (id, buffer))
    }

    /// The submission after which no buffer is waiting to be dropped.
    pub(crate) fn last_leaves_after(&self) -> Option<u64> {
        self.leaving.back().map(|(last_use, _, _)| *last_use)
    }
}
