//! Separable footprints whose axes are not those of the image, in sheared columns.
//!
//! `g(√across·(X + shear·Y))·g(√along·Y)` is no product of a column and a row of pixels, but it is one of a
//! column of `u = X + shear·Y` and a row. So coefficients have columns of `u`, one to a pixel, or two where
//! footprints are small, and a row of pixels reads those that it crosses, which lie at one fraction of a
//! column for the whole row:
//!
//! ```text
//! for each row of touched blocks:
//!     for each column of u that it crosses: rows of pixels from rows of coefficients (b_spline.rs)
//!     for each touched block, and each of its rows: sheet += Σⱼ β³(fraction − j)·columns[u + j]
//! ```
//!
//! Between columns the sums are those of a cubic B-spline, which spreads a footprint by its own variance, a
//! third of a squared column. Footprints are made narrower by as much, and so come out as wide as they
//! should: a Gaussian of 1.2 columns or more is then off by some thousandths.

use super::b_spline::{Coefficients, RowSpline};
use crate::footprints::weights::Lanes;
use crate::pixels::blocks::{BLOCK_SIDE, BLOCKS_ACROSS};
use crate::pixels::quad::{QUAD, Quad};
use crate::pixels::rectangle::TILE_SIDE;
use crate::pixels::sheet::Sheet;
use crate::pixels::tile::Tile;
use crate::sections::cut::bits;
use fearless_simd::{Simd, f32x4, f32x8, f32x16, prelude::*};

/// The variance of a cubic B-spline, in squared columns.
pub(super) const VARIANCE: f32 = 1.0 / 3.0;

/// Footprints may be sheared by no more pixels a row.
pub(super) const MOST_SHEAR: f32 = 1.0;

/// Columns to a pixel, at most.
pub(super) const MOST_PER_PIXEL: usize = 2;

/// Quads in a row of coefficients: those of a tile, as many as the shear moves its rows, and what the spline
/// needs beside.
pub(super) const WIDTH: usize = MOST_PER_PIXEL * (2 * BLOCKS_ACROSS + 2);

/// Sheared columns on one tile.
#[derive(Clone, Copy, Debug)]
pub(super) struct Columns {
    shear: f64,
    per_pixel: usize,
    /// Where the first column lies that there is room for, in columns from the tile's left side at its upper
    /// edge. Columns of all tiles lie alike, and so do the splines between them.
    left: f64,
}

/// A row of pixels among the columns.
#[derive(Clone, Copy)]
struct Line {
    /// The first column that counts for the first pixel.
    first: usize,
    /// How much of four columns that follow each other a pixel has.
    taps: [f32; 4],
}

/// Rows of pixels, still in columns of `u`, channel by channel: a pixel's columns begin anywhere.
type RowsOfU = [Row; BLOCK_SIDE];

type Row = [[f32; WIDTH * QUAD]; N_CHANNELS];

const N_CHANNELS: usize = 4;

impl Columns {
    pub(super) fn of(shear: f32, per_pixel: usize, tile: &Tile) -> Self {
        let shear = f64::from(shear);
        let [x, y] = tile.origin.map(|pixel| pixel as f64);
        let half = 0.5 * TILE_SIDE as f64;
        let least = per_pixel as f64 * (x + shear * (y + half) - half * shear.abs());
        // A spline has two columns before a pixel.
        let left = per_pixel as f64 * (x + shear * y) - (least.floor() - 2.0);
        Self { shear, per_pixel, left }
    }

    /// `u`, in columns, of points in pixels from the tile's upper left corner.
    #[inline(always)]
    pub(super) fn of_pixels<S: Simd>(&self, simd: S, [x, y]: [f32x8<S>; 2]) -> f32x8<S> {
        let in_pixels = y.mul_add(f32x8::splat(simd, self.shear as f32), x);
        let left = f32x8::splat(simd, self.left as f32);
        in_pixels.mul_add(f32x8::splat(simd, self.per_pixel as f32), left)
    }

    fn line(&self, row: usize) -> Line {
        let per_pixel = self.per_pixel as f64;
        // Columns lie in the middle of their parts of a pixel, as pixels lie in the middle of themselves.
        let first_column = 0.5 * (per_pixel - 1.0);
        let position = self.left + per_pixel * self.shear * (row as f64 + 0.5) + first_column;
        // A spline has a column before the position that it is for.
        let before = position.floor() as usize - 1;
        let t = position.fract() as f32;
        let (t2, t3, rest) = (t * t, t * t * t, 1.0 - t);
        let first = rest * rest * rest / 6.0;
        let second = (4.0 - 6.0 * t2 + 3.0 * t3) / 6.0;
        let last = t3 / 6.0;
        Line { first: before, taps: [first, second, 1.0 - first - second - last, last] }
    }

    /// Adds what the coefficients stand for to the touched pixels of their sheet, and empties them. A
    /// function of its own, as it is called once a slab and takes long to compile.
    #[inline(never)]
    pub(super) fn reconstruct<S: Simd>(
        &self,
        simd: S,
        spline: &RowSpline,
        sheet: &mut Sheet,
        coefficients: &mut Coefficients,
    ) {
        simd.vectorize(
            #[inline(always)]
            || self.reconstruct_inlined(simd, spline, sheet, coefficients),
        );
    }

