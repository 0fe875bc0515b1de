//! The slab hierarchy (paper §3.2, eqs. 6–8 and figure 8): how much a thick section is darkened so
//! that it looks like the thin ones it stands for.
//!
//! Level `n` has the width `base·2ⁿ`. Its section is made of the two of level `n − 1` that it covers,
//! `h_f` in front and `h_b` behind. Widths between levels interpolate the *darkening*, the ratio of
//! the normalised to the plain section. Model §2 has the cases that the paper leaves open.

use crate::SectionDesc;
use slabsplat_core::Normalization;

/// The hierarchy over one ray through one kernel.
pub(crate) struct Hierarchy<'a> {
    pub(crate) section: &'a SectionDesc<'a>,
    pub(crate) rho: f64,
}

/// Sections below this are next to nothing, and rounding decides what is left of the two that one is made of:
/// the difference of two antiderivatives has 10⁻¹⁶ of noise. Towards 0 the ratio tends to 1, as only one of
/// the two is not 0.
const LEAST_SECTION: f64 = 1e-11;

/// The opacity that eq. 8 assumes ("taking an average α_v = 0.5").
const ALPHA: f64 = 0.5;

impl Hierarchy<'_> {
    /// Normalised over plain section, for the slab with this front face; 1 where there is next to nothing.
    pub(crate) fn darkening(&self, front: f64) -> f64 {
        let SectionDesc { width, base_width, .. } = *self.section;
        if width <= base_width {
            return 1.0;
        }
        let level = (width / base_width).log2();
        let below = level.floor();
        let width_below = base_width * below.exp2();
        let t = (width - width_below) / width_below;
        let at_level = |level: f64| self.darkening_at_level(level, front);
        if t == 0.0 {
            at_level(below)
        } else {
            (1.0 - t) * at_level(below) + t * at_level(below + 1.0)
        }
    }

    fn darkening_at_level(&self, level: f64, front: f64) -> f64 {
        let width = self.section.base_width * level.exp2();
        let plain = self.section.plain(self.rho, front, width);
        if plain < LEAST_SECTION { 1.0 } else { self.normalized(width, front) / plain }
    }

    /// `N_n(ρ, a)` of the level whose width is `width`.
    fn normalized(&self, width: f64, front: f64) -> f64 {
        if !self.section.meets(front, width) {
            return 0.0;
        }
        if width <= self.section.base_width {
            return self.section.plain(self.rho, front, width);
        }
        let half = width / 2.0;
        let h_f = self.normalized(half, front);
        let h_b = self.normalized(half, front + half * self.section.kappa);
        join(self.section.normalization, h_f, h_b)
    }
}

/// One thick section from the two thin ones that it covers.
fn join(normalization: Normalization, h_f: f64, h_b: f64) -> f64 {
    match normalization {
        Normalization::None => h_f + h_b,
        // Negative where sections are heavier than the paper's ever are, on a grid whose voxels are
        // much longer along the ray than `unit`. A sheet's sum then counts as at least 0.
        Normalization::Paper => h_f + h_b - (2.0 * h_b * h_f + 0.5 * h_b * h_b * h_f),
        Normalization::Product => (h_f * h_f + h_b * h_b - ALPHA * h_b * h_b * h_f).max(0.0).sqrt(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Gaussian;
    use crate::kernel::half_chord;

    fn desc(normalization: Normalization, width: f64) -> SectionDesc<'static> {
        SectionDesc { kernel: &Gaussian, width, kappa: KAPPA, normalization, base_width: 0.5 }
    }

    const KAPPA: f64 = 1.25;

    #[test]
    fn hierarchy_without_normalization_adds_up() {
        for width in [1.0, 2.5, 16.0] {
            let section = &desc(Normalization::None, width);
            for front in [-2.1, -0.3, 1.2] {
                let darkening = Hierarchy { section, rho: 0.4 }.darkening(front);
                assert!((darkening - 1.0).abs() < 1e-12, "{width} {front}: {darkening}");
            }
        }
    }

    /// Eq. 6, for one voxel of opacity ½: what two slabs composite is what the joined slab shows.
    #[test]
    fn hierarchy_product_satisfies_equation_6() {
        for (rho, front) in [(0.0, -1.0), (0.4, -0.7), (1.1, 0.2)] {
            let thin = desc(Normalization::Product, 0.5);
            let h_f = thin.weight(rho, front);
            let h_b = thin.weight(rho, front + 0.5 * KAPPA);
            let composited = h_f * h_f * ALPHA + (1.0 - ALPHA * h_f) * h_b * h_b * ALPHA;
            let joined = desc(Normalization::Product, 1.0).weight(rho, front);
            assert!((joined * joined * ALPHA - composited).abs() < 1e-14, "{rho} {front}");
        }
    }

    /// Eq. 8 as printed.
    #[test]
    fn hierarchy_paper_subtracts_equation_8() {
        let (rho, front) = (0.3, -0.6);
        let thin = desc(Normalization::Paper, 0.5);
        let (h_f, h_b) = (thin.weight(rho, front), thin.weight(rho, front + 0.5 * KAPPA));
        let expected = h_f + h_b - (2.0 * h_b * h_f + 0.5 * h_b * h_b * h_f);
        let joined = desc(Normalization::Paper, 1.0).weight(rho, front);
        assert!((joined - expected).abs() < 1e-14);
    }

    #[test]
    fn hierarchy_interpolates_between_levels() {
        for normalization in [Normalization::Paper, Normalization::Product] {
            let weight = |width| desc(normalization, width).weight(0.2, -0.9);
            let darkening =
                |width| weight(width) / desc(Normalization::None, width).weight(0.2, -0.9);
            for below in [0.5, 1.0, 2.0] {
                let expected = 0.75 * darkening(below) + 0.25 * darkening(2.0 * below);
                let difference = darkening(1.25 * below) - expected;
                assert!(difference.abs() < 1e-12, "{normalization} {below}");
            }
            assert!((darkening(1.0 + 1e-9) - darkening(1.0)).abs() < 1e-8, "continuous at a level");
            assert!((darkening(2.0 - 1e-9) - darkening(2.0)).abs() < 1e-8, "continuous at a level");
        }
    }

    /// Where a level's slab just touches the kernel: the ratio was one of rounding errors there.
    #[test]
    fn hierarchy_of_next_to_nothing_is_plain() {
        for normalization in [Normalization::Paper, Normalization::Product] {
            let kernel: &dyn crate::Kernel = &crate::CrawfisMax;
            for rho in [0.0, 0.1, 0.7, 1.3] {
                let section = &SectionDesc { kernel, ..desc(normalization, 3.3) };
                let touching = -half_chord(kernel.radius(), rho) - 2.0 * KAPPA;
                let darkening = |by: f64| Hierarchy { section, rho }.darkening(touching + by);
                let steps = (0..150).map(|i| 1e-17 * 1.25_f64.powi(i));
                for by in steps.filter(|by| *by < 1e-3) {
                    let jump = (darkening(by) - darkening(-by)).abs();
                    assert!(jump < 1e-2, "{normalization} {rho} {by}: {jump}");
                }
            }
        }
    }

    #[test]
    fn hierarchy_leaves_thin_slabs_alone() {
        for width in [0.1, 0.5] {
            let plain = desc(Normalization::None, width).weight(0.5, 0.1);
            assert_eq!(desc(Normalization::Product, width).weight(0.5, 0.1), plain);
        }
    }
}
