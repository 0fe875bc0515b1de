//! What is stored of each relevant voxel, in up to four buffers: no device binds as much at once as a large
//! list takes. A voxel's buffer and its index there are the upper and the lower bits of its number.

use crate::memory::{Buffer, Memory, too_large};
use crate::{Device, DeviceInfo, Slice, Write};
use slabsplat_backend::BackendError;

/// Buffers that a shader sees at once.
const N_CHUNKS: u64 = 4;

/// Up to four buffers of elements.
#[derive(Debug)]
pub(crate) struct Chunks {
    label: &'static str,
    element_bytes: u64,
    /// The number of elements of a full buffer is a power of two: this one.
    pub(crate) bits: u32,
    buffers: [Buffer; N_CHUNKS as usize],
}

impl Chunks {
    /// Chunks as large as the device can bind.
    pub(crate) fn new(label: &'static str, element_bytes: u64, info: &DeviceInfo) -> Self {
        let elements = info.max_binding_bytes.min(info.max_buffer_bytes) / element_bytes;
        // A voxel's number has 32 bits.
        let bits = elements.checked_ilog2().unwrap_or(0).min(30);
        Self { label, element_bytes, bits, buffers: [0; 4].map(|_| Buffer::new(label)) }
    }

    /// Elements that there can be.
    pub(crate) fn most(&self) -> u64 {
        N_CHUNKS << self.bits
    }

    /// Sees to it that there is room for `n` elements.
    pub(crate) fn grow<D: Device>(
        &mut self,
        memory: &mut Memory,
        device: &mut D,
        n: u64,
    ) -> Result<(), BackendError> {
        if self.most() < n {
            let [needed, available] = [n, self.most()].map(|n| n * self.element_bytes);
            return Err(too_large(device, self.label, needed, available));
        }
        for chunk in 0..N_CHUNKS {
            // An empty chunk is bound, too.
            let n_elements = self.len_of(chunk, n).max(1);
            let buffer = &mut self.buffers[chunk as usize];
            memory.grow(device, buffer, n_elements * self.element_bytes)?;
        }
        Ok(())
    }

    pub(crate) fn buffers(&mut self) -> impl Iterator<Item = &mut Buffer> {
        self.buffers.iter_mut()
    }

    /// The chunks that hold any of `n` elements: number of the first element, number of elements, buffer.
    pub(crate) fn filled(&self, n: u64) -> impl Iterator<Item = (u64, u64, Slice)> + '_ {
        (0..N_CHUNKS)
            .map(move |chunk| (chunk << self.bits, self.len_of(chunk, n), chunk as usize))
            .filter(|(_, n_elements, _)| 0 < *n_elements)
            .map(|(first, n_elements, chunk)| (first, n_elements, self.buffers[chunk].all()))
    }

    /// The chunk of an element, and how many there are from it to the end of a full one.
    pub(crate) fn chunk_of(&self, element: u64) -> (Slice, u64) {
        let chunk = element >> self.bits;
        (self.buffers[chunk as usize].all(), ((chunk + 1) << self.bits) - element)
    }

    /// Writes the bytes of elements from that one on, for which there is room.
    pub(crate) fn writes<'a>(&self, first: u64, mut bytes: &'a [u8]) -> Vec<Write<'a>> {
        let (mut element, mut writes) = (first, Vec::new());
        while !bytes.is_empty() {
            let (chunk, n_left) = self.chunk_of(element);
            let n_bytes = (bytes.len() as u64).min(n_left * self.element_bytes);
            let (now, later) = bytes.split_at(n_bytes as usize);
            let offset = (element & ((1 << self.bits) - 1)) * self.element_bytes;
            writes.push(Write { buffer: chunk.buffer, offset, bytes: now.into() });
            (element, bytes) = (element + n_left, later);
        }
        writes
    }

    pub(crate) fn all(&self) -> impl Iterator<Item = Slice> + '_ {
        self.buffers.iter().map(Buffer::all)
    }

    fn len_of(&self, chunk: u64, n: u64) -> u64 {
        n.saturating_sub(chunk << self.bits).min(1 << self.bits)
    }
}
