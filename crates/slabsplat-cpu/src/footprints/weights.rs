//! The weights of a footprint on a row of pixels, as many at once as a vector has lanes.
//!
//! ```text
//! once for some columns:   dx = column − centre; if the ellipse is upright, across·dx²
//! once a row of them:      x = across·(dx + shear·dy)² + along·dy² − 1       (x is 2·(ρ/R)² − 1)
//!                          weight = p(x) where x < edge of the section's disc, else 0
//! p(x) = c₀ + c₁·x + … + c₇·x⁷  [ + c₈·x⁸ + c₉·x⁹ + c₁₀·x¹⁰ + c₁₁·chord ]
//! ```
//!
//! 1. `x` is what a pixel's position gives at once: there is no root, and no load that depends on the pixel.
//! 2. Of an upright ellipse the columns' part is squared once for all rows.
//! 3. Powers go up by pairs and fours (Estrin), so that multiply-adds need not wait for each other.
//! 4. What the bracket holds is skipped for voxels so faint that eight coefficients do.
//!
//! Where no polynomial is good enough, [`ByTable`] reads the table pixel by pixel, at some ten times the
//! cost.

use super::raster::PixelShape;
use fearless_simd::{Simd, SimdBase, SimdFloat, prelude::*};
use slabsplat_kernel::{CubicSectionTable, MAX_COEFFICIENTS, SectionTable};

/// Most lanes of a vector.
const MAX_LANES: usize = 16;

/// `0.5, 1.5, …`: the centres of pixels.
pub(super) const CENTERS: [f32; MAX_LANES] = {
    let mut centers = [0.0; MAX_LANES];
    let mut lane = 0;
    while lane < MAX_LANES {
        centers[lane] = lane as f32 + 0.5;
        lane += 1;
    }
    centers
};

/// A vector of weights, of 8 or 16 lanes.
pub(crate) trait Lanes<S: Simd>: SimdFloat<S> + SimdBase<S, Element = f32> {}

impl<S: Simd, V: SimdFloat<S> + SimdBase<S, Element = f32>> Lanes<S> for V {}

/// How a footprint weighs the pixels around it.
pub(crate) trait Weigh<S: Simd> {
    /// Prepares the columns from `left` on, which lies that many pixels right of the footprint's centre: what
    /// its rows share.
    fn columns<V: Lanes<S>>(&self, simd: S, shape: &PixelShape, left: f32) -> V;

    /// The weights of the pixels of a row `dy` pixels below the centre; 0 outside of the footprint.
    fn row<V: Lanes<S>>(&self, simd: S, shape: &PixelShape, columns: V, dy: f32) -> V;
}

/// A polynomial in `x = 2·(ρ/R)² − 1`, of `N` coefficients (8, or 12, of which the last is that of the
/// chord); `SHEARED` if the axes of its ellipse are not those of the image.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Polynomial<'a, const N: usize, const SHEARED: bool> {
    pub(crate) coefficients: &'a [f32; MAX_COEFFICIENTS],
    /// `x` at the edge of the section's disc.
    pub(crate) edge: f32,
    /// Units of chords from the voxel to the slab's faces.
    pub(crate) faces: [f32; 2],
}

impl<S: Simd, const N: usize, const SHEARED: bool> Weigh<S> for Polynomial<'_, N, SHEARED> {
    /// Pixels right of the centre if it is sheared, else what they add to `x`.
    #[inline(always)]
    fn columns<V: Lanes<S>>(&self, simd: S, shape: &PixelShape, left: f32) -> V {
        let dx = V::from_slice(simd, &CENTERS[..V::LEN]) + left;
        if SHEARED { dx } else { dx * dx * shape.across }
    }

    #[inline(always)]
    fn row<V: Lanes<S>>(&self, simd: S, shape: &PixelShape, columns: V, dy: f32) -> V {
        let from_row = shape.along * dy * dy - 1.0;
        let x = if SHEARED {
            let u = columns + shape.shear * dy;
            (u * shape.across).mul_add(u, V::splat(simd, from_row))
        } else {
            columns + from_row
        };
        let inside = x.simd_lt(V::splat(simd, self.edge));
        inside.select(self.at(simd, x), V::splat(simd, 0.0))
    }
}

impl<const N: usize, const SHEARED: bool> Polynomial<'_, N, SHEARED> {
    /// The polynomial at `x`, by Estrin's scheme: pairs, then fours, so that multiply-adds need not wait
    /// for each other as long as in Horner's.
    #[inline(always)]
    fn at<S: Simd, V: Lanes<S>>(&self, simd: S, x: V) -> V {
        let [powers @ .., of_chord] = self.coefficients;
        if N == 8 {
            let [low @ .., _, _, _] = powers;
            return eight(simd, low, x);
        }
        let polynomial = eleven(simd, powers, x);
        // Where the ray leaves the ball; inside of the section's disc it meets the slab before.
        let end = (V::splat(simd, 1.0) - x).max(V::splat(simd, 0.0)).sqrt();
        let [front, back] = self.faces.map(|face| V::splat(simd, face));
        let chord = end.min(back) - (-end).max(front);
        chord.mul_add(V::splat(simd, *of_chord), polynomial)
    }
}

/// `c₀ + c₁·x`.
#[inline(always)]
fn pair<S: Simd, V: Lanes<S>>(simd: S, [c0, c1]: [f32; 2], x: V) -> V {
    V::splat(simd, c1).mul_add(x, V::splat(simd, c0))
}

