//! Transfer functions are lists of points, each a list of numbers.

use serde::{Deserialize, Serialize};

use crate::{Isosurface, IsosurfaceError, PiecewiseLinear, TransferError, TransferFunction};

/// The keys of a transfer function; white by default.
#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TransferKeys {
    /// Value and opacity.
    opacity: Vec<[f64; 2]>,
    /// Value, red, green and blue.
    #[serde(default = "all_white")]
    color: Vec<[f64; 4]>,
}

fn all_white() -> Vec<[f64; 4]> {
    vec![[0.0, 1.0, 1.0, 1.0]]
}

impl TryFrom<TransferKeys> for TransferFunction {
    type Error = TransferError;

    fn try_from(TransferKeys { opacity, color }: TransferKeys) -> Result<Self, TransferError> {
        let opacity = opacity.into_iter().map(|[value, alpha]| (value, alpha));
        let color = color.into_iter().map(|[value, r, g, b]| (value, [r, g, b]));
        Self::new(opacity, color)
    }
}

impl From<TransferFunction> for TransferKeys {
    fn from(transfer: TransferFunction) -> Self {
        let opacity = points(transfer.opacity_points()).map(|(value, [alpha])| [value, alpha]);
        let color = points(transfer.color_points()).map(|(value, [r, g, b])| [value, r, g, b]);
        Self { opacity: opacity.collect(), color: color.collect() }
    }
}

fn points<const N: usize>(
    function: &PiecewiseLinear<N>,
) -> impl Iterator<Item = (f64, [f64; N])> + '_ {
    function.points().iter().copied()
}

/// The keys of an isosurface; opaque by default.
#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct IsosurfaceKeys {
    value: f64,
    #[serde(default = "opaque")]
    opacity: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    color: Option<[f64; 3]>,
}

/// The opacity of what does not say.
pub(crate) fn opaque() -> f64 {
    1.0
}

impl TryFrom<IsosurfaceKeys> for Isosurface {
    type Error = IsosurfaceError;

    fn try_from(keys: IsosurfaceKeys) -> Result<Self, IsosurfaceError> {
        Self::new(keys.value, keys.opacity, keys.color)
    }
}

impl From<Isosurface> for IsosurfaceKeys {
    fn from(surface: Isosurface) -> Self {
        Self { value: surface.value(), opacity: surface.opacity(), color: surface.color() }
    }
}

/// The colour of what does not say.
pub(crate) fn white() -> [f64; 3] {
    [1.0; 3]
}
