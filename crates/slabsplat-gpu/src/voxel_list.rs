//! The relevant voxels of a layer on the device: a record each, and how many there are.

use crate::chunks::Chunks;
use crate::classifier::Classifier;
use crate::job::JobLayer;
use crate::listing::{HostRecords, Listing, ListingName};
use crate::memory::Memory;
use crate::params::{COUNT_OF_LISTS, RECORD_BYTES};
use crate::pass_list::PassList;
use crate::uploads::Uploads;
use crate::volumes::Volumes;
use crate::{Device, DeviceInfo, Slice, Write};
use slabsplat_backend::BackendError;
use slabsplat_core::FrameHandle;

/// What its records are called where there is no room for them.
const LABEL: &str = "relevant voxels";

/// The relevant voxels of a layer of the last job, and by what they were listed.
#[derive(Debug)]
pub(crate) struct VoxelList {
    listed: Option<ListingName>,
    classifier: Classifier,
    pub(crate) records: Chunks,
    /// Where it is counted how many there are.
    pub(crate) count_slot: u32,
}

/// What goes ahead of a frame's own passes, to which each list that is made adds.
pub(crate) struct Preamble<'m, 'a> {
    pub(crate) volumes: &'m Volumes,
    pub(crate) counts: Slice,
    pub(crate) passes: &'m mut PassList,
    pub(crate) uploads: &'m mut Uploads,
    pub(crate) writes: &'m mut Vec<Write<'a>>,
    pub(crate) frame: &'m FrameHandle,
}

impl VoxelList {
    /// An empty list, with that number among all that there are.
    pub(crate) fn new(number: u32, info: &DeviceInfo) -> Self {
        Self {
            listed: None,
            classifier: Classifier::new(),
            records: Chunks::new(LABEL, RECORD_BYTES, info),
            count_slot: COUNT_OF_LISTS + number,
        }
    }

    /// Whether it is that of a layer.
    pub(crate) fn is_of(&self, layer: &JobLayer) -> bool {
        self.listed.as_ref().is_some_and(|listed| listed.is_of(&layer.listing))
    }

    /// Makes it that of a layer: by passes, or by records that are sent at once and go before all passes.
    pub(crate) fn make<'a, D: Device>(
        &mut self,
        (memory, device): (&mut Memory, &mut D),
        layer: &'a JobLayer,
        preamble: Preamble<'_, 'a>,
    ) -> Result<(), BackendError> {
        let Preamble { volumes, counts, passes, uploads, writes, frame } = preamble;
        self.listed = None;
        self.records.grow(memory, device, layer.max_voxels)?;
        match &layer.listing {
            Listing::ByDevice(known, classification) => {
                self.classifier.prepare((memory, device), known, classification, writes)?;
                let (pieces, count) = (volumes.pieces(known), (counts, self.count_slot));
                self.classifier.push_passes(known, pieces, &self.records, count, passes);
            }
            Listing::ByHost(records) => {
                self.classifier.forget(memory, device);
                self.send(device, records, uploads, frame)?;
                writes.push(self.count(counts, records));
            }
        }
        self.listed = Some(layer.listing.name());
        Ok(())
    }

    /// Sends all records, for a frame.
    fn send<D: Device>(
        &self,
        device: &mut D,
        records: &HostRecords,
        uploads: &mut Uploads,
        frame: &FrameHandle,
    ) -> Result<(), BackendError> {
        records.for_each_piece(frame, |piece| {
            frame.check()?;
            let bytes = bytemuck::cast_slice(&piece.records);
            let writes = self.records.writes(piece.first, bytes);
            uploads.send(device, LABEL, writes)
        })
    }

    /// Writes how many records there are.
    fn count<'a>(&self, counts: Slice, records: &HostRecords) -> Write<'a> {
        let n_records = records.n_records() as u32;
        let offset = counts.offset + size_of_val(&n_records) as u64 * u64::from(self.count_slot);
        let bytes = bytemuck::bytes_of(&n_records).to_vec().into();
        Write { buffer: counts.buffer, offset, bytes }
    }

    /// Gives everything back.
    pub(crate) fn forget<D: Device>(&mut self, memory: &mut Memory, device: &mut D) {
        self.listed = None;
        memory.free_all(device, self.records.buffers());
        self.classifier.forget(memory, device);
    }
}
