//! Tissues in computed tomography, by Hounsfield units: water is 0 and air −1000.
//!
//! The ranges are those of the presets `ct-…`, whose files name their sources: fat −190 … −30, muscle
//! −29 … 150, blood with a contrast agent above 250, spongy bone 150 … 350, compact bone above that.

use super::histogram::Histogram;
use super::look::{Curves, Points};

/// Hounsfield units, and red, green, blue there.
const COLORS: [(f64, [f64; 3]); 8] = [
    (-900.0, [0.70, 0.55, 0.55]),
    (-500.0, [0.86, 0.66, 0.58]),
    (-100.0, [0.95, 0.78, 0.62]),
    (40.0, [0.90, 0.58, 0.48]),
    (120.0, [0.88, 0.52, 0.42]),
    (250.0, [0.96, 0.88, 0.74]),
    (600.0, [1.00, 0.96, 0.88]),
    (1500.0, [1.00, 1.00, 0.97]),
];

/// Hounsfield units and opacity: bone in a body like glass.
const BONE: [(f64, f64); 6] =
    [(-300.0, 0.0), (-80.0, 0.024), (80.0, 0.024), (140.0, 0.04), (300.0, 0.6), (1000.0, 0.95)];

/// The same without bone: opaque from the skin on.
const SOFT: [(f64, f64); 3] = [(-500.0, 0.0), (-100.0, 0.6), (60.0, 0.9)];

/// Bone, and the least share of a body that it is where it is the matter.
const BONE_FROM: f64 = 250.0;
const BONE_SHARE: f64 = 0.01;

/// Where a body begins.
const BODY_FROM: f64 = -300.0;

/// Hounsfield units per voxel step, and what opacity is multiplied with: borders are seen, and what is even
/// all around is not.
const BORDERS: [(f64, f64); 3] = [(15.0, 0.08), (120.0, 0.4), (300.0, 1.0)];

/// Opacity and colours of values that are Hounsfield units and `water` together.
pub(super) fn curves(histogram: &Histogram, water: f64) -> Curves {
    let share_from =
        |units: f64| histogram.share_from(histogram.scale.level_of(units + water).unwrap_or(0));
    let has_bone = BONE_SHARE * share_from(BODY_FROM) < share_from(BONE_FROM);
    let (opacity, what): (&[_], _) = match has_bone {
        true => (&BONE, "bone, and skin like glass"),
        false => (&SOFT, "skin"),
    };
    let at = |&(units, opacity): &(f64, f64)| (units + water, [opacity]);
    let gradient_opacity: Points<1> = BORDERS.iter().map(|&(g, factor)| (g, [factor])).collect();
    Curves {
        opacity: opacity.iter().map(at).collect(),
        color: COLORS.iter().map(|&(units, color)| (units + water, color)).collect(),
        gradient_opacity: has_bone.then_some(gradient_opacity),
        what: what.to_owned(),
    }
}
