//! The relevant voxels on the device: `L_r` of the paper's §4, made by the device itself from samples that
//! stay there. A new transfer function sends its points, nothing else.

use crate::chunks::Chunks;
use crate::classification::Classification;
use crate::job::{Job, KnownVolume};
use crate::memory::{Buffer, Memory, too_large};
use crate::params::{COUNT_VOXELS, RECORD_BYTES, Step};
use crate::pass_list::{PassList, StepBuffer, n_groups};
use crate::samples::{Piece, VOXELS_PER_BLOCK, pieces};
use crate::sums::{BLOCK, Sums};
use crate::{Device, DeviceInfo, Pass, Slice, Write};
use slabsplat_backend::BackendError;
use slabsplat_shaders::{CLASSIFY_COUNT, CLASSIFY_EMIT};
use std::sync::Arc;

const _: () = assert!(VOXELS_PER_BLOCK == BLOCK as usize, "a block's count is one to be summed");

/// A volume on the device.
#[derive(Debug)]
struct Resident {
    known: Arc<KnownVolume>,
    pieces: Vec<(Piece, Buffer)>,
}

/// The relevant voxels of the last job, and what they were made from.
#[derive(Debug)]
pub(crate) struct VoxelList {
    volume: Option<Resident>,
    made_for: Option<Classification>,
    steps: StepBuffer,
    params: Buffer,
    transfer: Buffer,
    sums: Sums,
    pub(crate) records: Chunks,
}

impl VoxelList {
    pub(crate) fn new(info: &DeviceInfo) -> Self {
        Self {
            volume: None,
            made_for: None,
            steps: StepBuffer::new(),
            params: Buffer::new("volume parameters"),
            transfer: Buffer::new("transfer function"),
            sums: Sums::new("relevant counts", "relevant totals"),
            records: Chunks::new("relevant voxels", RECORD_BYTES, info),
        }
    }

    /// The passes that leave the job's relevant voxels in `records`, and what must be written before; none
    /// if that is what is there.
    pub(crate) fn passes<'a, D: Device>(
        &mut self,
        (memory, device): (&mut Memory, &mut D),
        job: &'a Job,
        counts: Slice,
        writes: &mut Vec<Write<'a>>,
    ) -> Result<Vec<Pass>, BackendError> {
        let has_volume = self.volume.as_ref().is_some_and(|v| Arc::ptr_eq(&v.known, &job.known));
        if has_volume && self.made_for.as_ref() == Some(&job.classification) {
            return Ok(Vec::new());
        }
        self.made_for = None;
        if !has_volume {
            self.forget_volume(memory, device);
            self.take_volume(memory, device, &job.known, writes)?;
        }
        let transfer: &[u8] = bytemuck::cast_slice(&job.classification.transfer);
        memory.grow(device, &mut self.params, size_of_val(&job.classification.params) as u64)?;
        memory.grow(device, &mut self.transfer, transfer.len() as u64)?;
        self.records.grow(memory, device, job.max_voxels)?;
        let n_voxels = job.known.volume.grid().n_voxels() as u64;
        let n_blocks = u64::from(n_groups(n_voxels, BLOCK));
        self.sums.grow(memory, device, n_blocks)?;
        let params = bytemuck::bytes_of(&job.classification.params);
        for (buffer, bytes) in [(&self.params, params), (&self.transfer, transfer)] {
            writes.push(Write { buffer: buffer.all().buffer, offset: 0, bytes: bytes.into() });
        }
        let mut passes = self.steps.list(memory, device)?;
        self.push_passes(counts, n_blocks, &mut passes);
        self.made_for = Some(job.classification.clone());
        Ok(self.steps.finish(passes, writes))
    }

    /// Gives everything back. What was promised did not happen, so the next job begins anew.
    pub(crate) fn forget<D: Device>(&mut self, memory: &mut Memory, device: &mut D) {
        self.made_for = None;
        self.forget_volume(memory, device);
        memory.free_all(device, self.records.buffers().chain(self.sums.buffers()));
        let others = [&mut self.params, &mut self.transfer, self.steps.emptied()];
        memory.free_all(device, others.into_iter());
    }

    fn forget_volume<D: Device>(&mut self, memory: &mut Memory, device: &mut D) {
        for (_, mut buffer) in self.volume.take().into_iter().flat_map(|v| v.pieces) {
            memory.free(device, &mut buffer);
        }
    }

    fn take_volume<'a, D: Device>(
        &mut self,
        memory: &mut Memory,
        device: &mut D,
        known: &'a Arc<KnownVolume>,
        writes: &mut Vec<Write<'a>>,
    ) -> Result<(), BackendError> {
        let what = "samples";
        let most = device.info().max_binding_bytes.min(device.info().max_buffer_bytes);
        let pieces =
            pieces(&known.volume, most).map_err(|needed| too_large(device, what, needed, most))?;
        let resident = Resident { known: known.clone(), pieces: Vec::new() };
        let held = &mut self.volume.insert(resident).pieces;
        for piece in pieces {
            let mut buffer = Buffer::new(what);
            let grown = memory.grow(device, &mut buffer, piece.n_bytes(&known.volume));
            if let Err(error) = grown {
                self.forget_volume(memory, device);
                return Err(error);
            }
            let mut offset = 0;
            for bytes in piece.bytes(&known.volume).into_iter().filter(|bytes| !bytes.is_empty()) {
                let n_bytes = bytes.len() as u64;
                writes.push(Write { buffer: buffer.all().buffer, offset, bytes });
                offset += n_bytes;
            }
            held.push((piece, buffer));
        }
        Ok(())
    }

    fn push_passes(&self, counts: Slice, n_blocks: u64, passes: &mut PassList) {
        let pieces = self.volume.as_ref().map_or(&[][..], |volume| &volume.pieces);
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
        passes.begin("classify");
        for (piece, samples) in pieces {
            let bindings = [params, samples.all(), transfer, sums];
            passes.push(&CLASSIFY_COUNT, &bindings, step(piece), groups(piece));
        }
        self.sums.scan(passes, counts, n_blocks, COUNT_VOXELS);
        for (piece, samples) in pieces {
            let mut bindings = vec![params, samples.all(), transfer, sums, totals];
            bindings.extend(self.records.all());
            passes.push(&CLASSIFY_EMIT, &bindings, step(piece), groups(piece));
        }
    }
}
