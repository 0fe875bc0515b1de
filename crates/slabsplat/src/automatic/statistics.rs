//! What a look at a volume's values finds: how often each occurs, and how rough values are there.
//!
//! ```text
//! rows   some rows of voxels, evenly spread, all of them in a volume of up to 2²² voxels
//! range  extremes of the rows; without the outliers, again and again while these stretch the scale
//! bins   for each level of values: voxels, and sums over them of first and second differences, and of
//!        neighbours that are equal
//! ```
//!
//! Rows are dealt to tasks by their number and tasks are joined in order, so that the sums are the same
//! whatever the number of threads.

use rayon::prelude::*;
use slabsplat_core::{Sample, SampleType, Scaling, Volume, with_samples};
use std::collections::BTreeSet;

use super::histogram::{Histogram, N_BINS};
use super::scale::Scale;
use crate::small_samples::SmallSamples;

/// Voxels that are looked at: more would not change a picture, and 1024³ would take seconds.
const N_VOXELS: usize = 1 << 22;

/// Tasks that share the rows; each has levels of its own.
const N_TASKS: usize = 32;

/// Levels of the scale on which outliers are found.
const N_LEVELS: usize = 1 << 16;

/// Values of label maps that are counted.
const MAX_DISTINCT: usize = 512;

/// Share of the voxels beside the most frequent level that count as outliers at either end.
const OUTLIERS: f64 = 5e-4;

/// How often a scale is cut to the range without outliers: numbers of 32 bits have 256 binary orders, and
/// each time takes up to 16 of them.
const MAX_CUTS: usize = 16;

/// What is known of a volume's values.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Statistics {
    /// By level; `None` if there are no two values that can be told apart.
    pub(super) histogram: Option<Histogram>,
    /// All values, if they are whole numbers and few; without those that rows missed.
    pub(super) distinct: Option<Vec<f64>>,
    /// The least and the largest value that was met, infinite if there is none.
    pub(super) extremes: [f64; 2],
}

impl Statistics {
    pub(super) fn of(volume: &Volume) -> Self {
        with_samples!(volume.samples(), |samples| Rows::new(volume, samples).statistics())
    }
}

/// Which rows of a volume are looked at, evenly spread. A volume of these alone is looked at whole, and so
/// has the same statistics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct LookedAt {
    /// Every how manieth row along y and along z.
    pub(crate) stride: usize,
    pub(crate) n_rows: usize,
}

impl LookedAt {
    /// Of a volume of so many voxels along x, y and z.
    pub(crate) fn of(dims: [usize; 3]) -> Self {
        let n_all = dims[1] * dims[2];
        let n_wanted = (N_VOXELS / dims[0]).max(1);
        // An odd stride meets rows of both parities whichever way it wraps.
        let stride = n_all.div_ceil(n_wanted) | 1;
        Self { stride, n_rows: n_all.div_ceil(stride) }
    }
}

/// Rows of a volume that are looked at.
struct Rows<'a, T> {
    samples: &'a [T],
    scaling: Scaling,
    dims: [usize; 3],
    looked_at: LookedAt,
    /// The values of their voxels and how many have each, where that is fewer numbers.
    counted: Option<Vec<(f64, u64)>>,
}

impl<'a, T: Sample> Rows<'a, T> {
    fn new(volume: &Volume, samples: &'a [T]) -> Self {
        let dims = volume.grid().dims();
        let (scaling, looked_at) = (volume.scaling(), LookedAt::of(dims));
        let rows = Self { samples, scaling, dims, looked_at, counted: None };
        Self { counted: rows.count(), ..rows }
    }

    fn count(&self) -> Option<Vec<(f64, u64)>> {
        let small = SmallSamples::fewer_than(self.looked_at.n_rows * self.dims[0], T::TYPE)?;
        let counts = self.by_task(|rows| small.counts(rows.flat_map(|row| self.row(row))));
        Some(small.with_values(&counts, self.scaling))
    }

    /// What becomes of `nothing` by all values and how many voxels have each, part by part.
    fn folded<R: Send>(
        &self,
        nothing: impl Fn() -> R + Sync,
        add: impl Fn(&mut R, f64, u64) + Sync,
    ) -> Vec<R> {
        if let Some(counted) = &self.counted {
            let mut all = nothing();
            counted.iter().for_each(|&(value, n)| add(&mut all, value, n));
            return vec![all];
        }
        self.by_task(|rows| {
            let mut of_task = nothing();
            for &sample in rows.flat_map(|row| self.row(row)) {
                add(&mut of_task, self.value(sample), 1);
            }
            of_task
        })
    }

