//! The smaller kernel of Crawfis & Max, "Texture splats for 3D scalar and vector field
//! visualization", Visualization '93: the paper's reference [2] and its §7.

use crate::Kernel;
use crate::kernel::half_chord;

/// Two cubics that meet at `r = 0.88` and end at `R = 1.556228`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CrawfisMax;

const RADIUS: f64 = 1.556_228;
const BREAK: f64 = 0.88;

/// A cubic in `r`, by rising power.
type Cubic = [f64; 4];

const INNER: Cubic = [0.557_526, 0.0, -1.157_743, 0.671_033];

/// `p (R − r)² + q (R − r)³`, multiplied out.
const OUTER: Cubic = {
    let (p, q) = (0.067_599, 0.282_474);
    [
        p * RADIUS * RADIUS + q * RADIUS * RADIUS * RADIUS,
        -2.0 * p * RADIUS - 3.0 * q * RADIUS * RADIUS,
        p + 3.0 * q * RADIUS,
        -q,
    ]
};

impl Kernel for CrawfisMax {
    fn name(&self) -> &str {
        "crawfis-max"
    }

    fn radius(&self) -> f64 {
        RADIUS
    }

    fn value(&self, r: f64) -> f64 {
        let at = |[c0, c1, c2, c3]: Cubic| c0 + r * (c1 + r * (c2 + r * c3));
        if r < BREAK {
            at(INNER)
        } else if r < RADIUS {
            at(OUTER)
        } else {
            0.0
        }
    }

    fn line_integral(&self, rho: f64, a: f64, b: f64) -> f64 {
        let clamped = |end: f64| (a.clamp(-end, end), b.clamp(-end, end));
        let (outer_a, outer_b) = clamped(half_chord(RADIUS, rho));
        let (inner_a, inner_b) = clamped(half_chord(BREAK, rho));
        let swap: Cubic = std::array::from_fn(|power| INNER[power] - OUTER[power]);
        integral(OUTER, rho, outer_a, outer_b) + integral(swap, rho, inner_a, inner_b)
    }
}

/// `∫ cubic(√(ρ² + t²)) dt` from `a` to `b`.
fn integral(cubic: Cubic, rho: f64, a: f64, b: f64) -> f64 {
    antiderivative(cubic, rho, b) - antiderivative(cubic, rho, a)
}

fn antiderivative([c0, c1, c2, c3]: Cubic, rho: f64, t: f64) -> f64 {
    let rho2 = rho * rho;
    let r = rho.hypot(t);
    // ρ² asinh(t/ρ) tends to 0 with ρ, though the arcsine itself does not.
    let arc = if rho2 < 1e-24 { 0.0 } else { rho2 * (t / rho).asinh() };
    let of_r = 0.5 * (t * r + arc);
    let of_r2 = t * (rho2 + t * t / 3.0);
    let of_r3 = 0.125 * (t * r * (2.0 * t * t + 5.0 * rho2) + 3.0 * rho2 * arc);
    c0 * t + c1 * of_r + c2 * of_r2 + c3 * of_r3
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crawfis_max_is_continuous() {
        let at = |r: f64| CrawfisMax.value(r);
        assert!((at(BREAK.next_down()) - at(BREAK)).abs() < 1e-5);
        assert!(at(RADIUS.next_down()).abs() < 1e-12);
        let direct = |r: f64| 0.067_599 * (RADIUS - r).powi(2) + 0.282_474 * (RADIUS - r).powi(3);
        assert!((at(1.2) - direct(1.2)).abs() < 1e-14);
    }
}
