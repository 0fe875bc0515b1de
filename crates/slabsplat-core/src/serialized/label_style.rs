//! What a label changes: nothing that it does not say.

use serde::{Deserialize, Serialize};

use super::opaque;
use crate::{LabelStyle, TransferFunction};

/// The keys of a label's style. Ranges are checked where labels get it ([`Labels::new`](crate::Labels::new)).
#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct LabelStyleKeys {
    #[serde(skip_serializing_if = "Option::is_none")]
    color: Option<[f64; 3]>,
    #[serde(default = "opaque")]
    opacity: f64,
    /// The transfer function instead of the layer's.
    #[serde(skip_serializing_if = "Option::is_none")]
    classify: Option<TransferFunction>,
}

impl From<LabelStyleKeys> for LabelStyle {
    fn from(LabelStyleKeys { color, opacity, classify }: LabelStyleKeys) -> Self {
        Self { transfer: classify, color, opacity }
    }
}

impl From<LabelStyle> for LabelStyleKeys {
    fn from(LabelStyle { transfer, color, opacity }: LabelStyle) -> Self {
        Self { color, opacity, classify: transfer }
    }
}
