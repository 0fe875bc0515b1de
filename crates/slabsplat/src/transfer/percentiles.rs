//! Percentiles of a volume's values, and what parts an object from its background.
//!
//! Values are counted in bins, and those of the bin that has the one asked for again in bins of its own:
//! nothing is sorted or copied, and values of 16 bits are found at once.

use super::values::{Bins, VolumeValues};
use crate::otsu;

/// Bins in which percentiles are looked for: those of 16 bits each have one.
const N_FINE_BINS: usize = 1 << 16;

/// Times that a bin is counted again in bins of its own: 16 bits each.
const N_PASSES: usize = 4;

/// Bins that are fine enough to part an object from its background.
const N_COARSE_BINS: usize = 512;

/// What so many percent of the finite values do not exceed: the least value of which that is true. `None` if
/// no value is finite.
pub(super) fn percentile(values: &dyn VolumeValues, percent: f64) -> Option<f64> {
    percentile_within(values, values.range()?, percent)
}

/// The same of the values within a range whose ends some have.
fn percentile_within(values: &dyn VolumeValues, range: [f64; 2], percent: f64) -> Option<f64> {
    let mut bins = Bins { range, n_bins: N_FINE_BINS };
    let (mut n_before, mut rank) = (0, None);
    for _ in 0..N_PASSES {
        if bins.range[0] == bins.range[1] {
            break;
        }
        let counts = values.counts(bins);
        let rank = *rank.get_or_insert_with(|| rank_of(percent, counts.iter().sum()));
        let mut n_until = n_before;
        let bin = counts.iter().position(|&n| {
            n_until += n;
            rank <= n_until
        })?;
        n_before = n_until - counts[bin];
        bins.range = values.extremes_where(&|value| bins.bin_of(value) == Some(bin))?;
    }
    Some(bins.range[0])
}

/// Which of `n` sorted values a percentile is, from 1 on.
fn rank_of(percent: f64, n: u64) -> u64 {
    ((percent / 100.0 * n as f64).ceil() as u64).clamp(1, n.max(1))
}

/// The level of the background, and what so many percent of the object do not exceed, as [`otsu`] parts them;
/// `None` if fewer than two values differ.
pub(super) fn object_range(values: &dyn VolumeValues, percent: f64) -> Option<[f64; 2]> {
    let range = values.range().filter(|[lo, hi]| lo < hi)?;
    let bins = Bins { range, n_bins: N_COARSE_BINS };
    let last = otsu::split(&values.counts(bins)).last;
    let is_behind = |value| bins.bin_of(value).is_some_and(|bin| bin <= last);
    let is_object = |value| bins.bin_of(value).is_some_and(|bin| last < bin);
    let background = percentile_within(values, values.extremes_where(&is_behind)?, 50.0)?;
    let bright = percentile_within(values, values.extremes_where(&is_object)?, percent)?;
    (background < bright).then_some([background, bright])
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::{Grid, Samples, Scaling, Volume};

    fn row(samples: Samples) -> Volume {
        let grid = Grid::with_spacing([samples.len(), 1, 1], [1.0; 3]).unwrap();
        Volume::new(grid, samples, Scaling::IDENTITY).unwrap()
    }

    /// Against sorting.
    #[test]
    fn percentiles_are_those_of_sorted_values() {
        let mut state = 1_u64;
        let mut values: Vec<f64> = Vec::new();
        for _ in 0..5000 {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let x = (state >> 11) as f64 / (1_u64 << 53) as f64;
            values.push(if x < 0.7 { 0.0 } else { (1.0 - x).ln() * 1e3 });
        }
        // Strays that leave nearly all in one bin.
        values.extend([1e300, -1e12, f64::NAN, f64::INFINITY]);
        let mut sorted: Vec<f64> =
            values.iter().copied().filter(|value| value.is_finite()).collect();
        sorted.sort_by(f64::total_cmp);
        let volume = row(Samples::F64(values));
        for percent in [0.0, 0.01, 1.0, 12.5, 29.0, 31.0, 50.0, 99.9, 100.0] {
            let rank = ((percent / 100.0 * sorted.len() as f64).ceil() as usize).max(1);
            let found = percentile(&volume, percent).unwrap();
            // Four passes leave 2⁻⁶⁴ of the range.
            let is_close = (found - sorted[rank - 1]).abs() <= 1e300 * 2.0_f64.powi(-62);
            assert!(is_close, "{percent} %: {found}, not {}", sorted[rank - 1]);
        }
    }

    #[test]
    fn percentiles_of_few_bits_are_exact() {
        let volume = row(Samples::I16((-500..500).collect()));
        for (percent, expected) in
            [(0.0, -500.0), (0.1, -500.0), (0.2, -499.0), (50.0, -1.0), (100.0, 499.0)]
        {
            assert_eq!(percentile(&volume, percent), Some(expected), "{percent} %");
        }
        assert_eq!(percentile(&row(Samples::U8(vec![7])), 3.0), Some(7.0));
        assert_eq!(percentile(&row(Samples::F32(vec![f32::NAN])), 3.0), None);
        let wide = row(Samples::F64(vec![-1.7e308, 1.7e308]));
        assert_eq!([50.0, 51.0].map(|p| percentile(&wide, p)), [Some(-1.7e308), Some(1.7e308)]);
    }

    #[test]
    fn object_is_above_its_background() {
        let mut samples: Vec<u8> = (0..800).map(|idx| 5 + (idx % 3) as u8).collect();
        samples.extend((0..100).map(|idx| 100 + idx as u8));
        let volume = row(Samples::U8(samples));
        assert_eq!(object_range(&volume, 100.0), Some([6.0, 199.0]));
        assert_eq!(object_range(&volume, 50.0), Some([6.0, 149.0]));
        for samples in [vec![3], vec![3, 3]] {
            assert_eq!(object_range(&row(Samples::U8(samples)), 99.0), None);
        }
        assert_eq!(object_range(&row(Samples::U8(vec![0, 9])), 99.0), Some([0.0, 9.0]));
    }
}
