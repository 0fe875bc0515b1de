//! The paper's kernel (eq. 3), with base 2 instead of its printed base e (model §2).

use crate::Kernel;
use crate::kernel::half_chord;
use std::f64::consts::{LN_2, PI};

/// `h(r) = c·2^(−2r²)` up to `R = 2`, whose whole footprint at the centre is (nearly) 0.446.
///
/// Table 1's weights 0.446, 0.223 and 0.0278 are those of base 2, and only base 2 sums to one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Gaussian;

/// Eq. 3's factor: the footprint at the centre, if the kernel had no end.
const PEAK_OF_FOOTPRINT: f64 = 0.446;

impl Kernel for Gaussian {
    fn name(&self) -> &str {
        "gaussian"
    }

    fn radius(&self) -> f64 {
        2.0
    }

    fn value(&self, r: f64) -> f64 {
        let peak = PEAK_OF_FOOTPRINT / (PI / (2.0 * LN_2)).sqrt();
        if r < self.radius() { peak * falloff(r) } else { 0.0 }
    }

    /// The Gaussian factors into across and along the ray; along it is an error function.
    fn line_integral(&self, rho: f64, a: f64, b: f64) -> f64 {
        let end = half_chord(self.radius(), rho);
        let [a, b] = [a, b].map(|t| libm::erf((2.0 * LN_2).sqrt() * t.clamp(-end, end)));
        PEAK_OF_FOOTPRINT * falloff(rho) * 0.5 * (b - a)
    }
}

fn falloff(r: f64) -> f64 {
    (-2.0 * r * r).exp2()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Table 1: 0.446, 0.223 and 0.0278 at r² = 0, ½ and 2, of a kernel without an end.
    #[test]
    fn gaussian_table_1_weights() {
        for (r_squared, weight) in [(0.0, 0.446), (0.5, 0.223), (2.0, 0.0278_f64)] {
            let f = PEAK_OF_FOOTPRINT * falloff(f64::sqrt(r_squared));
            assert!((f - weight).abs() < 1e-4, "{r_squared}: {f}");
        }
        assert!((Gaussian.value(0.0) - 0.29627).abs() < 5e-6, "{}", Gaussian.value(0.0));
    }
}
