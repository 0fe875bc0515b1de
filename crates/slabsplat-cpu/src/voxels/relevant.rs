//! The relevant voxels of the last plan, cached for the next one.

use slabsplat_backend::{ByIdentity, Cached};
use slabsplat_core::{IsoRange, Labels, PiecewiseLinear, TransferFunction, Volume};
use slabsplat_traverse::{BrickRanges, RelevantList, VoxelRules};
use std::sync::Arc;

/// What is cached between frames; nothing before the first.
#[derive(Debug, Default)]
pub(crate) struct Relevant(Cached<ByIdentity<Volume>, OfVolume>);

#[derive(Debug)]
struct OfVolume {
    brick_ranges: BrickRanges,
    /// What decides beside ranges which voxels are listed.
    rules: Option<OwnRules>,
    list: RelevantList,
}

type OwnRules = (TransferFunction, Option<Labels>, Option<PiecewiseLinear<1>>);

fn as_rules((transfer, labels, gradient_opacity): &OwnRules) -> VoxelRules<'_> {
    let (labels, gradient_opacity) = (labels.as_ref(), gradient_opacity.as_ref());
    VoxelRules { transfer, labels, gradient_opacity }
}

impl Relevant {
    /// The voxels of `volume` with values in `ranges` that are visible by these rules. The bricks of a new
    /// volume are looked through; new ranges change the list by their difference from the last ones.
    pub(crate) fn voxels(
        &mut self,
        volume: &Arc<Volume>,
        ranges: &[IsoRange],
        rules: &VoxelRules<'_>,
    ) -> &RelevantList {
        let of_volume = self.0.made_of(ByIdentity::of(volume), |_| OfVolume {
            brick_ranges: BrickRanges::new(volume),
            rules: None,
            list: RelevantList::default(),
        });
        let OfVolume { brick_ranges, rules: listed_by, list } = of_volume;
        let rules = (!rules.are_by_value()).then_some(rules);
        if listed_by.as_ref().map(as_rules) != rules.copied() {
            *listed_by = rules.map(|&VoxelRules { transfer, labels, gradient_opacity }| {
                (transfer.clone(), labels.cloned(), gradient_opacity.cloned())
            });
            *list = RelevantList::default();
        }
        if list.ranges() != ranges {
            list.update(volume, brick_ranges, ranges, rules);
        }
        list
    }

    /// Bytes held beside the volume.
    pub(crate) fn resident_bytes(&self) -> usize {
        let bytes = |of: &OfVolume| of.brick_ranges.resident_bytes() + of.list.resident_bytes();
        self.0.value().map_or(0, bytes)
    }
}
