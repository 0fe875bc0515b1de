//! The relevant voxels of the last plan, cached for the next one.

use slabsplat_backend::{ByIdentity, Cached};
use slabsplat_core::{IsoRange, Labels, TransferFunction, Volume};
use slabsplat_traverse::{BrickRanges, LabelRanges, RelevantList};
use std::sync::Arc;

/// What is cached between frames; nothing before the first.
#[derive(Debug, Default)]
pub(crate) struct Relevant(Cached<ByIdentity<Volume>, OfVolume>);

#[derive(Debug)]
struct OfVolume {
    brick_ranges: BrickRanges,
    /// What decides beside ranges which voxels are listed.
    by_label: Option<(TransferFunction, Labels)>,
    list: RelevantList,
}

impl Relevant {
    /// The voxels of `volume` with values in `ranges`, and labels that are visible there. The bricks of a new
    /// volume are looked through; new ranges change the list by their difference from the last ones.
    pub(crate) fn voxels(
        &mut self,
        volume: &Arc<Volume>,
        ranges: &[IsoRange],
        labels: Option<LabelRanges<'_>>,
    ) -> &RelevantList {
        let of_volume = self.0.made_of(ByIdentity::of(volume), |_| OfVolume {
            brick_ranges: BrickRanges::new(volume),
            by_label: None,
            list: RelevantList::default(),
        });
        let OfVolume { brick_ranges, by_label, list } = of_volume;
        let listed_by = by_label.as_ref().map(|(transfer, labels)| (transfer, labels));
        if listed_by != labels.map(|LabelRanges { labels, transfer }| (transfer, labels)) {
            *by_label =
                labels.map(|LabelRanges { labels, transfer }| (transfer.clone(), labels.clone()));
            *list = RelevantList::default();
        }
        if list.ranges() != ranges {
            list.update(volume, brick_ranges, ranges, labels);
        }
        list
    }

    /// Bytes held beside the volume.
    pub(crate) fn resident_bytes(&self) -> usize {
        let bytes = |of: &OfVolume| of.brick_ranges.resident_bytes() + of.list.resident_bytes();
        self.0.value().map_or(0, bytes)
    }
}
