//! What a kernel is, and which are built in.

use crate::{CrawfisMax, Gaussian};
use std::fmt::Debug;
use std::sync::Arc;
use thiserror::Error;

/// A radially symmetric reconstruction kernel of finite radius, in index space.
///
/// Shifted to all integer points, its copies sum to about 1 everywhere; it is nowhere negative, and its
/// values and line integrals go together. [`Kernels`](crate::Kernels) takes kernels of one's own, and looks
/// whether they are such. Two calls with the same numbers give the same result.
pub trait Kernel: Debug + Send + Sync {
    /// The name that scene files and settings use.
    fn name(&self) -> &str;

    /// `R`: the kernel is 0 from here on, in voxel steps; at most [`MAX_RADIUS`].
    fn radius(&self) -> f64;

    /// `h(r)` at the distance `r ≥ 0` from the voxel.
    fn value(&self, r: f64) -> f64;

    /// `∫ h(√(ρ² + t²)) dt` for `t` from `a` to `b`, exactly; `a ≤ b`.
    fn line_integral(&self, rho: f64, a: f64, b: f64) -> f64;

    /// `F(ρ)`: the line integral over all depths.
    fn footprint(&self, rho: f64) -> f64 {
        self.line_integral(rho, -self.radius(), self.radius())
    }
}

/// The largest support of a kernel, in voxel steps: errors of sections are added up over so many layers of
/// voxels ([`ErrorBudget`](crate::ErrorBudget)), and tables of densities have cells for it.
pub const MAX_RADIUS: f64 = 2.0;

/// The names of the built-in kernels, the default first.
pub const KERNEL_NAMES: &[&str] = &["gaussian", "crawfis-max"];

/// There is no kernel of that name.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("there is no kernel \"{name}\"; there are {}", known.join(", "))]
#[non_exhaustive]
pub struct UnknownKernel {
    /// The name asked for.
    pub name: String,
    /// The names that there are.
    pub known: Vec<String>,
}

/// The built-in kernel called `name`.
///
/// # Errors
/// If it is none of [`KERNEL_NAMES`].
pub fn kernel_named(name: &str) -> Result<Arc<dyn Kernel>, UnknownKernel> {
    match name {
        "gaussian" => Ok(Arc::new(Gaussian)),
        "crawfis-max" => Ok(Arc::new(CrawfisMax)),
        _ => Err(UnknownKernel {
            name: name.to_owned(),
            known: KERNEL_NAMES.iter().copied().map(str::to_owned).collect(),
        }),
    }
}

/// Half the length of the chord that a ball of radius `radius` cuts out of a ray at distance `rho`.
pub(crate) fn half_chord(radius: f64, rho: f64) -> f64 {
    ((radius - rho) * (radius + rho)).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kernel_names_are_found() {
        for &name in KERNEL_NAMES {
            let kernel = kernel_named(name).unwrap();
            assert_eq!(kernel.name(), name);
            assert!(kernel.radius() <= MAX_RADIUS, "{name}");
        }
        let err = kernel_named("box").unwrap_err().to_string();
        assert_eq!(err, "there is no kernel \"box\"; there are gaussian, crawfis-max");
    }

    /// model §2: `F(0)` of both kernels.
    #[test]
    fn kernel_footprint_at_center() {
        for (name, expected) in [("gaussian", 0.4456), ("crawfis-max", 0.6999)] {
            let f0 = kernel_named(name).unwrap().footprint(0.0);
            assert!((f0 - expected).abs() < 5e-5, "{name}: {f0}");
        }
    }

    #[test]
    fn kernel_ends_at_its_radius() {
        for &name in KERNEL_NAMES {
            let kernel = kernel_named(name).unwrap();
            let radius = kernel.radius();
            assert!(0.0 < kernel.value(radius - 1e-3), "{name}");
            assert_eq!([radius, 2.0 * radius].map(|r| kernel.value(r)), [0.0; 2], "{name}");
        }
    }

    /// model §2: `∫h dV` of both kernels, by the midpoint rule over spherical shells.
    #[test]
    fn kernel_integrates_to_one() {
        for (name, expected) in [("gaussian", 0.9993), ("crawfis-max", 1.0000)] {
            let kernel = kernel_named(name).unwrap();
            let n_shells = 100_000;
            let dr = kernel.radius() / f64::from(n_shells);
            let integral: f64 = (0..n_shells)
                .map(|shell| (f64::from(shell) + 0.5) * dr)
                .map(|r| 4.0 * std::f64::consts::PI * r * r * kernel.value(r) * dr)
                .sum();
            assert!((integral - expected).abs() < 5e-5, "{name}: {integral}");
        }
    }

    /// model §2: the range of `Σh`, searched on a fine lattice within one cell.
    #[test]
    fn kernel_ripple() {
        for (name, lo, hi) in [("gaussian", 0.993, 1.004), ("crawfis-max", 0.998, 1.005)] {
            let kernel = kernel_named(name).unwrap();
            let sums = lattice_sums(&*kernel, 20);
            let min = sums.iter().copied().fold(f64::INFINITY, f64::min);
            let max = sums.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            assert!(
                (min - lo).abs() < 5.5e-4 && (max - hi).abs() < 5.5e-4,
                "{name}: {min} … {max}"
            );
        }
    }

    /// `Σh` at the points of an eighth of a cell; the rest of the cell mirrors it.
    fn lattice_sums(kernel: &dyn Kernel, n: u32) -> Vec<f64> {
        let coordinate = |step: u32| f64::from(step) / f64::from(2 * n);
        let steps =
            (0..=n).flat_map(|i| (i..=n).flat_map(move |j| (j..=n).map(move |k| [i, j, k])));
        steps.map(|at| sum_at(kernel, at.map(coordinate))).collect()
    }

    fn sum_at(kernel: &dyn Kernel, [x, y, z]: [f64; 3]) -> f64 {
        let voxels = -3..=3;
        let squares = |c: f64| voxels.clone().map(move |v: i32| (c - f64::from(v)).powi(2));
        let mut sum = 0.0;
        for xx in squares(x) {
            for yy in squares(y) {
                sum += squares(z).map(|zz| kernel.value((xx + yy + zz).sqrt())).sum::<f64>();
            }
        }
        sum
    }
}
