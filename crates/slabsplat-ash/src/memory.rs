//! Buffers with memory of their own, and the bytes of those that the processor sees.

use crate::context::Context;
use crate::error::{Fault, during};
use ash::vk;
use gpu_allocator::vulkan::{
    Allocation, AllocationCreateDesc, AllocationScheme, Allocator, AllocatorCreateDesc,
};
use gpu_allocator::{AllocationSizes, MemoryLocation};
use std::ffi::c_void;
use std::ptr::NonNull;
use std::sync::{Arc, Mutex, PoisonError};

const MIB: u64 = 1 << 20;

/// All memory of a device. Freed when the last buffer has gone.
pub(crate) struct Memory {
    // Goes first, for it gives its blocks back to the device.
    allocator: Mutex<Allocator>,
    context: Arc<Context>,
}

/// What a buffer is for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BufferDesc<'a> {
    pub(crate) label: &'a str,
    pub(crate) size: u64,
    pub(crate) usage: vk::BufferUsageFlags,
    pub(crate) location: MemoryLocation,
}

/// A buffer, with memory until it is dropped. The device must be done with it by then.
pub(crate) struct Buffer {
    pub(crate) handle: vk::Buffer,
    pub(crate) size: u64,
    allocation: Allocation,
    memory: Arc<Memory>,
}

impl Memory {
    pub(crate) fn new(context: &Arc<Context>) -> Result<Arc<Self>, Fault> {
        // Blocks grow with what is asked for, so that a small volume does not take a quarter of a
        // gigabyte. What is larger than a block has memory of its own.
        let sizes = AllocationSizes::new(16 * MIB, 4 * MIB)
            .with_max_device_memblock_size(256 * MIB)
            .with_max_host_memblock_size(64 * MIB);
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: context.instance.functions.clone(),
            device: context.functions.clone(),
            physical_device: context.candidate.handle,
            debug_settings: gpu_allocator::AllocatorDebugSettings::default(),
            buffer_device_address: false,
            allocation_sizes: sizes,
        })?;
        Ok(Arc::new(Self { allocator: Mutex::new(allocator), context: Arc::clone(context) }))
    }

    /// A buffer whose bytes are anything.
    pub(crate) fn buffer(self: &Arc<Self>, desc: BufferDesc<'_>) -> Result<Buffer, Fault> {
        let info = vk::BufferCreateInfo::default()
            .size(desc.size)
            .usage(desc.usage)
            .sharing_mode(vk::SharingMode::EXCLUSIVE);
        // SAFETY: the size is above 0 and within the device's limits, which `AshDevice` and `Pool` check.
        let handle = unsafe { self.context.functions.create_buffer(&info, None) }
            .map_err(during("vkCreateBuffer"))?;
        // From here on, dropping it cleans up.
        let mut buffer = Buffer {
            handle,
            size: desc.size,
            allocation: Allocation::default(),
            memory: Arc::clone(self),
        };
        buffer.allocation = self.allocate(handle, desc)?;
        buffer.bind()?;
        self.context.name(handle, desc.label);
        Ok(buffer)
    }

    fn allocate(&self, buffer: vk::Buffer, desc: BufferDesc<'_>) -> Result<Allocation, Fault> {
        // SAFETY: the buffer was made with this device just now.
        let requirements = unsafe { self.context.functions.get_buffer_memory_requirements(buffer) };
        let of_scheme = |allocation_scheme| AllocationCreateDesc {
            name: desc.label,
            requirements,
            location: desc.location,
            linear: true,
            allocation_scheme,
        };
        let mut allocator = self.allocator.lock().unwrap_or_else(PoisonError::into_inner);
        let in_a_block = allocator.allocate(&of_scheme(AllocationScheme::GpuAllocatorManaged));
        match in_a_block.map_err(Fault::from) {
            // A whole block does not fit any more, but the buffer alone may.
            Err(Fault::OutOfMemory) => {
                Ok(allocator.allocate(&of_scheme(AllocationScheme::DedicatedBuffer(buffer)))?)
            }
            result => result,
        }
    }

    fn free(&self, allocation: Allocation) {
        let mut allocator = self.allocator.lock().unwrap_or_else(PoisonError::into_inner);
        // It fails only for what is not this allocator's.
        let _ = allocator.free(allocation);
    }
}

impl Buffer {
    fn bind(&self) -> Result<(), Fault> {
        // SAFETY: the allocation was made for the buffer's requirements, and its memory is not freed
        // before the allocation is, in `drop`.
        let bound = unsafe {
            self.memory.context.functions.bind_buffer_memory(
                self.handle,
                self.allocation.memory(),
                self.allocation.offset(),
            )
        };
        bound.map_err(during("vkBindBufferMemory"))
    }

    /// Puts bytes where the processor sees the buffer.
    pub(crate) fn write(&mut self, offset: u64, bytes: &[u8]) {
        let target: *mut u8 = self.mapped(offset, bytes.len() as u64).as_ptr().cast();
        // SAFETY: `mapped` checked the range; the bytes are borrowed from elsewhere, and no other
        // reference into the buffer exists.
        unsafe { target.copy_from_nonoverlapping(bytes.as_ptr(), bytes.len()) };
    }

    /// Words that the device has written where the processor sees the buffer, in as many bytes.
    pub(crate) fn read(&self, offset: u64, size: u64) -> Vec<u32> {
        let source = self.mapped(offset, size);
        let size = usize::try_from(size).expect("mapped memory fits the address space");
        // SAFETY: `mapped` checked the range, and `Readback` asks only for bytes that the device has
        // written and is done with.
        let bytes = unsafe { std::slice::from_raw_parts(source.as_ptr().cast::<u8>(), size) };
        bytemuck::cast_slice(bytes).to_vec()
    }

    /// The address of a range that the processor sees.
    fn mapped(&self, offset: u64, size: u64) -> NonNull<c_void> {
        let end = offset.checked_add(size).expect("ranges of buffers are small");
        assert!(end <= self.size, "internal: bytes {offset} to {end} of {}", self.size);
        let start = self.allocation.mapped_ptr().expect("such buffers are made mappable");
        let offset = usize::try_from(offset).expect("mapped memory fits the address space");
        // SAFETY: the allocation is at least as long as the buffer, and the offset is within it.
        unsafe { start.byte_add(offset) }
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        // SAFETY: the device is done with it, as the type says.
        unsafe { self.memory.context.functions.destroy_buffer(self.handle, None) };
        self.memory.free(std::mem::take(&mut self.allocation));
    }
}
