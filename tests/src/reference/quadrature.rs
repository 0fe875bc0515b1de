//! Gauss–Legendre quadrature, with its nodes found by Newton's method.
//!
//! An `n`-point rule is exact for polynomials up to degree `2n − 1` and converges geometrically for
//! smooth functions. It knows nothing of kinks: the caller splits the interval there.

use std::f64::consts::PI;

/// A rule on `[−1, 1]`.
#[derive(Clone, Debug)]
pub struct GaussLegendre {
    /// Position and weight of every node.
    nodes: Vec<(f64, f64)>,
}

impl GaussLegendre {
    /// The rule with `n` nodes.
    pub fn new(n: usize) -> Self {
        Self { nodes: (0..n).map(|i| node(n, i)).collect() }
    }

    /// `∫ f(x) dx` from `a` to `b`.
    pub fn integrate(&self, a: f64, b: f64, f: impl Fn(f64) -> f64) -> f64 {
        let [integral] = self.integrate_each(a, b, |x| [f(x)]);
        integral
    }

    /// The same of several functions at a time.
    pub fn integrate_each<const N: usize>(
        &self,
        a: f64,
        b: f64,
        f: impl Fn(f64) -> [f64; N],
    ) -> [f64; N] {
        let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
        let mut sums = [0.0; N];
        for &(x, weight) in &self.nodes {
            let terms = f(middle + half * x);
            sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += weight * term);
        }
        sums.map(|sum| half * sum)
    }
}

/// The `i`th root of the Legendre polynomial of degree `n`, and its weight.
fn node(n: usize, i: usize) -> (f64, f64) {
    let mut x = (PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
    // Newton doubles the number of digits each time; the guess has at least two.
    for _ in 0..8 {
        let (p, slope) = legendre(n, x);
        x -= p / slope;
    }
    let (_, slope) = legendre(n, x);
    (x, 2.0 / ((1.0 - x * x) * slope * slope))
}

/// Legendre polynomial of degree `n` at `x` by its three-term recurrence, and its derivative.
fn legendre(n: usize, x: f64) -> (f64, f64) {
    let (mut before, mut p) = (0.0, 1.0);
    for k in 0..n {
        let k = k as f64;
        (before, p) = (p, ((2.0 * k + 1.0) * x * p - k * before) / (k + 1.0));
    }
    (p, n as f64 * (x * p - before) / (x * x - 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quadrature_is_exact_for_polynomials() {
        let rule = GaussLegendre::new(24);
        for degree in 0..48 {
            let exact = (3.0_f64.powi(degree + 1) - 1.0) / f64::from(degree + 1);
            let sum = rule.integrate(1.0, 3.0, |x| x.powi(degree));
            assert!((sum / exact - 1.0).abs() < 1e-13, "degree {degree}: {sum}, not {exact}");
        }
    }

    #[test]
    fn quadrature_converges_for_smooth_functions() {
        let rule = GaussLegendre::new(24);
        assert!((rule.integrate(0.0, PI, f64::sin) - 2.0).abs() < 1e-14);
        let half_bell = rule.integrate(0.0, 6.0, |x| (-x * x).exp());
        assert!((half_bell - 0.5 * PI.sqrt()).abs() < 1e-10, "{half_bell}");
    }
}
