//! The compositing models (model §3): what a sheet sums of a voxel, and how sums become a pixel.
//!
//! This is the one place that says what they mean. Backends have loops of their own, for vectors and for
//! shaders, and tests hold those against [`Compositing::resolve`]. Whoever adds a model adds it here, and
//! the compiler names where else it must be handled: the matches on [`Compositing`] have no arm for all
//! others.

use crate::Compositing;

/// Opacity from which on extinction stays what it is: at 1 it would be infinite.
pub const MAX_OPACITY: f64 = 1.0 - 1e-6;

/// `μ = −ln(1 − α)` of an opacity, 0 to 1; at most that of [`MAX_OPACITY`], 13.8.
///
/// ```
/// assert_eq!(slabsplat_core::extinction(0.0), 0.0);
/// assert!((slabsplat_core::extinction(0.5) - 0.5_f64.ln().abs()).abs() < 1e-15);
/// assert!(slabsplat_core::extinction(1.0) < 13.82);
/// ```
pub fn extinction(opacity: f64) -> f64 {
    -(-opacity.min(MAX_OPACITY)).ln_1p()
}

impl Compositing {
    /// What a sheet sums of an opacity: `α`, or `μ = −ln(1 − α)`.
    #[inline]
    pub fn weight(self, opacity: f64) -> f64 {
        match self {
            Self::Separate | Self::Associated => opacity,
            Self::Extinction => extinction(opacity),
        }
    }

    /// Whether a sheet sums colours times their [`weight`](Self::weight); if not, as they are.
    #[inline]
    pub fn weights_colors(self) -> bool {
        match self {
            Self::Separate => false,
            Self::Associated | Self::Extinction => true,
        }
    }

    /// Whether what is summed is an extinction, which has no bound that a pixel can see; if not, it is an
    /// opacity.
    #[inline]
    pub fn sums_extinction(self) -> bool {
        match self {
            Self::Separate | Self::Associated => false,
            Self::Extinction => true,
        }
    }

    /// What composites the sums of several layers of densities, each of what it alone would show
    /// ([model §10](crate::model)): where colours are summed as they are, each layer's are weighted first, so
    /// that one that shows little adds little.
    #[inline]
    pub fn of_joined_densities(self) -> Self {
        match self {
            Self::Separate | Self::Associated => Self::Associated,
            Self::Extinction => Self::Extinction,
        }
    }

    /// The premultiplied colour and opacity of a sheet's sums of colour and weight (eqs. 2, 4–7). A weight of
    /// 0 or less, which only the `paper` normalisation can give, counts as nothing.
    ///
    /// ```
    /// use slabsplat_core::Compositing;
    ///
    /// let sums = [0.4, 0.2, 0.0, 0.5];
    /// assert_eq!(Compositing::Separate.resolve(sums), [0.2, 0.1, 0.0, 0.5]);
    /// assert_eq!(Compositing::Associated.resolve(sums), sums);
    /// let [.., opacity] = Compositing::Extinction.resolve(sums);
    /// assert!((opacity - (1.0 - (-0.5_f64).exp())).abs() < 1e-15);
    /// ```
    #[inline]
    pub fn resolve(self, [r, g, b, weight]: [f64; 4]) -> [f64; 4] {
        let (factor, opacity) = match self {
            Self::Separate => {
                let opacity = weight.clamp(0.0, 1.0);
                let [r, g, b] = [r, g, b].map(|sum| opacity * sum.clamp(0.0, 1.0));
                return [r, g, b, opacity];
            }
            Self::Associated => ((1.0 / weight).min(1.0), weight.min(1.0)),
            Self::Extinction => (-(-weight).exp_m1() / weight, -(-weight).exp_m1()),
        };
        if weight <= 0.0 {
            return [0.0; 4];
        }
        [factor * r, factor * g, factor * b, opacity]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extinction_is_what_opacity_loses() {
        assert_eq!(extinction(0.0), 0.0);
        assert!((extinction(0.5) - 2.0_f64.ln()).abs() < 1e-15);
        assert!((extinction(1.0) - 1e6_f64.ln()).abs() < 1e-9);
        for opacity in [1e-12, 0.3, 0.99, MAX_OPACITY] {
            let [.., resolved] =
                Compositing::Extinction.resolve([0.0, 0.0, 0.0, extinction(opacity)]);
            assert!((resolved / opacity - 1.0).abs() < 1e-12, "{opacity}");
        }
    }

    #[test]
    fn sheets_sum_weights_and_weighted_colors() {
        for &compositing in Compositing::ALL {
            let sums_extinction = compositing == Compositing::Extinction;
            assert_eq!(compositing.sums_extinction(), sums_extinction);
            assert_eq!(compositing.weights_colors(), compositing != Compositing::Separate);
            let weight = if sums_extinction { 4.0_f64.ln() } else { 0.75 };
            assert!((compositing.weight(0.75) - weight).abs() < 1e-12, "{compositing}");
            let joined = compositing.of_joined_densities();
            assert!(joined.weights_colors(), "{compositing}: a faint layer would show as much");
            assert_eq!(joined.sums_extinction(), sums_extinction, "{compositing}");
        }
    }

    #[test]
    fn sums_resolve_to_premultiplied_colors() {
        let check = |compositing: Compositing, sums: [f64; 4], expected: [f64; 4]| {
            let resolved = compositing.resolve(sums);
            let differs = |(a, b): (&f64, f64)| 1e-12 < (a - b).abs();
            assert!(!resolved.iter().zip(expected).any(differs), "{compositing}: {resolved:?}");
        };
        check(Compositing::Separate, [2.0, -1.0, 0.5, 0.5], [0.5, 0.0, 0.25, 0.5]);
        check(Compositing::Separate, [0.5, 1.0, 0.0, 2.0], [0.5, 1.0, 0.0, 1.0]);
        check(Compositing::Associated, [0.4, 0.2, 0.1, 0.5], [0.4, 0.2, 0.1, 0.5]);
        check(Compositing::Associated, [0.4, 0.2, 0.1, 2.0], [0.2, 0.1, 0.05, 1.0]);
        let thick = 2.0_f64.ln();
        check(Compositing::Extinction, [thick, 0.0, thick / 4.0, thick], [0.5, 0.0, 0.125, 0.5]);
        for &compositing in Compositing::ALL {
            for weight in [0.0, -0.5] {
                check(compositing, [0.5, 0.5, 0.5, weight], [0.0; 4]);
            }
        }
    }
}
