//! The relevant voxels of the last plan, cached for the next one: a list of all, or bricks that are made when
//! they are seen.

use slabsplat_backend::{ByIdentity, Cached, LayerPlan};
use slabsplat_core::{Cancelled, FrameHandle, IsoRange, StageError, Volume};
use slabsplat_traverse::{
    BrickLister, BrickRanges, BricksOnDemand, OwnVoxelRules, RelevantList, VoxelRules,
};
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
    on_demand: Cached<MadeBy, BricksOnDemand>,
}

/// How the relevant voxels of a layer are had.
#[derive(Debug)]
pub(crate) enum RelevantVoxels<'a> {
    /// All of them, listed.
    Listed(&'a RelevantList),
    /// Brick by brick, where cells may be drawn instead.
    OnDemand(OnDemand<'a>),
}

impl RelevantVoxels<'_> {
    /// How many they are.
    pub(crate) fn n_voxels(&self) -> u64 {
        match self {
            Self::Listed(list) => list.len() as u64,
            Self::OnDemand(on_demand) => on_demand.bricks.n_voxels(),
        }
    }
}

/// What bricks depend on beside the volume: rules, ranges, and which cells have second moments.
type MadeBy = (OwnVoxelRules, Vec<IsoRange>, f32);

/// Bricks that are made when they are seen, and what makes them.
#[derive(Debug)]
pub(crate) struct OnDemand<'a> {
    pub(crate) bricks: &'a BricksOnDemand,
    pub(crate) lister: BrickLister<'a>,
    /// The extinction of cells from which they have second moments.
    pub(crate) moments_from: f32,
}

/// What bricks that are made on demand may take: a quarter of what the volume does, so that they fit where
/// that does.
const BUDGET_SHARE: usize = 4;

/// And as much of small ones: some million cells.
const LEAST_BUDGET_BYTES: usize = 64 << 20;

impl Relevant {
    /// The voxels of a layer that are visible by these rules. The bricks of a new volume are looked through.
    pub(crate) fn voxels<'a>(
        &'a mut self,
        layer: &LayerPlan<'a>,
        ranges: &'a [IsoRange],
        rules: &VoxelRules<'a>,
        frame: &FrameHandle,
    ) -> Result<RelevantVoxels<'a>, StageError> {
        let of_volume = self.of_volume(layer.volume, frame)?;
        if let Some(cells) = &layer.coarser {
            // Of all levels it is the same.
            let by = (rules, cells.limits.by_mean_normals as f32);
            let on_demand = of_volume.on_demand(layer.volume, ranges, by, frame)?;
            return Ok(RelevantVoxels::OnDemand(on_demand));
        }
        of_volume.listed(layer.volume, ranges, rules, frame).map(RelevantVoxels::Listed)
    }

    fn of_volume(
        &mut self,
        volume: &Arc<Volume>,
        frame: &FrameHandle,
    ) -> Result<&mut OfVolume, Cancelled> {
        self.0.try_made_of(ByIdentity::of(volume), |_| {
            Ok(OfVolume {
                brick_ranges: BrickRanges::for_frame(volume, frame)?,
                rules: None,
                list: RelevantList::default(),
                on_demand: Cached::default(),
            })
        })
    }

    /// Bytes held beside the volume.
    pub(crate) fn resident_bytes(&self) -> usize {
        let bytes = |of: &OfVolume| {
            let on_demand = of.on_demand.value().map_or(0, BricksOnDemand::resident_bytes);
            of.brick_ranges.resident_bytes() + of.list.resident_bytes() + on_demand
        };
        self.0.value().map_or(0, bytes)
    }
}

impl OfVolume {
    /// New ranges change the list by their difference from the last ones.
    fn listed(
        &mut self,
        volume: &Volume,
        ranges: &[IsoRange],
        rules: &VoxelRules<'_>,
        frame: &FrameHandle,
    ) -> Result<&RelevantList, StageError> {
        self.on_demand = Cached::default();
        let rules = (!rules.are_by_value()).then_some(rules);
        if self.rules.as_ref().map(OwnVoxelRules::rules) != rules.copied() {
            self.rules = rules.map(OwnVoxelRules::new);
            self.list = RelevantList::default();
        }
        if self.list.ranges() != ranges {
            self.list.update_for_frame(volume, &self.brick_ranges, ranges, rules, frame)?;
        }
        Ok(&self.list)
    }

    fn on_demand<'a>(
        &'a mut self,
        volume: &'a Volume,
        ranges: &'a [IsoRange],
        (rules, moments_from): (&VoxelRules<'a>, f32),
        frame: &FrameHandle,
    ) -> Result<OnDemand<'a>, Cancelled> {
        (self.rules, self.list) = (None, RelevantList::default());
        let decide = (!rules.are_by_value()).then_some(rules);
        let lister = BrickLister::new(volume, &self.brick_ranges, ranges, decide);
        let made_by = (OwnVoxelRules::new(rules), ranges.to_vec(), moments_from);
        let bricks = self.on_demand.try_made_of(made_by, |_| {
            let of_samples = volume.grid().n_voxels() * volume.sample_type().size_bytes();
            let budget = (of_samples / BUDGET_SHARE).max(LEAST_BUDGET_BYTES);
            let n_voxels = lister.count_all(frame)?;
            Ok(BricksOnDemand::new(volume.grid(), n_voxels, budget))
        })?;
        bricks.start_frame();
        Ok(OnDemand { bricks, lister, moments_from })
    }
}