    fn statistics(&self) -> Statistics {
        let extremes = self.extremes();
        let distinct = self.distinct();
        let histogram = self.scale(extremes).map(|scale| self.histogram(scale));
        Statistics { histogram, distinct, extremes }
    }

    /// What `look` finds in each task's rows, in their order.
    fn by_task<R: Send>(
        &self,
        look: impl Fn(&mut dyn Iterator<Item = usize>) -> R + Sync,
    ) -> Vec<R> {
        let LookedAt { stride, n_rows } = self.looked_at;
        let of_task = |task: usize| {
            let rows = task * n_rows / N_TASKS..(task + 1) * n_rows / N_TASKS;
            look(&mut rows.map(|row| row * stride))
        };
        (0..N_TASKS).into_par_iter().map(of_task).collect()
    }

    fn row(&self, row: usize) -> &'a [T] {
        &self.samples[row * self.dims[0]..][..self.dims[0]]
    }

    fn value(&self, sample: T) -> f64 {
        self.scaling.apply(sample.to_f64())
    }

    fn extremes(&self) -> [f64; 2] {
        self.extremes_where(f64::is_finite)
    }

    /// The least and the largest of some values, infinite if there are none.
    fn extremes_where(&self, is_one: impl Fn(f64) -> bool + Sync) -> [f64; 2] {
        let nothing = [f64::INFINITY, f64::NEG_INFINITY];
        let joined = |[a, b]: [f64; 2], [c, d]: [f64; 2]| [a.min(c), b.max(d)];
        let of_parts = self.folded(
            || nothing,
            |ends, value, _| {
                if is_one(value) {
                    *ends = joined(*ends, [value; 2]);
                }
            },
        );
        of_parts.into_iter().fold(nothing, joined)
    }

    /// All values, if they are whole and few.
    fn distinct(&self) -> Option<Vec<f64>> {
        let of_parts = self.folded(
            || (Some(BTreeSet::new()), f64::NAN),
            |(found, last), value, _| {
                let Some(values) = found else { return };
                if value == *last || !value.is_finite() {
                    return;
                }
                *last = value;
                let is_whole = value.fract() == 0.0 && value.abs() <= 2_f64.powi(53);
                if is_whole {
                    values.insert(value as i64);
                }
                if !is_whole || MAX_DISTINCT < values.len() {
                    *found = None;
                }
            },
        );
        let mut all = BTreeSet::new();
        for (found, _) in of_parts {
            all.extend(found?);
        }
        (all.len() <= MAX_DISTINCT).then(|| all.into_iter().map(|value| value as f64).collect())
    }

    /// The scale of the histogram, cut to what is no outlier.
    fn scale(&self, [mut lo, mut hi]: [f64; 2]) -> Option<Scale> {
        let step = self.step();
        for _ in 0..MAX_CUTS {
            let levels = Scale::new([lo, hi], N_LEVELS, step)?;
            let counts = self.counts(&levels);
            if let Some(inside) = self.crowded(&levels, &counts, [lo, hi]) {
                [lo, hi] = inside;
                continue;
            }
            let [first, last] = without_outliers(&counts);
            let is_tight = levels.n() / 16 <= last - first || levels.n() <= N_BINS;
            [lo, hi] = levels.values_of([first, last], [lo, hi]);
            if is_tight {
                break;
            }
        }
        Scale::new([lo, hi], N_BINS, step)
    }

    /// The values of a level that has nearly all voxels, if they differ: then it is the others that stray.
    /// Those beyond `range`, which count at its ends, have strayed before.
    fn crowded(&self, levels: &Scale, counts: &[u64], range: [f64; 2]) -> Option<[f64; 2]> {
        let most = (0..counts.len()).max_by_key(|&level| counts[level])?;
        let n_others = counts.iter().sum::<u64>() - counts[most];
        if OUTLIERS * (counts[most] as f64) < n_others as f64 {
            return None;
        }
        let is_inside = |value| range[0] <= value && value <= range[1];
        let all =
            self.extremes_where(|value| is_inside(value) && levels.level_of(value) == Some(most));
        (all[0] < all[1]).then_some(all)
    }

    /// What values differ by at least, if samples are whole numbers.
    fn step(&self) -> f64 {
        match T::TYPE {
            SampleType::F32 | SampleType::F64 => 0.0,
            SampleType::U8
            | SampleType::I8
            | SampleType::U16
            | SampleType::I16
            | SampleType::U32
            | SampleType::I32 => self.scaling.slope.abs(),
        }
    }

    fn counts(&self, levels: &Scale) -> Vec<u64> {
        let of_parts = self.folded(
            || vec![0; levels.n()],
            |counts: &mut Vec<u64>, value, n| {
                levels.level_of(value).into_iter().for_each(|level| counts[level] += n);
            },
        );
        let mut all = vec![0; levels.n()];
        for counts in of_parts {
            all.iter_mut().zip(counts).for_each(|(all, n)| *all += n);
        }
        all
    }

    fn histogram(&self, scale: Scale) -> Histogram {
        let of_rows = self.by_task(|rows| {
            let mut histogram = Histogram::empty(scale);
            rows.for_each(|row| self.add_row(row, &mut histogram));
            histogram
        });
        let mut all = Histogram::empty(scale);
        of_rows.iter().for_each(|histogram| all.add(histogram));
        all
    }

    fn add_row(&self, row: usize, histogram: &mut Histogram) {
        let row = self.row(row);
        for (x, &sample) in row.iter().enumerate() {
            let value = self.value(sample);
            if !value.is_finite() {
                continue;
            }
            let neighbor =
                |x: usize| Some(self.value(row[x])).filter(|v| v.is_finite()).unwrap_or(value);
            let before = neighbor(x.saturating_sub(1));
            let after = neighbor((x + 1).min(row.len() - 1));
            let differences =
                [0.5 * (after - before).abs(), 0.5 * (before - 2.0 * value + after).abs()];
            histogram.add_voxel(value, differences, value == after && x + 1 < row.len());
        }
    }
}

