//! The passes by which the device finds the relevant voxels of a layer among the samples that it holds.

use crate::chunks::Chunks;
use crate::classification::Classification;
use crate::known_volume::KnownVolume;
use crate::memory::{Buffer, Memory};
use crate::params::Step;
use crate::pass_list::{PassList, n_groups};
use crate::samples::{Piece, VOXELS_PER_BLOCK};
use crate::sums::{BLOCK, Sums};
use crate::{Device, Slice, Write};
use slabsplat_backend::BackendError;
use slabsplat_shaders::{CLASSIFY_COUNT, CLASSIFY_EMIT};

const _: () = assert!(VOXELS_PER_BLOCK == BLOCK as usize, "a block's count is one to be summed");

/// What the device needs for that beside samples.
#[derive(Debug)]
pub(crate) struct Classifier {
    params: Buffer,
    transfer: Buffer,
    sums: Sums,
}

impl Classifier {
    pub(crate) fn new() -> Self {
        Self {
            params: Buffer::new("volume parameters"),
            transfer: Buffer::new("transfer function"),
            sums: Sums::new("relevant counts", "relevant totals"),
        }
    }

    /// Sees to it that there is room, and writes what voxels are classified by.
    pub(crate) fn prepare<'a, D: Device>(
        &mut self,
        (memory, device): (&mut Memory, &mut D),
        known: &KnownVolume,
        classification: &'a Classification,
        writes: &mut Vec<Write<'a>>,
    ) -> Result<(), BackendError> {
        let Classification { params, transfer, .. } = classification;
        let (params, transfer) = (bytemuck::bytes_of(params), bytemuck::cast_slice(transfer));
        memory.grow(device, &mut self.params, params.len() as u64)?;
        memory.grow(device, &mut self.transfer, transfer.len() as u64)?;
        self.sums.grow(memory, device, n_blocks(known))?;
        for (buffer, bytes) in [(&self.params, params), (&self.transfer, transfer)] {
            writes.push(Write { buffer: buffer.all().buffer, offset: 0, bytes: bytes.into() });
        }
        Ok(())
    }

    /// Pushes the passes that write the records of a volume's relevant voxels, whose samples are in these
    /// pieces, and count them.
    pub(crate) fn push_passes(
        &self,
        known: &KnownVolume,
        pieces: &[(Piece, Buffer)],
        records: &Chunks,
        (counts, count_slot): (Slice, u32),
        passes: &mut PassList,
    ) {
        let step = |piece: &Piece| Step {
            first: piece.voxels.start as u32,
            n_elements: piece.voxels.len() as u32,
            first_block: (piece.voxels.start / VOXELS_PER_BLOCK) as u32,
            first_sample: piece.samples.start as u32,
            chunk_bits: records.bits,
            ..Step::default()
        };
        let groups = |piece: &Piece| n_groups(piece.voxels.len() as u64, BLOCK);
        let [params, transfer] = [&self.params, &self.transfer].map(Buffer::all);
        let [sums, totals] = [&self.sums.elements, &self.sums.totals].map(Buffer::all);
        for (piece, samples) in pieces {
            let bindings = [params, samples.all(), transfer, sums];
            passes.push(&CLASSIFY_COUNT, &bindings, step(piece), groups(piece));
        }
        self.sums.scan(passes, counts, n_blocks(known), count_slot);
        for (piece, samples) in pieces {
            let mut bindings = vec![params, samples.all(), transfer, sums, totals];
            bindings.extend(records.all());
            passes.push(&CLASSIFY_EMIT, &bindings, step(piece), groups(piece));
        }
    }

    /// Gives everything back.
    pub(crate) fn forget<D: Device>(&mut self, memory: &mut Memory, device: &mut D) {
        let Self { params, transfer, sums } = self;
        memory.free_all(device, [params, transfer].into_iter().chain(sums.buffers()));
    }
}

/// Blocks of a volume's voxels.
fn n_blocks(known: &KnownVolume) -> u64 {
    n_groups(known.volume.grid().n_voxels() as u64, BLOCK).into()
}
