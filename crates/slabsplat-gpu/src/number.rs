//! Samples as keys and as numbers: how a volume's values become what the shaders compare and interpolate.
//!
//! A shader has no 64-bit floats. So the host turns what is said of *values* (iso-ranges, points of
//! the transfer function) into what is to be done with *samples*: ranges into ranges of keys, which are
//! exact for every type, and positions into positions among the samples' own numbers, where 8- and 16-bit
//! integers and 32-bit floats need no rounding.

use slabsplat_core::{IsoRange, SampleType, Scaling, Volume};

/// How the samples of a volume sort, and what they stand for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Numbers {
    sample_type: SampleType,
    scaling: Scaling,
    /// Floating-point samples are divided by this power of two.
    exponent: i32,
}

/// Positions of points stay finite as floats.
const FURTHEST: f64 = 1e30;

impl Numbers {
    pub(crate) fn new(volume: &Volume) -> Self {
        Self { sample_type: volume.sample_type(), scaling: volume.scaling(), exponent: 0 }
    }

    /// The same, with floating-point samples scaled so that those among which `values` lie are near 1. Others
    /// may be too large for a float, and then lie beyond all values, or too small, and are 0 beside them.
    pub(crate) fn scaled_for(self, values: impl Iterator<Item = f64>) -> Self {
        let exponent =
            exponent_of(values.map(|value| self.inverse(value).abs()).fold(0.0, f64::max));
        // What the powers are multiplied with stays finite, and for 32 bits they are floats themselves.
        let exponent = match self.sample_type {
            SampleType::F32 => exponent.clamp(-100, 100),
            SampleType::F64 => exponent.clamp(-1022, 1022),
            _ => 0,
        };
        Self { exponent, ..self }
    }

    /// The sample that would have a value, be there such a sample or not.
    fn inverse(&self, value: f64) -> f64 {
        let sample = (value - self.scaling.intercept) / self.scaling.slope;
        sample.clamp(-f64::MAX, f64::MAX)
    }

    /// The number by which the shaders know the type.
    pub(crate) fn type_code(&self) -> u32 {
        SampleType::ALL.iter().position(|&t| t == self.sample_type).map_or(0, |code| code as u32)
    }

    /// Samples are divided by two to the power of this.
    pub(crate) fn exponent(&self) -> i32 {
        self.exponent
    }

    /// Whether values fall where samples rise.
    pub(crate) fn is_falling(&self) -> bool {
        self.scaling.slope < 0.0
    }

    /// The keys of the samples with values in `range`: the least and the largest; `None` if there are none.
    pub(crate) fn key_range(&self, range: IsoRange) -> Option<[u64; 2]> {
        let first = self.first_key(|value| match self.is_falling() {
            false => range.lo <= value,
            true => value <= range.hi,
        });
        let end = self.first_key(|value| match self.is_falling() {
            false => range.hi < value,
            true => value < range.lo,
        });
        (first < end).then(|| [first, end - 1])
    }

    /// Where among the scaled numbers of the samples a value lies: at the number of the sample that has
    /// it, or strictly between those of the samples before and after.
    pub(crate) fn position(&self, value: f64) -> f64 {
        let [least, largest] = self.keys();
        let after = self.first_key(|v| if self.is_falling() { v <= value } else { value <= v });
        let exact = self.inverse(value);
        let mut position = exact;
        if after <= largest && self.value(after) == value {
            position = self.number(after);
        } else if least < after && after <= largest {
            let [lower, upper] = [after - 1, after].map(|key| self.number(key));
            let margin = ((upper - lower) * 2e-9).max(exact.abs() * 2e-14);
            if (lower + margin).is_finite() && lower + margin < upper - margin {
                position = exact.clamp(lower + margin, upper - margin);
            }
        }
        (position * 2_f64.powi(-self.exponent)).clamp(-FURTHEST, FURTHEST)
    }

    /// A key as two words, the high one first, as the shaders compare it.
    pub(crate) fn words(&self, key: u64) -> [u32; 2] {
        match self.sample_type {
            SampleType::F64 => [(key >> 32) as u32, key as u32],
            _ => [key as u32, 0],
        }
    }

    /// The first key whose value is `behind` something, where all after it are; one past the last if none
    /// is.
    fn first_key(&self, behind: impl Fn(f64) -> bool) -> u64 {
        let [mut lo, largest] = self.keys();
        let mut hi = largest + 1;
        while lo < hi {
            let middle = lo + (hi - lo) / 2;
            if behind(self.value(middle)) {
                hi = middle;
            } else {
                lo = middle + 1;
            }
        }
        lo
    }

    /// The keys of the least and the largest number, infinities included.
    fn keys(&self) -> [u64; 2] {
        match self.sample_type {
            SampleType::U8 => [0, u64::from(u8::MAX)],
            SampleType::U16 => [0, u64::from(u16::MAX)],
            SampleType::U32 => [0, u64::from(u32::MAX)],
            SampleType::I8 => [i8::MIN, i8::MAX].map(|i| integer_key(i.into())),
            SampleType::I16 => [i16::MIN, i16::MAX].map(|i| integer_key(i.into())),
            SampleType::I32 => [i32::MIN, i32::MAX].map(integer_key),
            SampleType::F32 => [f32::NEG_INFINITY, f32::INFINITY].map(f32_key),
            SampleType::F64 => [f64::NEG_INFINITY, f64::INFINITY].map(f64_key),
        }
    }

