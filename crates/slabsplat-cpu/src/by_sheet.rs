//! The second level of the toss (paper §7): a tile's voxels by the sheet that each goes to first.

use crate::voxel::Voxel;
use fearless_simd::{Simd, f32x8, prelude::*, u32x8};
use std::ops::Range;

/// Voxels sorted by class and sheet; equals keep their order. The voxels themselves are sorted, not their places: they
/// are then read front to back, once for every sheet that they meet.
#[derive(Debug, Default)]
pub(crate) struct BySheet {
    /// The sheets to which any voxel goes first.
    sheets: Range<usize>,
    /// The sheets that have buckets.
    with_buckets: Range<usize>,
    /// Where the voxels of each class and sheet start, and where the last ones end.
    starts: Vec<u32>,
    voxels: Vec<Voxel>,
}

/// Some of the voxels, one after the other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Run<'a> {
    of: &'a BySheet,
    start: usize,
    /// How many.
    pub(crate) len: usize,
}

/// Voxels that are read at once.
pub(crate) const N_AT_ONCE: usize = 8;

impl BySheet {
    /// Sorts the voxels of `runs`, of which `key_of` tells the class, below `n_classes`, and the sheet, one of `sheets`;
    /// forgets others.
    pub(crate) fn sort<'a>(
        &mut self,
        n_classes: usize,
        sheets: Range<usize>,
        runs: impl Iterator<Item = &'a [Voxel]> + Clone,
        key_of: impl Fn(&Voxel) -> (usize, usize),
    ) {
        // Where slabs are thin and there is no voxel, even empty buckets would be felt.
        let is_empty = runs.clone().all(<[Voxel]>::is_empty);
        let n_sheets = if is_empty { 0 } else { sheets.len() };
        let bucket_of = |voxel: &Voxel| {
            let (class, sheet) = key_of(voxel);
            class * n_sheets + sheet - sheets.start
        };
        // One entry more than counts need: while voxels are placed, `starts[bucket + 1]` is where the next one
        // of a bucket goes, and ends up as where the bucket after it starts.
        self.starts.clear();
        self.starts.resize(n_classes * n_sheets + 2, 0);
        let starts = self.starts.as_mut_slice();
        for run in runs.clone() {
            for voxel in run {
                starts[bucket_of(voxel) + 2] += 1;
            }
        }
        let counts = &starts[2..];
        let is_met = |&sheet: &usize| counts[sheet..].iter().step_by(n_sheets).any(|&n| 0 < n);
        let first = (0..n_sheets).find(is_met).unwrap_or(0);
        let end = (first..n_sheets).rfind(is_met).map_or(first, |last| last + 1);
        self.sheets = sheets.start + first..sheets.start + end;
        self.with_buckets = sheets.start..sheets.start + n_sheets;
        let mut sum = 0;
        for count in starts {
            sum += *count;
            *count = sum;
        }
        self.make_room(sum as usize + N_AT_ONCE);
        self.place(runs, bucket_of);
    }

    /// Puts every voxel where the next one of its bucket goes.
    #[inline(always)]
    fn place<'a>(
        &mut self,
        runs: impl Iterator<Item = &'a [Voxel]>,
        bucket_of: impl Fn(&Voxel) -> usize,
    ) {
        let sorted = self.voxels.as_mut_slice();
        let starts = self.starts.as_mut_slice();
        for run in runs {
            for voxel in run {
                let next = &mut starts[bucket_of(voxel) + 1];
                let place = *next as usize;
                *next += 1;
                sorted[place] = *voxel;
            }
        }
    }

    fn make_room(&mut self, n_voxels: usize) {
        if self.voxels.len() < n_voxels {
            self.voxels.reserve_exact(n_voxels + n_voxels / 8 - self.voxels.len());
            self.voxels.resize(n_voxels, Voxel::default());
        }
    }

    /// The sheets to which voxels go first.
    pub(crate) fn sheets(&self) -> Range<usize> {
        self.sheets.clone()
    }

    pub(crate) fn resident_bytes(&self) -> usize {
        self.voxels.capacity() * size_of::<Voxel>() + 4 * self.starts.capacity()
    }

    /// The voxels of a class that go first to `sheets`, by sheet and then in the order in which they came.
    pub(crate) fn starting_in(&self, class: usize, sheets: Range<usize>) -> Run<'_> {
        let n_sheets = self.with_buckets.len();
        let place = |sheet: usize| sheet.saturating_sub(self.with_buckets.start).min(n_sheets);
        let [start, end] = [sheets.start, sheets.end].map(|sheet| {
            self.starts.get(class * n_sheets + place(sheet)).map_or(0, |&s| s as usize)
        });
        Run { of: self, start, len: end.saturating_sub(start) }
    }
}

impl<'a> Run<'a> {
    /// The voxels from `first` on, component by component: right, up, depth, and the sheets that they go to. There may be fewer in the run; then the rest is of no meaning.
    #[inline(always)]
    pub(crate) fn at_once<S: Simd>(&self, simd: S, first: usize) -> ([f32x8<S>; 3], u32x8<S>) {
        let voxels = self.of.voxels[self.start + first..].first_chunk::<N_AT_ONCE>();
        let voxels = voxels.expect("there is room behind the last voxel").each_ref();
        let component = |axis: usize| voxels.map(|voxel| voxel.point[axis]);
        let [right, up, depth] = [component(0), component(1), component(2)];
        let point = [right.simd_into(simd), up.simd_into(simd), depth.simd_into(simd)];
        (point, voxels.map(|voxel| voxel.sheets).simd_into(simd))
    }

    /// What a sheet sums of a voxel.
    #[inline(always)]
    pub(crate) fn color(&self, idx: usize) -> [f32; 4] {
        self.of.voxels[self.start + idx].color
    }

    /// All of them.
    pub(crate) fn iter(self) -> impl Iterator<Item = Voxel> + 'a {
        self.of.voxels[self.start..self.start + self.len].iter().copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_seeds::for_each_seed;

    #[test]
    fn by_sheet_is_a_stable_sort() {
        for_each_seed(1, |mut rng| {
            let mut sorted = BySheet::default();
            for n_voxels in [0, 1, 7, 500, 20] {
                let voxel = |id: usize| {
                    let point = [id as f32, rng.usize(0..3) as f32, rng.usize(5..25) as f32];
                    Voxel { point, ..Voxel::default() }
                };
                let voxels: Vec<Voxel> = (0..n_voxels).map(voxel).collect();
                let key_of = |voxel: &Voxel| (voxel.point[1] as usize, voxel.point[2] as usize);
                sorted.sort(3, 4..25, voxels.chunks(9), key_of);
                let sheets = || voxels.iter().map(|voxel| key_of(voxel).1);
                if let (Some(first), Some(last)) = (sheets().min(), sheets().max()) {
                    assert_eq!(sorted.sheets(), first..last + 1);
                }
                assert_eq!(sorted.sheets().is_empty(), voxels.is_empty());
                for first in 0..30 {
                    for end in first..30 {
                        for class in 0..3 {
                            let is_meant = |v: &&Voxel| {
                                key_of(v).0 == class && (first..end).contains(&key_of(v).1)
                            };
                            let mut expected: Vec<&Voxel> =
                                voxels.iter().filter(is_meant).collect();
                            expected.sort_by_key(|voxel| key_of(voxel));
                            let run = sorted.starting_in(class, first..end);
                            assert_eq!(run.len, expected.len());
                            let same = run.iter().zip(expected).all(|(a, b)| a.point == b.point);
                            assert!(same, "class {class}, {first}..{end}");
                        }
                    }
                }
            }
        });
    }
}
