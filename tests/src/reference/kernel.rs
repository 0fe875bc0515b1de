//! The kernels of model §2 and their integrals along a ray.
//!
//! The integrals are numerical and know no closed form, so that they check the closed forms of the
//! renderer under test. All kernels are smooth but for a few radii; the quadrature is split where
//! the ray crosses those.

use super::GaussLegendre;
use slabsplat_core::KernelName;
use slabsplat_core::glam::DVec3;
use std::f64::consts::{LN_2, PI};
use std::sync::LazyLock;

/// A radially symmetric kernel, a sphere in index space.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// Eq. 3 with base 2, cut off at 2 voxel steps.
    Gaussian,
    /// Crawfis & Max 1993.
    CrawfisMax,
    /// That of the facade's example of a kernel of one's own: `105/(32πR³)·(1 − r²/R²)²`.
    Biweight,
}

/// Good for 10⁻¹⁰ on the pieces of any of them, as tested below.
static RULE: LazyLock<GaussLegendre> = LazyLock::new(|| GaussLegendre::new(24));

/// Good for as much on pieces of a Gaussian that are at most a voxel step long, which most are.
static SHORT_RULE: LazyLock<GaussLegendre> = LazyLock::new(|| GaussLegendre::new(12));

/// Where the two pieces of crawfis-max meet.
const CRAWFIS_MAX_JOINT: f64 = 0.88;

impl Kernel {
    /// The kernel that the model gives that name.
    ///
    /// # Panics
    /// If it gives it to none.
    pub fn named(name: &KernelName) -> Self {
        match name.0.as_ref() {
            "gaussian" => Self::Gaussian,
            "crawfis-max" => Self::CrawfisMax,
            "biweight" => Self::Biweight,
            other => panic!("the reference knows no kernel named {other}"),
        }
    }

    /// `R`, beyond which the kernel is 0, in voxel steps.
    pub fn radius(self) -> f64 {
        match self {
            Self::Gaussian => 2.0,
            Self::CrawfisMax => 1.556228,
            Self::Biweight => 1.7,
        }
    }

    /// `h(r)`.
    pub fn at(self, r: f64) -> f64 {
        if self.radius() <= r {
            return 0.0;
        }
        match self {
            Self::Gaussian => 0.446 / (PI / (2.0 * LN_2)).sqrt() * (-2.0 * r * r).exp2(),
            Self::CrawfisMax if r < CRAWFIS_MAX_JOINT => {
                0.557526 - 1.157743 * r.powi(2) + 0.671033 * r.powi(3)
            }
            Self::CrawfisMax => {
                let inward = self.radius() - r;
                0.067599 * inward.powi(2) + 0.282474 * inward.powi(3)
            }
            Self::Biweight => {
                let volume = 32.0 * PI / 105.0 * self.radius().powi(3);
                (1.0 - (r / self.radius()).powi(2)).powi(2) / volume
            }
        }
    }

    /// `∫ h(|start + t·step|) dt` for `t` from `from` to `to`, in index space.
    pub fn line_integral(self, start: DVec3, step: DVec3, [from, to]: [f64; 2]) -> f64 {
        let cuts = self.kinks_along(start, step);
        let piece = |ends: &[f64]| {
            let (a, b) = (ends[0].max(from), ends[1].min(to));
            if b <= a {
                return 0.0;
            }
            let is_short = self == Self::Gaussian && (b - a) * step.length() <= 1.0;
            let rule = if is_short { &SHORT_RULE } else { &RULE };
            rule.integrate(a, b, |t| self.at((start + t * step).length()))
        };
        cuts.windows(2).map(piece).sum()
    }

