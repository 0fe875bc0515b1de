//! Samples by rank, and iso-ranges among them.
//!
//! Whether a voxel is relevant is asked of its value, which takes a conversion and a multiply-add in 64
//! bits. Values rise with samples (or fall), so an iso-range of values is a range of samples; its ends are
//! found by bisection, with the very arithmetic that makes values, and then samples are compared as they
//! are: exact for every type, and eight or sixteen at a time.

use slabsplat_core::{IsoRange, Sample, Scaling};

/// A sample type whose numbers can be counted, from the least to the largest.
pub(crate) trait Ordered: Sample {
    /// The least number, −∞ for floats.
    const LEAST: Self;
    /// The largest number, +∞ for floats.
    const MOST: Self;

    /// How many numbers are smaller (for floats, up to a constant).
    fn rank(self) -> u64;

    /// The number of that rank.
    fn from_rank(rank: u64) -> Self;

    /// What stands where a neighbour of a voxel with this sample is missing: NaN, or the sample itself for
    /// types without NaN.
    fn missing_neighbor(self) -> Self;
}

macro_rules! impl_ordered_int {
    ($($ty:ty),*) => {$(
        impl Ordered for $ty {
            const LEAST: Self = Self::MIN;
            const MOST: Self = Self::MAX;

            fn rank(self) -> u64 {
                (i64::from(self) - i64::from(Self::MIN)) as u64
            }

            fn from_rank(rank: u64) -> Self {
                (rank as i64 + i64::from(Self::MIN)) as Self
            }

            #[inline]
            fn missing_neighbor(self) -> Self {
                self
            }
        }
    )*};
}

impl_ordered_int!(u8, i8, u16, i16, u32, i32);

macro_rules! impl_ordered_float {
    ($($ty:ty as $bits:ty),*) => {$(
        impl Ordered for $ty {
            const LEAST: Self = Self::NEG_INFINITY;
            const MOST: Self = Self::INFINITY;

            /// Bits that rise as the numbers do; −0 comes right before 0.
            fn rank(self) -> u64 {
                let sign = 1 << (<$bits>::BITS - 1);
                let bits = self.to_bits();
                (if bits & sign == 0 { bits | sign } else { !bits }).into()
            }

            fn from_rank(rank: u64) -> Self {
                let sign = 1 << (<$bits>::BITS - 1);
                let bits = rank as $bits;
                Self::from_bits(if bits & sign == 0 { !bits } else { bits & !sign })
            }

            #[inline]
            fn missing_neighbor(self) -> Self {
                Self::NAN
            }
        }
    )*};
}

impl_ordered_float!(f32 as u32, f64 as u64);

/// The samples whose values are in `range`: the least and the largest of them. There may be none, then
/// the first is above the second.
pub(crate) fn samples_in<T: Ordered>(scaling: Scaling, range: IsoRange) -> [T; 2] {
    let ranks = T::LEAST.rank()..T::MOST.rank() + 1;
    let first_not = |before: &dyn Fn(f64) -> bool| {
        partition_point(ranks.clone(), |rank| before(scaling.apply(T::from_rank(rank).to_f64())))
    };
    let [start, end] = if 0.0 < scaling.slope {
        [first_not(&|value| value < range.lo), first_not(&|value| value <= range.hi)]
    } else {
        [first_not(&|value| range.hi < value), first_not(&|value| range.lo <= value)]
    };
    if start < end { [T::from_rank(start), T::from_rank(end - 1)] } else { [T::MOST, T::LEAST] }
}

/// The first of `ranks` that is not `before`, where those that are come first.
fn partition_point(ranks: std::ops::Range<u64>, before: impl Fn(u64) -> bool) -> u64 {
    let (mut start, mut end) = (ranks.start, ranks.end);
    while start < end {
        let middle = start + (end - start) / 2;
        if before(middle) { start = middle + 1 } else { end = middle }
    }
    start
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check_order<T: Ordered + std::fmt::Debug>(rising: &[T]) {
        for pair in rising.windows(2) {
            assert!(pair[0].rank() < pair[1].rank(), "{pair:?}");
        }
        for &number in rising {
            assert!(T::from_rank(number.rank()) == number, "{number:?}");
        }
    }

    #[test]
    fn ranks_rise_with_numbers() {
        check_order(&[u8::MIN, 1, u8::MAX]);
        check_order(&[i8::MIN, -1, 0, i8::MAX]);
        check_order(&[i32::MIN, -1, 0, i32::MAX]);
        check_order(&[f32::NEG_INFINITY, -1.0, -1e-40, -0.0, 0.0, 1e-40, 1.0, f32::INFINITY]);
        check_order(&[f64::NEG_INFINITY, -1.0, -1e-310, -0.0, 0.0, 1e-310, 1.0, f64::INFINITY]);
    }

    #[test]
    fn samples_in_range_are_those_with_values_inside() {
        let check = |slope: f64, intercept: f64, lo: f64, hi: f64| {
            let scaling = Scaling { slope, intercept };
            let [first, last] = samples_in::<u8>(scaling, IsoRange { lo, hi });
            for sample in 0..=255_u8 {
                let value = scaling.apply(sample.into());
                let is_inside = lo <= value && value <= hi;
                assert_eq!(first <= sample && sample <= last, is_inside, "{sample} {lo} {hi}");
            }
        };
        check(1.0, 0.0, 80.0, 255.0);
        check(1.0, 0.0, 80.5, 80.6);
        check(0.1, 0.3, 0.1 * 7.0 + 0.3, 0.1 * 7.0 + 0.3);
        check(-2.0, 100.0, f64::NEG_INFINITY, 0.0);
        check(-2.0, 100.0, 1000.0, f64::INFINITY);
    }

    #[test]
    fn samples_in_range_of_floats() {
        let scaling = Scaling { slope: 2.0, intercept: 0.0 };
        let check = |lo, hi, expected: [f32; 2]| {
            assert_eq!(samples_in::<f32>(scaling, IsoRange { lo, hi }), expected);
        };
        check(0.0, 3.0, [-0.0, 1.5]);
        check(1.0, f64::INFINITY, [0.5, f32::INFINITY]);
        check(f64::NEG_INFINITY, -1.0, [f32::NEG_INFINITY, -0.5]);
        let between = 1.0_f64.next_up();
        check(between, between, [f32::INFINITY, f32::NEG_INFINITY]);
    }
}
