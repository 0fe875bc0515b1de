//! The relevant voxels of the last plan, cached for the next one.

use slabsplat_backend::{ByIdentity, Cached};
use slabsplat_core::{Cancelled, FrameHandle, IsoRange, Volume};
use slabsplat_traverse::{BrickRanges, OwnVoxelRules, RelevantList, VoxelRules};
use std::sync::Arc;

/// What is cached between frames; nothing before the first.
#[derive(Debug, Default)]
pub(crate) struct Relevant(Cached<ByIdentity<Volume>, OfVolume>);

#[derive(Debug)]
struct OfVolume {
    brick_ranges: BrickRanges,
    /// What decides beside ranges which voxels are listed.
    rules: Option<OwnVoxelRules>,
    list: RelevantList,
}

impl Relevant {
    /// The voxels of `volume` with values in `ranges` that are visible by these rules. The bricks of a new
    /// volume are looked through; new ranges change the list by their difference from the last ones.
    pub(crate) fn voxels(
        &mut self,
        volume: &Arc<Volume>,
        ranges: &[IsoRange],
        rules: &VoxelRules<'_>,
        frame: &FrameHandle,
    ) -> Result<&RelevantList, Cancelled> {
        let of_volume = self.0.try_made_of(ByIdentity::of(volume), |_| {
            let brick_ranges = BrickRanges::for_frame(volume, frame)?;
            Ok(OfVolume { brick_ranges, rules: None, list: RelevantList::default() })
        })?;
        let OfVolume { brick_ranges, rules: listed_by, list } = of_volume;
        let rules = (!rules.are_by_value()).then_some(rules);
        if listed_by.as_ref().map(OwnVoxelRules::rules) != rules.copied() {
            *listed_by = rules.map(OwnVoxelRules::new);
            *list = RelevantList::default();
        }
        if list.ranges() != ranges {
            list.update_for_frame(volume, brick_ranges, ranges, rules, frame)?;
        }
        Ok(list)
    }

    /// Bytes held beside the volume.
    pub(crate) fn resident_bytes(&self) -> usize {
        let bytes = |of: &OfVolume| of.brick_ranges.resident_bytes() + of.list.resident_bytes();
        self.0.value().map_or(0, bytes)
    }
}
