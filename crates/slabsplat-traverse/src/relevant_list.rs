//! `L_r`, the list of relevant voxels, and its update by difference (paper §4).
//!
//! The paper keeps the list in the order of values, where an iso-range is one run. Ours is stored brick by
//! brick, in memory order: neighbours in the list are then neighbours in space, so that gradients, shading
//! and the toss run through caches instead of around them, and a brick can be culled whole. A changed
//! range only touches bricks that hold values at its ends (`relevant_update.rs`).

use crate::relevant_update::{Update, update};
use crate::{Brick, BrickGrid, BrickRanges, VoxelRecord, VoxelRules};
use rayon::prelude::*;
use slabsplat_core::{FrameHandle, IsoRange, StageError, Volume, with_samples};

/// The voxels with an opacity above 0, by brick; bricks, and voxels within a brick, in memory order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RelevantList {
    pub(crate) grid: BrickGrid,
    pub(crate) bricks: Vec<Brick>,
    pub(crate) records: Vec<VoxelRecord>,
    pub(crate) ranges: Vec<IsoRange>,
}

/// How many voxels an update touched.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ListChange {
    /// Voxels that became relevant; only for these a normal is computed.
    pub n_added: usize,
    /// Voxels that no longer are.
    pub n_dropped: usize,
}

impl RelevantList {
    /// The bricks that hold relevant voxels, in memory order.
    pub fn bricks(&self) -> &[Brick] {
        &self.bricks
    }

    /// The voxels of one of the [`bricks`](Self::bricks), in memory order.
    #[inline]
    pub fn voxels_of(&self, brick: &Brick) -> &[VoxelRecord] {
        &self.records[brick.voxels()]
    }

    /// All relevant voxels, brick by brick.
    pub fn records(&self) -> &[VoxelRecord] {
        &self.records
    }

    /// How many voxels are relevant.
    pub fn len(&self) -> usize {
        self.records.len()
    }

    /// Whether none is.
    pub fn is_empty(&self) -> bool {
        self.records.is_empty()
    }

    /// The iso-ranges that the list is of.
    pub fn ranges(&self) -> &[IsoRange] {
        &self.ranges
    }

    /// How the volume is cut into bricks.
    pub fn grid(&self) -> &BrickGrid {
        &self.grid
    }

    /// The coordinates of a voxel of one of the [`bricks`](Self::bricks).
    #[inline]
    pub fn voxel_coords(&self, brick: &Brick, record: VoxelRecord) -> [usize; 3] {
        self.grid.voxel_coords(brick, record)
    }

    /// The index in memory of a voxel of one of the [`bricks`](Self::bricks), x fastest.
    #[inline]
    pub fn voxel_idx(&self, brick: &Brick, record: VoxelRecord) -> usize {
        self.grid.voxel_idx(self.grid.voxel_coords(brick, record))
    }

    /// Bytes held.
    pub fn resident_bytes(&self) -> usize {
        self.bricks.capacity() * size_of::<Brick>()
            + self.records.capacity() * size_of::<VoxelRecord>()
    }

    /// Makes the list that of `ranges` (disjoint, rising), and returns what changed. `volume` and
    /// `brick_ranges` must be those of every earlier update.
    ///
    /// With `rules` it has only voxels that are visible by them. These too must be those of every earlier
    /// update, and `ranges` must hold what is visible of any label.
    ///
    /// # Panics
    /// If there is no room for it.
    pub fn update(
        &mut self,
        volume: &Volume,
        brick_ranges: &BrickRanges,
        ranges: &[IsoRange],
        rules: Option<&VoxelRules<'_>>,
    ) -> ListChange {
        self.update_for_frame(volume, brick_ranges, ranges, rules, &FrameHandle::new())
            .expect("nobody cancels the frame, and there is room")
    }

    /// The same for a frame.
    ///
    /// # Errors
    /// If that is cancelled, or there is no room for the list. Then the list is as it was, or empty.
    pub fn update_for_frame(
        &mut self,
        volume: &Volume,
        brick_ranges: &BrickRanges,
        ranges: &[IsoRange],
        rules: Option<&VoxelRules<'_>>,
        frame: &FrameHandle,
    ) -> Result<ListChange, StageError> {
        self.grid = BrickGrid::new(volume.grid());
        let to = Update { volume, brick_ranges, ranges, rules, frame };
        with_samples!(volume.samples(), |s| update(self, s, &to))
    }

