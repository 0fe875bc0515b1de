//! Samples as keys: how what is said of a volume's values becomes what the shaders compare.
//!
//! A shader has no 64-bit floats. So the host turns what is said of *values* (iso-ranges, points of the
//! transfer function) into what is to be done with *keys*: integers that sort as the samples do, exactly, for
//! every type.

use slabsplat_core::{IsoRange, SampleType, Scaling, Volume};

/// How the samples of a volume sort, and what they stand for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Numbers {
    sample_type: SampleType,
    scaling: Scaling,
}

impl Numbers {
    pub(crate) fn new(volume: &Volume) -> Self {
        Self { sample_type: volume.sample_type(), scaling: volume.scaling() }
    }

    /// The number by which the shaders know the type.
    pub(crate) fn type_code(&self) -> u32 {
        SampleType::ALL.iter().position(|&t| t == self.sample_type).map_or(0, |code| code as u32)
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

    /// Whether values are other numbers than samples.
    #[cfg(test)]
    pub(crate) fn scales(&self) -> bool {
        self.scaling != Scaling::IDENTITY
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
    pub(crate) fn first_key(&self, behind: impl Fn(f64) -> bool) -> u64 {
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
    pub(crate) fn keys(&self) -> [u64; 2] {
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

    /// The value of the sample that has a key.
    pub(crate) fn value(&self, key: u64) -> f64 {
        self.scaling.apply(self.number(key))
    }

    /// The sample that has a key.
    pub(crate) fn number(&self, key: u64) -> f64 {
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

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::{Grid, Samples};
    use slabsplat_seeds::for_each_seed;

    fn numbers(samples: Samples, slope: f64, intercept: f64) -> Numbers {
        let grid = Grid::with_spacing([samples.len(), 1, 1], [1.0; 3]).unwrap();
        Numbers::new(&Volume::new(grid, samples, Scaling { slope, intercept }).unwrap())
    }

    /// A key is in the range exactly if its value is, for every type and sign of slope.
    #[test]
    fn key_ranges_are_exact() {
        for_each_seed(1, |mut rng| {
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
        });
    }

    #[test]
    fn key_range_of_nothing() {
        let numbers = numbers(vec![0_u8].into(), 1.0, 0.0);
        assert_eq!(numbers.key_range(IsoRange { lo: 300.0, hi: 400.0 }), None);
        assert_eq!(numbers.key_range(IsoRange { lo: 7.2, hi: 7.8 }), None);
        assert_eq!(numbers.key_range(IsoRange { lo: 7.0, hi: f64::INFINITY }), Some([7, 255]));
    }
}
