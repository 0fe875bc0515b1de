//! The test signal of Marschner and Lobb: rings near the Nyquist limit, which every flaw of a
//! reconstruction shows in.
//!
//! S. Marschner, R. Lobb, "An Evaluation of Reconstruction Filters for Volume Rendering", IEEE
//! Visualization '94: ρ(x, y, z) = (1 − sin(πz/2) + α (1 + ρ_r(√(x² + y²)))) / (2 (1 + α)) with
//! ρ_r(r) = cos(2π f_M cos(πr/2)), on −1 … 1 along each axis.

use std::f64::consts::PI;

use slabsplat_core::Samples;
use slabsplat_core::glam::DVec3;

use super::sampled;

/// f_M, the frequency of the rings.
const FREQUENCY: f64 = 6.0;

/// α, the height of the rings.
const AMPLITUDE: f64 = 0.25;

/// In 32-bit floats: steps of 8 bits would be seen on the rings, and are not the reconstruction's.
pub(super) fn samples(size: usize) -> Samples {
    let half_side = (size as f64 - 1.0) / 2.0;
    Samples::F32(sampled(size, |place| density(place / half_side) as f32))
}

fn density(p: DVec3) -> f64 {
    let rings = (2.0 * PI * FREQUENCY * (PI * p.x.hypot(p.y) / 2.0).cos()).cos();
    (1.0 - (PI * p.z / 2.0).sin() + AMPLITUDE * (1.0 + rings)) / (2.0 * (1.0 + AMPLITUDE))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin_volume;

    #[test]
    fn marschner_lobb_known_values() {
        // In the middle both cosines are 1; at the rim the outer one is cos 0.
        assert!((density(DVec3::ZERO) - 0.6).abs() < 1e-12);
        assert!((density(DVec3::new(1.0, 0.0, 0.0)) - 0.6).abs() < 1e-12);
        assert!((density(DVec3::new(0.0, 0.0, 1.0)) - 0.2).abs() < 1e-12);
        assert!((density(DVec3::new(0.0, 1.0, -1.0)) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn marschner_lobb_spans_the_cube() {
        let volume = builtin_volume("marschner-lobb", None).unwrap();
        let corner = density(DVec3::splat(-1.0)) as f32;
        assert_eq!(volume.value(0), f64::from(corner));
        let [lo, hi] = volume.summary().range.unwrap();
        assert!(0.0 <= lo && hi <= 1.0 + 1e-6, "{lo} .. {hi}");
    }
}