/// The first and the last level that is none of outliers.
fn without_outliers(counts: &[u64]) -> [usize; 2] {
    let most = counts.iter().copied().max().unwrap_or(0);
    let n_others = counts.iter().sum::<u64>() - most;
    let n_outliers = (n_others as f64 * OUTLIERS) as u64;
    let end = |levels: &mut dyn Iterator<Item = usize>| {
        let mut n_left = n_outliers;
        for level in levels {
            if n_left < counts[level] {
                return level;
            }
            n_left -= counts[level];
        }
        0
    };
    [end(&mut (0..counts.len())), end(&mut (0..counts.len()).rev())]
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::Grid;

    /// Counted values and voxels one by one say the same.
    fn assert_same<T: Sample>(samples: &[T])
    where
        Vec<T>: Into<slabsplat_core::Samples>,
    {
        let grid = Grid::with_spacing([samples.len() / 20, 5, 4], [1.0; 3]).unwrap();
        let scaling = Scaling { slope: 0.25, intercept: -7.0 };
        let volume = Volume::new(grid, samples.to_vec().into(), scaling).unwrap();
        let counted = Rows::new(&volume, samples);
        assert!(counted.counted.is_some(), "{:?}", T::TYPE);
        let one_by_one = Rows { counted: None, ..Rows::new(&volume, samples) };
        assert_eq!(counted.statistics(), one_by_one.statistics(), "{:?}", T::TYPE);
    }

    #[test]
    fn statistics_are_the_same_of_counts_and_of_voxels() {
        let mut rng = fastrand::Rng::with_seed(3);
        for spread in [1, 3, 40, 1000] {
            let mut sample = || (1.0 - rng.f64().powi(4)) * f64::from(spread);
            let n = 120_000;
            assert_same(&(0..n).map(|_| sample() as u8).collect::<Vec<_>>());
            assert_same(&(0..n).map(|_| -sample() as i8).collect::<Vec<_>>());
            assert_same(&(0..n).map(|_| sample() as u16).collect::<Vec<_>>());
            // One that strays.
            let strays = (0..n).map(|i| if i == 9 { 32767 } else { -9 - sample() as i16 });
            assert_same(&strays.collect::<Vec<_>>());
        }
    }
}
