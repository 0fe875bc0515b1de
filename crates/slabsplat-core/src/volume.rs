//! A scalar volume: samples on a grid, with the file's slope and intercept.

#[cfg(feature = "ndarray")]
use crate::GridError;
use crate::{Grid, Sample, SampleType, Samples, with_samples};
use std::fmt;
use std::ops::Range;
use thiserror::Error;

/// Turns a stored sample into the value that it stands for: `value = slope · sample + intercept`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(clippy::exhaustive_structs, reason = "a line has a slope and an intercept")]
pub struct Scaling {
    /// Factor; finite and not zero.
    pub slope: f64,
    /// Offset; finite.
    pub intercept: f64,
}

impl Scaling {
    /// The value is the sample.
    pub const IDENTITY: Self = Self { slope: 1.0, intercept: 0.0 };

    /// The value that `sample` stands for.
    #[inline]
    pub fn apply(self, sample: f64) -> f64 {
        // Kept apart so that the identity is exact for infinities too (0 · ∞ never occurs here,
        // but ∞ + 0 does).
        sample * self.slope + self.intercept
    }
}

/// A scalar volume.
///
/// There are as many samples as the grid has voxels. Samples may be NaN or infinite: a NaN voxel is
/// never drawn, an infinite one takes the transfer function's value at that end.
#[derive(Clone)]
pub struct Volume {
    grid: Grid,
    samples: Samples,
    scaling: Scaling,
}

/// Why a volume cannot be made.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum VolumeError {
    /// The number of samples is not that of the grid's voxels.
    #[error("a grid of {expected} voxels was given {actual} samples")]
    WrongLength {
        /// Voxels of the grid.
        expected: usize,
        /// Samples given.
        actual: usize,
    },
    /// The grid has more voxels than a volume may have.
    #[error("a volume may have 4294967295 voxels, and the grid has {0:?}: read some of them alone")]
    TooLarge([usize; 3]),
    /// Slope or intercept is not finite, or the slope is zero.
    #[error("values cannot be scaled by slope {slope} and intercept {intercept}")]
    BadScaling {
        /// The slope given.
        slope: f64,
        /// The intercept given.
        intercept: f64,
    },
}

/// What a pass over all values of a volume finds.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Summary {
    /// Smallest and largest finite value; `None` if there is none.
    pub range: Option<[f64; 2]>,
    /// Voxels that are NaN.
    pub n_nan: usize,
    /// Voxels that are −∞, and +∞.
    pub n_infinite: [usize; 2],
}

impl fmt::Debug for Volume {
    /// All but the samples themselves, of which there may be billions.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { grid, samples, scaling } = self;
        let samples = format_args!("{} of {}", samples.len(), samples.sample_type().name());
        f.debug_struct("Volume")
            .field("grid", grid)
            .field("samples", &samples)
            .field("scaling", scaling)
            .finish()
    }
}

impl Volume {
    /// A volume of `samples` on `grid`, x fastest.
    ///
    /// # Errors
    /// If there are more or fewer samples than voxels, or the scaling is not finite or flat.
    pub fn new(grid: Grid, samples: Samples, scaling: Scaling) -> Result<Self, VolumeError> {
        if grid.is_large() {
            return Err(VolumeError::TooLarge(grid.dims()));
        }
        let (expected, actual) = (grid.n_voxels(), samples.len());
        if expected != actual {
            return Err(VolumeError::WrongLength { expected, actual });
        }
        let Scaling { slope, intercept } = scaling;
        if !slope.is_normal() || !intercept.is_finite() {
            return Err(VolumeError::BadScaling { slope, intercept });
        }
        Ok(Self { grid, samples, scaling })
    }

    /// A volume of what `sample` says of each voxel `(i, j, k)` of `grid`. Values are samples as they are.
    ///
    /// ```
    /// use slabsplat_core::{Grid, Volume};
    ///
    /// let grid = Grid::centered([32; 3], [0.1; 3])?;
    /// let volume = Volume::from_fn(grid, |voxel| {
    ///     let [x, y, z] = voxel.map(|c| c as f32 * 0.1 - 1.55);
    ///     (x * x + y * y + z * z).sqrt()
    /// });
    /// assert_eq!(volume.value(0), f64::from(1.55_f32 * 3_f32.sqrt()));
    /// # Ok::<(), slabsplat_core::GridError>(())
    /// ```
    pub fn from_fn<T: Sample>(grid: Grid, mut sample: impl FnMut([usize; 3]) -> T) -> Self
    where
        Samples: From<Vec<T>>,
    {
        let voxels = (0..grid.n_voxels()).map(|voxel_idx| grid.voxel_coords(voxel_idx));
        let samples = voxels.map(&mut sample).collect::<Vec<_>>();
        Self { grid, samples: samples.into(), scaling: Scaling::IDENTITY }
    }

