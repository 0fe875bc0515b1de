//! Separable footprints whose axes are not those of the image, in sheared columns.
//!
//! `g(√across·(X + lean·Y))·g(√along·Y)` is no product of a column and a row of pixels, but it is one of a
//! column of `u = X + lean·Y` and a row. So coefficients have columns of `u`, and a row of pixels reads those
//! that it crosses, which lie at one fraction of a column for the whole row:
//!
//! ```text
//! for each row of touched blocks:
//!     for each column of u that it crosses: rows of pixels from rows of coefficients (b_spline.rs)
//!     for each touched block, and each of its rows: sheet += Σⱼ β³(fraction − j)·columns[u + j]
//! ```
//!
//! Between columns the sums are those of a cubic B-spline, which spreads a footprint by its own variance, a
//! third of a squared pixel. Footprints are made narrower by as much, and so come out as wide as they should:
//! a Gaussian of 1.2 pixels or more is then off by some thousandths.

use super::b_spline::{Coefficients, RowSpline};
use crate::pixels::blocks::{BLOCK_SIDE, BLOCKS_ACROSS};
use crate::pixels::quad::{QUAD, Quad};
use crate::pixels::rectangle::TILE_SIDE;
use crate::pixels::sheet::Sheet;
use crate::pixels::tile::Tile;
use crate::sections::cut::bits;
use fearless_simd::{Simd, f32x16, prelude::*};

/// The variance of a cubic B-spline, in squared pixels.
pub(super) const VARIANCE: f32 = 1.0 / 3.0;

/// Footprints may be sheared by no more columns a row.
pub(super) const MOST_LEAN: f32 = 1.0;

/// Quads in a row of coefficients: those of a tile, as many as the shear moves its rows, and what the spline
/// needs beside.
pub(super) const WIDTH: usize = 2 * BLOCKS_ACROSS + 2;

/// Sheared columns on one tile.
#[derive(Clone, Copy, Debug)]
pub(super) struct Columns {
    lean: f64,
    /// Where the first column lies that there is room for, in pixels from the tile's left side at its upper
    /// edge. Columns of all tiles lie alike, and so do the splines between them.
    left: f64,
}

/// A row of pixels among the columns.
#[derive(Clone, Copy)]
struct Line {
    /// The quad of columns in which the first quad of pixels begins, and where in it.
    first_quad: usize,
    first: usize,
    /// How much of four columns that follow each other a pixel has.
    taps: [f32; 4],
}

impl Columns {
    pub(super) fn of(lean: f32, tile: &Tile) -> Self {
        let lean = f64::from(lean);
        let [x, y] = tile.origin.map(|pixel| pixel as f64);
        let half = 0.5 * TILE_SIDE as f64;
        let least = x + lean * (y + half) - half * lean.abs();
        // A spline has two columns before a pixel.
        Self { lean, left: x + lean * y - (least.floor() - 2.0) }
    }

    /// `u` of the tile's upper left corner, in columns.
    pub(super) fn left(&self) -> f32 {
        self.left as f32
    }

    fn line(&self, row: usize) -> Line {
        let place = self.left + self.lean * (row as f64 + 0.5);
        let start = place.floor() as usize - 1;
        let t = place.fract() as f32;
        let (t2, t3, rest) = (t * t, t * t * t, 1.0 - t);
        let first = rest * rest * rest / 6.0;
        let second = (4.0 - 6.0 * t2 + 3.0 * t3) / 6.0;
        let last = t3 / 6.0;
        Line {
            first_quad: start / QUAD,
            first: start % QUAD,
            taps: [first, second, 1.0 - first - second - last, last],
        }
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
        let mut rows_of_u = [[Quad::ZERO; WIDTH]; BLOCK_SIDE];
        for block_row in 0..BLOCKS_ACROSS {
            let columns = touched.row(block_row);
            if columns == 0 {
                continue;
            }
            let first_row = block_row * BLOCK_SIDE;
            let lines: [Line; BLOCK_SIDE] = std::array::from_fn(|row| self.line(first_row + row));
            let ends = [0, BLOCK_SIDE - 1].map(|row| lines[row].first_quad);
            let first = ends[0].min(ends[1]) + columns.trailing_zeros() as usize;
            let last = ends[0].max(ends[1]) + 2 + columns.ilog2() as usize;
            let rows = &all_rows[spline.first_row_of(block_row)..];
            rows_from_coefficients(simd, spline, rows, first..last + 1, &mut rows_of_u);
            for (row, line) in lines.iter().enumerate() {
                for column in bits(columns) {
                    let sum = line.sum(simd, &rows_of_u[row], column);
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
    onto: &mut [[Quad; WIDTH]; BLOCK_SIDE],
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
            sum.store_slice(&mut row[quad].0);
        }
    }
}

impl Line {
    /// Four pixels, from the columns around each.
    #[inline(always)]
    fn sum<S: Simd>(&self, simd: S, row: &[Quad; WIDTH], column: usize) -> f32x16<S> {
        let first = self.first_quad + column;
        let a = f32x16::from_slice(simd, &row[first].0);
        let b = f32x16::from_slice(simd, &row[first + 1].0);
        let c = f32x16::from_slice(simd, &row[first + 2].0);
        let columns = match self.first {
            0 => [a, next::<S, 1>(a, b), next::<S, 2>(a, b), next::<S, 3>(a, b)],
            1 => [next::<S, 1>(a, b), next::<S, 2>(a, b), next::<S, 3>(a, b), b],
            2 => [next::<S, 2>(a, b), next::<S, 3>(a, b), b, next::<S, 1>(b, c)],
            _ => [next::<S, 3>(a, b), b, next::<S, 1>(b, c), next::<S, 2>(b, c)],
        };
        let mut sum = f32x16::splat(simd, 0.0);
        for (column, tap) in columns.into_iter().zip(self.taps) {
            sum = column.mul_add(f32x16::splat(simd, tap), sum);
        }
        sum
    }
}

/// In every channel, the four pixels that begin `SHIFT` pixels behind those of `a`; `b` comes after.
#[inline(always)]
fn next<S: Simd, const SHIFT: usize>(a: f32x16<S>, b: f32x16<S>) -> f32x16<S> {
    a.slide_within_blocks::<SHIFT>(b)
}
