//! Samples as bytes, in the machine's own order: ranks are of one kind.

use slabsplat::{Sample, SampleType, Samples, with_samples};

/// The type's index, and the samples as they are in memory.
pub(crate) fn to_bytes(samples: &Samples) -> Vec<u8> {
    let mut bytes = vec![type_idx(samples.sample_type())];
    with_samples!(samples, |s| bytes.extend_from_slice(bytemuck::cast_slice(s)));
    bytes
}

/// Nothing if they are no samples.
pub(crate) fn from_bytes(bytes: &[u8]) -> Option<Samples> {
    let (type_idx, bytes) = bytes.split_first()?;
    match TYPES.get(usize::from(*type_idx))? {
        SampleType::U8 => read::<u8>(bytes),
        SampleType::I8 => read::<i8>(bytes),
        SampleType::U16 => read::<u16>(bytes),
        SampleType::I16 => read::<i16>(bytes),
        SampleType::U32 => read::<u32>(bytes),
        SampleType::I32 => read::<i32>(bytes),
        SampleType::F32 => read::<f32>(bytes),
        SampleType::F64 => read::<f64>(bytes),
    }
}

const TYPES: &[SampleType] = SampleType::ALL;

fn type_idx(of: SampleType) -> u8 {
    let idx = TYPES.iter().position(|other| *other == of);
    idx.expect("all types are listed") as u8
}

fn read<T: Sample>(bytes: &[u8]) -> Option<Samples>
where
    Samples: From<Vec<T>>,
{
    if !bytes.len().is_multiple_of(size_of::<T>()) {
        return None;
    }
    let mut samples = vec![T::zeroed(); bytes.len() / size_of::<T>()];
    bytemuck::cast_slice_mut(&mut samples).copy_from_slice(bytes);
    Some(samples.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_what_they_were() {
        let all: [Samples; 8] = [
            vec![0_u8, 255].into(),
            vec![-128_i8].into(),
            vec![65535_u16, 3].into(),
            vec![-3_i16].into(),
            vec![u32::MAX].into(),
            vec![i32::MIN, 1].into(),
            vec![f32::INFINITY, -0.5].into(),
            vec![f64::MIN_POSITIVE].into(),
        ];
        for samples in all {
            let bytes = to_bytes(&samples);
            assert_eq!(from_bytes(&bytes), Some(samples.clone()));
            let is_of_bytes = samples.sample_type().size_bytes() == 1;
            assert_eq!(from_bytes(&bytes[..bytes.len() - 1]).is_some(), is_of_bytes);
        }
        assert_eq!(from_bytes(&[]), None);
        assert_eq!(from_bytes(&[8, 1]), None);
    }
}
