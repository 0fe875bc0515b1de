//! The relevant voxels of the last plan, kept for the next one.

use slabsplat_core::{IsoRange, Volume};
use slabsplat_traverse::{BrickRanges, RelevantList};
use std::sync::Arc;

/// What is kept between frames; nothing before the first.
#[derive(Debug, Default)]
pub(crate) struct Relevant {
    of: Option<OfVolume>,
}

#[derive(Debug)]
struct OfVolume {
    volume: Arc<Volume>,
    brick_ranges: BrickRanges,
    list: RelevantList,
}

impl Relevant {
    /// The voxels of `volume` with values in `ranges`. The bricks of a new volume are
    /// looked through; new ranges change the list by their difference from the last ones.
    pub(crate) fn voxels(&mut self, volume: &Arc<Volume>, ranges: &[IsoRange]) -> &RelevantList {
        if !self.of.as_ref().is_some_and(|of| Arc::ptr_eq(&of.volume, volume)) {
            // Dropped first: two volumes' lists need not fit at a time.
            self.of = None;
        }
        let of = self.of.get_or_insert_with(|| OfVolume::new(volume.clone()));
        if of.list.ranges() != ranges {
            of.list.update(&of.volume, &of.brick_ranges, ranges);
        }
        &of.list
    }

    /// Bytes held beside the volume.
    pub(crate) fn resident_bytes(&self) -> usize {
        self.of.as_ref().map_or(0, |of| of.brick_ranges.resident_bytes() + of.list.resident_bytes())
    }
}

impl OfVolume {
    fn new(volume: Arc<Volume>) -> Self {
        let brick_ranges = BrickRanges::new(&volume);
        Self { volume, brick_ranges, list: RelevantList::default() }
    }
}
