//! Volumes on the device: their samples, which stay there for as long as jobs are about them.

use crate::job::Job;
use crate::known_volume::KnownVolume;
use crate::memory::{Buffer, Memory, too_large};
use crate::samples::{Piece, pieces};
use crate::{Device, Write};
use slabsplat_backend::BackendError;
use std::sync::Arc;

/// The volumes of the last job whose samples are looked at, each once.
#[derive(Debug, Default)]
pub(crate) struct Volumes {
    resident: Vec<Resident>,
}

/// A volume on the device.
#[derive(Debug)]
struct Resident {
    known: Arc<KnownVolume>,
    pieces: Vec<(Piece, Buffer)>,
}

impl Volumes {
    /// Frees all but a job's, and takes those that are not there.
    pub(crate) fn update<'a, D: Device>(
        &mut self,
        (memory, device): (&mut Memory, &mut D),
        job: &'a Job,
        writes: &mut Vec<Write<'a>>,
    ) -> Result<(), BackendError> {
        let needed = || job.layers.iter().filter_map(|layer| layer.listing.samples());
        let is_needed =
            |resident: &mut Resident| needed().any(|known| Arc::ptr_eq(known, &resident.known));
        for mut old in self.resident.extract_if(.., |resident| !is_needed(resident)) {
            old.free(memory, device);
        }
        for known in needed() {
            if self.index_of(known).is_none() {
                self.resident.push(Resident { known: known.clone(), pieces: Vec::new() });
                let pieces = &mut self.resident.last_mut().expect("one was pushed").pieces;
                take((memory, device), known, pieces, writes)?;
            }
        }
        Ok(())
    }

    /// The pieces of a volume that is there.
    pub(crate) fn pieces(&self, known: &Arc<KnownVolume>) -> &[(Piece, Buffer)] {
        self.index_of(known).map_or(&[], |idx| &self.resident[idx].pieces)
    }

    /// Gives everything back.
    pub(crate) fn forget<D: Device>(&mut self, memory: &mut Memory, device: &mut D) {
        for mut resident in self.resident.drain(..) {
            resident.free(memory, device);
        }
    }

    fn index_of(&self, known: &Arc<KnownVolume>) -> Option<usize> {
        self.resident.iter().position(|resident| Arc::ptr_eq(&resident.known, known))
    }
}

impl Resident {
    fn free<D: Device>(&mut self, memory: &mut Memory, device: &mut D) {
        memory.free_all(device, self.pieces.iter_mut().map(|(_, buffer)| buffer));
    }
}

/// Sends a volume to buffers that are added to `held`.
fn take<'a, D: Device>(
    (memory, device): (&mut Memory, &mut D),
    known: &'a Arc<KnownVolume>,
    held: &mut Vec<(Piece, Buffer)>,
    writes: &mut Vec<Write<'a>>,
) -> Result<(), BackendError> {
    let what = "samples";
    let most = device.info().max_binding_bytes.min(device.info().max_buffer_bytes);
    let pieces =
        pieces(&known.volume, most).map_err(|needed| too_large(device, what, needed, most))?;
    for piece in pieces {
        let mut buffer = Buffer::new(what);
        memory.grow(device, &mut buffer, piece.n_bytes(&known.volume))?;
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
