//! A volume on the device: its samples in their own type, in pieces that fit a binding.
//!
//! A piece covers a run of voxels, and holds one slice more on either side, so that gradients need no
//! other piece.

use crate::number::{f32_key, f64_key, integer_key};
use slabsplat_core::{Samples, Volume, with_samples};
use std::borrow::Cow;
use std::ops::Range;

/// Voxels that a workgroup of the classification looks at.
pub(crate) const VOXELS_PER_BLOCK: usize = 2048;

/// Samples at whose multiples pieces begin, so that they begin with a word.
const SAMPLES_PER_WORD: usize = 4;

/// A piece of a volume.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Piece {
    /// Its voxels.
    pub(crate) voxels: Range<usize>,
    /// The samples that it holds.
    pub(crate) samples: Range<usize>,
}

/// Cuts a volume into pieces of at most `max_bytes`; `Err` says how many bytes the smallest takes.
pub(crate) fn pieces(volume: &Volume, max_bytes: u64) -> Result<Vec<Piece>, u64> {
    let [nx, ny, _] = volume.grid().dims();
    let (n_voxels, sample_bytes) = (volume.grid().n_voxels(), volume.sample_type().size_bytes());
    let halo = nx * ny;
    let padding = 2 * SAMPLES_PER_WORD;
    let max_samples = usize::try_from(max_bytes).unwrap_or(usize::MAX) / sample_bytes;
    let n_blocks = max_samples.saturating_sub(2 * halo + padding) / VOXELS_PER_BLOCK;
    if n_blocks == 0 && max_samples < n_voxels + padding {
        return Err(((2 * halo + padding + VOXELS_PER_BLOCK) * sample_bytes) as u64);
    }
    let len = (n_blocks * VOXELS_PER_BLOCK).max(VOXELS_PER_BLOCK);
    let piece = |first: usize| {
        let end = (first + len).min(n_voxels);
        let first_sample = first.saturating_sub(halo) / SAMPLES_PER_WORD * SAMPLES_PER_WORD;
        Piece { voxels: first..end, samples: first_sample..(end + halo).min(n_voxels) }
    };
    Ok((0..n_voxels).step_by(len).map(piece).collect())
}

impl Piece {
    /// The bytes of its samples: whole words, and what is left over, filled up to a word.
    pub(crate) fn bytes<'a>(&self, volume: &'a Volume) -> [Cow<'a, [u8]>; 2] {
        let bytes: &[u8] =
            with_samples!(volume.samples(), |s| { bytemuck::cast_slice(&s[self.samples.clone()]) });
        let (words, rest) = bytes.split_at(bytes.len() / 4 * 4);
        let mut last = rest.to_vec();
        last.resize(rest.len().div_ceil(4) * 4, 0);
        [words.into(), last.into()]
    }

    /// Bytes that it takes on the device.
    pub(crate) fn n_bytes(&self, volume: &Volume) -> u64 {
        (self.samples.len() * volume.sample_type().size_bytes()).div_ceil(4) as u64 * 4
    }
}

/// How many samples there are of each key, or of each run of keys that agree in their upper 16 bits. It says
/// at once how many voxels can be relevant, before the device has counted.
#[derive(Clone, Debug)]
pub(crate) struct KeyCounts {
    counts: Vec<u32>,
    /// The least key that there can be.
    first_key: u64,
    /// Lower bits of a key, which are not distinguished.
    dropped_bits: u32,
}

impl KeyCounts {
    pub(crate) fn new(volume: &Volume) -> Self {
        match volume.samples() {
            Samples::U8(s) => Self::count(s, 0, 0, |&i| u64::from(i)),
            Samples::U16(s) => Self::count(s, 0, 0, |&i| u64::from(i)),
            Samples::I8(s) => {
                Self::count(s, integer_key(i8::MIN.into()), 0, |&i| integer_key(i.into()))
            }
            Samples::I16(s) => {
                Self::count(s, integer_key(i16::MIN.into()), 0, |&i| integer_key(i.into()))
            }
            Samples::U32(s) => Self::count(s, 0, 16, |&i| u64::from(i)),
            Samples::I32(s) => Self::count(s, 0, 16, |&i| integer_key(i)),
            Samples::F32(s) => Self::count(s, 0, 16, |&f| f32_key(f)),
            Samples::F64(s) => Self::count(s, 0, 48, |&f| f64_key(f)),
        }
    }

