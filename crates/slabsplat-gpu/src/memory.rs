//! Buffers that stay on the device from frame to frame, and how much they take.

use crate::{BufferId, Device, DeviceError, Slice};
use slabsplat_backend::BackendError;

/// A buffer that grows when more is asked of it, and never shrinks.
#[derive(Debug)]
pub(crate) struct Buffer {
    label: &'static str,
    memory: Option<(BufferId, u64)>,
}

/// Keeps account of a device's memory.
#[derive(Debug, Default)]
pub(crate) struct Memory {
    resident: u64,
}

impl Buffer {
    /// A buffer of no bytes yet.
    pub(crate) fn new(label: &'static str) -> Self {
        Self { label, memory: None }
    }

    /// All of it.
    ///
    /// # Panics
    /// If it never grew.
    pub(crate) fn all(&self) -> Slice {
        let (buffer, size) = self.memory.expect("buffers are grown before they are bound");
        Slice { buffer, offset: 0, size }
    }

    /// Its bytes.
    pub(crate) fn size(&self) -> u64 {
        self.memory.map_or(0, |(_, size)| size)
    }
}

impl Memory {
    /// Bytes of all buffers.
    pub(crate) fn resident_bytes(&self) -> u64 {
        self.resident
    }

    /// Sees to it that a buffer has at least `size` bytes. What was in it is lost if it grows.
    pub(crate) fn grow<D: Device>(
        &mut self,
        device: &mut D,
        buffer: &mut Buffer,
        size: u64,
    ) -> Result<(), BackendError> {
        let size = size.max(4).next_multiple_of(4);
        if size <= buffer.size() {
            return Ok(());
        }
        self.free(device, buffer);
        self.check(device, buffer.label, size)?;
        let id = device
            .create_buffer(buffer.label, size)
            .map_err(|error| backend_error(device, buffer.label, &error))?;
        self.resident += size;
        buffer.memory = Some((id, size));
        Ok(())
    }

    pub(crate) fn free<D: Device>(&mut self, device: &mut D, buffer: &mut Buffer) {
        if let Some((id, size)) = buffer.memory.take() {
            device.destroy_buffer(id);
            self.resident -= size;
        }
    }

    pub(crate) fn free_all<'b, D: Device>(
        &mut self,
        device: &mut D,
        buffers: impl Iterator<Item = &'b mut Buffer>,
    ) {
        buffers.for_each(|buffer| self.free(device, buffer));
    }

    /// Asks for no more than the device has, as far as it reports: drivers may accept, and then swap.
    fn check<D: Device>(
        &self,
        device: &D,
        what: &'static str,
        size: u64,
    ) -> Result<(), BackendError> {
        let info = device.info();
        let free = info.memory_bytes.map_or(u64::MAX, |all| all.saturating_sub(self.resident));
        let available = free.min(info.max_buffer_bytes);
        if size <= available { Ok(()) } else { Err(too_large(device, what, size, available)) }
    }
}

/// The error for something that a device has no room for.
pub(crate) fn too_large<D: Device>(
    device: &D,
    what: &'static str,
    needed_bytes: u64,
    available_bytes: u64,
) -> BackendError {
    let device = device.info().name.clone();
    BackendError::OutOfMemory { what, device, needed_bytes, available_bytes }
}

/// A device's error as the contract says it.
pub(crate) fn backend_error<D: Device>(
    device: &D,
    what: &'static str,
    error: &DeviceError,
) -> BackendError {
    match error {
        // The device does not say how much it had left, only that it was less.
        DeviceError::OutOfMemory { bytes } => {
            too_large(device, what, *bytes, bytes.saturating_sub(1))
        }
        DeviceError::Refused { .. } => {
            BackendError::Unable { device: device.info().name.clone(), reason: error.to_string() }
        }
        DeviceError::Lost { reason } => {
            BackendError::DeviceLost { device: device.info().name.clone(), reason: reason.clone() }
        }
    }
}
