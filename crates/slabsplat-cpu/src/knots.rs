//! Footprints that are products, summed along rows last.
//!
//! Where a footprint is `g(x)·g(y)`, the sum over voxels may be taken in two steps. A voxel adds its columns `g(x)` to four
//! rows of *knots*, with the weights of a cubic B-spline; when a slab is done, every row of pixels is gathered
//! from the knots around it:
//!
//! ```text
//! Σᵢ cᵢ·g(x − xᵢ)·g(y − yᵢ)  ≈  Σₖ P(y, k) · Σᵢ cᵢ·g(x − xᵢ)·β³(yᵢ/s − k)
//! ```
//!
//! `P(y, ·)` are the coefficients of the spline that interpolates `u ↦ g(y − s·u)` at all whole `u` (Unser,
//! "Splines: a perfect fit for signal and image processing", 1999, eq. 8). So a voxel costs four rows, however many its footprint has, and the rest is paid
//! once a slab, not once a voxel. Knots are a whole number to four rows of pixels, so that all blocks of all tiles see them
//! alike, and as far apart as the profile's width allows.

use crate::blocks::{BLOCK_SIDE, BLOCKS_ACROSS};
use crate::by_sheet::N_AT_ONCE;
use crate::quad::{QUAD, Quad};
use crate::raster::PixelShape;
use crate::sheet::{Row, Sheet};
use crate::tile::TILE_SIDE;
use crate::weights::Weigh;
use fearless_simd::{Simd, f32x8, f32x16, prelude::*, u32x8};
use slabsplat_kernel::SectionProducts;

/// Knots to the radius of a kernel, at least.
const LEAST_PER_RADIUS: f64 = 4.5;

/// By how much of its peak a product is off at most for being a spline; in the mean, by next to nothing.
pub(crate) const WORST_ERROR: f64 = 4.5e-3;

/// Knots to the radius, at most.
const MOST_PER_RADIUS: f64 = 12.0;

/// Most knots to a block of four rows. With more, footprints are so few rows high that nothing is gained.
const MOST_PER_BLOCK: usize = 5;

/// Knots that count for a block, at most.
const MOST_TAPS: usize = 2 * (MOST_PER_RADIUS as usize + 1) + MOST_PER_BLOCK;

/// Quads that are splatted at once: a vector of weights.
const WINDOW: usize = 4;

/// The knots that a voxel adds to.
pub(crate) const N_TOUCHED: usize = 4;

/// How rows of pixels follow from rows of knots, for footprints of one size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RowSpline {
    /// Knots to a block of four rows of pixels.
    per_block: usize,
    /// Knots above the tile that may be touched.
    pub(crate) n_above: usize,
    /// The first knot that counts for the first block of a tile.
    first: usize,
    /// How much that one and the ones behind it count for each row of a block.
    taps: [[f32; BLOCK_SIDE]; MOST_TAPS],
    n_taps: usize,
}

impl RowSpline {
    /// `None` if footprints of that shape are too low or too high for it.
    pub(crate) fn new(shape: &PixelShape, products: &SectionProducts) -> Option<Self> {
        let radius_in_blocks = f64::from(2.0 / shape.along).sqrt() / BLOCK_SIDE as f64;
        let per_block = ((LEAST_PER_RADIUS / radius_in_blocks).ceil() as usize).max(1);
        let radius = radius_in_blocks * per_block as f64;
        if MOST_PER_BLOCK < per_block || !(radius <= MOST_PER_RADIUS) {
            return None;
        }
        let at = |row: usize| (row as f64 + 0.5) / BLOCK_SIDE as f64 * per_block as f64;
        let first = (at(0) - radius - 0.5).ceil();
        let last = (at(BLOCK_SIDE - 1) + radius + 0.5).floor();
        let mut taps = [[0.0; BLOCK_SIDE]; MOST_TAPS];
        for row in 0..BLOCK_SIDE {
            let of_row = coefficients(products, radius, first - at(row));
            taps.iter_mut().zip(of_row).for_each(|(taps, tap)| taps[row] = tap);
        }
        let n_above = radius.ceil() as usize + 3;
        Some(Self {
            per_block,
            n_above,
            first: (n_above as f64 + first) as usize,
            taps,
            n_taps: (last - first) as usize + 1,
        })
    }

    /// Knots to a row of pixels.
    pub(crate) fn per_pixel(&self) -> f32 {
        self.per_block as f32 / BLOCK_SIDE as f32
    }