    fn value(&self, key: u64) -> f64 {
        self.scaling.apply(self.number(key))
    }

    /// The sample that has a key.
    fn number(&self, key: u64) -> f64 {
        match self.sample_type {
            SampleType::U8 | SampleType::U16 | SampleType::U32 => key as f64,
            SampleType::I8 | SampleType::I16 | SampleType::I32 => {
                f64::from((key as u32 ^ SIGN_32) as i32)
            }
            SampleType::F32 => {
                let key = key as u32;
                f32::from_bits(if key & SIGN_32 == 0 { !key } else { key ^ SIGN_32 }).into()
            }
            SampleType::F64 => {
                f64::from_bits(if key & SIGN_64 == 0 { !key } else { key ^ SIGN_64 })
            }
        }
    }
}

const SIGN_32: u32 = 1 << 31;
const SIGN_64: u64 = 1 << 63;

pub(crate) fn integer_key(i: i32) -> u64 {
    u64::from(i as u32 ^ SIGN_32)
}

pub(crate) fn f32_key(number: f32) -> u64 {
    let bits = number.to_bits();
    u64::from(if bits & SIGN_32 == 0 { bits | SIGN_32 } else { !bits })
}

pub(crate) fn f64_key(number: f64) -> u64 {
    let bits = number.to_bits();
    if bits & SIGN_64 == 0 { bits | SIGN_64 } else { !bits }
}

/// A number as the sum of two floats.
pub(crate) fn split(number: f64) -> [f32; 2] {
    let high = number as f32;
    [high, (number - f64::from(high)) as f32]
}

/// The power of two at or below a number; 0 for 0.
fn exponent_of(number: f64) -> i32 {
    if number == 0.0 { 0 } else { number.log2().floor() as i32 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::{Grid, Samples};

    fn numbers(samples: Samples, slope: f64, intercept: f64) -> Numbers {
        let grid = Grid::with_spacing([samples.len(), 1, 1], [1.0; 3]).unwrap();
        Numbers::new(&Volume::new(grid, samples, Scaling { slope, intercept }).unwrap())
    }

    /// A key is in the range exactly if its value is, for every type and sign of slope.
    #[test]
    fn key_ranges_are_exact() {
        let seed = fastrand::u64(..);
        println!("seed {seed}");
        let mut rng = fastrand::Rng::with_seed(seed);
        for slope in [1.0, 0.1, -0.3] {
            let cases = [
                numbers(vec![0_u8].into(), slope, 7.0),
                numbers(vec![0_i8].into(), slope, 7.0),
                numbers(vec![0_u16].into(), slope, 7.0),
                numbers(vec![0_i16].into(), slope, 7.0),
                numbers(vec![0_u32].into(), slope, 7.0),
                numbers(vec![0_i32].into(), slope, 7.0),
                numbers(vec![1.0_f32].into(), slope, 7.0),
                numbers(vec![1.0_f64].into(), slope, 7.0),
            ];
            for numbers in cases {
                let [least, largest] = numbers.keys();
                for _ in 0..200 {
                    let [a, b] = [0, 1].map(|_| numbers.value(rng.u64(least..=largest)));
                    let (lo, hi) = (a.min(b), a.max(b));
                    let range = numbers.key_range(IsoRange { lo, hi });
                    for key in [0, 1].map(|_| rng.u64(least..=largest)) {
                        let value = numbers.value(key);
                        let expected = lo <= value && value <= hi;
                        let inside = range.is_some_and(|[a, b]| a <= key && key <= b);
                        assert_eq!(inside, expected, "{numbers:?} {lo} {hi} {value}");
                    }
                }
            }
        }
    }

    #[test]
    fn key_range_of_nothing() {
        let numbers = numbers(vec![0_u8].into(), 1.0, 0.0);
        assert_eq!(numbers.key_range(IsoRange { lo: 300.0, hi: 400.0 }), None);
        assert_eq!(numbers.key_range(IsoRange { lo: 7.2, hi: 7.8 }), None);
        assert_eq!(numbers.key_range(IsoRange { lo: 7.0, hi: f64::INFINITY }), Some([7, 255]));
    }

    /// A step at a value that a sample has must stay on the right side of that sample.
    #[test]
    fn positions_keep_their_side() {
        for slope in [0.1, -0.1] {
            let numbers = numbers(vec![0_u8].into(), slope, 0.3);
            for sample in 0..=255_u64 {
                let value = numbers.value(sample);
                assert_eq!(numbers.position(value), sample as f64);
                for (beside, is_above) in [(value.next_up(), true), (value.next_down(), false)] {
                    let position = numbers.position(beside);
                    let is_behind = is_above == (0.0 < slope);
                    assert_eq!((sample as f64) < position, is_behind, "{sample} {position}");
                    assert!((position - sample as f64).abs() < 1e-6);
                }
            }
        }
    }

    #[test]
    fn positions_of_floats_are_scaled() {
        let numbers = numbers(vec![1.0_f32].into(), 2.0, 0.0).scaled_for([6e30, -1e3].into_iter());
        assert_eq!(numbers.exponent(), 100);
        assert_eq!(numbers.position(2.0 * 2_f64.powi(100)), 1.0);
        assert_eq!(split(1.0 + 2_f64.powi(-30)), [1.0, 2_f32.powi(-30)]);
    }
}