    /// The `t` at which the ray meets the kernel's rim and the radii where `h` is not smooth, in
    /// order. They coincide where the ray passes by.
    fn kinks_along(self, start: DVec3, step: DVec3) -> [f64; 6] {
        let nearest = -start.dot(step) / step.length_squared();
        let rho_squared = (start + nearest * step).length_squared();
        let half = |radius: f64| (radius * radius - rho_squared).max(0.0).sqrt() / step.length();
        let rim = half(self.radius());
        let (joint, center) = match self {
            Self::Gaussian | Self::Biweight => (rim, rim),
            // r³ has no fourth derivative at the centre, and next to it hardly any.
            Self::CrawfisMax => (half(CRAWFIS_MAX_JOINT), 0.0),
        };
        [-rim, -joint, -center, center, joint, rim].map(|t| nearest + t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn whole_footprint(kernel: Kernel, rho: f64) -> f64 {
        kernel.line_integral(DVec3::X * rho, DVec3::Z, [-9.0, 9.0])
    }

    /// `∫ h dV` by shells.
    fn volume_integral(kernel: Kernel) -> f64 {
        let shell = |r: f64| 4.0 * PI * r * r * kernel.at(r);
        RULE.integrate(0.0, CRAWFIS_MAX_JOINT, shell)
            + RULE.integrate(CRAWFIS_MAX_JOINT, kernel.radius(), shell)
    }

    /// Least and greatest `Σh` over the points of a cell.
    fn ripple(kernel: Kernel) -> [f64; 2] {
        const N: i32 = 24;
        let fraction = |i: i32| f64::from(i) / f64::from(N);
        let offsets = || -2..=3;
        let mut range = [f64::INFINITY, f64::NEG_INFINITY];
        for point in
            (0..=N).flat_map(|i| (0..=i).flat_map(move |j| (0..=j).map(move |k| [i, j, k])))
        {
            let p = DVec3::from_array(point.map(fraction));
            let mut sum = 0.0;
            for (i, j) in offsets().flat_map(|i| offsets().map(move |j| (i, j))) {
                for k in offsets() {
                    sum += kernel
                        .at((p - DVec3::new(f64::from(i), f64::from(j), f64::from(k))).length());
                }
            }
            range = [range[0].min(sum), range[1].max(sum)];
        }
        range
    }

    #[test]
    fn kernel_numbers_of_spec() {
        let check = |kernel: Kernel, footprint: f64, integral: f64, [least, greatest]: [f64; 2]| {
            assert!((whole_footprint(kernel, 0.0) - footprint).abs() < 5e-5, "{kernel:?}");
            assert!((volume_integral(kernel) - integral).abs() < 5e-5, "{kernel:?}");
            let [lo, hi] = ripple(kernel);
            assert!((lo - least).abs() < 5.1e-4 && (hi - greatest).abs() < 5.1e-4, "{lo} {hi}");
        };
        check(Kernel::Gaussian, 0.4456, 0.9993, [0.993, 1.004]);
        check(Kernel::CrawfisMax, 0.6999, 1.0000, [0.998, 1.005]);
    }

    #[test]
    fn kernel_constant_and_peak() {
        let c = Kernel::Gaussian.at(0.0);
        assert!((c - 0.29627).abs() < 5e-6, "{c}");
        for kernel in [Kernel::Gaussian, Kernel::CrawfisMax] {
            assert_eq!(kernel.at(kernel.radius()), 0.0);
            assert_eq!(kernel.at(9.0), 0.0);
        }
    }

    /// The pieces of crawfis-max meet with their values and slopes, as far as its digits go.
    #[test]
    fn kernel_crawfis_max_is_smooth_at_its_joint() {
        let h = |r| Kernel::CrawfisMax.at(r);
        let (left, right) = (CRAWFIS_MAX_JOINT - 1e-6, CRAWFIS_MAX_JOINT + 1e-6);
        assert!((h(left) - h(right)).abs() < 1e-5, "{} {}", h(left), h(right));
        let slopes = [(h(left) - h(left - 1e-4)) * 1e4, (h(right + 1e-4) - h(right)) * 1e4];
        assert!((slopes[0] - slopes[1]).abs() < 1e-3, "{slopes:?}");
    }

    /// A Gaussian factors: along any ray the footprint is `h(ρ)` times one integral.
    #[test]
    fn kernel_line_integral_of_gaussian_factors() {
        let along =
            |rho: f64, t: f64| Kernel::Gaussian.line_integral(DVec3::X * rho, DVec3::Z, [-t, t]);
        let ratio = along(0.7, 0.9) / along(0.2, 0.9);
        let expected = (-2.0_f64 * (0.49 - 0.04)).exp2();
        assert!((ratio - expected).abs() < 1e-13, "{ratio} {expected}");
    }

    /// Against the same integral in ten thousand steps, near the centre line and near the rim.
    #[test]
    fn kernel_line_integral_converges() {
        for kernel in [Kernel::Gaussian, Kernel::CrawfisMax] {
            for rho in [0.0_f64, 1e-3, 0.05, 0.3, 0.8799, 0.8801, 1.2, 1.55] {
                for [a, b] in [[-9.0, 9.0], [-0.3, 0.4], [0.1, 1.9]] {
                    let ray = |t: f64| kernel.at(rho.hypot(t));
                    // A fine midpoint rule between the same kinks, mapped so that its ends are dense.
                    let fine = fine_integral(kernel, rho, [a, b], &ray);
                    let rule = kernel.line_integral(DVec3::X * rho, DVec3::Z, [a, b]);
                    assert!(
                        (rule - fine).abs() < 1e-10,
                        "{kernel:?} {rho} {a}..{b}: {rule} {fine}"
                    );
                }
            }
        }
    }

    fn fine_integral(kernel: Kernel, rho: f64, [a, b]: [f64; 2], f: &dyn Fn(f64) -> f64) -> f64 {
        let rim = (kernel.radius().powi(2) - rho * rho).max(0.0).sqrt();
        let (a, b) = (a.max(-rim), b.min(rim));
        let n = 20_000;
        let rule = GaussLegendre::new(6);
        let at = |i: usize| a + (b - a) * i as f64 / n as f64;
        (0..n).map(|i| rule.integrate(at(i), at(i + 1), f)).sum()
    }
}
