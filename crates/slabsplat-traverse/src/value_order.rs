//! All voxels sorted by value (paper §4: "After the volume is read from memory, the voxels are
//! sorted with respect to their value").
//!
//! Samples of 8 and 16 bits are counted into place; each task owns a range of values, hence a slice
//! of the output, and scans the whole volume for it. That reads the volume once a task, which
//! costs less than it looks: the scan streams, the scattered writes are what takes the time. Wider
//! samples are sorted by a key that holds the voxel's place, so that equal values keep their order.

use rayon::prelude::*;
use slabsplat_core::{IsoRange, Sample, Volume, with_samples};
use std::ops::Range;

/// The voxels of a volume from small values to large, equal ones as they lie in memory. NaN voxels
/// are left out: they are never relevant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ValueOrder {
    voxel_idxs: Vec<u32>,
}

impl ValueOrder {
    /// Sorts the voxels of `volume`, in parallel.
    pub fn new(volume: &Volume) -> Self {
        let rises = 0.0 < volume.scaling().slope;
        let voxel_idxs = with_samples!(volume.samples(), |s| sorted(s, rises));
        Self { voxel_idxs }
    }

    /// The voxels' places in memory, sorted by value.
    pub fn voxel_idxs(&self) -> &[u32] {
        &self.voxel_idxs
    }

    /// Which part of the order has values in `range`: two binary searches.
    pub fn within(&self, volume: &Volume, range: IsoRange) -> Range<usize> {
        let first_not = |below: &dyn Fn(f64) -> bool| {
            self.voxel_idxs.partition_point(|&voxel_idx| below(volume.value(voxel_idx as usize)))
        };
        let start = first_not(&|value| value < range.lo);
        start..first_not(&|value| value <= range.hi).max(start)
    }
}

fn sorted<T: Sample>(samples: &[T], rises: bool) -> Vec<u32> {
    match T::TYPE.size_bytes() {
        1 | 2 => sorted_by_counting(samples, rises),
        _ => sorted_by_key(samples, rises),
    }
}

/// Levels of a sample of up to 16 bits.
const N_LEVELS: usize = 1 << 16;

fn sorted_by_counting<T: Sample>(samples: &[T], rises: bool) -> Vec<u32> {
    let level_of = |sample: T| {
        let level = sample.to_f64() as i32 + if sample_is_signed::<T>() { 1 << 15 } else { 0 };
        if rises { level as usize } else { N_LEVELS - 1 - level as usize }
    };
    let counts = count_levels(samples, &level_of);
    let mut order = vec![0_u32; samples.len()];
    let shares = share_levels(&counts, samples.len().div_ceil(rayon::current_num_threads()).max(1));
    let mut rest = order.as_mut_slice();
    let mut tasks = Vec::with_capacity(shares.len());
    for levels in shares {
        let n_voxels = counts[levels.clone()].iter().sum();
        let (slice, others) = rest.split_at_mut(n_voxels);
        tasks.push((levels, slice));
        rest = others;
    }
    tasks.into_par_iter().for_each(|(levels, slice)| {
        let mut next = starts(&counts[levels.clone()]);
        for (voxel_idx, &sample) in samples.iter().enumerate() {
            let level = level_of(sample);
            if levels.contains(&level) {
                let place = &mut next[level - levels.start];
                slice[*place] = voxel_idx as u32;
                *place += 1;
            }
        }
    });
    order
}

fn sample_is_signed<T: Sample>() -> bool {
    T::TYPE.name().starts_with("int")
}

fn count_levels<T: Sample>(samples: &[T], level_of: &(impl Fn(T) -> usize + Sync)) -> Vec<usize> {
    let add = |mut a: Vec<usize>, b: Vec<usize>| {
        a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
        a
    };
    samples
        .par_chunks(1 << 20)
        .map(|chunk| {
            let mut counts = vec![0; N_LEVELS];
            for &sample in chunk {
                counts[level_of(sample)] += 1;
            }
            counts
        })
        .reduce(|| vec![0; N_LEVELS], add)
}

/// Cuts the levels into runs of about `target` voxels each.
fn share_levels(counts: &[usize], target: usize) -> Vec<Range<usize>> {
    let mut shares = Vec::new();
    let (mut start, mut n_voxels) = (0, 0);
    for (level, count) in counts.iter().enumerate() {
        n_voxels += count;
        if target <= n_voxels {
            shares.push(start..level + 1);
            (start, n_voxels) = (level + 1, 0);
        }
    }
    shares.push(start..counts.len());
    shares
}

