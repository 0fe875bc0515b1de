//! A scalar volume: samples on a grid, with the file's slope and intercept.

use crate::{Grid, Sample, SampleType, Samples, with_samples};
use std::fmt;
use thiserror::Error;

/// Turns a stored sample into the value that it stands for: `value = slope · sample + intercept`.
#[derive(Clone, Copy, Debug, PartialEq)]
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
pub enum VolumeError {
    /// The number of samples is not that of the grid's voxels.
    #[error("a grid of {expected} voxels was given {actual} samples")]
    WrongLength {
        /// Voxels of the grid.
        expected: usize,
        /// Samples given.
        actual: usize,
    },
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
pub struct Summary {
    /// Smallest and largest value; `None` if every voxel is NaN. May be infinite.
    pub range: Option<[f64; 2]>,
    /// Voxels that are NaN.
    pub n_nan: usize,
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

    /// Range of the values and number of NaN voxels.
    pub fn summary(&self) -> Summary {
        let (range, n_nan) = with_samples!(&self.samples, |s| range_and_nans(s));
        let range = range.map(|r| {
            let [a, b] = r.map(|v| self.scaling.apply(v));
            [a.min(b), a.max(b)]
        });
        Summary { range, n_nan }
    }
}

#[expect(clippy::eq_op, reason = "a sample that differs from itself is NaN, whatever its type")]
fn range_and_nans<T: Sample>(samples: &[T]) -> (Option<[f64; 2]>, usize) {
    let n_nan = samples.iter().filter(|&&v| v != v).count();
    let mut numbers = samples.iter().copied().filter(|&v| v == v);
    let range = numbers.next().map(|first| {
        let (lo, hi) = numbers.fold((first, first), |(lo, hi), v| {
            (if v < lo { v } else { lo }, if hi < v { v } else { hi })
        });
        [lo.to_f64(), hi.to_f64()]
    });
    (range, n_nan)
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
    fn volume_scales_values() {
        let v = row(vec![-2_i16, 5], Scaling { slope: -0.5, intercept: 10.0 });
        assert_eq!(v.value(0), 11.0);
        assert_eq!(v.summary(), Summary { range: Some([7.5, 11.0]), n_nan: 0 });
    }

    #[test]
    fn volume_summary_leaves_out_nan() {
        let v = row(vec![f32::NAN, 2.0, f32::NEG_INFINITY], Scaling::IDENTITY);
        assert_eq!(v.summary(), Summary { range: Some([f64::NEG_INFINITY, 2.0]), n_nan: 1 });
        let all_nan = row(vec![f64::NAN; 3], Scaling::IDENTITY);
        assert_eq!(all_nan.summary(), Summary { range: None, n_nan: 3 });
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
