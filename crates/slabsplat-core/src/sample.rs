//! Samples in the type that the file has, from 8 bits to 64, never widened in memory.

use crate::choices::named;

/// A number that a volume can be made of.
pub trait Sample: bytemuck::Pod + PartialOrd + Send + Sync {
    /// The type's name and size.
    const TYPE: SampleType;

    /// The sample as a 64-bit float; exact for every supported type.
    fn to_f64(self) -> f64;
}

/// The type of a volume's samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[expect(clippy::exhaustive_enums, reason = "who reads samples has to know each")]
pub enum SampleType {
    /// 8 bits, unsigned.
    U8,
    /// 8 bits, signed.
    I8,
    /// 16 bits, unsigned.
    U16,
    /// 16 bits, signed.
    I16,
    /// 32 bits, unsigned.
    U32,
    /// 32 bits, signed.
    I32,
    /// 32 bits, floating point.
    F32,
    /// 64 bits, floating point.
    F64,
}

impl SampleType {
    /// Bytes of one sample.
    pub fn size_bytes(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

// NumPy's names.
named!(SampleType {
    U8 = "uint8",
    I8 = "int8",
    U16 = "uint16",
    I16 = "int16",
    U32 = "uint32",
    I32 = "int32",
    F32 = "float32",
    F64 = "float64",
});

/// Runs `$body` with `$slice` bound to the slice inside `$samples`, whatever its type is.
#[macro_export]
macro_rules! with_samples {
    ($samples:expr, |$slice:ident| $body:expr) => {
        match $samples {
            $crate::Samples::U8($slice) => $body,
            $crate::Samples::I8($slice) => $body,
            $crate::Samples::U16($slice) => $body,
            $crate::Samples::I16($slice) => $body,
            $crate::Samples::U32($slice) => $body,
            $crate::Samples::I32($slice) => $body,
            $crate::Samples::F32($slice) => $body,
            $crate::Samples::F64($slice) => $body,
        }
    };
}

/// The samples of a volume, x fastest, in their own type.
#[derive(Clone, Debug, PartialEq)]
#[expect(clippy::exhaustive_enums, reason = "who reads samples has to know each")]
pub enum Samples {
    /// 8 bits, unsigned.
    U8(Vec<u8>),
    /// 8 bits, signed.
    I8(Vec<i8>),
    /// 16 bits, unsigned.
    U16(Vec<u16>),
    /// 16 bits, signed.
    I16(Vec<i16>),
    /// 32 bits, unsigned.
    U32(Vec<u32>),
    /// 32 bits, signed.
    I32(Vec<i32>),
    /// 32 bits, floating point.
    F32(Vec<f32>),
    /// 64 bits, floating point.
    F64(Vec<f64>),
}

impl Samples {
    /// How many samples there are.
    pub fn len(&self) -> usize {
        with_samples!(self, |s| s.len())
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Adds others of the same type behind these.
    ///
    /// # Panics
    /// If they are of another type.
    pub fn append(&mut self, others: &Self) {
        assert_eq!(self.sample_type(), others.sample_type(), "samples of one volume have one type");
        fn append<T: Sample>(samples: &mut Vec<T>, others: &Samples) {
            with_samples!(others, |s| samples.extend_from_slice(bytemuck::cast_slice(s)));
        }
        with_samples!(self, |s| append(s, others));
    }

    /// The type of the samples.
    pub fn sample_type(&self) -> SampleType {
        fn type_of<T: Sample>(_: &[T]) -> SampleType {
            T::TYPE
        }
        with_samples!(self, |s| type_of(s))
    }
}

macro_rules! impl_sample {
    ($($ty:ty => $variant:ident),*) => {$(
        impl Sample for $ty {
            const TYPE: SampleType = SampleType::$variant;

            #[inline]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
        }

        impl From<Vec<$ty>> for Samples {
            fn from(samples: Vec<$ty>) -> Self {
                Self::$variant(samples)
            }
        }
    )*};
}

impl_sample!(u8 => U8, i8 => I8, u16 => U16, i16 => I16, u32 => U32, i32 => I32, f32 => F32, f64 => F64);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sample_type_names_round_trip() {
        for &t in SampleType::ALL {
            assert_eq!(t.name().parse(), Ok(t));
            assert!(t.name().ends_with(&(8 * t.size_bytes()).to_string()));
        }
        assert!("complex64".parse::<SampleType>().is_err());
    }

    #[test]
    fn samples_are_appended() {
        let mut samples = Samples::from(vec![1_i16, -2]);
        samples.append(&vec![3_i16].into());
        assert_eq!(samples, vec![1_i16, -2, 3].into());
    }

    #[test]
    fn samples_know_their_type() {
        assert_eq!(Samples::from(vec![1_i16]).sample_type(), SampleType::I16);
        assert_eq!(Samples::from(vec![1.0_f64, 2.0]).len(), 2);
        assert!(Samples::U8(vec![]).is_empty() && !Samples::U8(vec![0]).is_empty());
    }
}
