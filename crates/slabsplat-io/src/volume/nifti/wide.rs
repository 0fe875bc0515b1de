//! Integers of 64 bits, which label maps of NumPy have: nearly always they fit into 32.

use std::io::Read;

use slabsplat_core::Samples;

use super::super::Endian;
use super::super::stream::DataStream;
use crate::IoError;

/// Voxels that are read at a time.
const N_AT_ONCE: usize = 1 << 13;

/// Integers that a 64-bit float has all of.
const MAX_EXACT: u64 = 1 << 53;

/// Reads voxels as integers of 32 bits, or, if one does not fit, as 64-bit floats.
pub(super) fn read(
    stream: &mut DataStream<'_>,
    n_voxels: usize,
    is_signed: bool,
    endian: Endian,
    warnings: &mut Vec<String>,
) -> Result<Samples, IoError> {
    stream.check_left((n_voxels as u64).saturating_mul(8))?;
    let mut wide = Wide { is_signed, ..Wide::default() };
    let mut bytes = vec![0; 8 * N_AT_ONCE.min(n_voxels)];
    let mut n_left = n_voxels;
    while 0 < n_left {
        let n = n_left.min(N_AT_ONCE);
        let chunk = &mut bytes[..8 * n];
        stream.read_exact(chunk).map_err(|source| stream.read_error(source))?;
        for voxel in chunk.chunks_exact(8) {
            let voxel = voxel.try_into().expect("chunks have this size");
            let bits = match endian {
                Endian::Little => u64::from_le_bytes(voxel),
                Endian::Big => u64::from_be_bytes(voxel),
            };
            wide.push(bits);
        }
        n_left -= n;
    }
    if wide.is_rounded {
        let what = "some integers are too large for 64-bit floats, and were rounded";
        warnings.push(what.to_owned());
    }
    Ok(wide.finish())
}

/// Voxels as they come.
#[derive(Default)]
struct Wide {
    is_signed: bool,
    /// While all fit: the bits of 32-bit integers.
    narrow: Vec<u32>,
    /// From the first that does not.
    floats: Vec<f64>,
    is_rounded: bool,
}

impl Wide {
    fn push(&mut self, bits: u64) {
        let narrow = if self.is_signed {
            i32::try_from(bits as i64).ok().map(|value| value as u32)
        } else {
            u32::try_from(bits).ok()
        };
        if let (Some(narrow), true) = (narrow, self.floats.is_empty()) {
            self.narrow.push(narrow);
            return;
        }
        if self.floats.is_empty() {
            let is_signed = self.is_signed;
            let float =
                |bits: u32| if is_signed { f64::from(bits as i32) } else { f64::from(bits) };
            self.floats = std::mem::take(&mut self.narrow).into_iter().map(float).collect();
        }
        let (float, size) = if self.is_signed {
            ((bits as i64) as f64, (bits as i64).unsigned_abs())
        } else {
            (bits as f64, bits)
        };
        self.is_rounded |= MAX_EXACT < size;
        self.floats.push(float);
    }

    fn finish(self) -> Samples {
        match (self.floats.is_empty(), self.is_signed) {
            (false, _) => Samples::F64(self.floats),
            (true, true) => Samples::I32(bytemuck::cast_vec(self.narrow)),
            (true, false) => Samples::U32(self.narrow),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wide(is_signed: bool, values: &[u64]) -> (Samples, bool) {
        let mut wide = Wide { is_signed, ..Wide::default() };
        values.iter().for_each(|&bits| wide.push(bits));
        let is_rounded = wide.is_rounded;
        (wide.finish(), is_rounded)
    }

    #[test]
    fn wide_integers_are_as_narrow_as_they_can_be() {
        assert_eq!(wide(true, &[1, u64::MAX]), (Samples::I32(vec![1, -1]), false));
        assert_eq!(wide(false, &[1, 1 << 31]), (Samples::U32(vec![1, 1 << 31]), false));
        let expected = Samples::F64(vec![1.0, 4_294_967_296.0, 2.0]);
        assert_eq!(wide(false, &[1, 1 << 32, 2]), (expected, false));
        let expected = Samples::F64(vec![-1.0, -9.223_372_036_854_776e18]);
        assert_eq!(wide(true, &[u64::MAX, 1 << 63]), (expected, true));
    }
}