    /// Makes it empty, and retains its room.
    pub(crate) fn clear(&mut self) {
        self.bricks.clear();
        self.records.clear();
        self.ranges.clear();
    }

    /// Fills `results`, one a voxel, in parallel: `fill` is called for each brick with its voxels and their
    /// part of the results.
    pub fn fill_by_brick<T: Send>(
        &self,
        results: &mut [T],
        fill: impl Fn(&Brick, &[VoxelRecord], &mut [T]) + Sync,
    ) {
        self.fill_bricks(&self.bricks, results, fill);
    }

    /// The same for the voxels of some of the [`bricks`](Self::bricks) only.
    pub fn fill_bricks<T: Send>(
        &self,
        bricks: &[Brick],
        results: &mut [T],
        fill: impl Fn(&Brick, &[VoxelRecord], &mut [T]) + Sync,
    ) {
        let mut rest = results;
        let mut tasks = Vec::with_capacity(bricks.len() / BRICKS_PER_TASK + 1);
        for bricks in bricks.chunks(BRICKS_PER_TASK) {
            let n_voxels = bricks.iter().map(|brick| usize::from(brick.n_voxels)).sum();
            let (part, others) = rest.split_at_mut(n_voxels);
            tasks.push((bricks, part));
            rest = others;
        }
        tasks.into_par_iter().for_each(|(bricks, mut rest)| {
            for brick in bricks {
                let (part, others) = rest.split_at_mut(brick.n_voxels.into());
                fill(brick, self.voxels_of(brick), part);
                rest = others;
            }
        });
    }
}

