//! Two-dimensional transfer functions are `boxes`, or an `image` with its pixels.

use serde::{Deserialize, Serialize};

use super::{opaque, white};
use crate::{Transfer2dError, TransferBox, TransferImage};

/// The keys of a box: of all gradients, opaque, white and with sharp ends if it does not say.
#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TransferBoxKeys {
    values: [f64; 2],
    #[serde(default = "any_gradient", skip_serializing_if = "is_any_gradient")]
    gradients: [f64; 2],
    #[serde(default = "opaque")]
    opacity: f64,
    #[serde(default = "white")]
    color: [f64; 3],
    /// Over how much of values and of gradients it fades.
    #[serde(default)]
    fade: [f64; 2],
}

const ANY_GRADIENT: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

fn any_gradient() -> [f64; 2] {
    ANY_GRADIENT
}

/// Then it is left out: not every format has infinities.
fn is_any_gradient(gradients: &[f64; 2]) -> bool {
    *gradients == ANY_GRADIENT
}

impl TryFrom<TransferBoxKeys> for TransferBox {
    type Error = Transfer2dError;

    fn try_from(keys: TransferBoxKeys) -> Result<Self, Transfer2dError> {
        let TransferBoxKeys { values, gradients, opacity, color, fade } = keys;
        Self::new(values, gradients)?.opacity(opacity)?.color(color)?.fade(fade)
    }
}

impl From<TransferBox> for TransferBoxKeys {
    fn from(part: TransferBox) -> Self {
        let (values, gradients) = (part.values(), part.gradients());
        let (opacity, color, fade) = part.look();
        Self { values, gradients, opacity, color, fade }
    }
}

/// The keys of a picture: pixels a row, and all pixels, the top row first.
#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TransferImageKeys {
    width: usize,
    values: [f64; 2],
    gradients: [f64; 2],
    /// Red, green, blue and opacity.
    pixels: Vec<[f32; 4]>,
}

impl TryFrom<TransferImageKeys> for TransferImage {
    type Error = Transfer2dError;

    fn try_from(keys: TransferImageKeys) -> Result<Self, Transfer2dError> {
        Self::new(keys.width, keys.pixels, keys.values, keys.gradients)
    }
}

impl From<TransferImage> for TransferImageKeys {
    fn from(image: TransferImage) -> Self {
        Self {
            width: image.width(),
            values: image.values(),
            gradients: image.gradients(),
            pixels: image.pixels().to_vec(),
        }
    }
}
