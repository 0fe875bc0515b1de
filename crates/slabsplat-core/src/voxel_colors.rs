//! Voxels that have colours of their own (model §15): red, green and blue beside the scalar that opacity and
//! normals are made of.

use std::fmt;
use std::sync::Arc;
use thiserror::Error;

/// The colour of each voxel of a grid; a copy shares them.
///
/// ```
/// use slabsplat_core::{ColorSamples, VoxelColors};
///
/// let colors = VoxelColors::new([2, 1, 1], ColorSamples::U8(vec![[255, 0, 0], [0, 51, 255]]))?;
/// assert_eq!(colors.at(1), [0.0, 0.2, 1.0]);
/// assert_eq!(colors.samples().luminances().sample_type().name(), "uint8");
/// # Ok::<(), slabsplat_core::WrongNumberOfColors>(())
/// ```
#[derive(Clone)]
pub struct VoxelColors {
    dims: [usize; 3],
    samples: Arc<ColorSamples>,
}

/// Red, green and blue of voxels, x fastest, as integers from 0 to the largest of their type:
/// display-referred, and not multiplied with any opacity.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ColorSamples {
    /// Of 8 bits.
    U8(Vec<[u8; 3]>),
    /// Of 16 bits.
    U16(Vec<[u16; 3]>),
}

/// There is not one colour for each voxel.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{n_voxels} voxels were given {n_colors} colours")]
#[non_exhaustive]
pub struct WrongNumberOfColors {
    /// Voxels of the grid.
    pub n_voxels: usize,
    /// Colours given.
    pub n_colors: usize,
}

impl VoxelColors {
    /// Colours of a grid of so many voxels along each axis.
    ///
    /// # Errors
    /// If there are more of them or fewer.
    pub fn new(dims: [usize; 3], samples: ColorSamples) -> Result<Self, WrongNumberOfColors> {
        let n_voxels = dims.into_iter().fold(1, usize::saturating_mul);
        let n_colors = samples.len();
        if n_voxels != n_colors {
            return Err(WrongNumberOfColors { n_voxels, n_colors });
        }
        Ok(Self { dims, samples: Arc::new(samples) })
    }

    /// Voxels along the axes of the grid.
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// The colours as they are stored.
    pub fn samples(&self) -> &ColorSamples {
        &self.samples
    }

    /// Red, green and blue of a voxel, 0 … 1 each.
    #[inline]
    pub fn at(&self, voxel_idx: usize) -> [f32; 3] {
        self.samples.at(voxel_idx)
    }

    /// Whether both are the same colours, in memory.
    pub fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.samples, &other.samples) && self.dims == other.dims
    }
}

impl fmt::Debug for VoxelColors {
    /// All but the colours themselves, of which there may be billions.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { dims, samples } = self;
        let n_bits = 8 * samples.size_bytes() / (3 * samples.len().max(1));
        f.debug_struct("VoxelColors").field("dims", dims).field("n_bits", &n_bits).finish()
    }
}

impl PartialEq for VoxelColors {
    /// As [`is_same`](Self::is_same): nothing goes through billions of voxels unasked.
    fn eq(&self, other: &Self) -> bool {
        self.is_same(other)
    }
}

/// Shares of red, green and blue in ten thousandths: luma of ITU-R BT.709-6, item 3.2, which is of
/// display-referred values.
const LUMA_SHARES: [u64; 3] = [2126, 7152, 722];

impl ColorSamples {
    /// How many colours there are.
    pub fn len(&self) -> usize {
        match self {
            Self::U8(colors) => colors.len(),
            Self::U16(colors) => colors.len(),
        }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Bytes of all of them.
    pub fn size_bytes(&self) -> usize {
        match self {
            Self::U8(colors) => size_of_val(colors.as_slice()),
            Self::U16(colors) => size_of_val(colors.as_slice()),
        }
    }

    /// How light each of them is, in the same type: `0.2126 R + 0.7152 G + 0.0722 B` (ITU-R BT.709), to the
    /// nearest whole number.
    pub fn luminances(&self) -> crate::Samples {
        match self {
            Self::U8(colors) => {
                let luma = |color: &[u8; 3]| luma(color.map(u64::from)) as u8;
                colors.iter().map(luma).collect::<Vec<_>>().into()
            }
            Self::U16(colors) => {
                let luma = |color: &[u16; 3]| luma(color.map(u64::from)) as u16;
                colors.iter().map(luma).collect::<Vec<_>>().into()
            }
        }
    }

    #[inline]
    fn at(&self, voxel_idx: usize) -> [f32; 3] {
        match self {
            Self::U8(colors) => colors[voxel_idx].map(|channel| f32::from(channel) / 255.0),
            Self::U16(colors) => colors[voxel_idx].map(|channel| f32::from(channel) / 65535.0),
        }
    }
}

/// The weights add up to one, so that it is no larger than the largest of the three.
fn luma(color: [u64; 3]) -> u64 {
    let [r, g, b] = LUMA_SHARES;
    (r * color[0] + g * color[1] + b * color[2] + 5000) / 10_000
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Samples;

    #[test]
    fn voxel_colors_are_one_a_voxel() {
        let colors = |n| ColorSamples::U16(vec![[1, 2, 3]; n]);
        assert!(VoxelColors::new([2, 3, 1], colors(6)).is_ok());
        let error = VoxelColors::new([2, 3, 1], colors(5)).unwrap_err();
        assert_eq!(error.to_string(), "6 voxels were given 5 colours");
        assert!(VoxelColors::new([usize::MAX; 3], colors(6)).is_err());
    }

    #[test]
    fn voxel_colors_are_equal_if_they_are_the_same() {
        let new = || VoxelColors::new([1; 3], ColorSamples::U8(vec![[7, 8, 9]])).unwrap();
        let colors = new();
        assert_eq!(colors, colors.clone());
        assert_ne!(colors, new());
        assert_eq!(format!("{colors:?}"), "VoxelColors { dims: [1, 1, 1], n_bits: 8 }");
    }

    #[test]
    fn luminances_are_those_of_bt_709() {
        let of = |color: [u8; 3]| ColorSamples::U8(vec![color]).luminances();
        for (color, expected) in [
            ([0; 3], 0),
            ([255; 3], 255),
            ([77; 3], 77),
            // 54.213, 182.376 and 18.411.
            ([255, 0, 0], 54),
            ([0, 255, 0], 182),
            ([0, 0, 255], 18),
            ([10, 20, 200], 31),
        ] {
            assert_eq!(of(color), Samples::U8(vec![expected]), "{color:?}");
        }
        let wide = ColorSamples::U16(vec![[65535; 3], [65535, 0, 0]]);
        assert_eq!(wide.luminances(), Samples::U16(vec![65535, 13933]));
    }
}
