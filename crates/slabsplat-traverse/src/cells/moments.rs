//! Second moments of a cell's normals, where their mean alone is not enough.
//!
//! Of eight voxels whose normals differ much, `|n·l|` has a mean that their mean normal hardly tells, and
//! another in every cell; `lᵀMl`, the mean of `(n·l)²`, tells it: for random normals it is off by a third of
//! that. Where cells are faint, a pixel sees so many that it does not matter.

use super::record::dither;

/// `M`, the mean of `normal·normalᵀ` over a cell's voxels, weighted with their extinctions: xx, yy, zz, xy,
/// xz and yz, in steps of 1/1023. Its trace is the share of voxels that have a normal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Moments(u64);

const STEPS: f32 = 1023.0;
const BITS: usize = 10;

impl Moments {
    /// Rounded with a dither, as [`CellRecord`](super::CellRecord) is, for a cell in that slot.
    pub(super) fn new(moments: [f32; 6], slot: usize) -> Self {
        let rounded = |idx: usize| {
            // Products of two components lie between −½ and ½.
            let from_least = if idx < 3 { moments[idx] } else { moments[idx] + 0.5 };
            ((from_least * STEPS + dither(slot, idx)).clamp(0.0, STEPS) as u64) << (BITS * idx)
        };
        Self((0..6).map(rounded).sum())
    }

    /// All six, 10 bits each, the first in the lowest: the last three from −½ on.
    pub fn to_bits(self) -> u64 {
        self.0
    }

    /// What it was made of, but for rounding.
    #[inline(always)]
    pub fn values(self) -> [f32; 6] {
        let mut values = [0.0; 6];
        for (idx, value) in values.iter_mut().enumerate() {
            let steps = ((self.0 >> (BITS * idx)) as u32 & ((1 << BITS) - 1)) as f32;
            *value = steps * (1.0 / STEPS) - if idx < 3 { 0.0 } else { 0.5 };
        }
        values
    }
}

/// Those of one normal.
#[inline(always)]
pub(super) fn of_normal([x, y, z]: [f32; 3]) -> [f32; 6] {
    [x * x, y * y, z * z, x * y, x * z, y * z]
}

/// `lᵀMl`.
#[inline(always)]
pub(crate) fn along([xx, yy, zz, xy, xz, yz]: [f32; 6], [x, y, z]: [f32; 3]) -> f32 {
    xx * x * x + yy * y * y + zz * z * z + 2.0 * (xy * x * y + xz * x * z + yz * y * z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_seeds::for_each_seed;

    #[test]
    fn moments_are_means_of_squares() {
        for_each_seed(1, |mut rng| {
            let mut direction = || {
                let v = [0; 3].map(|_| rng.f32() - 0.5);
                let length = v.iter().map(|x| x * x).sum::<f32>().sqrt();
                v.map(|x| x / length)
            };
            let (normals, light) = ([0; 8].map(|_| direction()), direction());
            let mut mean = [0.0; 6];
            for normal in normals {
                mean.iter_mut().zip(of_normal(normal)).for_each(|(sum, it)| *sum += it / 8.0);
            }
            let product = |n: [f32; 3]| n.iter().zip(light).map(|(a, b)| a * b).sum::<f32>();
            let expected = normals.map(|n| product(n).powi(2)).iter().sum::<f32>() / 8.0;
            assert!((along(mean, light) - expected).abs() < 1e-6);
            let mut off = 0.0;
            for slot in 0..512 {
                let stored = Moments::new(mean, slot).values();
                assert!((along(stored, light) - expected).abs() < 4e-3);
                off += (along(stored, light) - expected) / 512.0;
            }
            assert!(off.abs() < 1e-4, "{off}");
        });
    }
}
