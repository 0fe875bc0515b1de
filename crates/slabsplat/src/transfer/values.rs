//! How many voxels of a volume have which values.

use crate::small_samples::SmallSamples;
use rayon::prelude::*;
use slabsplat_core::{Sample, Scaling, Volume, with_samples};

/// How many voxels have values in each of some bins of equal width. NaN and infinities are left out.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ValueCounts {
    /// The least and the largest value that are counted.
    pub range: [f64; 2],
    /// How many voxels there are in each bin, from the least value on; what is on a border is in the upper
    /// one.
    pub counts: Vec<u64>,
}

/// The values of a volume, wherever its voxels are; of those that are counted the finite ones.
#[cfg(feature = "files")]
pub(crate) trait VolumeValues {
    /// All voxels, or those [rows](crate::automatic::LookedAt) that stand for them where its look is found.
    fn rows(&self) -> &Volume;

    /// The least and the largest; `None` if there is none.
    fn range(&self) -> Option<[f64; 2]>;

    /// How many are in each of some bins.
    fn counts(&self, bins: Bins) -> Vec<u64>;

    /// The least and the largest of some; `None` if there are none.
    fn extremes_where(&self, is_one: &(dyn Fn(f64) -> bool + Sync)) -> Option<[f64; 2]>;
}

#[cfg(feature = "files")]
impl VolumeValues for Volume {
    fn rows(&self) -> &Volume {
        self
    }

    fn range(&self) -> Option<[f64; 2]> {
        self.summary().range
    }

    fn counts(&self, bins: Bins) -> Vec<u64> {
        bins.counts(self)
    }

    fn extremes_where(&self, is_one: &(dyn Fn(f64) -> bool + Sync)) -> Option<[f64; 2]> {
        with_samples!(self.samples(), |samples| extremes_of(samples, self.scaling(), is_one))
    }
}

#[cfg(feature = "files")]
fn extremes_of<T: Sample>(
    samples: &[T],
    scaling: Scaling,
    is_one: impl Fn(f64) -> bool + Sync,
) -> Option<[f64; 2]> {
    let nothing = || [f64::INFINITY, f64::NEG_INFINITY];
    let joined = |[a, b]: [f64; 2], [c, d]: [f64; 2]| [a.min(c), b.max(d)];
    if let Some(small) = SmallSamples::fewer_than(samples.len(), T::TYPE) {
        let values = small.counted(samples, scaling).into_iter().map(|(value, _)| value);
        let ends = values.filter(|&value| is_one(value)).map(|value| [value; 2]);
        return ends.reduce(joined);
    }
    let of_chunk = |chunk: &[T]| {
        let values = chunk.iter().map(|sample| scaling.apply(sample.to_f64()));
        values
            .filter(|&value| is_one(value))
            .fold(nothing(), |[min, max], value| [min.min(value), max.max(value)])
    };
    let [min, max] = samples.par_chunks(CHUNK_LEN).map(of_chunk).reduce(nothing, joined);
    (min <= max).then_some([min, max])
}

/// Voxels that a thread counts at a time.
const CHUNK_LEN: usize = 1 << 16;

impl ValueCounts {
    /// Counts all finite values; `None` if there are none.
    ///
    /// # Panics
    /// If there are to be no bins.
    pub fn of(volume: &Volume, n_bins: usize) -> Option<Self> {
        assert!(0 < n_bins, "usage: values are counted in one bin at least");
        let bins = Bins { range: volume.summary().range?, n_bins };
        Some(Self { range: bins.range, counts: bins.counts(volume) })
    }

    /// Those that somebody else has counted, in bins of equal width from the least value on.
    pub fn of_counts(range: [f64; 2], counts: Vec<u64>) -> Self {
        Self { range, counts }
    }
}

/// A range of values, cut into bins of equal width.
#[derive(Clone, Copy)]
pub(crate) struct Bins {
    pub(crate) range: [f64; 2],
    pub(crate) n_bins: usize,
}

impl Bins {
    /// The bin that a value is in; `None` outside of the range.
    #[inline]
    pub(crate) fn bin_of(self, value: f64) -> Option<usize> {
        let [lo, hi] = self.range;
        // Halved, as the distance of two ends of the numbers is infinite.
        let t = (0.5 * value - 0.5 * lo) / (0.5 * hi - 0.5 * lo);
        // In a range of one value, 0 / 0 is in the first.
        let bin = (t * self.n_bins as f64) as usize;
        (lo <= value && value <= hi).then_some(bin.min(self.n_bins - 1))
    }

    /// How many values are in each.
    pub(crate) fn counts(self, volume: &Volume) -> Vec<u64> {
        with_samples!(volume.samples(), |samples| self.counts_of(samples, volume.scaling()))
    }

    fn counts_of<T: Sample>(self, samples: &[T], scaling: Scaling) -> Vec<u64> {
        if let Some(small) = SmallSamples::fewer_than(samples.len(), T::TYPE) {
            let mut counts = vec![0; self.n_bins];
            for (value, n) in small.counted(samples, scaling) {
                self.bin_of(value).into_iter().for_each(|bin| counts[bin] += n);
            }
            return counts;
        }
        let count = |mut counts: Vec<u64>, chunk: &[T]| {
            let values = chunk.iter().map(|sample| scaling.apply(sample.to_f64()));
            values.filter_map(|value| self.bin_of(value)).for_each(|bin| counts[bin] += 1);
            counts
        };
        let sum = |mut a: Vec<u64>, b: Vec<u64>| {
            a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
            a
        };
        let nothing = || vec![0; self.n_bins];
        samples.par_chunks(CHUNK_LEN).fold(nothing, count).reduce(nothing, sum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::{Grid, Samples};

    fn row(samples: Samples) -> Volume {
        let grid = Grid::with_spacing([samples.len(), 1, 1], [1.0; 3]).unwrap();
        Volume::new(grid, samples, Scaling::IDENTITY).unwrap()
    }

    #[test]
    fn values_are_counted() {
        let volume = row(Samples::F32(vec![0.0, 0.5, 1.0, 4.0, f32::NAN, 2.0]));
        let counted = ValueCounts::of(&volume, 4).unwrap();
        assert_eq!((counted.range, counted.counts), ([0.0, 4.0], vec![2, 1, 1, 1]));
        assert_eq!(ValueCounts::of(&row(Samples::F32(vec![f32::NAN])), 4), None);
    }

    #[test]
    fn values_of_every_type_are_counted_alike() {
        let of = |idx: u32| (idx.wrapping_mul(2_654_435_761) >> 20) as u8 & 0x7f;
        let all: Vec<u8> = (0..100_000).map(of).collect();
        let expected =
            ValueCounts::of(&row(Samples::F32(all.iter().map(|&v| v.into()).collect())), 37);
        let same = [
            Samples::U8(all.clone()),
            Samples::I8(all.iter().map(|&v| v as i8).collect()),
            Samples::U16(all.iter().map(|&v| v.into()).collect()),
            Samples::I16(all.iter().map(|&v| v.into()).collect()),
        ];
        for samples in same {
            assert_eq!(ValueCounts::of(&row(samples), 37), expected);
        }
    }
}
