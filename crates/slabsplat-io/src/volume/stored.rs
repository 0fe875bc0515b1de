//! Types of numbers that files have and volumes have not: half floats, and integers of 64 bits.
//!
//! Half floats become `float32`, which holds all of them. Integers of 64 bits become the first of `int32`,
//! `uint32` and `float64` that holds what comes, which is found while they come.

use std::collections::TryReserveError;

use slabsplat_core::{Sample, SampleType, Samples, with_samples};

use super::Endian;

/// What a number in a file is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum StoredType {
    /// What a volume has, too.
    Sample(SampleType),
    /// 16 bits, floating point.
    F16,
    /// 64 bits, signed.
    I64,
    /// 64 bits, unsigned.
    U64,
}

/// From here on not every integer is a 64-bit float.
const MAX_EXACT: i128 = 1 << 53;

impl From<SampleType> for StoredType {
    fn from(sample_type: SampleType) -> Self {
        Self::Sample(sample_type)
    }
}

impl StoredType {
    /// A byte.
    pub(super) const U8_SAMPLE: Self = Self::Sample(SampleType::U8);

    pub(super) fn size_bytes(self) -> usize {
        match self {
            Self::Sample(sample_type) => sample_type.size_bytes(),
            Self::F16 => 2,
            Self::I64 | Self::U64 => 8,
        }
    }

    /// The type that takes the most memory of those that the samples may get.
    pub(super) fn widest(self) -> SampleType {
        match self {
            Self::Sample(sample_type) => sample_type,
            Self::F16 => SampleType::F32,
            Self::I64 | Self::U64 => SampleType::F64,
        }
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Sample(sample_type) => sample_type.name(),
            Self::F16 => "float16",
            Self::I64 => "int64",
            Self::U64 => "uint64",
        }
    }

    /// By NumPy's name.
    pub(super) fn named(name: &str) -> Option<Self> {
        match name {
            "float16" => Some(Self::F16),
            "int64" => Some(Self::I64),
            "uint64" => Some(Self::U64),
            _ => name.parse().ok().map(Self::Sample),
        }
    }

    /// By the letter of its kind and its bytes, as NumPy writes them: `u2`, `f8`, `b1`.
    pub(super) fn of_code(code: &str) -> Option<Self> {
        Self::named(match code {
            "b1" | "u1" => "uint8",
            "i1" => "int8",
            "u2" => "uint16",
            "i2" => "int16",
            "u4" => "uint32",
            "i4" => "int32",
            "u8" => "uint64",
            "i8" => "int64",
            "f2" => "float16",
            "f4" => "float32",
            "f8" => "float64",
            _ => return None,
        })
    }
}

/// Integers of 64 bits, in the least type that held all that came so far.
pub(super) struct Narrowed {
    samples: Samples,
    /// Whether one came that a 64-bit float rounds.
    is_rounded: bool,
}

impl Narrowed {
    pub(super) fn new(samples: Vec<i32>) -> Self {
        Self { samples: Samples::I32(samples), is_rounded: false }
    }

    /// Puts `numbers` where they belong, the first at `first` and each `stride` after the one before.
    pub(super) fn put(
        &mut self,
        first: usize,
        stride: usize,
        numbers: impl Iterator<Item = i128> + Clone,
    ) {
        self.widen_for(numbers.clone());
        let places = numbers.enumerate().map(|(idx, number)| (first + idx * stride, number));
        match &mut self.samples {
            Samples::I32(samples) => places.for_each(|(at, number)| samples[at] = number as i32),
            Samples::U32(samples) => places.for_each(|(at, number)| samples[at] = number as u32),
            Samples::F64(samples) => places.for_each(|(at, number)| samples[at] = number as f64),
            _ => unreachable!("integers are narrowed to three types"),
        }
    }

