//! Samples of up to 16 bits: there are so few that what depends on a sample alone is found once for each of
//! them, and not for each voxel.

use rayon::prelude::*;
use slabsplat_core::{Sample, SampleType, Scaling};

/// All samples of a type, from the least on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SmallSamples {
    least: i32,
    n: usize,
}

/// Parts in which voxels are counted at most, each of which has its own counts.
const N_PARTS: usize = 32;

/// Voxels of a part, at least.
const PART_LEN: usize = 1 << 20;

impl SmallSamples {
    /// Of a type of up to 16 bits.
    pub(crate) fn of(sample_type: SampleType) -> Option<Self> {
        let least = match sample_type {
            SampleType::U8 | SampleType::U16 => 0,
            SampleType::I8 => i8::MIN.into(),
            SampleType::I16 => i16::MIN.into(),
            SampleType::U32 | SampleType::I32 | SampleType::F32 | SampleType::F64 => return None,
        };
        Some(Self { least, n: 1 << (8 * sample_type.size_bytes()) })
    }

    /// Of a type of which there are fewer samples than voxels.
    pub(crate) fn fewer_than(n_voxels: usize, sample_type: SampleType) -> Option<Self> {
        Self::of(sample_type).filter(|small| small.n < n_voxels)
    }

    /// How many there are.
    #[cfg(feature = "files")]
    pub(crate) fn n(self) -> usize {
        self.n
    }

    /// Which of them a sample is.
    #[inline]
    pub(crate) fn idx_of<T: Sample>(self, sample: T) -> usize {
        (sample.to_f64() as i32 - self.least) as usize
    }

    /// The value of each.
    pub(crate) fn values(self, scaling: Scaling) -> impl Iterator<Item = f64> {
        (0..self.n).map(move |idx| scaling.apply(f64::from(self.least) + idx as f64))
    }

    /// How many voxels have each of them.
    pub(crate) fn counts<'a, T: Sample>(self, samples: impl Iterator<Item = &'a T>) -> Vec<u64> {
        let mut counts = vec![0; self.n];
        samples.for_each(|&sample| counts[self.idx_of(sample)] += 1);
        counts
    }

    /// The values that voxels have, and how many.
    pub(crate) fn counted<T: Sample>(self, samples: &[T], scaling: Scaling) -> Vec<(f64, u64)> {
        let parts = samples.par_chunks(samples.len().div_ceil(N_PARTS).max(PART_LEN));
        let counts: Vec<_> = parts.map(|part| self.counts(part.iter())).collect();
        self.with_values(&counts, scaling)
    }

    /// The same of what was counted in parts.
    pub(crate) fn with_values(self, counts: &[Vec<u64>], scaling: Scaling) -> Vec<(f64, u64)> {
        let counts = (0..self.n).map(|idx| counts.iter().map(|part| part[idx]).sum());
        self.values(scaling).zip(counts).filter(|(_, n)| 0 < *n).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_found<T: Sample>(samples: &[T]) {
        let small = SmallSamples::of(T::TYPE).unwrap();
        let scaling = Scaling { slope: -0.5, intercept: 3.0 };
        let values: Vec<f64> = small.values(scaling).collect();
        for sample in samples {
            assert_eq!(values[small.idx_of(*sample)], scaling.apply(sample.to_f64()));
        }
        let counted = small.counted(samples, scaling);
        assert_eq!(counted.iter().map(|(_, n)| n).sum::<u64>(), samples.len() as u64);
        for (value, n) in counted {
            let has_it = |sample: &&T| scaling.apply(sample.to_f64()) == value;
            assert_eq!(samples.iter().filter(has_it).count() as u64, n);
        }
    }

    #[test]
    fn each_sample_has_its_place() {
        assert_found(&[0_u8, 1, 255, 1, 1]);
        assert_found(&[-128_i8, 0, 127, 0]);
        assert_found(&[0_u16, 65535, 65535, 9]);
        assert_found(&[-32768_i16, -1, 0, 32767]);
        assert_eq!(SmallSamples::of(SampleType::F32), None);
        assert_eq!(SmallSamples::fewer_than(256, SampleType::U8), None);
        assert_eq!(SmallSamples::fewer_than(257, SampleType::I8).map(|it| it.n), Some(256));
    }
}
