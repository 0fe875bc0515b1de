//! Separable footprints, summed along rows last: rows of B-spline coefficients, and rows of pixels from them.
//!
//! Where footprints are `g(x)·g(y)`, the sum over voxels can be taken in two steps. A voxel adds its columns
//! `g(x)` to four rows of *coefficients*, with the weights of a cubic B-spline; when all of a slab are there,
//! every row of pixels is reconstructed from the rows of coefficients around it:
//!
//! ```text
//! Σᵢ cᵢ·g(x − xᵢ)·g(y − yᵢ)  ≈  Σₖ P(y, k) · Σᵢ cᵢ·g(x − xᵢ)·β³(yᵢ/s − k)
//! ```
//!
//! `P(y, ·)` are the coefficients of the cubic spline that interpolates `u ↦ g(y − s·u)` at all whole `u`
//! (Unser, "Splines: A Perfect Fit for Signal and Image Processing", IEEE Signal Processing Magazine 16(6),
//! 1999). So a voxel costs four rows, however high its footprint is, and the rest is paid once a slab. A
//! block of pixels has a whole number of rows of coefficients, so that all blocks of all tiles see them
//! alike; they are as far apart as the profile's width allows.

use crate::footprints::raster::PixelShape;
use crate::pixels::blocks::{BLOCK_SIDE, BLOCKS_ACROSS};
use crate::pixels::quad::Quad;
use crate::pixels::sheet::Sheet;
use crate::voxels::by_sheet::N_AT_ONCE;
use fearless_simd::{Simd, f32x8, f32x16, prelude::*, u32x8};
use slabsplat_kernel::SeparableSections;

/// Rows of coefficients to the radius of a kernel, at least.
const LEAST_PER_RADIUS: f64 = 4.5;

/// By how much of its peak a footprint is off at most for being a spline; in the mean, by next to nothing.
pub(crate) const WORST_ERROR: f64 = 4.6e-3;

/// Rows of coefficients to the radius, at most.
const MOST_PER_RADIUS: f64 = 12.0;

/// Most rows of coefficients to a block of four rows of pixels: footprints are then little more than two
/// pixels high, and a voxel still costs four rows.
const MOST_PER_BLOCK: usize = 16;

/// Rows of coefficients that count for a block, at most.
const MOST_TAPS: usize = 2 * (MOST_PER_RADIUS as usize + 1) + MOST_PER_BLOCK;

/// The rows of coefficients that a voxel adds to.
pub(crate) const N_TOUCHED: usize = 4;

/// What is summed of a sheet by separable footprints, and its pixels are yet to be reconstructed from; 0
/// between slabs.
#[derive(Debug, Default)]
pub(crate) struct Coefficients {
    pub(super) quads: Vec<Quad>,
    /// The columns of quads that were added to, a bit each.
    pub(super) touched: u64,
}

impl Coefficients {
    /// Makes sure that there are as many quads.
    pub(crate) fn grow(&mut self, n_quads: usize) {
        if self.quads.len() < n_quads {
            self.quads.resize(n_quads, Quad::ZERO);
        }
    }

    /// Rows of that many quads, and the columns that were added to, a bit each.
    #[inline(always)]
    pub(super) fn rows_mut<const WIDTH: usize>(&mut self) -> (&mut [[Quad; WIDTH]], &mut u64) {
        (self.quads.as_chunks_mut().0, &mut self.touched)
    }

    /// Empties them.
    #[inline(always)]
    pub(super) fn clear<const WIDTH: usize>(&mut self, n_rows: usize) {
        let (rows, touched) = self.rows_mut::<WIDTH>();
        let touched = std::mem::take(touched);
        for row in &mut rows[..n_rows] {
            for (column, quad) in row.iter_mut().enumerate() {
                if touched >> column & 1 == 1 {
                    *quad = Quad::ZERO;
                }
            }
        }
    }

    pub(crate) fn resident_bytes(&self) -> usize {
        self.quads.capacity() * size_of::<Quad>()
    }
}

/// How rows of pixels follow from rows of coefficients, for footprints of one size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RowSpline {
    /// Rows of coefficients to a block of four rows of pixels.
    per_block: usize,
    /// Rows of coefficients that a tile has.
    n_rows: usize,
    /// Rows of coefficients above the tile that may be touched.
    pub(crate) n_above: usize,
    /// The first row of coefficients that counts for the first block of a tile.
    first: usize,
    /// How much that one and the ones behind it count for each row of a block.
    taps: [[f32; BLOCK_SIDE]; MOST_TAPS],
    n_taps: usize,
}

impl RowSpline {
    /// `None` if footprints of that shape are too low or too high for it.
    pub(crate) fn new(shape: &PixelShape, sections: &SeparableSections) -> Option<Self> {
        let radius_in_blocks = f64::from(2.0 / shape.along).sqrt() / BLOCK_SIDE as f64;
        let per_block = ((LEAST_PER_RADIUS / radius_in_blocks).ceil() as usize).max(1);
        let radius = radius_in_blocks * per_block as f64;
        if MOST_PER_BLOCK < per_block || MOST_PER_RADIUS < radius || radius.is_nan() {
            return None;
        }
        let at = |row: usize| (row as f64 + 0.5) / BLOCK_SIDE as f64 * per_block as f64;
        let first = (at(0) - radius - 0.5).ceil();
        let last = (at(BLOCK_SIDE - 1) + radius + 0.5).floor();
        let mut taps = [[0.0; BLOCK_SIDE]; MOST_TAPS];
        for row in 0..BLOCK_SIDE {
            let of_row = taps_of(sections, radius, first - at(row));
            taps.iter_mut().zip(of_row).for_each(|(taps, tap)| taps[row] = tap);
        }
        let n_above = radius.ceil() as usize + 3;
        Some(Self {
            per_block,
            n_rows: per_block * BLOCKS_ACROSS + 2 * n_above,
            n_above,
            first: (n_above as f64 + first) as usize,
            taps,
            n_taps: (last - first) as usize + 1,
        })
    }

