//! The inner loop: one footprint's weights over the pixels of a tile.
//!
//! ```text
//! for every 16 columns that the footprint's box meets, or 8 at its end, from a multiple of 4 on:
//!     for every row of the box:
//!         as many weights at once, 0 outside of the footprint (weights.rs)
//!         for every 4 of them that the box meets: sheet += weight·colour, 4 pixels at once
//! ```
//!
//! 1. Nothing in it depends on a pixel's position but the weights, so that processors guess every branch
//!    within a footprint.
//! 2. Columns are the outer loop, so that a vector of them is prepared once for all rows.
//! 3. Four pixels of a sheet are a cache line, which is loaded and stored as a whole (pixels/quad.rs).
//! 4. Which footprint lies where is prepared before, for eight at a time (sections/batch.rs), or each would
//!    have to wait for its own square root.

use super::raster::PixelShape;
use super::weights::{Lanes, Polynomial, Weigh};
use crate::pixels::quad::{QUAD, Quad};
use crate::pixels::rectangle::PixelBox;
use crate::pixels::sheet::Sheet;
use fearless_simd::{Simd, f32x8, f32x16, prelude::*};
use slabsplat_kernel::MAX_COEFFICIENTS;

/// A footprint that is about to be splatted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Footprint {
    /// Its centre, in pixels from the tile's upper left corner.
    pub(crate) center: [f32; 2],
    /// The pixels that it may touch.
    pub(crate) pixels: PixelBox,
    /// What a sheet sums, at weight 1.
    pub(crate) color: [f32; 4],
}

/// Adds a footprint to a sheet.
#[inline(always)]
pub(crate) fn splat<S: Simd>(
    simd: S,
    sheet: &mut Sheet,
    shape: &PixelShape,
    footprint: &Footprint,
    weigh: &impl Weigh<S>,
) {
    let first = usize::from(footprint.pixels.min[0]) / QUAD;
    let end = usize::from(footprint.pixels.end[0]).div_ceil(QUAD);
    let mut quad = first;
    while quad + 4 <= end {
        add_columns::<S, f32x16<S>, 4>(simd, sheet, shape, footprint, weigh, quad);
        quad += 4;
    }
    match end.saturating_sub(quad) {
        3 => add_columns::<S, f32x16<S>, 3>(simd, sheet, shape, footprint, weigh, quad),
        2 => add_columns::<S, f32x8<S>, 2>(simd, sheet, shape, footprint, weigh, quad),
        1 => add_columns::<S, f32x8<S>, 1>(simd, sheet, shape, footprint, weigh, quad),
        _ => {}
    }
}

/// The same as a function of its own, for weights that take longer than a call.
#[inline(never)]
pub(crate) fn splat_outlined<S: Simd>(
    simd: S,
    sheet: &mut Sheet,
    shape: &PixelShape,
    footprint: &Footprint,
    weigh: &impl Weigh<S>,
) {
    simd.vectorize(
        #[inline(always)]
        || splat(simd, sheet, shape, footprint, weigh),
    );
}

/// A polynomial in `x`, before it is known how much of one it takes.
#[derive(Clone, Copy)]
pub(crate) struct AnyPolynomial<'a> {
    pub(crate) coefficients: &'a [f32; MAX_COEFFICIENTS],
    /// `x` at the edge of the section's disc.
    pub(crate) edge: f32,
    /// Units of chords from the voxel to the slab's faces.
    pub(crate) faces: [f32; 2],
}

impl<'a> AnyPolynomial<'a> {
    /// That of a whole footprint.
    pub(crate) fn whole(coefficients: &'a [f32; MAX_COEFFICIENTS]) -> Self {
        Self { coefficients, edge: 1.0, faces: [f32::NEG_INFINITY, f32::INFINITY] }
    }

    /// Adds a footprint to a sheet, weighted by a polynomial of as low a degree as does.
    ///
    /// Inlined where registers are wide and calls would cost the most; a sheared footprint is rare. All loops
    /// of all instruction sets in every place would take minutes to compile.
    #[inline(always)]
    pub(crate) fn splat<S: Simd>(
        self,
        simd: S,
        sheet: &mut Sheet,
        shape: &PixelShape,
        footprint: &Footprint,
        is_sheared: bool,
    ) {
        if const { S::f32s::LEN < 8 } || is_sheared {
            self.splat_outlined(simd, sheet, shape, footprint, is_sheared);
        } else {
            splat_by_degree::<S, false>(simd, sheet, shape, footprint, self);
        }
    }

    /// The same as a function of its own.
    #[inline(never)]
    pub(crate) fn splat_outlined<S: Simd>(
        self,
        simd: S,
        sheet: &mut Sheet,
        shape: &PixelShape,
        footprint: &Footprint,
        is_sheared: bool,
    ) {
        simd.vectorize(
            #[inline(always)]
            || match is_sheared {
                false => splat_by_degree::<S, false>(simd, sheet, shape, footprint, self),
                true => splat_by_degree::<S, true>(simd, sheet, shape, footprint, self),
            },
        );
    }
}

#[inline(always)]
fn splat_by_degree<S: Simd, const SHEARED: bool>(
    simd: S,
    sheet: &mut Sheet,
    shape: &PixelShape,
    footprint: &Footprint,
    AnyPolynomial { coefficients, edge, faces }: AnyPolynomial<'_>,
) {
    // Mostly easy to guess: neighbours are about as opaque.
    let is_low_degree = coefficients[8..] == [0.0; 4];
    macro_rules! splat_as {
        ($n:literal) => {{
            let weigh = Polynomial::<$n, SHEARED> { coefficients, edge, faces };
            splat(simd, sheet, shape, footprint, &weigh);
        }};
    }
    if is_low_degree { splat_as!(8) } else { splat_as!(12) }
}

/// Adds the columns of some quads: as many as a vector has pixels, or fewer.
#[inline(always)]
fn add_columns<S: Simd, V: Lanes<S>, const N_QUADS: usize>(
    simd: S,
    sheet: &mut Sheet,
    shape: &PixelShape,
    footprint: &Footprint,
    weigh: &impl Weigh<S>,
    first_quad: usize,
) {
    let color = f32x16::from_slice(simd, &Quad::of(footprint.color).0);
    let [first_row, end_row] = [footprint.pixels.min[1], footprint.pixels.end[1]].map(usize::from);
    let left = (first_quad * QUAD) as f32 - footprint.center[0];
    let columns: V = weigh.columns(simd, shape, left);
    let mut dy = first_row as f32 + 0.5 - footprint.center[1];
    for row in sheet.rows_mut(first_row..end_row) {
        let weights = weigh.row(simd, shape, columns, dy);
        dy += 1.0;
        let weights = weights.as_slice().as_chunks::<QUAD>().0;
        let Some(quads) = row[first_quad..].first_chunk_mut::<N_QUADS>() else { continue };
        for (quad, weights) in quads.iter_mut().zip(weights) {
            quad.add_weighted(simd, *weights, color);
        }
    }
}
