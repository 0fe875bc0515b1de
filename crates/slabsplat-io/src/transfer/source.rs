//! What a file or a preset says of how values look: a transfer function, and what its numbers count.

use slabsplat_core::{PiecewiseLinear, Shading, TransferFunction};

/// A transfer function from a file or a preset, before it meets a volume.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct TransferSource {
    /// Opacity and colour over values that count as `scale` says.
    pub transfer: TransferFunction,
    /// What the values count.
    pub scale: ValueScale,
    /// What opacities are multiplied with, by the length of the gradient per voxel step, in the same scale.
    pub gradient_opacity: Option<PiecewiseLinear<1>>,
    /// What light does, if the source says it.
    pub shading: Option<Shading>,
    /// The world length that opacities are per, if not a voxel step.
    pub unit_distance: Option<f64>,
    /// The name, if it is a preset.
    pub preset: Option<String>,
}

/// What the values of a transfer function count, and with that, what moves them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[expect(clippy::exhaustive_enums, reason = "who fits a transfer function has to know each")]
pub enum ValueScale {
    /// The volume's values, by points written for them: nothing moves these.
    #[default]
    Points,
    /// The volume's values; a window moves them so that the least and the greatest are its ends.
    Values,
    /// Hounsfield units, which some files store with a constant added; a window moves them as it moves
    /// values.
    Hounsfield,
    /// From 0, the least value of the volume, to 1, the largest; or the ends of a window.
    Data,
    /// From 0, the background, to 1, what so many percent of the object do not exceed; or the ends of a
    /// window.
    Object {
        /// Above 0 and at most 100.
        percentile: f64,
    },
}

impl ValueScale {
    /// Whether 0 and 1 mean something only once there is a volume, or a window.
    pub fn is_relative(self) -> bool {
        match self {
            Self::Points | Self::Values | Self::Hounsfield => false,
            Self::Data | Self::Object { .. } => true,
        }
    }
}

impl TransferSource {
    /// A transfer function that a file gives over the volume's values.
    pub(super) fn of_values(transfer: TransferFunction) -> Self {
        Self {
            transfer,
            scale: ValueScale::Values,
            gradient_opacity: None,
            shading: None,
            unit_distance: None,
            preset: None,
        }
    }
}