    /// Appends `numbers`, for which room is reserved first: exactly that of `n_expected`, or more if they
    /// are fewer than those that come.
    pub(super) fn append(
        &mut self,
        numbers: impl ExactSizeIterator<Item = i128> + Clone,
        n_expected: usize,
    ) -> Result<(), TryReserveError> {
        self.widen_for(numbers.clone());
        let n_numbers = numbers.len();
        match &mut self.samples {
            Samples::I32(samples) => {
                reserve(samples, n_numbers, n_expected)?;
                samples.extend(numbers.map(|number| number as i32));
            }
            Samples::U32(samples) => {
                reserve(samples, n_numbers, n_expected)?;
                samples.extend(numbers.map(|number| number as u32));
            }
            Samples::F64(samples) => {
                reserve(samples, n_numbers, n_expected)?;
                samples.extend(numbers.map(|number| number as f64));
            }
            _ => unreachable!("integers are narrowed to three types"),
        }
        Ok(())
    }

    pub(super) fn len(&self) -> usize {
        self.samples.len()
    }

    fn widen_for(&mut self, numbers: impl Iterator<Item = i128>) {
        let (min, max) = numbers.fold((0, 0), |(min, max), n| (n.min(min), n.max(max)));
        self.is_rounded |= min < -MAX_EXACT || MAX_EXACT < max;
        self.widen(min, max);
    }

    fn widen(&mut self, min: i128, max: i128) {
        let is_within = match &self.samples {
            Samples::I32(_) => i128::from(i32::MIN) <= min && max <= i128::from(i32::MAX),
            Samples::U32(_) => 0 <= min && max <= i128::from(u32::MAX),
            _ => true,
        };
        if is_within {
            return;
        }
        let none = Samples::I32(Vec::new());
        self.samples = match std::mem::replace(&mut self.samples, none) {
            Samples::I32(samples)
                if 0 <= min
                    && max <= i128::from(u32::MAX)
                    && samples.iter().all(|&sample| 0 <= sample) =>
            {
                // The same bytes: no second copy.
                Samples::U32(bytemuck::cast_vec(samples))
            }
            Samples::I32(samples) => Samples::F64(samples.into_iter().map(f64::from).collect()),
            Samples::U32(samples) => Samples::F64(samples.into_iter().map(f64::from).collect()),
            others => others,
        };
    }

    pub(super) fn finish(self, stored: StoredType, warnings: &mut Vec<String>) -> Samples {
        warnings.push(said_of_narrowed(stored, self.samples.sample_type(), self.is_rounded));
        self.samples
    }

    /// The same as numbers that hold any of them, and what all that came so far become.
    pub(super) fn widened(self, so_far: &mut WideRange) -> Vec<f64> {
        so_far.is_rounded |= self.is_rounded;
        let numbers: Vec<f64> =
            with_samples!(&self.samples, |s| s.iter().map(|n| n.to_f64()).collect());
        for number in &numbers {
            so_far.ends = [number.min(so_far.ends[0]), number.max(so_far.ends[1])];
        }
        numbers
    }
}

/// The least and the largest of integers of 64 bits, and 0, as they become samples.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct WideRange {
    ends: [f64; 2],
    /// Whether a 64-bit float rounds one.
    is_rounded: bool,
}

impl WideRange {
    /// The type that [`Narrowed`] would have for all of them.
    pub(super) fn sample_type(&self) -> SampleType {
        let [min, max] = self.ends;
        if f64::from(i32::MIN) <= min && max <= f64::from(i32::MAX) {
            SampleType::I32
        } else if 0.0 <= min && max <= f64::from(u32::MAX) {
            SampleType::U32
        } else {
            SampleType::F64
        }
    }

    /// What is to be said of them, if that is what they were.
    pub(super) fn said_of(&self, stored: StoredType) -> String {
        said_of_narrowed(stored, self.sample_type(), self.is_rounded)
    }
}

/// Integers in 64-bit floats as that type, which holds all of them; other samples are of it already.
pub(super) fn narrowed(samples: Samples, narrowed: SampleType) -> Samples {
    match (samples, narrowed) {
        (Samples::F64(numbers), SampleType::I32) => {
            Samples::I32(numbers.into_iter().map(|n| n as i32).collect())
        }
        (Samples::F64(numbers), SampleType::U32) => {
            Samples::U32(numbers.into_iter().map(|n| n as u32).collect())
        }
        (samples, _) => samples,
    }
}

