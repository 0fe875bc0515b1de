//! What callers must keep to, checked before it reaches the driver, which would not notice.
//!
//! A violation is a mistake in the caller's program, so it panics.

use crate::choose::Candidate;
use crate::memory::Buffer;
use slabsplat_gpu::{Pass, Slice, Write};
use slabsplat_shaders::BindingKind;

/// Most workgroups along an axis.
const MAX_GROUPS: u32 = 65535;

/// The size of a buffer.
pub(crate) fn size(label: &str, size: u64) {
    assert!(
        0 < size && size.is_multiple_of(4),
        "usage: buffer {label} has {size} bytes, not a multiple of 4 above 0"
    );
}

/// Bytes for a buffer.
pub(crate) fn write(write: &Write<'_>, buffer: &Buffer) {
    let size = write.bytes.len() as u64;
    assert!(
        write.offset.is_multiple_of(4) && size.is_multiple_of(4),
        "usage: a write of {size} bytes at {} is not in steps of 4",
        write.offset
    );
    assert!(
        is_within(write.offset, size, buffer),
        "usage: a write of {size} bytes at {} of {}",
        write.offset,
        buffer.size
    );
}

/// What is read back.
pub(crate) fn read(slice: &Slice, buffer: &Buffer) {
    assert!(
        slice.offset.is_multiple_of(4) && slice.size.is_multiple_of(4),
        "usage: {slice:?} is not in steps of 4"
    );
    assert!(
        0 < slice.size && is_within(slice.offset, slice.size, buffer),
        "usage: {slice:?} is read of {} bytes",
        buffer.size
    );
}

/// A run of a shader; `buffers` are those of its bindings.
pub(crate) fn pass(pass: &Pass, buffers: &[&Buffer], device: &Candidate) {
    let name = pass.shader.name;
    let groups = pass.groups;
    assert!(
        groups.iter().all(|n| (1..=MAX_GROUPS).contains(n)),
        "usage: {name} runs in {groups:?} workgroups"
    );
    assert!(
        pass.bindings.len() == pass.shader.bindings.len(),
        "usage: {name} is bound to {} slices",
        pass.bindings.len()
    );
    for ((slice, binding), buffer) in pass.bindings.iter().zip(pass.shader.bindings).zip(buffers) {
        let max_bytes = match binding.kind {
            BindingKind::Uniform => device.max_uniform_bytes,
            BindingKind::Read | BindingKind::Written => device.info.max_binding_bytes,
        };
        assert!(
            slice.offset.is_multiple_of(device.info.offset_alignment)
                && slice.size.is_multiple_of(4)
                && 0 < slice.size
                && slice.size <= max_bytes
                && is_within(slice.offset, slice.size, buffer),
            "usage: {name} is bound to {slice:?} of {} bytes as {binding:?}",
            buffer.size
        );
    }
}

fn is_within(offset: u64, size: u64, buffer: &Buffer) -> bool {
    offset.checked_add(size).is_some_and(|end| end <= buffer.size)
}
