//! The relevant voxels of the last plan, cached for the next one: a list of all, or bricks that are made when
//! they are seen.

use slabsplat_backend::{ByIdentity, Cached, ColorSplats, FramePlan, LayerPlan, Splats};
use slabsplat_core::{Cancelled, FrameHandle, IsoRange, StageError, Volume};
use slabsplat_traverse::{
    BrickLister, BrickRanges, BricksOnDemand, OwnVoxelRules, RelevantList, VoxelRecord, VoxelRules,
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
    n_voxels: Cached<ListedBy, u64>,
    list: RelevantList,
    on_demand: Cached<MadeBy, BricksOnDemand>,
}

/// How the relevant voxels of a layer are had.
#[derive(Debug)]
pub(crate) enum RelevantVoxels<'a> {
    /// All of them, listed.
    Listed(&'a RelevantList),
    /// Brick by brick, where cells may be drawn instead, or a list would have no room.
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

/// What decides which voxels of a volume are relevant.
type ListedBy = (OwnVoxelRules, Vec<IsoRange>);

/// What bricks depend on beside the volume: rules, ranges, and which cells have second moments.
type MadeBy = (ListedBy, f32);

/// Bricks that are made when they are seen, and what makes them.
#[derive(Debug)]
pub(crate) struct OnDemand<'a> {
    pub(crate) bricks: &'a BricksOnDemand,
    pub(crate) lister: BrickLister<'a>,
    /// The extinction of cells from which they have second moments.
    pub(crate) moments_from: f32,
}

/// What may be retained of a volume's relevant voxels.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Budget {
    /// Nothing, as where they serve one frame.
    Nothing,
    /// A quarter of what the volume takes, so that it fits where that does, and as much of small ones.
    Quarter {
        /// What is that of small ones.
        least_bytes: usize,
    },
}

impl Default for Budget {
    /// Some million voxels or cells.
    fn default() -> Self {
        Self::Quarter { least_bytes: 64 << 20 }
    }
}

impl Budget {
    /// That of a frame: a part is drawn once, within a budget of its caller's (model §17).
    pub(crate) fn of(self, plan: &FramePlan<'_>) -> Self {
        if plan.part.is_some() { Self::Nothing } else { self }
    }

    fn bytes(self, volume: &Volume) -> usize {
        let of_samples = volume.grid().n_voxels() * volume.sample_type().size_bytes();
        match self {
            Self::Nothing => 0,
            Self::Quarter { least_bytes } => (of_samples / 4).max(least_bytes),
        }
    }

    /// Whether a list of so many voxels may be retained.
    fn has_room(self, volume: &Volume, n_voxels: u64) -> bool {
        n_voxels * size_of::<VoxelRecord>() as u64 <= self.bytes(volume) as u64
    }
}

impl Relevant {
    /// The voxels of a layer that are visible by these rules. The bricks of a new volume are looked through.
    pub(crate) fn voxels<'a>(
        &'a mut self,
        layer: &LayerPlan<'a>,
        ranges: &'a [IsoRange],
        rules: &VoxelRules<'a>,
        budget: Budget,
        frame: &FrameHandle,
    ) -> Result<RelevantVoxels<'a>, StageError> {
        let of_volume = self.of_volume(layer.volume, frame)?;
        let takes_bricks = matches!(layer.splats, Splats::Colors(ColorSplats::Sections(_)));
        let of_list = (layer.volume.as_ref(), ranges, rules);
        let is_on_demand = takes_bricks
            && (layer.coarser.is_some() || !of_volume.has_room_for_list(of_list, budget, frame)?);
        if is_on_demand {
            // Of all levels it is the same.
            let by_mean_normals = layer.coarser.as_ref().map(|cells| cells.limits.by_mean_normals);
            let moments_from = by_mean_normals.unwrap_or(f64::INFINITY) as f32;
            let on_demand = of_volume.on_demand(of_list, moments_from, budget, frame)?;
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
                n_voxels: Cached::default(),
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

    /// Whether all relevant voxels may be listed. Of a small volume all may be, whichever they are.
    fn has_room_for_list<'a>(
        &mut self,
        of_list: (&'a Volume, &'a [IsoRange], &VoxelRules<'a>),
        budget: Budget,
        frame: &FrameHandle,
    ) -> Result<bool, Cancelled> {
        let (volume, ..) = of_list;
        let has_room = |n_voxels: u64| budget.has_room(volume, n_voxels);
        if has_room(volume.grid().n_voxels() as u64) {
            return Ok(true);
        }
        self.n_voxels(of_list, frame).map(has_room)
    }

    fn n_voxels<'a>(
        &mut self,
        (volume, ranges, rules): (&'a Volume, &'a [IsoRange], &VoxelRules<'a>),
        frame: &FrameHandle,
    ) -> Result<u64, Cancelled> {
        let Self { n_voxels, brick_ranges, .. } = self;
        let lister = lister(volume, brick_ranges, ranges, rules);
        let listed_by = (OwnVoxelRules::new(rules), ranges.to_vec());
        n_voxels.try_made_of(listed_by, |_| lister.count_all(frame)).copied()
    }

    fn on_demand<'a>(
        &'a mut self,
        of_list: (&'a Volume, &'a [IsoRange], &VoxelRules<'a>),
        moments_from: f32,
        budget: Budget,
        frame: &FrameHandle,
    ) -> Result<OnDemand<'a>, Cancelled> {
        let n_voxels = self.n_voxels(of_list, frame)?;
        let (volume, ranges, rules) = of_list;
        (self.rules, self.list) = (None, RelevantList::default());
        let made_by = ((OwnVoxelRules::new(rules), ranges.to_vec()), moments_from);
        let new = |_: &_| BricksOnDemand::new(volume.grid(), n_voxels, budget.bytes(volume));
        let bricks = self.on_demand.made_of(made_by, new);
        bricks.start_frame();
        let lister = lister(volume, &self.brick_ranges, ranges, rules);
        Ok(OnDemand { bricks, lister, moments_from })
    }
}

fn lister<'a>(
    volume: &'a Volume,
    brick_ranges: &'a BrickRanges,
    ranges: &'a [IsoRange],
    rules: &VoxelRules<'a>,
) -> BrickLister<'a> {
    BrickLister::new(volume, brick_ranges, ranges, (!rules.are_by_value()).then_some(rules))
}