fn said_of_narrowed(stored: StoredType, kept: SampleType, is_rounded: bool) -> String {
    let (stored, kept) = (stored.name(), kept.name());
    if is_rounded {
        format!("samples of {stored} were rounded to {kept}: some are beyond 2^53")
    } else {
        format!("samples of {stored} became {kept}, which holds all of them")
    }
}

/// Room for `n_more` items: just for `n_expected`, if those are more.
pub(super) fn reserve<T>(
    items: &mut Vec<T>,
    n_more: usize,
    n_expected: usize,
) -> Result<(), TryReserveError> {
    match n_expected {
        n if n_more <= n => items.try_reserve_exact(n),
        _ => items.try_reserve(n_more),
    }
}

/// The number in the first bytes of `bytes`.
pub(super) fn integer(bytes: &[u8], stored: StoredType, endian: Endian) -> i128 {
    let mut number = [0; 8];
    number.copy_from_slice(&bytes[..8]);
    if endian == Endian::Big {
        number.reverse();
    }
    match stored {
        StoredType::U64 => i128::from(u64::from_le_bytes(number)),
        _ => i128::from(i64::from_le_bytes(number)),
    }
}

/// The half float in the first bytes of `bytes`.
pub(super) fn half(bytes: &[u8], endian: Endian) -> f32 {
    let bits = [bytes[0], bytes[1]];
    half::f16::from_bits(match endian {
        Endian::Little => u16::from_le_bytes(bits),
        Endian::Big => u16::from_be_bytes(bits),
    })
    .to_f32()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn narrowed_takes_the_least_type() {
        let check = |numbers: &[i128], expected: Samples, word: &str| {
            // One after the other, so that the type changes on the way.
            let mut narrowed = Narrowed::new(vec![0; numbers.len()]);
            for (at, &number) in numbers.iter().enumerate() {
                narrowed.put(at, 1, std::iter::once(number));
            }
            let mut appended = Narrowed::new(Vec::new());
            for &number in numbers {
                appended.append(std::iter::once(number), 0).unwrap();
            }
            assert_eq!(appended.finish(StoredType::I64, &mut Vec::new()), expected);
            let mut warnings = Vec::new();
            assert_eq!(narrowed.finish(StoredType::I64, &mut warnings), expected);
            assert!(warnings[0].contains(word), "{warnings:?}");
        };
        check(&[-5, i128::from(i32::MAX)], Samples::I32(vec![-5, i32::MAX]), "int32");
        check(&[7, 1 << 31], Samples::U32(vec![7, 1 << 31]), "uint32");
        check(&[-1, 1 << 31], Samples::F64(vec![-1.0, 2_147_483_648.0]), "float64");
        check(&[1 << 31, -1], Samples::F64(vec![2_147_483_648.0, -1.0]), "float64");
        check(&[1 << 40], Samples::F64(vec![1_099_511_627_776.0]), "became float64");
        let lost = (1 << 53) + 1;
        check(&[lost], Samples::F64(vec![9_007_199_254_740_992.0]), "rounded to float64");
    }

    #[test]
    fn stored_types_by_name_and_code() {
        assert_eq!(StoredType::of_code("b1"), Some(StoredType::Sample(SampleType::U8)));
        assert_eq!(StoredType::of_code("f2"), StoredType::named("float16"));
        assert_eq!(StoredType::of_code("c8"), None);
        assert_eq!(half(&[0x3c, 0x00], Endian::Big), 1.0);
        assert_eq!(half(&[0x00, 0xc0], Endian::Little), -2.0);
        assert_eq!(integer(&[0xff; 8], StoredType::I64, Endian::Big), -1);
        assert_eq!(integer(&[0xff; 8], StoredType::U64, Endian::Big), i128::from(u64::MAX));
    }
}