    #[inline(always)]
    fn reconstruct_inlined<S: Simd>(
        &self,
        simd: S,
        spline: &RowSpline,
        Sheet { sums, touched }: &mut Sheet,
        coefficients: &mut Coefficients,
    ) {
        let (all_rows, _) = coefficients.rows_mut::<WIDTH>();
        let mut rows_of_u: RowsOfU = [[[0.0; WIDTH * QUAD]; N_CHANNELS]; BLOCK_SIDE];
        for block_row in 0..BLOCKS_ACROSS {
            let columns = touched.row(block_row);
            if columns == 0 {
                continue;
            }
            let first_row = block_row * BLOCK_SIDE;
            let lines: [Line; BLOCK_SIDE] = std::array::from_fn(|row| self.line(first_row + row));
            let ends = [0, BLOCK_SIDE - 1].map(|row| lines[row].first);
            let per_block = BLOCK_SIDE * self.per_pixel;
            let first = ends[0].min(ends[1]) + per_block * columns.trailing_zeros() as usize;
            let end = ends[0].max(ends[1]) + per_block * (columns.ilog2() as usize + 1) + 3;
            let quads = first / QUAD..end.div_ceil(QUAD);
            let rows = &all_rows[spline.first_row_of(block_row)..];
            rows_from_coefficients(simd, spline, rows, quads, &mut rows_of_u);
            for (row, line) in lines.iter().enumerate() {
                for column in bits(columns) {
                    let first = line.first + per_block * column;
                    let sum = match self.per_pixel {
                        1 => line.sum(simd, &rows_of_u[row], first),
                        _ => line.sum_of_every_other(simd, &rows_of_u[row], first),
                    };
                    let pixels = &mut sums[first_row + row][column].0;
                    (f32x16::from_slice(simd, pixels) + sum).store_slice(pixels);
                }
            }
        }
        coefficients.clear::<WIDTH>(spline.n_rows());
    }
}

/// Rows of pixels, still in columns of `u`.
#[inline(always)]
fn rows_from_coefficients<S: Simd>(
    simd: S,
    spline: &RowSpline,
    rows: &[[Quad; WIDTH]],
    quads: std::ops::Range<usize>,
    onto: &mut RowsOfU,
) {
    for quad in quads {
        let mut block = [f32x16::splat(simd, 0.0); BLOCK_SIDE];
        for (taps, row) in spline.taps().iter().zip(rows) {
            let coefficient = f32x16::from_slice(simd, &row[quad].0);
            for (sum, tap) in block.iter_mut().zip(taps) {
                *sum = coefficient.mul_add(f32x16::splat(simd, *tap), *sum);
            }
        }
        for (sum, row) in block.iter().zip(onto.iter_mut()) {
            let sum = sum.as_slice().as_chunks::<QUAD>().0;
            for (channel, sum) in row.iter_mut().zip(sum) {
                channel[quad * QUAD..][..QUAD].copy_from_slice(sum);
            }
        }
    }
}

impl Line {
    /// Four pixels of which the first one's columns begin at `first`.
    #[inline(always)]
    fn sum<S: Simd>(&self, simd: S, [a, b, c, d]: &Row, first: usize) -> f32x16<S> {
        let [a, b]: [f32x4<S>; 2] = [self.blend(simd, a, first), self.blend(simd, b, first)];
        in_quad([a, b, self.blend(simd, c, first), self.blend(simd, d, first)])
    }

    /// The same of two columns each.
    #[inline(always)]
    fn sum_of_every_other<S: Simd>(&self, simd: S, [a, b, c, d]: &Row, first: usize) -> f32x16<S> {
        let [a, b] = [self.blend(simd, a, first), self.blend(simd, b, first)];
        let [c, d] = [self.blend(simd, c, first), self.blend(simd, d, first)];
        in_quad([
            every_other(simd, a),
            every_other(simd, b),
            every_other(simd, c),
            every_other(simd, d),
        ])
    }

    /// What lies at this fraction of a column between columns, from `first` on.
    #[inline(always)]
    fn blend<S: Simd, V: Lanes<S>>(
        &self,
        simd: S,
        columns: &[f32; WIDTH * QUAD],
        first: usize,
    ) -> V {
        let mut sum = V::splat(simd, 0.0);
        for (idx, tap) in self.taps.into_iter().enumerate() {
            let columns = V::from_slice(simd, &columns[first + idx..][..V::LEN]);
            sum = columns.mul_add(V::splat(simd, tap), sum);
        }
        sum
    }
}

#[inline(always)]
fn every_other<S: Simd>(simd: S, columns: f32x8<S>) -> f32x4<S> {
    let [a, _, b, _, c, _, d, _]: [f32; 8] = columns.into();
    [a, b, c, d].simd_into(simd)
}

/// Four channels of four pixels.
#[inline(always)]
fn in_quad<S: Simd>([a, b, c, d]: [f32x4<S>; N_CHANNELS]) -> f32x16<S> {
    a.combine(b).combine(c.combine(d))
}
