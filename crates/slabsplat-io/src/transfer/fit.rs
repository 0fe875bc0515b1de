//! What makes a transfer function fit a volume, as a scene file or flags say it before there is one.

use slabsplat_core::{PiecewiseLinear, TransferFunction};
use thiserror::Error;

use super::{TransferSource, ValueScale};

/// How a layer's transfer function becomes the one that its volume is shown with.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct TransferFit {
    /// What its values count.
    pub scale: ValueScale,
    /// What values it is stretched to, and a colour map.
    pub stretch: Option<Stretch>,
    /// Colours over 0 … 1 instead of its own: over the window, else over what its values count, else over
    /// all values of the volume.
    pub colormap: Option<PiecewiseLinear<3>>,
    /// Opacities of the volume's values instead of its own.
    pub opacity: Option<PiecewiseLinear<1>>,
    /// Colours of the volume's values instead of its own.
    pub color: Option<PiecewiseLinear<3>>,
    /// What opacities are multiplied with, 1 at most: at least 0.
    pub opacity_scale: f64,
    /// The world length that opacities are per; if there is none, a voxel step.
    pub unit_distance: Option<f64>,
    /// What opacities are multiplied with, by gradients in its scale; a layer may say otherwise.
    pub gradient_opacity: Option<PiecewiseLinear<1>>,
    /// The preset that it is, for what is said of values that do not suit.
    pub preset: Option<String>,
}

/// The values that a transfer function is stretched to.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(clippy::exhaustive_enums, reason = "who fits a transfer function has to know each")]
pub enum Stretch {
    /// From one value to a greater one.
    Window([f64; 2]),
    /// From what so many percent of the voxels do not exceed to what so many do not.
    Percentiles([f64; 2]),
}

/// Why a transfer function cannot be fitted to a volume.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum FitError {
    /// The ends of a window do not rise.
    #[error("a window goes from a value to a greater one, not from {} to {}", .0[0], .0[1])]
    Window([f64; 2]),
    /// The percentiles do not rise, or are none.
    #[error("percentiles go from 0 to 100 and rise, not from {} to {}", .0[0], .0[1])]
    Percentiles([f64; 2]),
    /// Nothing lies between two percentiles.
    #[error(
        "the percentiles {} and {} of the volume are the same value, {value}: choose others, or a window",
        .percentiles[0], .percentiles[1]
    )]
    NothingBetween {
        /// Those asked for.
        percentiles: [f64; 2],
        /// The value of both.
        value: f64,
    },
    /// A window has nothing to move.
    #[error(
        "a window or percentiles move presets, files and colour maps, and no points that are written for \
         values: leave one out, or add a colour map"
    )]
    PointsDoNotMove,
    /// A factor of opacity cannot be.
    #[error("opacity is scaled by a number of at least 0, not by {0}")]
    OpacityScale(f64),
    /// A length cannot be.
    #[error("the unit distance of opacity is a positive length, not {0}")]
    UnitDistance(f64),
    /// Numbers do not reach, or have nothing between them.
    #[error("the transfer function has no room between the values {} and {}", .0[0], .0[1])]
    NoRoom([f64; 2]),
}

impl Default for TransferFit {
    fn default() -> Self {
        Self {
            scale: ValueScale::Points,
            stretch: None,
            colormap: None,
            opacity: None,
            color: None,
            opacity_scale: 1.0,
            unit_distance: None,
            gradient_opacity: None,
            preset: None,
        }
    }
}

impl Stretch {
    /// The stretch, if its ends can be.
    ///
    /// # Errors
    /// If the ends do not rise, are not finite, or percentiles are not between 0 and 100.
    pub fn checked(self) -> Result<Self, FitError> {
        match self {
            Self::Window([lo, hi]) if lo < hi && lo.is_finite() && hi.is_finite() => Ok(self),
            Self::Window(ends) => Err(FitError::Window(ends)),
            Self::Percentiles([lo, hi]) if 0.0 <= lo && lo < hi && hi <= 100.0 => Ok(self),
            Self::Percentiles(ends) => Err(FitError::Percentiles(ends)),
        }
    }
}

impl TransferFit {
    /// The transfer function of a source, and how it fits.
    pub fn of_source(source: TransferSource) -> (TransferFunction, Self) {
        let TransferSource { transfer, scale, gradient_opacity, unit_distance, preset, .. } =
            source;
        (transfer, Self { scale, gradient_opacity, unit_distance, preset, ..Self::default() })
    }

    /// That its numbers can be, and a window has something to move where the layer `has_transfer`.
    pub(crate) fn check(&self, has_transfer: bool) -> Result<(), FitError> {
        if !(0.0..f64::INFINITY).contains(&self.opacity_scale) {
            return Err(FitError::OpacityScale(self.opacity_scale));
        }
        if let Some(distance) = self.unit_distance.filter(|it| !it.is_normal() || *it < 0.0) {
            return Err(FitError::UnitDistance(distance));
        }
        self.stretch.map(Stretch::checked).transpose()?;
        let are_points = has_transfer && self.scale == ValueScale::Points;
        let has_both = self.opacity.is_some() && self.color.is_some();
        if self.stretch.is_some() && self.colormap.is_none() && (are_points || has_both) {
            return Err(FitError::PointsDoNotMove);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fit_says_what_cannot_be() {
        let check = |fit: TransferFit, has_transfer, expected: &str| {
            let error = fit.check(has_transfer).unwrap_err().to_string();
            assert!(error.contains(expected), "{error} should contain {expected}");
        };
        let fit = TransferFit::default;
        let stretched = |stretch| TransferFit { stretch: Some(stretch), ..fit() };
        check(stretched(Stretch::Window([2.0, 2.0])), false, "to a greater one, not from 2 to 2");
        check(stretched(Stretch::Window([0.0, f64::INFINITY])), false, "not from 0 to inf");
        check(stretched(Stretch::Percentiles([-1.0, 50.0])), false, "from 0 to 100");
        check(stretched(Stretch::Percentiles([1.0, f64::NAN])), false, "from 0 to 100");
        check(stretched(Stretch::Window([0.0, 1.0])), true, "leave one out");
        check(TransferFit { opacity_scale: -1.0, ..fit() }, false, "not by -1");
        check(TransferFit { unit_distance: Some(0.0), ..fit() }, false, "positive length, not 0");
        let window = stretched(Stretch::Window([0.0, 1.0]));
        assert!(window.check(false).is_ok());
        assert!(TransferFit { scale: ValueScale::Values, ..window }.check(true).is_ok());
    }
}