    fn count<T>(
        samples: &[T],
        first_key: u64,
        dropped_bits: u32,
        key_of: impl Fn(&T) -> u64,
    ) -> Self {
        let mut counts = vec![0; 1 << 16];
        for sample in samples {
            counts[((key_of(sample) - first_key) >> dropped_bits) as usize] += 1;
        }
        Self { counts, first_key, dropped_bits }
    }

    /// At least as many samples as have keys within the ranges, which are disjoint and rise.
    pub(crate) fn at_most(&self, key_ranges: &[[u64; 2]]) -> u64 {
        let mut n_samples = 0;
        // Two ranges may begin and end in one run of keys, which is counted once.
        let mut next_run = 0;
        for range in key_ranges {
            let [first, last] =
                range.map(|key| ((key - self.first_key) >> self.dropped_bits) as usize);
            let runs = first.max(next_run)..last + 1;
            next_run = next_run.max(last + 1);
            n_samples += self.counts[runs].iter().map(|&n| u64::from(n)).sum::<u64>();
        }
        n_samples
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::{Grid, Scaling};

    fn volume(dims: [usize; 3], samples: Samples) -> Volume {
        let grid = Grid::with_spacing(dims, [1.0; 3]).unwrap();
        Volume::new(grid, samples, Scaling::IDENTITY).unwrap()
    }

    /// Every voxel is in one piece, with all its neighbours.
    #[test]
    fn pieces_hold_their_neighbours() {
        let dims = [33, 21, 40];
        let halo = dims[0] * dims[1];
        let n_voxels = halo * dims[2];
        let volume = volume(dims, vec![0_u16; n_voxels].into());
        for max_bytes in [8_000, 10_000, 30_000, 1 << 20] {
            let pieces = pieces(&volume, max_bytes).unwrap();
            assert_eq!(pieces[0].voxels.start, 0);
            assert_eq!(pieces[pieces.len() - 1].voxels.end, n_voxels);
            for pair in pieces.windows(2) {
                assert_eq!(pair[0].voxels.end, pair[1].voxels.start);
            }
            for piece in pieces {
                assert!(piece.n_bytes(&volume) <= max_bytes, "{piece:?}");
                assert!(piece.samples.start <= piece.voxels.start.saturating_sub(halo));
                assert!((piece.voxels.end + halo).min(n_voxels) <= piece.samples.end);
                let [words, last] = piece.bytes(&volume);
                assert_eq!((words.len() + last.len()) as u64, piece.n_bytes(&volume));
            }
        }
        assert_eq!(pieces(&volume, 1000), Err((2 * halo + 8 + 2048) as u64 * 2));
    }

    #[test]
    fn key_counts_are_never_too_few() {
        let counts = KeyCounts::new(&volume([5, 1, 1], vec![1_u8, 3, 3, 200, 255].into()));
        assert_eq!(counts.at_most(&[[2, 3], [200, 254]]), 3);
        let signed = KeyCounts::new(&volume([4, 1, 1], vec![-300_i16, -2, 0, 7].into()));
        assert_eq!(signed.at_most(&[[integer_key(-2), integer_key(6)]]), 2);
        let floats = vec![-1.0_f32, 0.5, 0.50001, 2.0, f32::NAN];
        let counts = KeyCounts::new(&volume([5, 1, 1], floats.into()));
        let key = f32_key(0.5);
        assert_eq!(counts.at_most(&[[key, key], [f32_key(0.50001), f32_key(0.50002)]]), 2);
        assert_eq!(counts.at_most(&[]), 0);
    }
}