    /// Rows of coefficients to a row of pixels.
    pub(crate) fn per_pixel(&self) -> f32 {
        self.per_block as f32 / BLOCK_SIDE as f32
    }

    /// Rows of coefficients that a tile has.
    pub(crate) fn n_rows(&self) -> usize {
        self.n_rows
    }

    /// The first of the rows of coefficients that voxels add to, and how much of `factor` each of the rows
    /// takes: β³ at the four rows around a centre.
    #[inline(always)]
    pub(crate) fn touched<S: Simd>(
        &self,
        simd: S,
        center: f32x8<S>,
        factor: f32x8<S>,
    ) -> ([u32; N_AT_ONCE], [[f32; N_AT_ONCE]; N_TOUCHED]) {
        let one = f32x8::splat(simd, 1.0);
        // Centres lie within a radius of the tile, and so between the rows that there are.
        let at = center
            .mul_add(f32x8::splat(simd, self.per_pixel()), f32x8::splat(simd, self.n_above as f32));
        let last = f32x8::splat(simd, (self.n_rows() - N_TOUCHED + 1) as f32);
        let at = at.max(one).min(last);
        let whole = at.floor();
        let t = at - whole;
        let rest = one - t;
        let sixth = factor * (1.0 / 6.0);
        let (t3, rest3) = (t * t * t, rest * rest * rest);
        let first = sixth * rest3;
        let last = sixth * t3;
        // 4 − 6t² + 3t³ of sixths, and the rest of all.
        let second = (t * t).mul_add(
            f32x8::splat(simd, -6.0),
            t3.mul_add(f32x8::splat(simd, 3.0), f32x8::splat(simd, 4.0)),
        ) * sixth;
        let third = factor - first - second - last;
        let mut weights = [[0.0; N_AT_ONCE]; N_TOUCHED];
        for (weights, of_row) in weights.iter_mut().zip([first, second, third, last]) {
            of_row.store_slice(weights);
        }
        let first_row: u32x8<S> = (whole - one).to_int();
        (first_row.into(), weights)
    }

    /// Adds what the coefficients stand for to the touched pixels of their sheet, and empties them.
    #[inline(always)]
    pub(crate) fn reconstruct<S: Simd>(
        &self,
        simd: S,
        Sheet { sums, touched }: &mut Sheet,
        coefficients: &mut Coefficients,
    ) {
        let (all_rows, _) = coefficients.rows_mut::<BLOCKS_ACROSS>();
        for [column, row] in touched.iter() {
            let rows = &all_rows[self.first_row_of(row)..];
            let Some(pixels) = sums[row * BLOCK_SIDE..].first_chunk_mut::<BLOCK_SIDE>() else {
                continue;
            };
            let mut block = [f32x16::splat(simd, 0.0); BLOCK_SIDE];
            for (sum, pixels) in block.iter_mut().zip(pixels.iter()) {
                *sum = f32x16::from_slice(simd, &pixels[column].0);
            }
            for (taps, row) in self.taps().iter().zip(rows) {
                let coefficient = f32x16::from_slice(simd, &row[column].0);
                for (sum, tap) in block.iter_mut().zip(taps) {
                    *sum = coefficient.mul_add(f32x16::splat(simd, *tap), *sum);
                }
            }
            for (sum, pixels) in block.iter().zip(pixels) {
                sum.store_slice(&mut pixels[column].0);
            }
        }
        coefficients.clear::<BLOCKS_ACROSS>(self.n_rows());
    }

    /// The rows of coefficients that count for a row of blocks are those from this one on.
    #[inline(always)]
    pub(super) fn first_row_of(&self, row: usize) -> usize {
        row * self.per_block + self.first
    }

    /// How much these rows count for each row of pixels in the block.
    #[inline(always)]
    pub(super) fn taps(&self) -> &[[f32; BLOCK_SIDE]] {
        &self.taps[..self.n_taps]
    }
}

/// The coefficients of the cubic spline that interpolates the profile, from the one on that lies `first` rows
/// of coefficients behind a row of pixels; `radius` such rows are the kernel's radius.
fn taps_of(sections: &SeparableSections, radius: f64, first: f64) -> [f32; MOST_TAPS] {
    let sample = |tap: usize| sections.profile_at((first + tap as f64) / radius);
    let samples: [f64; MOST_TAPS] = std::array::from_fn(sample);
    // The samples of β³ are (z + 4 + z⁻¹)/6, whose inverse is √3·pole^|n|.
    let pole = 3.0_f64.sqrt() - 2.0;
    let mut sums = [0.0; MOST_TAPS];
    let mut before = 0.0;
    for (sum, sample) in sums.iter_mut().zip(samples) {
        before = sample + pole * before;
        *sum = before;
    }
    let mut behind = 0.0;
    for (sum, sample) in sums.iter_mut().zip(samples).rev() {
        *sum += behind;
        behind = pole * (sample + behind);
    }
    sums.map(|sum| (3.0_f64.sqrt() * sum) as f32)
}