/// Some thousand voxels a task.
const BRICKS_PER_TASK: usize = 32;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::naive_normals::naive_normal;
    use crate::tests::{random_ranges, random_volume};
    use slabsplat_core::glam::DVec3;
    use slabsplat_core::{Grid, Scaling};
    use slabsplat_seeds::for_each_seed;

    fn relevant(volume: &Volume, ranges: &[IsoRange]) -> Vec<usize> {
        let inside = |v: f64| ranges.iter().any(|r| r.lo <= v && v <= r.hi);
        let n = volume.grid().n_voxels();
        (0..n).filter(|&idx| inside(volume.value(idx))).collect()
    }

    fn listed(list: &RelevantList) -> Vec<(usize, VoxelRecord)> {
        let with_idx = |brick: &Brick| {
            let brick = *brick;
            list.voxels_of(&brick).iter().map(move |&r| (list.voxel_idx(&brick, r), r))
        };
        list.bricks().iter().flat_map(with_idx).collect()
    }

    /// The updated list is the list from scratch, and an update touches just what changed.
    #[test]
    fn relevant_list_update_is_a_difference() {
        for_each_seed(1, |mut rng| {
            for _ in 0..40 {
                let volume = random_volume(&mut rng);
                let brick_ranges = BrickRanges::new(&volume);
                let mut list = RelevantList::default();
                let mut before: Vec<usize> = Vec::new();
                for _ in 0..12 {
                    let ranges = random_ranges(&mut rng, &volume);
                    let change = list.update(&volume, &brick_ranges, &ranges, None);
                    let after = relevant(&volume, &ranges);
                    let mut actual: Vec<usize> =
                        listed(&list).iter().map(|(idx, _)| *idx).collect();
                    actual.sort_unstable();
                    assert_eq!(actual, after, "{ranges:?} {:?}", volume.grid());

                    let mut fresh = RelevantList::default();
                    fresh.update(&volume, &brick_ranges, &ranges, None);
                    assert_eq!(fresh, list, "order and normals too");

                    let n_added = after.iter().filter(|v| before.binary_search(v).is_err()).count();
                    let n_dropped =
                        before.iter().filter(|v| after.binary_search(v).is_err()).count();
                    assert_eq!(change, ListChange { n_added, n_dropped });
                    before = after;
                }
            }
        });
    }

    #[test]
    fn relevant_list_is_in_memory_order_of_bricks() {
        for_each_seed(1, |mut rng| {
            for _ in 0..20 {
                let volume = random_volume(&mut rng);
                let mut list = RelevantList::default();
                let ranges = random_ranges(&mut rng, &volume);
                list.update(&volume, &BrickRanges::new(&volume), &ranges, None);
                assert!(list.bricks().windows(2).all(|b| b[0].brick_idx < b[1].brick_idx));
                for brick in list.bricks() {
                    let voxels = list.voxels_of(brick);
                    assert!(!voxels.is_empty());
                    assert!(voxels.windows(2).all(|v| v[0].slot < v[1].slot));
                }
                assert_eq!(list.bricks().last().map_or(0, |b| b.voxels().end), list.len());
            }
        });
    }

    #[test]
    fn relevant_list_holds_normals() {
        for_each_seed(1, |mut rng| {
            let volume = random_volume(&mut rng);
            let mut list = RelevantList::default();
            let all = IsoRange { lo: f64::NEG_INFINITY, hi: f64::INFINITY };
            list.update(&volume, &BrickRanges::new(&volume), &[all], None);
            for (voxel_idx, record) in listed(&list) {
                let normal = DVec3::from(record.normal_in_world().map(f64::from));
                assert!(normal.distance(naive_normal(&volume, voxel_idx)) < 2.7e-5);
            }
        });
    }

    #[test]
    fn relevant_list_of_everything() {
        let grid = Grid::with_spacing([9, 8, 40], [1.0; 3]).unwrap();
        let volume = Volume::new(grid, vec![5_u8; 2880].into(), Scaling::IDENTITY).unwrap();
        let mut list = RelevantList::default();
        assert!(list.is_empty() && list.ranges().is_empty());
        let ranges = [IsoRange { lo: 5.0, hi: 6.0 }];
        list.update(&volume, &BrickRanges::new(&volume), &ranges, None);
        assert!(!list.is_empty());
        assert_eq!((list.len(), list.bricks().len()), (2880, 10));
        assert_eq!((list.ranges(), list.grid()), (&ranges[..], &BrickGrid::new(&grid)));
        let by_brick = list.bricks().iter().flat_map(|brick| list.voxels_of(brick));
        assert!(by_brick.eq(list.records()));
        let least = 2880 * size_of::<VoxelRecord>() + 10 * size_of::<Brick>();
        assert!((least..2 * least).contains(&list.resident_bytes()));
    }

    /// Voxels of ten values, as many of each.
    #[test]
    fn relevant_list_keeps_some_room() {
        let grid = Grid::with_spacing([80, 10, 10], [1.0; 3]).unwrap();
        let samples: Vec<u8> = (0..8000).map(|idx| (idx % 10) as u8).collect();
        let volume = Volume::new(grid, samples.into(), Scaling::IDENTITY).unwrap();
        let brick_ranges = BrickRanges::new(&volume);
        let mut list = RelevantList::default();
        let mut bytes_of_values_below = |end: f64| {
            list.update(&volume, &brick_ranges, &[IsoRange { lo: 0.0, hi: end - 1.0 }], None);
            list.resident_bytes()
        };
        let all = bytes_of_values_below(10.0);
        assert_eq!(bytes_of_values_below(8.0), all, "for those that may come back");
        assert_eq!(bytes_of_values_below(9.0), all, "one has come back");
        assert!(bytes_of_values_below(7.0) < all * 3 / 4, "they are too many");
        assert_eq!(bytes_of_values_below(10.0), all, "no more than is needed");
    }

    #[test]
    fn relevant_list_does_not_depend_on_threads() {
        for_each_seed(1, |mut rng| {
            let volume = random_volume(&mut rng);
            let ranges = random_ranges(&mut rng, &volume);
            let with_threads = |n_threads: usize| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
                pool.install(|| {
                    let mut list = RelevantList::default();
                    list.update(&volume, &BrickRanges::new(&volume), &ranges, None);
                    list
                })
            };
            let one = with_threads(1);
            assert!([2, 7].map(with_threads).iter().all(|list| *list == one));
        });
    }
}
