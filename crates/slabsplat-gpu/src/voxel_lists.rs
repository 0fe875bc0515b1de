//! The relevant voxels of all layers: a list each, which is made anew only if it is that of no layer before.

use crate::job::Job;
use crate::memory::Memory;
use crate::pass_list::StepBuffer;
use crate::uploads::Uploads;
use crate::volumes::Volumes;
use crate::voxel_list::{Preamble, VoxelList};
use crate::{Device, Pass, Slice, Write};
use slabsplat_backend::BackendError;
use slabsplat_core::FrameHandle;

/// The lists of the last job, in the order of its layers.
#[derive(Debug)]
pub(crate) struct VoxelLists {
    pub(crate) lists: Vec<VoxelList>,
    volumes: Volumes,
    steps: StepBuffer,
    uploads: Uploads,
}

impl VoxelLists {
    pub(crate) fn new() -> Self {
        Self {
            lists: Vec::new(),
            volumes: Volumes::default(),
            steps: StepBuffer::new(),
            uploads: Uploads::default(),
        }
    }

    /// The passes that leave the relevant voxels of a job's layers in the lists, and what must be written
    /// before; none if that is what is there. Records that the host has made are sent at once.
    pub(crate) fn passes<'a, D: Device>(
        &mut self,
        (memory, device): (&mut Memory, &mut D),
        (job, frame): (&'a Job, &FrameHandle),
        counts: Slice,
        writes: &mut Vec<Write<'a>>,
    ) -> Result<Vec<Pass>, BackendError> {
        self.arrange((memory, device), job);
        self.volumes.update((memory, device), job, writes)?;
        let Self { lists, volumes, steps, uploads } = self;
        let of_layers = || lists.iter().zip(&job.layers);
        if of_layers().all(|(list, layer)| list.is_of(layer)) {
            return Ok(Vec::new());
        }
        let mut passes = steps.list(memory, device)?;
        passes.begin("classify");
        for (list, layer) in lists.iter_mut().zip(&job.layers) {
            if !list.is_of(layer) {
                let passes = &mut passes;
                let preamble = Preamble { volumes, counts, passes, uploads, writes, frame };
                list.make((memory, device), layer, preamble)?;
            }
        }
        Ok(steps.finish(passes, writes))
    }

    /// Notes which of the records that were sent have arrived.
    pub(crate) fn collect<D: Device>(&mut self, device: &mut D) {
        self.uploads.collect(device);
    }

    /// Gives everything back. What was promised did not happen, so the next job begins anew.
    pub(crate) fn forget<D: Device>(&mut self, memory: &mut Memory, device: &mut D) {
        self.volumes.forget(memory, device);
        for list in &mut self.lists {
            list.forget(memory, device);
        }
        memory.free(device, self.steps.emptied());
    }

    /// Makes lists as many as layers, and puts those that are made for one where it is.
    fn arrange<D: Device>(&mut self, (memory, device): (&mut Memory, &mut D), job: &Job) {
        let lists = &mut self.lists;
        for number in lists.len()..job.layers.len() {
            lists.push(VoxelList::new(number as u32, device.info()));
        }
        for (slot, layer) in job.layers.iter().enumerate() {
            let others = &lists[slot..];
            let is_free = |list: &VoxelList| !job.layers.iter().any(|layer| list.is_of(layer));
            let found = others.iter().position(|list| list.is_of(layer));
            let found = found.or_else(|| others.iter().position(is_free));
            lists.swap(slot, slot + found.unwrap_or(0));
        }
        for list in &mut lists[job.layers.len()..] {
            list.forget(memory, device);
        }
    }
}
