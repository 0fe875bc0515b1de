//! How a sheet's sums become premultiplied colour and opacity (model §3), and how that goes behind what a
//! pixel holds already. What the models mean is said in `crates/slabsplat-core/src/compositing.rs`.
//!
//! ```text
//! for eight pixels at once:
//!     τ = their sums of weight
//!     factor = (1 − e^(−τ))/τ in `extinction`, min(1, 1/τ) in `associated`; 0 where τ ≤ 0
//!     pixel += (1 − opacity)·factor·sums, all four channels alike
//! ```
//!
//! 1. In two of the three models a sheet's pixel is its sums times one factor, so that colour and opacity are
//!    one multiply-add, and only the factors need the pixels' opacities side by side.
//! 2. `1 − e^(−τ)` is a series that cancels nothing, as faint sheets come by the hundred thousand.
//! 3. `separate` multiplies two clamped sums, and goes pixel by pixel: it is there to be compared with.

use super::quad::{QUAD, Quad};
use fearless_simd::{Simd, f32x8, i32x8, prelude::*};
use slabsplat_core::Compositing;

/// Pixels that are composited at once.
const OCTET: usize = 8;

/// Puts eight sums behind eight pixels, empties the sums, and returns the least opacity of the eight.
#[inline(always)]
pub(crate) fn put_behind<S: Simd>(
    simd: S,
    compositing: Compositing,
    pixels: [&mut Quad; 2],
    [left, right]: [&mut Quad; 2],
) -> f32 {
    let behind = [std::mem::take(left), std::mem::take(right)];
    let weight = opacities(simd, [&behind[0], &behind[1]]);
    let factor = match compositing {
        Compositing::Separate => return put_product_behind(pixels, &behind),
        Compositing::Associated => f32x8::splat(simd, 1.0).min(f32x8::splat(simd, 1.0) / weight),
        Compositing::Extinction => mean_transparency(simd, weight),
    };
    // A sum below 0, which only the `paper` normalisation can have, counts as 0.
    let zero = f32x8::splat(simd, 0.0);
    let factor = weight.simd_gt(zero).select(factor, zero);
    let opacity = opacities(simd, [pixels[0], pixels[1]]);
    let factor = factor * (f32x8::splat(simd, 1.0) - opacity);
    let mut factors = [0.0; OCTET];
    factor.store_slice(&mut factors);
    for ((pixels, behind), factors) in
        pixels.into_iter().zip(&behind).zip(factors.as_chunks::<QUAD>().0)
    {
        let behind = behind.0.simd_into(simd);
        pixels.add_weighted(simd, *factors, behind);
    }
    factor.mul_add(weight, opacity).reduce_min()
}

/// `A·C` and `A`, both sums clamped (eqs. 4–7).
#[inline(always)]
fn put_product_behind(pixels: [&mut Quad; 2], behind: &[Quad; 2]) -> f32 {
    let mut least = f32::INFINITY;
    for (pixels, behind) in pixels.into_iter().zip(behind) {
        for idx in 0..QUAD {
            let mut pixel = pixels.pixel(idx);
            let [r, g, b, opacity] = behind.pixel(idx).map(|sum| sum.clamp(0.0, 1.0));
            let factor = opacity * (1.0 - pixel[3]);
            for (channel, added) in pixel.iter_mut().zip([r, g, b, 1.0]) {
                *channel += factor * added;
            }
            pixels.set_pixel(idx, pixel);
            least = least.min(pixel[3]);
        }
    }
    least
}

#[inline(always)]
fn opacities<S: Simd>(simd: S, [left, right]: [&Quad; 2]) -> f32x8<S> {
    let ([a, b, c, d], [e, f, g, h]) = (left.opacities(), right.opacities());
    [a, b, c, d, e, f, g, h].simd_into(simd)
}

/// `(1 − e^(−τ))/τ` for `τ > 0`, to some 2·10⁻⁷ of itself.
///
/// `τ = n·ln 2 + r`, so that `1 − e^(−τ) = (1 − 2⁻ⁿ) + 2⁻ⁿ·(1 − e^(−r))`, where the last is a series in `r`
/// and nothing cancels: thin sheets by the hundred thousand would else all be off to the same side.
#[inline(always)]
fn mean_transparency<S: Simd>(simd: S, tau: f32x8<S>) -> f32x8<S> {
    // Beyond, 1 − e^(−τ) is 1 in 32 bits.
    let bounded = tau.min(f32x8::splat(simd, 80.0));
    let n = (bounded * std::f32::consts::LOG2_E).round_ties_even();
    // ln 2 in two parts, of which n·the first is exact.
    let r = n.mul_add(f32x8::splat(simd, -0.693_359_4), bounded);
    let r = n.mul_add(f32x8::splat(simd, 2.121_944_4e-4), r);
    let mut sum = f32x8::splat(simd, 0.0);
    for term in SERIES {
        sum = sum.mul_add(r, f32x8::splat(simd, term));
    }
    // 2⁻ⁿ by its bits.
    let one = f32x8::splat(simd, 1.0);
    let exponent: i32x8<S> = (f32x8::splat(simd, 127.0) - n).to_int();
    let power: f32x8<S> = (exponent << 23).bitcast();
    let opacity = (sum * r).mul_add(power, one - power);
    opacity / tau
}

