//! `L_r`, the list of relevant voxels, and its update by difference (paper §4).
//!
//! The paper keeps the list in the order of values, where an iso-range is one run. Ours is kept in
//! memory order: neighbours in the list are then neighbours in space, and gradients, shading and the
//! toss run through caches instead of around them. A changed range still only touches the runs at its
//! ends: those voxels are found in the value order, sorted, and merged in or out.

use crate::{Normals, ValueOrder, VoxelRecord};
use rayon::prelude::*;
use slabsplat_core::{IsoRange, Volume};
use std::ops::Range;

/// The voxels with an opacity above 0, in memory order.
#[derive(Clone, Debug, Default)]
pub struct RelevantList {
    records: Vec<VoxelRecord>,
    /// The runs of the value order that the records come from, rising and disjoint.
    runs: Vec<Range<usize>>,
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
    /// The relevant voxels, in memory order.
    pub fn records(&self) -> &[VoxelRecord] {
        &self.records
    }

    /// Makes the list that of `ranges` (disjoint, rising), and tells what changed. `volume` and `order`
    /// must be those of every earlier update.
    pub fn update(
        &mut self,
        volume: &Volume,
        order: &ValueOrder,
        ranges: &[IsoRange],
    ) -> ListChange {
        let runs: Vec<Range<usize>> = ranges
            .iter()
            .map(|&range| order.within(volume, range))
            .filter(|run| !run.is_empty())
            .collect();
        let dropped = voxels_in(order, &difference(&self.runs, &runs));
        let added = voxels_in(order, &difference(&runs, &self.runs));
        if !dropped.is_empty() {
            self.remove(&dropped);
        }
        if !added.is_empty() {
            self.insert(&records_of(volume, &added));
        }
        self.runs = runs;
        ListChange { n_added: added.len(), n_dropped: dropped.len() }
    }

    fn remove(&mut self, dropped: &[u32]) {
        let mut dropped = dropped.iter().peekable();
        self.records.retain(|record| dropped.next_if(|&&d| d == record.voxel_idx).is_none());
    }

    fn insert(&mut self, added: &[VoxelRecord]) {
        if self.records.is_empty() {
            self.records.extend_from_slice(added);
            return;
        }
        // From the back, so that every record moves at most once and nothing is copied aside.
        let mut n_old = self.records.len();
        let mut n_new = added.len();
        self.records.resize(n_old + n_new, VoxelRecord { voxel_idx: 0, normal_in_world: [0.0; 3] });
        while 0 < n_new {
            let old_is_later =
                0 < n_old && added[n_new - 1].voxel_idx < self.records[n_old - 1].voxel_idx;
            let place = n_old + n_new - 1;
            self.records[place] = if old_is_later {
                n_old -= 1;
                self.records[n_old]
            } else {
                n_new -= 1;
                added[n_new]
            };
        }
    }
}

/// The parts of the runs `a` that no run of `b` covers; both are rising and disjoint.
fn difference(a: &[Range<usize>], b: &[Range<usize>]) -> Vec<Range<usize>> {
    let mut parts = Vec::new();
    for run in a {
        let mut start = run.start;
        for hole in b.iter().filter(|hole| hole.start < run.end && run.start < hole.end) {
            parts.push(start..hole.start.max(start));
            start = hole.end.min(run.end);
        }
        parts.push(start..run.end);
    }
    parts.retain(|part| !part.is_empty());
    parts
}

fn voxels_in(order: &ValueOrder, runs: &[Range<usize>]) -> Vec<u32> {
    let all = order.voxel_idxs();
    let mut voxels: Vec<u32> =
        runs.iter().flat_map(|run| all[run.clone()].iter().copied()).collect();
    voxels.par_sort_unstable();
    voxels
}

fn records_of(volume: &Volume, voxels: &[u32]) -> Vec<VoxelRecord> {
    let normals = Normals::new(volume);
    let record = |&voxel_idx: &u32| VoxelRecord {
        voxel_idx,
        normal_in_world: normals.at(voxel_idx as usize).as_vec3().to_array(),
    };
    voxels.par_iter().with_min_len(1 << 12).map(record).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::{Grid, Scaling};

    fn random_volume(rng: &mut fastrand::Rng) -> Volume {
        let grid = Grid::with_spacing([9, 8, 7], [1.0, 1.5, 0.7]).unwrap();
        let samples: Vec<u8> = (0..grid.n_voxels()).map(|_| rng.u8(0..40)).collect();
        Volume::new(grid, samples.into(), Scaling::IDENTITY).unwrap()
    }

    fn random_ranges(rng: &mut fastrand::Rng) -> Vec<IsoRange> {
        let mut ends: Vec<u8> = (0..2 * rng.usize(0..4)).map(|_| rng.u8(0..45)).collect();
        ends.sort_unstable();
        ends.dedup();
        ends.chunks_exact(2).map(|e| IsoRange { lo: e[0].into(), hi: e[1].into() }).collect()
    }

    fn relevant(volume: &Volume, ranges: &[IsoRange]) -> Vec<u32> {
        let inside = |v: f64| ranges.iter().any(|r| r.lo <= v && v <= r.hi);
        let n = volume.grid().n_voxels() as u32;
        (0..n).filter(|&idx| inside(volume.value(idx as usize))).collect()
    }

    /// The updated list is the list from scratch, and an update touches just what changed.
    #[test]
    fn relevant_list_update_is_a_difference() {
        let seed = fastrand::u64(..);
        println!("seed {seed}");
        let mut rng = fastrand::Rng::with_seed(seed);
        let volume = random_volume(&mut rng);
        let order = ValueOrder::new(&volume);
        let mut list = RelevantList::default();
        let mut before: Vec<u32> = Vec::new();
        for _ in 0..200 {
            let ranges = random_ranges(&mut rng);
            let change = list.update(&volume, &order, &ranges);
            let after = relevant(&volume, &ranges);
            let listed: Vec<u32> = list.records().iter().map(|r| r.voxel_idx).collect();
            assert_eq!(listed, after, "{ranges:?}");

            let mut fresh = RelevantList::default();
            fresh.update(&volume, &order, &ranges);
            assert_eq!(fresh.records(), list.records(), "normals too");

            let n_added = after.iter().filter(|v| before.binary_search(v).is_err()).count();
            let n_dropped = before.iter().filter(|v| after.binary_search(v).is_err()).count();
            assert_eq!(change, ListChange { n_added, n_dropped });
            before = after;
        }
    }

    #[test]
    #[expect(clippy::single_range_in_vec_init, reason = "a list of one run is meant")]
    fn difference_of_runs() {
        let check = |a: &[Range<usize>], b: &[Range<usize>], expected: &[Range<usize>]| {
            assert_eq!(difference(a, b), expected, "{a:?} − {b:?}");
        };
        check(&[0..9], &[], &[0..9]);
        check(&[0..9], &[0..9], &[]);
        check(&[0..9], &[2..3, 5..12], &[0..2, 3..5]);
        check(&[2..4, 6..8], &[3..7], &[2..3, 7..8]);
        check(&[4..6], &[0..3, 7..9], &[4..6]);
    }
}