    /// A copy of an array of the crate `ndarray` whose last axis is x, as stacks of images have it: voxel
    /// `(i, j, k)` is `array[[k, j, i]]`. `spacing` is along x, y and z; its middle is the world's origin.
    ///
    /// ```
    /// use slabsplat_core::Volume;
    ///
    /// let stack = ndarray::Array3::from_shape_fn((5, 48, 64), |(k, j, i)| (i + j + k) as u8);
    /// let volume = Volume::from_ndarray(&stack, [0.2, 0.2, 1.0])?;
    /// assert_eq!(volume.grid().dims(), [64, 48, 5]);
    /// # Ok::<(), slabsplat_core::GridError>(())
    /// ```
    ///
    /// # Errors
    /// If an axis is empty, there are too many voxels, or the spacing cannot be.
    #[cfg(feature = "ndarray")]
    pub fn from_ndarray<S: ndarray::Data<Elem: Sample>>(
        array: &ndarray::ArrayBase<S, ndarray::Ix3>,
        spacing: [f64; 3],
    ) -> Result<Self, GridError>
    where
        Samples: From<Vec<S::Elem>>,
    {
        let (nz, ny, nx) = array.dim();
        let grid = Grid::centered([nx, ny, nz], spacing)?;
        let samples = array.iter().copied().collect::<Vec<_>>();
        Ok(Self { grid, samples: samples.into(), scaling: Scaling::IDENTITY })
    }

    /// Where the voxels are.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The stored samples, x fastest.
    pub fn samples(&self) -> &Samples {
        &self.samples
    }

    /// The type of the stored samples.
    pub fn sample_type(&self) -> SampleType {
        self.samples.sample_type()
    }

    /// What turns samples into values.
    pub fn scaling(&self) -> Scaling {
        self.scaling
    }

    /// The value of the voxel at `voxel_idx`, NaN if the sample is.
    #[inline]
    pub fn value(&self, voxel_idx: usize) -> f64 {
        with_samples!(&self.samples, |s| self.scaling.apply(s[voxel_idx].to_f64()))
    }

    /// The same samples on another grid, say with a corrected spacing.
    ///
    /// # Errors
    /// If `grid` has another number of voxels.
    pub fn with_grid(self, grid: Grid) -> Result<Self, VolumeError> {
        Self::new(grid, self.samples, self.scaling)
    }

    /// Some of the voxels, where they are.
    ///
    /// # Panics
    /// If there is none, or one of them is not in the grid.
    #[must_use]
    pub fn cropped(&self, voxels: &[Range<usize>; 3]) -> Self {
        let grid = self.grid.cropped(voxels);
        let [x, y, z] = voxels.clone();
        let rows = z.flat_map(|k| y.clone().map(move |j| [x.start, j, k]));
        let starts = rows.map(|first| self.grid.voxel_idx(first));
        let samples = with_samples!(&self.samples, |s| {
            let rows = starts.flat_map(|start| &s[start..start + x.len()]);
            rows.copied().collect::<Vec<_>>().into()
        });
        Self { grid, samples, scaling: self.scaling }
    }

    /// Range of the values, and how many voxels have none that is finite.
    pub fn summary(&self) -> Summary {
        let mut summary = with_samples!(&self.samples, |s| summary_of(s));
        summary.range = summary.range.map(|range| {
            let [a, b] = range.map(|v| self.scaling.apply(v));
            [a.min(b), a.max(b)]
        });
        if self.scaling.slope < 0.0 {
            summary.n_infinite.reverse();
        }
        summary
    }
}