/// `(1 − e^(−r))/r = 1 − r/2 + r²/6 − …`, from its last term on; for `|r| ≤ ½ ln 2`.
const SERIES: [f32; 7] =
    [1.0 / 5040.0, -1.0 / 720.0, 1.0 / 120.0, -1.0 / 24.0, 1.0 / 6.0, -1.0 / 2.0, 1.0];

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};
    use slabsplat_seeds::for_each_seed;

    /// A sheet of those sums, behind nothing.
    fn resolved(compositing: Compositing, sums: [f32; 4]) -> [f32; 4] {
        behind(compositing, [0.0; 4], sums)
    }

    fn behind(compositing: Compositing, pixel: [f32; 4], sums: [f32; 4]) -> [f32; 4] {
        let (mut pixels, mut sums) = ([Quad::of(pixel); 2], [Quad::of(sums); 2]);
        let level = Level::new();
        let least = dispatch!(level, simd => put_behind(simd, compositing, pixels.each_mut(), sums.each_mut()));
        assert!((least - pixels[1].pixel(3)[3]).abs() < 1e-6);
        assert_eq!(sums[0].0, [0.0; 16]);
        for idx in 0..4 {
            assert_eq!(pixels[0].pixel(idx), pixels[1].pixel(3));
        }
        pixels[0].pixel(0)
    }

    fn close(a: [f32; 4], b: [f32; 4]) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6), "{a:?} {b:?}");
    }

    #[test]
    fn composite_resolves_sums() {
        use Compositing::{Associated, Extinction, Separate};
        close(resolved(Separate, [0.5, 2.0, 0.0, 0.5]), [0.25, 0.5, 0.0, 0.5]);
        close(resolved(Separate, [0.5, 0.5, 0.5, 2.0]), [0.5, 0.5, 0.5, 1.0]);
        close(resolved(Associated, [0.3, 0.2, 0.1, 0.5]), [0.3, 0.2, 0.1, 0.5]);
        close(resolved(Associated, [1.0, 2.0, 0.0, 2.0]), [0.5, 1.0, 0.0, 1.0]);
        let half = std::f32::consts::LN_2;
        close(resolved(Extinction, [half, 0.5 * half, 0.0, half]), [0.5, 0.25, 0.0, 0.5]);
        close(resolved(Extinction, [0.0; 4]), [0.0; 4]);
        close(resolved(Extinction, [0.1, 0.1, 0.1, -0.2]), [0.0; 4]);
        close(resolved(Associated, [0.1, 0.1, 0.1, -0.2]), [0.0; 4]);
        for compositing in [Separate, Associated] {
            close(
                behind(compositing, [0.1, 0.2, 0.0, 0.5], [1.0, 0.0, 0.0, 1.0]),
                [0.6, 0.2, 0.0, 1.0],
            );
        }
    }

    /// Against what the models mean, in 64 bits: weights from far below 1 to far above, negative ones, and
    /// none.
    #[test]
    fn composite_is_the_definition() {
        for_each_seed(1, |mut rng| {
            for _ in 0..2000 {
                for &compositing in Compositing::ALL {
                    let scale = 10.0_f32.powi(rng.i32(-4..2));
                    let weight = [scale * (rng.f32() - 0.1), 0.0][usize::from(rng.u8(..20) == 0)];
                    let of = if compositing.weights_colors() { weight } else { 1.5 };
                    let [r, g, b] = [0; 3].map(|_| of * rng.f32());
                    let sums = [r, g, b, weight];
                    let opacity = rng.f32();
                    let pixel = [opacity * rng.f32(), 0.0, opacity, opacity];
                    let resolved = compositing.resolve(sums.map(f64::from));
                    let through = 1.0 - f64::from(opacity);
                    let expected: [f32; 4] = std::array::from_fn(|channel| {
                        (f64::from(pixel[channel]) + through * resolved[channel]) as f32
                    });
                    close(behind(compositing, pixel, sums), expected);
                }
            }
        });
    }

    #[test]
    fn composite_opacity_is_right_for_every_tau() {
        for step in 0..4000 {
            let tau = 1e-6 * 1.005_f32.powi(step);
            let [.., opacity] = resolved(Compositing::Extinction, [0.0, 0.0, 0.0, tau]);
            let exact = -(-f64::from(tau)).exp_m1();
            assert!((f64::from(opacity) / exact - 1.0).abs() < 3e-7, "{tau}: {opacity} {exact}");
        }
    }

    /// A faint volume in ever so many sheets is as opaque as in one.
    #[test]
    fn composite_extinction_keeps_faint_sheets() {
        let n_sheets = 100_000;
        let (whole, mut through) = (0.01_f32, 1.0_f64);
        let sheet = |tau: f32| resolved(Compositing::Extinction, [0.0, 0.0, 0.0, tau])[3];
        (0..n_sheets).for_each(|_| through *= 1.0 - f64::from(sheet(whole / n_sheets as f32)));
        assert!((1.0 - through - f64::from(sheet(whole))).abs() < 1e-8, "{through}");
    }

    /// Two thin sheets of one colour are one thick sheet.
    #[test]
    fn composite_extinction_is_additive() {
        for (front, back) in [(0.1_f32, 0.3_f32), (1e-4, 2e-3), (5e-4, 5e-4), (3.0, 0.01)] {
            let sums = |tau: f32| [0.7 * tau, 0.2 * tau, tau, tau];
            let near = resolved(Compositing::Extinction, sums(front));
            let joined = behind(Compositing::Extinction, near, sums(back));
            close(joined, resolved(Compositing::Extinction, sums(front + back)));
        }
    }
}