    /// Rows of knots that a tile has.
    pub(crate) fn n_rows(&self) -> usize {
        self.per_block * BLOCKS_ACROSS + 2 * self.n_above
    }

    /// The first of the rows of knots that voxels add to, and how much of `factor` each of the rows takes: β³ at the
    /// four knots around a centre.
    #[inline(always)]
    pub(crate) fn touched<S: Simd>(
        &self,
        simd: S,
        center: f32x8<S>,
        factor: f32x8<S>,
    ) -> ([u32; N_AT_ONCE], [[f32; N_AT_ONCE]; N_TOUCHED]) {
        let one = f32x8::splat(simd, 1.0);
        // Centres lie within a radius of the tile, and so between the knots that there are.
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

    /// Adds what the knots of a sheet hold to its touched pixels, and empties them.
    #[inline(always)]
    pub(crate) fn gather<S: Simd>(&self, simd: S, sheet: &mut Sheet) {
        let Sheet { sums, touched, knots } = sheet;
        for [column, row] in touched.iter() {
            let knots = &knots[row * self.per_block + self.first..];
            let Some(pixels) = sums[row * BLOCK_SIDE..].first_chunk_mut::<BLOCK_SIDE>() else {
                continue;
            };
            let mut block = [f32x16::splat(simd, 0.0); BLOCK_SIDE];
            for (sum, pixels) in block.iter_mut().zip(pixels.iter()) {
                *sum = f32x16::from_slice(simd, &pixels[column].0);
            }
            for (taps, knots) in self.taps[..self.n_taps].iter().zip(knots) {
                let knot = f32x16::from_slice(simd, &knots[column].0);
                for (sum, tap) in block.iter_mut().zip(taps) {
                    *sum = knot.mul_add(f32x16::splat(simd, *tap), *sum);
                }
            }
            for (sum, pixels) in block.iter().zip(pixels) {
                sum.store_slice(&mut pixels[column].0);
            }
        }
        let columns = (0..BLOCKS_ACROSS).fold(0, |columns, row| columns | touched.row(row));
        for row in &mut knots[..self.n_rows()] {
            for (column, quad) in row.iter_mut().enumerate() {
                if columns >> column & 1 == 1 {
                    *quad = Quad::ZERO;
                }
            }
        }
    }
}

/// The coefficients of the cubic spline that interpolates the profile between knots, from the one on that lies `first` knots
/// behind a row of pixels; `radius` knots are the kernel's radius.
fn coefficients(products: &SectionProducts, radius: f64, first: f64) -> [f32; MOST_TAPS] {
    let sample = |tap: usize| products.profile_at((first + tap as f64) / radius);
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

/// A voxel's section that is a product.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Product {
    /// The column of its centre, in pixels from the tile's left side.
    pub(crate) center: f32,
    /// Columns of pixels that it may touch.
    pub(crate) columns: [u8; 2],
    /// The first row of knots.
    pub(crate) first_row: usize,
    /// How much of it each row of knots takes.
    pub(crate) weights: [f32; N_TOUCHED],
    /// What a sheet sums.
    pub(crate) color: [f32; 4],
}

impl Product {
    /// Adds it to the knots of a sheet.
    #[inline(always)]
    pub(crate) fn splat<S: Simd>(
        &self,
        simd: S,
        knots: &mut [Row],
        shape: &PixelShape,
        profile: &impl Weigh<S>,
    ) {
        let Some(rows) = knots[self.first_row..].first_chunk_mut::<N_TOUCHED>() else { return };
        let [first, end] = self.columns.map(usize::from);
        let (first, end) = (first / QUAD, end.div_ceil(QUAD));
        // Footprints are hardly ever wider than this; further left it is 0, and so nothing is lost.
        let mut quad = first.min(BLOCKS_ACROSS - WINDOW);
        self.splat_columns::<S, WINDOW>(simd, rows, shape, profile, quad);
        quad += WINDOW;
        while quad < end {
            self.splat_columns::<S, 1>(simd, rows, shape, profile, quad);
            quad += 1;
        }
    }

    #[inline(always)]
    fn splat_columns<S: Simd, const N_QUADS: usize>(
        &self,
        simd: S,
        rows: &mut [Row; N_TOUCHED],
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
            let Some(knots) = row[first_quad..].first_chunk_mut::<N_QUADS>() else { continue };
            for (knot, quad) in knots.iter_mut().zip(&quads) {
                let sum =
                    quad.mul_add(f32x16::splat(simd, weight), f32x16::from_slice(simd, &knot.0));
                sum.store_slice(&mut knot.0);
            }
        }
    }
}

