//! The caller's buffers, by id.

use crate::gpu::Gpu;
use slabsplat_gpu::{BufferId, DeviceError};
use std::collections::HashMap;

/// All buffers that are there.
#[derive(Debug, Default)]
pub(crate) struct Buffers {
    by_id: HashMap<BufferId, wgpu::Buffer>,
    n_created: u32,
}

impl Buffers {
    /// A buffer of zeros: wgpu clears it before its first use.
    pub(crate) fn create(
        &mut self,
        gpu: &Gpu,
        label: &'static str,
        size: u64,
    ) -> Result<BufferId, DeviceError> {
        let usage = wgpu::BufferUsages::STORAGE
            | wgpu::BufferUsages::UNIFORM
            | wgpu::BufferUsages::COPY_SRC
            | wgpu::BufferUsages::COPY_DST;
        let buffer = make(gpu, label, size, usage)?;
        let id = BufferId(self.n_created);
        self.n_created = self.n_created.checked_add(1).expect("nobody makes 2^32 buffers");
        self.by_id.insert(id, buffer);
        Ok(id)
    }

    /// Lets go of a buffer. wgpu keeps it until no work uses it any more.
    pub(crate) fn destroy(&mut self, id: BufferId) {
        assert!(self.by_id.remove(&id).is_some(), "{id:?} is not a buffer of this device");
    }

    pub(crate) fn get(&self, id: BufferId) -> &wgpu::Buffer {
        let buffer = self.by_id.get(&id);
        buffer.unwrap_or_else(|| panic!("{id:?} is not a buffer of this device"))
    }
}

/// Makes a buffer, or reports that there is no memory for it.
pub(crate) fn make(
    gpu: &Gpu,
    label: &'static str,
    size: u64,
    usage: wgpu::BufferUsages,
) -> Result<wgpu::Buffer, DeviceError> {
    if gpu.info.max_buffer_bytes < size {
        // To wgpu that is a mistake, not a want of memory.
        return Err(DeviceError::OutOfMemory { bytes: size });
    }
    let descriptor =
        wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false };
    let buffer = gpu.noting(|| gpu.device.create_buffer(&descriptor));
    gpu.faults.check_made(size)?;
    Ok(buffer)
}
