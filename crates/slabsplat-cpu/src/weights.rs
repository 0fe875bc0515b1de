//! The weights of a footprint on a row of pixels, eight at a time.

use crate::raster::PixelShape;
use fearless_simd::{Simd, f32x8, prelude::*};
use slabsplat_kernel::{MAX_COEFFICIENTS, SectionTable};

/// Pixels whose weights are found at once.
pub(crate) const LANES: usize = 8;

/// `0.5, 1.5, …`: the centres of pixels.
const CENTERS: [f32; LANES] = {
    let mut centers = [0.0; LANES];
    let mut lane = 0;
    while lane < LANES {
        centers[lane] = lane as f32 + 0.5;
        lane += 1;
    }
    centers
};

/// How a footprint weighs the pixels around it.
pub(crate) trait Weigh<S: Simd> {
    /// What the rows of a footprint share, for pixels from `left` on, which lies that many pixels right of
    /// its centre.
    type Columns: Copy;

    /// Prepares the columns from `left` to `left + 8`.
    fn columns(&self, simd: S, shape: &PixelShape, left: f32) -> Self::Columns;

    /// The weights of the pixels of a row `dy` pixels below the centre; 0 outside of the footprint.
    fn row(&self, simd: S, shape: &PixelShape, columns: Self::Columns, dy: f32) -> [f32; LANES];
}

/// A polynomial in `x = 2·(ρ/R)² − 1`, of `N` coefficients; `LEANS` if the axes of its ellipse are not those of the
/// image.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Polynomial<'a, const N: usize, const LEANS: bool> {
    pub(crate) coefficients: &'a [f32; MAX_COEFFICIENTS],
    /// `x` at the edge of the section's disc.
    pub(crate) edge: f32,
}

impl<S: Simd, const N: usize, const LEANS: bool> Weigh<S> for Polynomial<'_, N, LEANS> {
    /// Pixels right of the centre if it leans, else what they add to `x`.
    type Columns = f32x8<S>;

    #[inline(always)]
    fn columns(&self, simd: S, shape: &PixelShape, left: f32) -> f32x8<S> {
        let dx = f32x8::from_slice(simd, &CENTERS) + left;
        if LEANS { dx } else { dx * dx * shape.across }
    }

    #[inline(always)]
    fn row(&self, simd: S, shape: &PixelShape, columns: f32x8<S>, dy: f32) -> [f32; LANES] {
        let from_row = shape.along * dy * dy - 1.0;
        let x = if LEANS {
            let u = columns + shape.lean * dy;
            (u * shape.across).mul_add(u, f32x8::splat(simd, from_row))
        } else {
            columns + from_row
        };
        let inside = x.simd_lt(f32x8::splat(simd, self.edge));
        let weights = inside.select(self.at(simd, x), f32x8::splat(simd, 0.0));
        let mut row = [0.0; LANES];
        weights.store_slice(&mut row);
        row
    }
}

impl<const N: usize, const LEANS: bool> Polynomial<'_, N, LEANS> {
    /// The polynomial at `x`, by Estrin's scheme: pairs, then fours, so that multiply-adds need not wait
    /// for each other as long as in Horner's.
    #[inline(always)]
    fn at<S: Simd>(&self, simd: S, x: f32x8<S>) -> f32x8<S> {
        let coefficient = |k: usize| f32x8::splat(simd, self.coefficients[k]);
        let pair = |k: usize| coefficient(k + 1).mul_add(x, coefficient(k));
        let x2 = x * x;
        let four = |k: usize| pair(k + 2).mul_add(x2, pair(k));
        let x4 = x2 * x2;
        if N == 8 {
            four(4).mul_add(x4, four(0))
        } else {
            four(8).mul_add(x4, four(4)).mul_add(x4, four(0))
        }
    }
}

/// Sections whose slab faces cut a footprint's rays at different offsets: every pixel reads rows of its own from
/// the table.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tilted<'a> {
    pub(crate) table: &'a SectionTable,
    /// The kernel's radius in index units.
    pub(crate) radius: f32,
    /// Index units from the voxel to the slab's faces, on the ray through the footprint's centre.
    pub(crate) faces: [f32; 2],
}

impl<S: Simd> Weigh<S> for Tilted<'_> {
    type Columns = f32;

    #[inline(always)]
    fn columns(&self, _: S, _: &PixelShape, left: f32) -> f32 {
        left
    }

    #[inline(always)]
    fn row(&self, _: S, shape: &PixelShape, left: f32, dy: f32) -> [f32; LANES] {
        let [front, back] = self.faces;
        CENTERS.map(|center| {
            let dx = left + center;
            let u = dx + shape.lean * dy;
            // x is −1 at the centre and 1 at the kernel's edge.
            let outside = 1.0 - (shape.across * u * u + shape.along * dy * dy - 1.0);
            if outside <= 0.0 {
                return 0.0;
            }
            let half_chord = self.radius * (0.5 * outside).sqrt();
            let later = shape.tilt[0] * dx + shape.tilt[1] * dy;
            self.table.sample_at(
                half_chord * self.table.samples_per_index(),
                front + later,
                back + later,
            )
        })
    }
}
