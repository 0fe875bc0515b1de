//! Bind groups, cached as long as their buffers are there: most passes bind what they bound a frame ago.

use crate::buffers::Buffers;
use slabsplat_gpu::{BufferId, Slice};
use std::collections::HashMap;

/// More than any frame has, so that only a caller whose slices never repeat gets there.
const MOST: usize = 4096;

/// All bind groups, by shader and by what is bound.
#[derive(Debug, Default)]
pub(crate) struct BindGroups {
    // Two maps, not one with a pair as its key, so that a slice of slices finds its group.
    by_shader: HashMap<&'static str, HashMap<Vec<Slice>, wgpu::BindGroup>>,
    n_kept: usize,
}

impl BindGroups {
    /// The bind group of a shader, by its name and layout, with these slices bound in their order.
    pub(crate) fn get(
        &mut self,
        device: &wgpu::Device,
        buffers: &Buffers,
        (shader, layout): (&'static str, &wgpu::BindGroupLayout),
        bindings: &[Slice],
    ) -> wgpu::BindGroup {
        let of_shader = self.by_shader.get(shader);
        if let Some(cached) = of_shader.and_then(|groups| groups.get(bindings)) {
            return cached.clone();
        }
        if self.n_kept == MOST {
            self.by_shader.clear();
            self.n_kept = 0;
        }
        let made = make(device, buffers, (shader, layout), bindings);
        let of_shader = self.by_shader.entry(shader).or_default();
        of_shader.insert(bindings.to_vec(), made.clone());
        self.n_kept += 1;
        made
    }

    /// Drops what binds the buffer.
    pub(crate) fn forget(&mut self, buffer: BufferId) {
        for groups in self.by_shader.values_mut() {
            groups.retain(|bindings, _| bindings.iter().all(|slice| slice.buffer != buffer));
        }
        self.n_kept = self.by_shader.values().map(HashMap::len).sum();
    }

    #[cfg(test)]
    pub(crate) fn n_kept(&self) -> usize {
        self.n_kept
    }
}

fn make(
    device: &wgpu::Device,
    buffers: &Buffers,
    (shader, layout): (&'static str, &wgpu::BindGroupLayout),
    bindings: &[Slice],
) -> wgpu::BindGroup {
    let entry = |(binding, slice): (u32, &Slice)| wgpu::BindGroupEntry {
        binding,
        resource: wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer: buffers.get(slice.buffer),
            offset: slice.offset,
            size: wgpu::BufferSize::new(slice.size),
        }),
    };
    let entries: Vec<_> = (0..).zip(bindings).map(entry).collect();
    let label = Some(shader);
    device.create_bind_group(&wgpu::BindGroupDescriptor { label, layout, entries: &entries })
}