fn starts(counts: &[usize]) -> Vec<usize> {
    counts
        .iter()
        .scan(0, |sum, count| {
            let start = *sum;
            *sum += count;
            Some(start)
        })
        .collect()
}

#[expect(clippy::eq_op, reason = "a sample that differs from itself is NaN, whatever its type")]
fn sorted_by_key<T: Sample>(samples: &[T], rises: bool) -> Vec<u32> {
    let mut keys: Vec<(u64, u32)> = samples
        .par_iter()
        .enumerate()
        .filter(|&(_, &sample)| sample == sample)
        .map(|(voxel_idx, &sample)| (rising_bits(sample.to_f64(), rises), voxel_idx as u32))
        .collect();
    keys.par_sort_unstable();
    keys.into_par_iter().map(|(_, voxel_idx)| voxel_idx).collect()
}

/// Bits that sort as the numbers do. The two zeros are one.
fn rising_bits(value: f64, rises: bool) -> u64 {
    let bits = (value + 0.0).to_bits();
    let up = if bits >> 63 == 0 { bits | 1 << 63 } else { !bits };
    if rises { up } else { !up }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::{Grid, Samples, Scaling};

    fn volume(samples: Samples, slope: f64) -> Volume {
        let grid = Grid::with_spacing([samples.len(), 1, 1], [1.0; 3]).unwrap();
        Volume::new(grid, samples, Scaling { slope, intercept: 0.5 }).unwrap()
    }

    /// The order of a plain stable sort.
    fn naive(volume: &Volume) -> Vec<u32> {
        let n = volume.grid().n_voxels();
        let mut order: Vec<u32> =
            (0..n as u32).filter(|&i| !volume.value(i as usize).is_nan()).collect();
        order.sort_by(|&a, &b| {
            let [a, b] = [a, b].map(|i| volume.value(i as usize));
            a.partial_cmp(&b).unwrap()
        });
        order
    }

    #[test]
    fn value_order_is_a_stable_sort_of_every_type() {
        let seed = fastrand::u64(..);
        println!("seed {seed}");
        let mut rng = fastrand::Rng::with_seed(seed);
        let n = 5000;
        let floats = |rng: &mut fastrand::Rng| match rng.u8(0..20) {
            0 => f64::NAN,
            1 => f64::INFINITY,
            2 => f64::NEG_INFINITY,
            3 => -0.0,
            4 => 0.0,
            _ => f64::from(rng.i32(-50..50)) * 0.1,
        };
        for slope in [1.0, -2.0] {
            let cases: [Samples; 8] = [
                (0..n).map(|_| rng.u8(..)).collect::<Vec<_>>().into(),
                (0..n).map(|_| rng.i8(..)).collect::<Vec<_>>().into(),
                (0..n).map(|_| rng.u16(..)).collect::<Vec<_>>().into(),
                (0..n).map(|_| rng.i16(..)).collect::<Vec<_>>().into(),
                (0..n).map(|_| rng.u32(0..99)).collect::<Vec<_>>().into(),
                (0..n).map(|_| rng.i32(..)).collect::<Vec<_>>().into(),
                (0..n).map(|_| floats(&mut rng) as f32).collect::<Vec<_>>().into(),
                (0..n).map(|_| floats(&mut rng)).collect::<Vec<_>>().into(),
            ];
            for samples in cases {
                let volume = volume(samples, slope);
                assert_eq!(
                    ValueOrder::new(&volume).voxel_idxs(),
                    naive(&volume),
                    "{:?} slope {slope}",
                    volume.sample_type()
                );
            }
        }
    }

    #[test]
    fn value_order_finds_ranges() {
        let volume = volume(vec![5.0_f32, f32::NAN, 1.0, 3.0, f32::INFINITY, 3.0].into(), 1.0);
        let order = ValueOrder::new(&volume);
        let check = |lo, hi, expected: &[u32]| {
            let range = order.within(&volume, IsoRange { lo, hi });
            assert_eq!(&order.voxel_idxs()[range], expected, "{lo} … {hi}");
        };
        check(3.5, 3.5, &[3, 5]);
        check(f64::NEG_INFINITY, 1.5, &[2]);
        check(3.6, f64::INFINITY, &[0, 4]);
        check(3.6, 3.7, &[]);
        check(9.0, 2.0, &[]);
    }
}
