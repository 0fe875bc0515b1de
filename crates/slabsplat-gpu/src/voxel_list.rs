//! The relevant voxels of a layer on the device: `L_r` of the paper's §4, made by the device itself from
//! samples that stay there. A new transfer function sends its points, nothing else.

use crate::chunks::Chunks;
use crate::classification::Classification;
use crate::job::{JobLayer, KnownVolume};
use crate::memory::{Buffer, Memory};
use crate::params::{COUNT_OF_LISTS, RECORD_BYTES, Step};
use crate::pass_list::{PassList, n_groups};
use crate::samples::{Piece, VOXELS_PER_BLOCK};
use crate::sums::{BLOCK, Sums};
use crate::{Device, DeviceInfo, Slice, Write};
use slabsplat_backend::BackendError;
use slabsplat_shaders::{CLASSIFY_COUNT, CLASSIFY_EMIT};
use std::sync::Arc;

const _: () = assert!(VOXELS_PER_BLOCK == BLOCK as usize, "a block's count is one to be summed");

/// The relevant voxels of a layer of the last job, and what they were made from.
#[derive(Debug)]
pub(crate) struct VoxelList {
    made_for: Option<(Arc<KnownVolume>, Classification)>,
    params: Buffer,
    transfer: Buffer,
    sums: Sums,
    pub(crate) records: Chunks,
    /// Where the device counts them.
    pub(crate) count_slot: u32,
}

impl VoxelList {
    /// An empty list, with that number among all that there are.
    pub(crate) fn new(number: u32, info: &DeviceInfo) -> Self {
        Self {
            made_for: None,
            params: Buffer::new("volume parameters"),
            transfer: Buffer::new("transfer function"),
            sums: Sums::new("relevant counts", "relevant totals"),
            records: Chunks::new("relevant voxels", RECORD_BYTES, info),
            count_slot: COUNT_OF_LISTS + number,
        }
    }

    /// Whether it is that of a layer.
    pub(crate) fn is_of(&self, layer: &JobLayer) -> bool {
        self.made_for.as_ref().is_some_and(|(known, classification)| {
            Arc::ptr_eq(known, &layer.known) && *classification == layer.classification
        })
    }

    /// Sees to it that there is room for a layer's list, and writes what it is made from beside samples.
    pub(crate) fn prepare<'a, D: Device>(
        &mut self,
        (memory, device): (&mut Memory, &mut D),
        layer: &'a JobLayer,
        writes: &mut Vec<Write<'a>>,
    ) -> Result<(), BackendError> {
        self.made_for = None;
        let Classification { params, transfer, .. } = &layer.classification;
        let (params, transfer) = (bytemuck::bytes_of(params), bytemuck::cast_slice(transfer));
        memory.grow(device, &mut self.params, params.len() as u64)?;
        memory.grow(device, &mut self.transfer, transfer.len() as u64)?;
        self.records.grow(memory, device, layer.max_voxels)?;
        self.sums.grow(memory, device, n_blocks(layer))?;
        for (buffer, bytes) in [(&self.params, params), (&self.transfer, transfer)] {
            writes.push(Write { buffer: buffer.all().buffer, offset: 0, bytes: bytes.into() });
        }
        Ok(())
    }

    /// Pushes the passes that make it that of a layer, whose samples are in these pieces.
    pub(crate) fn push_passes(
        &mut self,
        layer: &JobLayer,
        pieces: &[(Piece, Buffer)],
        counts: Slice,
        passes: &mut PassList,
    ) {
        let step = |piece: &Piece| Step {
            first: piece.voxels.start as u32,
            n_elements: piece.voxels.len() as u32,
            first_block: (piece.voxels.start / VOXELS_PER_BLOCK) as u32,
            first_sample: piece.samples.start as u32,
            chunk_bits: self.records.bits,
            ..Step::default()
        };
        let groups = |piece: &Piece| n_groups(piece.voxels.len() as u64, BLOCK);
        let [params, transfer] = [&self.params, &self.transfer].map(Buffer::all);
        let [sums, totals] = [&self.sums.elements, &self.sums.totals].map(Buffer::all);
        for (piece, samples) in pieces {
            let bindings = [params, samples.all(), transfer, sums];
            passes.push(&CLASSIFY_COUNT, &bindings, step(piece), groups(piece));
        }
        self.sums.scan(passes, counts, n_blocks(layer), self.count_slot);
        for (piece, samples) in pieces {
            let mut bindings = vec![params, samples.all(), transfer, sums, totals];
            bindings.extend(self.records.all());
            passes.push(&CLASSIFY_EMIT, &bindings, step(piece), groups(piece));
        }
        self.made_for = Some((layer.known.clone(), layer.classification.clone()));
    }

    /// Gives everything back.
    pub(crate) fn forget<D: Device>(&mut self, memory: &mut Memory, device: &mut D) {
        self.made_for = None;
        memory.free_all(device, self.records.buffers().chain(self.sums.buffers()));
        memory.free_all(device, [&mut self.params, &mut self.transfer].into_iter());
    }
}

/// Blocks of a layer's voxels.
fn n_blocks(layer: &JobLayer) -> u64 {
    n_groups(layer.known.volume.grid().n_voxels() as u64, BLOCK).into()
}
