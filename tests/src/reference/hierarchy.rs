//! The slab hierarchy and its normalisation (paper §3.2, eqs. 6–8; model §2).

use slabsplat_core::Normalization;

/// How thick sections are made from thin ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hierarchy {
    /// How two sections are joined.
    pub normalization: Normalization,
    /// Width of the thinnest level, in `unit`s.
    pub base_width: f64,
}

impl Hierarchy {
    /// The section to draw of the slab `[front, front + width)`, where `plain(front, width)` is the
    /// integral of the kernel over a slab.
    pub fn section(&self, plain: &dyn Fn(f64, f64) -> f64, front: f64, width: f64) -> f64 {
        if self.normalization == Normalization::None || width <= self.base_width {
            return plain(front, width);
        }
        let (mut level, mut level_width) = (0, self.base_width);
        while 2.0 * level_width <= width {
            (level, level_width) = (level + 1, 2.0 * level_width);
        }
        let t = (width - level_width) / level_width;
        let thin = self.ratio(plain, level, front);
        let thick = if 0.0 < t { self.ratio(plain, level + 1, front) } else { thin };
        plain(front, width) * ((1.0 - t) * thin + t * thick)
    }

    /// Normalised over plain section at a level. What the slab hardly cuts is not normalised: rounding would
    /// decide.
    fn ratio(&self, plain: &dyn Fn(f64, f64) -> f64, level: u32, front: f64) -> f64 {
        let normalized = self.level_section(plain, level, front);
        let plain = plain(front, self.level_width(level));
        if plain < 1e-11 { 1.0 } else { normalized / plain }
    }

    fn level_width(&self, level: u32) -> f64 {
        self.base_width * f64::from(level).exp2()
    }

    /// The section of width `base·2ˡᵉᵛᵉˡ`, joined from those of the level below.
    fn level_section(&self, plain: &dyn Fn(f64, f64) -> f64, level: u32, front: f64) -> f64 {
        if level == 0 {
            return plain(front, self.base_width);
        }
        let h_f = self.level_section(plain, level - 1, front);
        let h_b = self.level_section(plain, level - 1, front + self.level_width(level - 1));
        self.joined(h_f, h_b)
    }

    /// One thick section from its front and back half.
    fn joined(&self, h_f: f64, h_b: f64) -> f64 {
        match self.normalization {
            Normalization::None => h_f + h_b,
            Normalization::Paper => h_f + h_b - (2.0 * h_b * h_f + 0.5 * h_b * h_b * h_f),
            Normalization::Product => {
                (h_f * h_f + h_b * h_b - 0.5 * h_b * h_b * h_f).max(0.0).sqrt()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A kernel that weighs 0.2 per unit between 0 and 3.
    fn bar(front: f64, width: f64) -> f64 {
        0.2 * ((front + width).clamp(0.0, 3.0) - front.clamp(0.0, 3.0))
    }

    fn section(normalization: Normalization, front: f64, width: f64) -> f64 {
        Hierarchy { normalization, base_width: 0.5 }.section(&bar, front, width)
    }

    #[test]
    fn hierarchy_base_and_thinner_are_plain() {
        for normalization in [Normalization::Paper, Normalization::Product] {
            for width in [0.1, 0.3, 0.5] {
                assert_eq!(section(normalization, 0.2, width), bar(0.2, width));
            }
        }
        assert_eq!(section(Normalization::None, 0.2, 2.7), bar(0.2, 2.7));
    }

    #[test]
    fn hierarchy_first_levels_by_hand() {
        let paper = 0.2 - (2.0 * 0.01 + 0.5 * 0.001);
        assert!((section(Normalization::Paper, 0.0, 1.0) - paper).abs() < 1e-15);
        let product = (0.02_f64 - 0.5 * 0.001).sqrt();
        assert!((section(Normalization::Product, 0.0, 1.0) - product).abs() < 1e-15);
        let twice = (2.0 * product * product - 0.5 * product.powi(3)).sqrt();
        assert!((section(Normalization::Product, 0.5, 2.0) - twice).abs() < 1e-15);
    }

    #[test]
    fn hierarchy_interpolates_ratio_between_levels() {
        let ratio = |width: f64| section(Normalization::Product, 0.0, width) / bar(0.0, width);
        let expected = 0.75 * ratio(1.0) + 0.25 * ratio(2.0);
        assert!((ratio(1.25) - expected).abs() < 1e-15);
        assert!(ratio(2.0) < ratio(1.25) && ratio(1.25) < ratio(1.0));
    }

    #[test]
    fn hierarchy_leaves_alone_what_only_one_half_holds() {
        for normalization in [Normalization::Paper, Normalization::Product] {
            assert!((section(normalization, -0.5, 1.0) - 0.1).abs() < 1e-15);
            assert_eq!(section(normalization, 3.5, 1.0), 0.0);
        }
    }

    /// Eq. 6 holds exactly for one voxel: the thick section looks like the two thin ones composited.
    #[test]
    fn hierarchy_product_is_eq_6() {
        let (h_f, h_b, alpha) = (0.3, 0.4, 0.5);
        let composited = alpha * (h_b * h_b - h_b * h_b * alpha * h_f + h_f * h_f);
        let hierarchy = Hierarchy { normalization: Normalization::Product, base_width: 0.5 };
        let thick = hierarchy.joined(h_f, h_b);
        assert!((alpha * thick * thick - composited).abs() < 1e-15);
    }
}