/// `c₀ + c₁·x + c₂·x² + c₃·x³`.
#[inline(always)]
fn four<S: Simd, V: Lanes<S>>(simd: S, [c0, c1, c2, c3]: [f32; 4], x: V, x2: V) -> V {
    pair(simd, [c2, c3], x).mul_add(x2, pair(simd, [c0, c1], x))
}

/// `c₀ + c₁·x + … + c₇·x⁷`.
#[inline(always)]
fn eight<S: Simd, V: Lanes<S>>(simd: S, coefficients: &[f32; 8], x: V) -> V {
    let [c0, c1, c2, c3, c4, c5, c6, c7] = *coefficients;
    let x2 = x * x;
    four(simd, [c4, c5, c6, c7], x, x2).mul_add(x2 * x2, four(simd, [c0, c1, c2, c3], x, x2))
}

/// The same `+ rest·x⁸`.
#[inline(always)]
fn eight_and<S: Simd, V: Lanes<S>>(simd: S, coefficients: &[f32; 8], rest: V, x: V) -> V {
    let [c0, c1, c2, c3, c4, c5, c6, c7] = *coefficients;
    let x2 = x * x;
    let x4 = x2 * x2;
    let high = rest.mul_add(x4, four(simd, [c4, c5, c6, c7], x, x2));
    high.mul_add(x4, four(simd, [c0, c1, c2, c3], x, x2))
}

/// `c₀ + c₁·x + … + c₈·x⁸`.
#[inline(always)]
pub(crate) fn nine<S: Simd, V: Lanes<S>>(simd: S, coefficients: &[f32; 9], x: V) -> V {
    let [low @ .., c8] = coefficients;
    eight_and(simd, low, V::splat(simd, *c8), x)
}

/// `c₀ + c₁·x + … + c₁₀·x¹⁰`.
#[inline(always)]
pub(crate) fn eleven<S: Simd, V: Lanes<S>>(simd: S, coefficients: &[f32; 11], x: V) -> V {
    let [low @ .., c8, c9, c10] = coefficients;
    let rest = V::splat(simd, *c10).mul_add(x * x, pair(simd, [*c8, *c9], x));
    eight_and(simd, low, rest, x)
}

/// Weights that are found for every pixel by itself.
pub(crate) trait WeighPixel {
    /// The weight of a pixel that far to the right of the centre, and below it.
    fn at(&self, shape: &PixelShape, dx: f32, dy: f32) -> f32;
}

/// Whatever weighs pixels weighs rows of them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PixelByPixel<W>(pub(crate) W);

impl<S: Simd, W: WeighPixel> Weigh<S> for PixelByPixel<W> {
    /// Pixels right of the centre.
    #[inline(always)]
    fn columns<V: Lanes<S>>(&self, simd: S, _: &PixelShape, left: f32) -> V {
        V::from_slice(simd, &CENTERS[..V::LEN]) + left
    }

    #[inline(always)]
    fn row<V: Lanes<S>>(&self, simd: S, shape: &PixelShape, columns: V, dy: f32) -> V {
        let mut weights = [0.0; MAX_LANES];
        for (weight, &dx) in weights.iter_mut().zip(columns.as_slice()) {
            *weight = self.0.at(shape, dx, dy);
        }
        V::from_slice(simd, &weights[..V::LEN])
    }
}

/// Sections that are read from the table: no polynomials may be good enough.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ByTable<'a> {
    pub(crate) table: &'a SectionTable,
    /// The kernel's radius in index units.
    pub(crate) radius: f32,
    /// Index units from the voxel to the slab's faces, on the ray through the footprint's centre.
    pub(crate) faces: [f32; 2],
    /// `x` at the edge of the section's disc; 1 if that differs from pixel to pixel.
    pub(crate) edge: f32,
}

impl WeighPixel for ByTable<'_> {
    #[inline(always)]
    fn at(&self, shape: &PixelShape, dx: f32, dy: f32) -> f32 {
        let u = dx + shape.shear * dy;
        let x = shape.across * u * u + shape.along * dy * dy - 1.0;
        if self.edge <= x {
            return 0.0;
        }
        let half_chord = self.radius * (0.5 * (1.0 - x)).sqrt();
        let later = shape.tilt[0] * dx + shape.tilt[1] * dy;
        let [front, back] = self.faces.map(|face| face + later);
        self.table.sample_at(half_chord * self.table.samples_per_index(), front, back)
    }
}

/// The same from a table that is read by cubics.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ByCubicTable<'a> {
    pub(crate) table: &'a CubicSectionTable,
    /// The kernel's radius in index units.
    pub(crate) radius: f32,
    /// Index units from the voxel to the slab's faces, on the ray through the footprint's centre.
    pub(crate) faces: [f32; 2],
}

impl WeighPixel for ByCubicTable<'_> {
    /// Out of line: it is called for a pixel at a time, and is no part of a loop over vectors.
    #[inline(never)]
    fn at(&self, shape: &PixelShape, dx: f32, dy: f32) -> f32 {
        let u = dx + shape.shear * dy;
        let form = 0.5 * (shape.across * u * u + shape.along * dy * dy);
        if 1.0 <= form {
            return 0.0;
        }
        let later = shape.tilt[0] * dx + shape.tilt[1] * dy;
        let rho_squared = self.radius * self.radius * form;
        self.table.weight(rho_squared, self.faces.map(|face| face + later))
    }
}
