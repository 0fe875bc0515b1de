//! The relevant voxels of the last plan, kept for the next one.

use slabsplat_core::{IsoRange, Volume};
use slabsplat_traverse::{RelevantList, ValueOrder, VoxelRecord};
use std::sync::Arc;

/// What is kept between frames; nothing before the first.
#[derive(Debug, Default)]
pub(crate) struct Relevant {
    of: Option<OfVolume>,
}

#[derive(Debug)]
struct OfVolume {
    volume: Arc<Volume>,
    order: ValueOrder,
    list: RelevantList,
    /// What `list` was last made for.
    ranges: Vec<IsoRange>,
}

impl Relevant {
    /// The voxels of `volume` with values in `ranges`. A new volume is sorted by value; new ranges change
    /// the list by their difference from the last ones.
    pub(crate) fn voxels(&mut self, volume: &Arc<Volume>, ranges: &[IsoRange]) -> &[VoxelRecord] {
        if !self.of.as_ref().is_some_and(|of| Arc::ptr_eq(&of.volume, volume)) {
            // Dropped first: two volumes' lists need not fit at a time.
            self.of = None;
        }
        let of = self.of.get_or_insert_with(|| OfVolume::new(volume.clone()));
        if of.ranges != ranges {
            of.list.update(&of.volume, &of.order, ranges);
            of.ranges = ranges.to_vec();
        }
        of.list.records()
    }

    /// Bytes held beside the volume.
    pub(crate) fn resident_bytes(&self) -> usize {
        self.of
            .as_ref()
            .map_or(0, |of| size_of_val(of.order.voxel_idxs()) + size_of_val(of.list.records()))
    }
}

impl OfVolume {
    fn new(volume: Arc<Volume>) -> Self {
        let order = ValueOrder::new(&volume);
        Self { volume, order, list: RelevantList::default(), ranges: Vec::new() }
    }
}
