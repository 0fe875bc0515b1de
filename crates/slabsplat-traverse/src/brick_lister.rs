//! The relevant voxels of one brick, for those who want some bricks and not the list of all
//! ([`RelevantList`](crate::RelevantList)).

use crate::gradient::{Normals, Real, is_narrow};
use crate::membership::{BrickMask, Membership};
use crate::order::Ordered;
use crate::relevant_update::{add_in_brick, met};
use crate::{BrickGrid, BrickRanges, VoxelRecord, VoxelRules};
use rayon::prelude::*;
use slabsplat_core::{Cancelled, FrameHandle, IsoRange, SampleType, Volume, with_samples};
use std::fmt;
use std::ops::Range;

/// Lists the voxels of single bricks. Cheap to make, but for thousands of labels.
pub struct BrickLister<'a> {
    lists: Box<dyn ListsBricks + Sync + 'a>,
    brick_ranges: &'a BrickRanges,
    grid: BrickGrid,
    ranges: &'a [IsoRange],
    /// Whether a brick whose values are all relevant holds relevant voxels alone: nothing else decides, and
    /// none is NaN.
    ranges_suffice: bool,
}

/// What there is for every type of samples.
trait ListsBricks {
    fn mask(&self, brick_idx: u32, ranges: Range<usize>) -> BrickMask;

    fn fill(&self, mask: &BrickMask, origin: [usize; 3], records: &mut [VoxelRecord]);
}

struct OfSamples<'a, T, F> {
    membership: Membership<'a, T>,
    normals: Normals<'a, T, F>,
}

impl<T: Ordered, F: Real + Sync> ListsBricks for OfSamples<'_, T, F> {
    fn mask(&self, brick_idx: u32, ranges: Range<usize>) -> BrickMask {
        self.membership.of_brick(brick_idx, ranges)
    }

    fn fill(&self, mask: &BrickMask, origin: [usize; 3], records: &mut [VoxelRecord]) {
        add_in_brick(mask, origin, &self.normals, 0, 0, records);
    }
}

impl<'a> BrickLister<'a> {
    /// Lists voxels with values in `ranges` (disjoint, rising), and with `rules` those alone that are visible
    /// by them, as [`RelevantList::update`](crate::RelevantList::update) does. `brick_ranges` are those of
    /// `volume`.
    pub fn new(
        volume: &'a Volume,
        brick_ranges: &'a BrickRanges,
        ranges: &'a [IsoRange],
        rules: Option<&VoxelRules<'a>>,
    ) -> Self {
        let grid = BrickGrid::new(volume.grid());
        let lists = with_samples!(volume.samples(), |s| {
            let membership = Membership::new(volume, s, grid, ranges, rules);
            if is_narrow(volume) {
                let normals = Normals::<_, f32>::new(volume, s);
                Box::new(OfSamples { membership, normals }) as Box<dyn ListsBricks + Sync + 'a>
            } else {
                let normals = Normals::<_, f64>::new(volume, s);
                Box::new(OfSamples { membership, normals })
            }
        });
        let may_be_nan = matches!(volume.sample_type(), SampleType::F32 | SampleType::F64);
        let ranges_suffice = rules.is_none() && !may_be_nan;
        Self { lists, brick_ranges, grid, ranges, ranges_suffice }
    }

    /// Whether a brick has a value within the ranges; if so, it may hold relevant voxels.
    pub fn may_hold(&self, brick_idx: u32) -> bool {
        !met(self.ranges, self.brick_ranges.of_brick(brick_idx as usize)).is_empty()
    }

    /// Appends the relevant voxels of a brick to `records`, in memory order.
    pub fn list(&self, brick_idx: u32, records: &mut Vec<VoxelRecord>) {
        if !self.may_hold(brick_idx) {
            return;
        }
        let mask = self.mask(brick_idx);
        let first = records.len();
        records.resize(first + mask.count(), VoxelRecord::default());
        self.lists.fill(&mask, self.grid.origin(brick_idx), &mut records[first..]);
    }

    /// How many voxels of the volume are relevant, in parallel, for a frame. Bricks whose values are all
    /// within one range are not looked at.
    ///
    /// # Errors
    /// If the frame is cancelled.
    pub fn count_all(&self, frame: &FrameHandle) -> Result<u64, Cancelled> {
        let n_bricks = self.brick_ranges.n_bricks() as u32;
        let of_brick = |brick_idx: u32| {
            if frame.is_cancelled() || !self.may_hold(brick_idx) {
                return 0;
            }
            let n_voxels = match self.holds_all(brick_idx) {
                true => self.grid.size_at(self.grid.origin(brick_idx)).iter().product(),
                false => self.mask(brick_idx).count(),
            };
            n_voxels as u64
        };
        let n_voxels = (0..n_bricks).into_par_iter().with_min_len(256).map(of_brick).sum();
        frame.check().map(|()| n_voxels)
    }

    /// Whether all voxels of a brick are relevant, as far as its least and its largest value tell.
    fn holds_all(&self, brick_idx: u32) -> bool {
        let within = self.brick_ranges.of_brick(brick_idx as usize);
        let holds = |range: &IsoRange| range.lo <= within.lo && within.hi <= range.hi;
        self.ranges_suffice && self.ranges.iter().any(holds)
    }

    fn mask(&self, brick_idx: u32) -> BrickMask {
        let within = self.brick_ranges.of_brick(brick_idx as usize);
        self.lists.mask(brick_idx, met(self.ranges, within))
    }
}

impl fmt::Debug for BrickLister<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { grid, ranges, ranges_suffice, .. } = self;
        let mut fields = f.debug_struct("BrickLister");
        fields.field("grid", grid).field("ranges", ranges);
        fields.field("ranges_suffice", ranges_suffice).finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::RelevantList;
    use crate::tests::{random_ranges, random_volume};
    use slabsplat_seeds::for_each_seed;

    #[test]
    fn brick_lister_lists_what_the_list_has() {
        for_each_seed(1, |mut rng| {
            for _ in 0..40 {
                let volume = random_volume(&mut rng);
                let ranges = random_ranges(&mut rng, &volume);
                let brick_ranges = BrickRanges::new(&volume);
                let mut list = RelevantList::default();
                list.update(&volume, &brick_ranges, &ranges, None);
                let lister = BrickLister::new(&volume, &brick_ranges, &ranges, None);
                let mut expected = list.bricks().iter().peekable();
                for brick_idx in 0..brick_ranges.n_bricks() as u32 {
                    let brick = expected.next_if(|brick| brick.brick_idx == brick_idx);
                    let mut records = vec![VoxelRecord::default()];
                    lister.list(brick_idx, &mut records);
                    assert_eq!(records[1..], *brick.map_or(&[][..], |brick| list.voxels_of(brick)));
                }
                assert_eq!(lister.count_all(&FrameHandle::new()), Ok(list.len() as u64));
            }
        });
    }
}
