//! The exact section of a kernel by a slab (paper §3.2, model §2): slow, and right by definition.

use crate::Kernel;
use crate::hierarchy::Hierarchy;
use slabsplat_core::Normalization;

/// Which section is meant: of what kernel, by how thick a slab, seen from where.
#[derive(Clone, Copy, Debug)]
pub struct SectionDesc<'a> {
    /// The kernel that is cut.
    pub kernel: &'a dyn Kernel,
    /// Slab width in `unit`s, above 0.
    pub width: f64,
    /// Index-space length of a ray over one `unit` of depth; 1 on a cubic grid.
    pub kappa: f64,
    /// How thick sections are darkened.
    pub normalization: Normalization,
    /// Width of the slab hierarchy's lowest level in `unit`s.
    pub base_width: f64,
}

impl SectionDesc<'_> {
    /// The weight `H(ρ, a)` of the section whose front face cuts the ray `front` index units behind
    /// the ray's point nearest to the voxel (before it, if negative).
    pub fn weight(&self, rho: f64, front: f64) -> f64 {
        let plain = self.plain(rho, front, self.width);
        match self.normalization {
            Normalization::None => plain,
            Normalization::Paper | Normalization::Product => {
                plain * Hierarchy { section: self, rho }.darkening(front)
            }
        }
    }

    /// The section of a slab of `width` `unit`s, without normalisation.
    pub(crate) fn plain(&self, rho: f64, front: f64, width: f64) -> f64 {
        self.kernel.line_integral(rho, front, front + width * self.kappa) / self.kappa
    }

    /// Whether a slab of `width` `unit`s with that front face cuts the ray within the kernel's ball.
    pub(crate) fn meets(&self, front: f64, width: f64) -> bool {
        let radius = self.kernel.radius();
        front < radius && -radius < front + width * self.kappa
    }

    /// The slab width along a ray in index space.
    pub fn width_in_index(&self) -> f64 {
        self.width * self.kappa
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{KERNEL_NAMES, kernel_named};

    fn plain(kernel: &dyn Kernel, kappa: f64, width: f64) -> SectionDesc<'_> {
        let normalization = Normalization::None;
        SectionDesc { kernel, width, kappa, normalization, base_width: 0.5 }
    }

    /// Simpson's rule on the kernel itself, which the closed forms must agree with.
    fn integral_by_simpson(kernel: &dyn Kernel, rho: f64, a: f64, b: f64) -> f64 {
        let n = 20_000;
        let h = (b - a) / f64::from(n);
        let at = |i: i32| kernel.value(rho.hypot(a + h * f64::from(i)));
        let inner: f64 = (1..n).map(|i| if i % 2 == 1 { 4.0 * at(i) } else { 2.0 * at(i) }).sum();
        (at(0) + inner + at(n)) * h / 3.0
    }

    #[test]
    fn section_closed_forms_match_quadrature() {
        for &name in KERNEL_NAMES {
            let kernel = kernel_named(name).unwrap();
            for rho in [0.0, 1e-13, 0.1, 0.5, 0.879, 0.88, 1.2, 1.55, 1.9, 2.5] {
                for (a, b) in [(-3.0, 3.0), (-2.0, -1.0), (-0.3, 0.4), (0.0, 0.5), (1.0, 9.0)] {
                    let exact = kernel.line_integral(rho, a, b);
                    let numeric = integral_by_simpson(&*kernel, rho, a, b);
                    // The Gaussian's step at R costs Simpson's rule one interval's worth.
                    assert!(
                        (exact - numeric).abs() < 1e-6,
                        "{name} {rho} {a} {b}: {exact} {numeric}"
                    );
                }
            }
        }
    }

    /// A slab that only touches the ball from without does not meet it.
    #[test]
    fn section_meets_what_it_weighs() {
        let kernel = kernel_named("gaussian").unwrap();
        for (kappa, width) in [(1.0, 1.0), (0.5, 1.0), (1.3, 0.4)] {
            let desc = plain(&*kernel, kappa, width);
            for front in [-9.0, -2.0 - width * kappa, -2.0, -1.9, 0.0, 1.9, 2.0, 9.0] {
                let weighs = 0.0 < desc.plain(0.0, front, width);
                assert_eq!(desc.meets(front, width), weighs, "{kappa} {width} {front}");
            }
        }
    }

    #[test]
    fn section_sums_to_footprint() {
        for &name in KERNEL_NAMES {
            let kernel = kernel_named(name).unwrap();
            for (kappa, width) in [(1.0, 0.5), (0.7, 1.0), (1.3, 0.4)] {
                let desc = plain(&*kernel, kappa, width);
                let sum: f64 = (-20..20)
                    .map(|slab| (f64::from(slab) + 0.37) * desc.width_in_index())
                    .map(|front| desc.weight(0.6, front))
                    .sum();
                assert!((sum - kernel.footprint(0.6) / kappa).abs() < 1e-12);
            }
        }
    }
}
