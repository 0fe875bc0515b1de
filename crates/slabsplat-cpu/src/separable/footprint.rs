//! A section that is a function of the column times the same one of the row, splatted onto the coefficients
//! of a B-spline (`b_spline.rs`).
//!
//! It takes four rows of as many columns as the footprint has, whatever its height. That the first window of
//! columns has always the same width, with zeros where the footprint ends, saves a branch that nobody can
//! guess.

use super::b_spline::N_TOUCHED;
use crate::footprints::raster::PixelShape;
use crate::footprints::weights::Weigh;
use crate::pixels::quad::{QUAD, Quad};
use fearless_simd::{Simd, f32x16, prelude::*};

/// A voxel's section that is separable.
#[derive(Clone, Copy, Debug)]
pub(super) struct SeparableFootprint {
    /// The column of its centre, in pixels from the tile's left side.
    pub(super) center: f32,
    /// Columns of pixels that it may touch.
    pub(super) columns: [u8; 2],
    /// The first row of coefficients.
    pub(super) first_row: usize,
    /// How much of it each row of coefficients takes.
    pub(super) weights: [f32; N_TOUCHED],
    /// What a sheet sums.
    pub(super) color: [f32; 4],
}

impl SeparableFootprint {
    /// Adds it to the coefficients of a sheet; `WINDOW` quads at once, of the four that a vector of weights
    /// has.
    #[inline(always)]
    pub(super) fn add_to<S: Simd, const WINDOW: usize, const WIDTH: usize>(
        &self,
        simd: S,
        (rows, touched): (&mut [[Quad; WIDTH]], &mut u64),
        shape: &PixelShape,
        profile: &impl Weigh<S>,
    ) {
        let [first, end] = self.columns.map(usize::from);
        let (first, end) = (first / QUAD, end.div_ceil(QUAD));
        // Most footprints are no wider than the window; further left it is 0, and so nothing is lost.
        let mut quad = first.min(WIDTH - WINDOW);
        *touched |= (1_u64 << end.max(quad + WINDOW)) - (1 << quad);
        let rows = rows[self.first_row..].first_chunk_mut::<N_TOUCHED>();
        let Some(rows) = rows else { return };
        self.add_columns::<S, WINDOW, WIDTH>(simd, rows, shape, profile, quad);
        quad += WINDOW;
        while quad < end {
            self.add_columns::<S, 1, WIDTH>(simd, rows, shape, profile, quad);
            quad += 1;
        }
    }

    #[inline(always)]
    fn add_columns<S: Simd, const N_QUADS: usize, const WIDTH: usize>(
        &self,
        simd: S,
        rows: &mut [[Quad; WIDTH]; N_TOUCHED],
        shape: &PixelShape,
        profile: &impl Weigh<S>,
        first_quad: usize,
    ) {
        let color = f32x16::from_slice(simd, &Quad::of(self.color).0);
        let left = (first_quad * QUAD) as f32 - self.center;
        let columns: f32x16<S> = profile.columns(simd, shape, left);
        let weights = profile.row(simd, shape, columns, 0.0);
        let weights = weights.as_slice().as_chunks::<QUAD>().0;
        let quad = |quad: usize| f32x16::block_splat(weights[quad].simd_into(simd)) * color;
        let quads: [f32x16<S>; N_QUADS] = std::array::from_fn(quad);
        for (row, weight) in rows.iter_mut().zip(self.weights) {
            let Some(row) = row[first_quad..].first_chunk_mut::<N_QUADS>() else { continue };
            for (coefficients, quad) in row.iter_mut().zip(&quads) {
                let sum = quad.mul_add(
                    f32x16::splat(simd, weight),
                    f32x16::from_slice(simd, &coefficients.0),
                );
                sum.store_slice(&mut coefficients.0);
            }
        }
    }
}