/// Of samples before scaling.
#[expect(clippy::eq_op, reason = "a sample that differs from itself is NaN, whatever its type")]
fn summary_of<T: Sample>(samples: &[T]) -> Summary {
    let n_nan = samples.iter().filter(|&&v| v != v).count();
    let n_of = |value: f64| samples.iter().filter(|v| v.to_f64() == value).count();
    let mut finite = samples.iter().copied().filter(|v| v.to_f64().is_finite());
    let range = finite.next().map(|first| {
        let (lo, hi) = finite.fold((first, first), |(lo, hi), v| {
            (if v < lo { v } else { lo }, if hi < v { v } else { hi })
        });
        [lo.to_f64(), hi.to_f64()]
    });
    Summary { range, n_nan, n_infinite: [f64::NEG_INFINITY, f64::INFINITY].map(n_of) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(samples: impl Into<Samples>, scaling: Scaling) -> Volume {
        let samples = samples.into();
        let grid = Grid::with_spacing([samples.len(), 1, 1], [1.0; 3]).unwrap();
        Volume::new(grid, samples, scaling).unwrap()
    }

    /// What holds a volume may be printed, in a test that fails or a log.
    #[test]
    fn volume_is_printed_without_its_samples() {
        let grid = Grid::with_spacing([100; 3], [1.0; 3]).unwrap();
        let volume = Volume::new(grid, vec![7_u8; 1_000_000].into(), Scaling::IDENTITY).unwrap();
        let text = format!("{volume:?}");
        assert!(text.contains("1000000 of uint8") && text.len() < 1000, "{text}");
    }

    #[test]
    fn volume_from_fn_has_x_fastest() {
        let grid = Grid::with_spacing([2, 3, 2], [1.0; 3]).unwrap();
        let volume = Volume::from_fn(grid, |[i, j, k]| (100 * i + 10 * j + k) as u16);
        assert_eq!(volume.sample_type(), SampleType::U16);
        for voxel_idx in 0..grid.n_voxels() {
            let [i, j, k] = grid.voxel_coords(voxel_idx);
            assert_eq!(volume.value(voxel_idx), (100 * i + 10 * j + k) as f64);
        }
    }

    /// In whatever order an array lies in memory.
    #[cfg(feature = "ndarray")]
    #[test]
    fn volume_from_ndarray_reads_by_axes() {
        use ndarray::{Array3, ShapeBuilder};
        let sample = |(k, j, i): (usize, usize, usize)| (100 * i + 10 * j + k) as i16;
        let rows = Array3::from_shape_fn((4, 3, 2), sample);
        let columns = Array3::from_shape_fn((4, 3, 2).f(), sample);
        for array in [rows, columns] {
            let volume = Volume::from_ndarray(&array, [1.0, 2.0, 3.0]).unwrap();
            let grid = volume.grid();
            assert_eq!((grid.dims(), grid.spacing()), ([2, 3, 4], [1.0, 2.0, 3.0]));
            assert_eq!(volume.value(grid.voxel_idx([1, 2, 3])), 123.0);
            assert_eq!(volume.value(grid.voxel_idx([1, 0, 2])), 102.0);
        }
    }

    #[test]
    fn volume_is_cropped_in_place() {
        let grid = Grid::with_spacing([4, 3, 5], [1.0, 2.0, 0.5]).unwrap();
        let volume = Volume::from_fn(grid, |[i, j, k]| (100 * i + 10 * j + k) as u16);
        let cropped = volume.cropped(&[1..3, 2..3, 0..4]);
        let of = cropped.grid();
        assert_eq!((of.dims(), of.spacing()), ([2, 1, 4], grid.spacing()));
        for voxel_idx in 0..of.n_voxels() {
            let [i, j, k] = of.voxel_coords(voxel_idx);
            assert_eq!(cropped.value(voxel_idx), (100 * (i + 1) + 10 * (j + 2) + k) as f64);
        }
        let first = of.world_from_index().translation;
        assert_eq!(first, glam::DVec3::new(1.0, 4.0, 0.0));
    }

    #[test]
    fn volume_scales_values() {
        let v = row(vec![-2_i16, 5], Scaling { slope: -0.5, intercept: 10.0 });
        assert_eq!(v.value(0), 11.0);
        let all = Summary { range: Some([7.5, 11.0]), n_nan: 0, n_infinite: [0, 0] };
        assert_eq!(v.summary(), all);
    }

    #[test]
    fn volume_summary_of_what_is_not_finite() {
        let samples = vec![f32::NAN, 2.0, f32::NEG_INFINITY, 5.0, f32::NEG_INFINITY, f32::INFINITY];
        let summary =
            |slope: f64| row(samples.clone(), Scaling { slope, intercept: 0.0 }).summary();
        let upright = Summary { range: Some([2.0, 5.0]), n_nan: 1, n_infinite: [2, 1] };
        assert_eq!(summary(1.0), upright);
        let reversed = Summary { range: Some([-5.0, -2.0]), n_nan: 1, n_infinite: [1, 2] };
        assert_eq!(summary(-1.0), reversed);
        let nothing = row(vec![f64::NAN; 3], Scaling::IDENTITY);
        assert_eq!(nothing.summary(), Summary { range: None, n_nan: 3, n_infinite: [0, 0] });
    }

    #[test]
    fn volume_rejects_wrong_length_and_scaling() {
        let grid = Grid::with_spacing([2, 1, 1], [1.0; 3]).unwrap();
        let err = Volume::new(grid, Samples::U8(vec![0; 3]), Scaling::IDENTITY).unwrap_err();
        assert_eq!(err, VolumeError::WrongLength { expected: 2, actual: 3 });
        for (slope, intercept) in [(0.0, 0.0), (f64::NAN, 0.0), (1.0, f64::INFINITY)] {
            let scaling = Scaling { slope, intercept };
            assert!(Volume::new(grid, Samples::U8(vec![0; 2]), scaling).is_err());
        }
    }
}
