//! How a sheet's sums become premultiplied colour and opacity (SPEC §3).

/// One of the three compositing models; chosen once a frame.
pub(crate) trait Composite: Sync {
    /// Premultiplied colour and opacity of a sheet with these sums. An opacity below 0, which only the
    /// `paper` normalisation can sum to, counts as 0.
    fn resolve(sums: [f32; 4]) -> [f32; 4];
}

/// `A·C` and `A`, both sums clamped (eqs. 4–7).
pub(crate) struct Separate;

/// `C·min(1, 1/A)` and `min(A, 1)` (eq. 2).
pub(crate) struct Associated;

/// `E·(1 − e^(−τ))/τ` and `1 − e^(−τ)`.
pub(crate) struct Extinction;

impl Composite for Separate {
    #[inline]
    fn resolve([r, g, b, a]: [f32; 4]) -> [f32; 4] {
        let opacity = a.clamp(0.0, 1.0);
        let [r, g, b] = [r, g, b].map(|c| opacity * c.clamp(0.0, 1.0));
        [r, g, b, opacity]
    }
}

impl Composite for Associated {
    #[inline]
    fn resolve([r, g, b, a]: [f32; 4]) -> [f32; 4] {
        if a <= 0.0 {
            return [0.0; 4];
        }
        let down = if 1.0 < a { 1.0 / a } else { 1.0 };
        [r * down, g * down, b * down, a.min(1.0)]
    }
}

impl Composite for Extinction {
    #[inline]
    fn resolve([r, g, b, tau]: [f32; 4]) -> [f32; 4] {
        if tau <= 0.0 {
            return [0.0; 4];
        }
        // Not 1 − e^(−τ), which rounds to steps of 6·10⁻⁸: a hundred thousand thin sheets would all be
        // off to the same side.
        let opacity = -(-tau).exp_m1();
        let mean = opacity / tau;
        [r * mean, g * mean, b * mean, opacity]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: [f32; 4], b: [f32; 4]) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6), "{a:?} {b:?}");
    }

    #[test]
    fn composite_resolves_sums() {
        close(Separate::resolve([0.5, 2.0, 0.0, 0.5]), [0.25, 0.5, 0.0, 0.5]);
        close(Separate::resolve([0.5, 0.5, 0.5, 2.0]), [0.5, 0.5, 0.5, 1.0]);
        close(Associated::resolve([0.3, 0.2, 0.1, 0.5]), [0.3, 0.2, 0.1, 0.5]);
        close(Associated::resolve([1.0, 2.0, 0.0, 2.0]), [0.5, 1.0, 0.0, 1.0]);
        let half = std::f32::consts::LN_2;
        close(Extinction::resolve([half, 0.5 * half, 0.0, half]), [0.5, 0.25, 0.0, 0.5]);
        close(Extinction::resolve([0.0; 4]), [0.0; 4]);
        close(Extinction::resolve([0.1, 0.1, 0.1, -0.2]), [0.0; 4]);
        close(Associated::resolve([0.1, 0.1, 0.1, -0.2]), [0.0; 4]);
    }

    /// A faint volume in ever so many sheets is as opaque as in one.
    #[test]
    fn composite_extinction_keeps_faint_sheets() {
        let n_sheets = 100_000;
        let (whole, mut through) = (0.01_f32, 1.0_f64);
        let [.., opacity] = Extinction::resolve([0.0, 0.0, 0.0, whole / n_sheets as f32]);
        (0..n_sheets).for_each(|_| through *= 1.0 - f64::from(opacity));
        let [.., expected] = Extinction::resolve([0.0, 0.0, 0.0, whole]);
        assert!((1.0 - through - f64::from(expected)).abs() < 1e-8, "{through}");
    }

    /// Two thin sheets of one colour are one thick sheet.
    #[test]
    fn composite_extinction_is_additive() {
        for (front, back) in [(0.1_f32, 0.3_f32), (1e-4, 2e-3), (5e-4, 5e-4), (3.0, 0.01)] {
            let sheet = |tau: f32| Extinction::resolve([0.7 * tau, 0.2 * tau, tau, tau]);
            let (near, far) = (sheet(front), sheet(back));
            let through = 1.0 - near[3];
            let joined = std::array::from_fn(|c| near[c] + through * far[c]);
            close(joined, sheet(front + back));
        }
    }
}