/// Rows of knots, as many as a tile ever needs.
pub(crate) fn grow(knots: &mut Vec<Row>, n_rows: usize) {
    if knots.len() < n_rows {
        knots.resize(n_rows, [Quad::ZERO; TILE_SIDE / QUAD]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blocks::Blocks;
    use crate::splat::PixelBox;
    use crate::weights::Polynomial;
    use fearless_simd::{Level, dispatch};
    use slabsplat_core::{Lookup, Normalization};
    use slabsplat_kernel::{SectionDesc, SectionTable, TableDesc, kernel_named};

    fn gaussian() -> SectionProducts {
        let kernel = kernel_named("gaussian").unwrap();
        let normalization = Normalization::None;
        let table = |width: f64| {
            let desc =
                SectionDesc { kernel: &*kernel, width, kappa: 1.0, normalization, base_width: 0.5 };
            let table = TableDesc { sections: 128, radial_samples: 256, lookup: Lookup::Linear };
            SectionTable::new(&desc, table)
        };
        SectionProducts::new(&table(1.0), &table(4.0))
    }

    /// Splats one product on a tile, by knots.
    #[inline(always)]
    fn splat<S: Simd>(
        simd: S,
        shape: &PixelShape,
        products: &SectionProducts,
        [x, y]: [f32; 2],
        sheet: &mut Sheet,
    ) {
        let spline = RowSpline::new(shape, products).unwrap();
        grow(&mut sheet.knots, spline.n_rows());
        let (rows, weights) = spline.touched(simd, f32x8::splat(simd, y), f32x8::splat(simd, 2.0));
        let radius = (2.0 / shape.across).sqrt();
        let column = |x: f32| x.round().clamp(0.0, TILE_SIDE as f32) as u8;
        let product = Product {
            center: x,
            columns: [column(x - radius), column(x + radius)],
            first_row: rows[0] as usize,
            weights: weights.map(|weights| weights[0]),
            color: [1.0, 0.5, 0.0, 3.0],
        };
        let profile = Polynomial::<8, false> { coefficients: products.profile(), edge: 1.0 };
        product.splat(simd, &mut sheet.knots, shape, &profile);
        let side = TILE_SIDE as u8;
        sheet.touched = Blocks::meeting(&PixelBox { min: [0; 2], end: [side; 2] });
        spline.gather(simd, sheet);
    }

    /// For footprints of every size, also outside of the tile; and what is left behind is nothing.
    #[test]
    fn knots_give_products() {
        let seed = fastrand::u64(..);
        println!("seed {seed}");
        let mut rng = fastrand::Rng::with_seed(seed);
        let products = gaussian();
        let level = Level::new();
        let (mut worst, mut sum, mut n) = (0.0_f32, 0.0, 0.0);
        for _ in 0..2000 {
            let [width, height] = [0; 2].map(|_| 3.7 + 40.0 * rng.f32() * rng.f32());
            let shape = PixelShape {
                across: 2.0 / (width * width),
                along: 2.0 / (height * height),
                ..PixelShape::default()
            };
            let at = |reach: f32, random: f32| (TILE_SIDE as f32 + 2.0 * reach) * random - reach;
            let center = [at(width, rng.f32()), at(height, rng.f32())];
            let mut sheet = Sheet::default();
            dispatch!(level, simd => splat(simd, &shape, &products, center, &mut sheet));
            assert!(sheet.knots.iter().flatten().all(|quad| quad.0 == [0.0; 16]));
            for (row, quads) in sheet.sums.iter().enumerate() {
                for column in 0..TILE_SIDE {
                    let part = |pixel: usize, center: f32, radius: f32| {
                        f64::from((pixel as f32 + 0.5 - center) / radius)
                    };
                    let across = products.profile_at(part(column, center[0], width));
                    let along = products.profile_at(part(row, center[1], height));
                    let peak = products.profile_at(0.0).powi(2);
                    let sums = quads[column / QUAD].pixel(column % QUAD);
                    let exact = (across * along / peak) as f32;
                    let found = sums[3] / (6.0 * peak as f32);
                    assert!((sums[1] - 0.5 * sums[0]).abs() < 1e-6 && sums[2] == 0.0);
                    worst = worst.max((found - exact).abs());
                    (sum, n) = (sum + found - exact, n + exact);
                }
            }
        }
        println!("worst {worst}, in the mean {}", sum / n);
        assert!(f64::from(worst) < WORST_ERROR, "{worst}");
        assert!((sum / n).abs() < 2e-4, "{}", sum / n);
    }
}
