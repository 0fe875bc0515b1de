//! A section that is a function of the column times the same one of the row, splatted onto the coefficients
//! of a B-spline (`b_spline.rs`).
//!
//! It takes four rows of as many columns as the footprint has, whatever its height. That the first window of
//! columns has always the same width, with zeros where the footprint ends, saves a branch that nobody can
//! guess.

use super::b_spline::{Coefficients, N_TOUCHED};
use crate::footprints::raster::PixelShape;
use crate::footprints::weights::Weigh;
use crate::pixels::blocks::BLOCKS_ACROSS;
use crate::pixels::quad::{QUAD, Quad};
use crate::pixels::sheet::Row;
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
    pub(super) fn add_to<S: Simd, const WINDOW: usize>(
        &self,
        simd: S,
        coefficients: &mut Coefficients,
        shape: &PixelShape,
        profile: &impl Weigh<S>,
    ) {
        let rows = coefficients.0[self.first_row..].first_chunk_mut::<N_TOUCHED>();
        let Some(rows) = rows else { return };
        let [first, end] = self.columns.map(usize::from);
        let (first, end) = (first / QUAD, end.div_ceil(QUAD));
        // Most footprints are no wider than the window; further left it is 0, and so nothing is lost.
        let mut quad = first.min(BLOCKS_ACROSS - WINDOW);
        self.add_columns::<S, WINDOW>(simd, rows, shape, profile, quad);
        quad += WINDOW;
        while quad < end {
            self.add_columns::<S, 1>(simd, rows, shape, profile, quad);
            quad += 1;
        }
    }

    #[inline(always)]
    fn add_columns<S: Simd, const N_QUADS: usize>(
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::footprints::weights::Polynomial;
    use crate::pixels::blocks::Blocks;
    use crate::pixels::rectangle::{PixelBox, TILE_SIDE};
    use crate::pixels::sheet::Sheet;
    use crate::separable::b_spline::{RowSpline, WORST_ERROR};
    use fearless_simd::{Level, dispatch, f32x8};
    use slabsplat_core::{Lookup, Normalization};
    use slabsplat_kernel::{SectionDesc, SectionTable, SeparableSections, TableDesc, kernel_named};
    use slabsplat_seeds::for_each_seed;

    fn gaussian() -> SeparableSections {
        let kernel = kernel_named("gaussian").unwrap();
        let normalization = Normalization::None;
        let table = |width: f64| {
            let desc =
                SectionDesc { kernel: &*kernel, width, kappa: 1.0, normalization, base_width: 0.5 };
            let table = TableDesc { sections: 128, radial_samples: 256, lookup: Lookup::Linear };
            SectionTable::new(&desc, table)
        };
        SeparableSections::new(&table(1.0), &table(4.0))
    }

    /// Splats one separable section on a tile, by a B-spline.
    #[inline(always)]
    fn splat<S: Simd>(
        simd: S,
        shape: &PixelShape,
        sections: &SeparableSections,
        [x, y]: [f32; 2],
        by_three: bool,
        (sheet, coefficients): (&mut Sheet, &mut Coefficients),
    ) {
        let spline = RowSpline::new(shape, sections).unwrap();
        coefficients.grow(spline.n_rows());
        let (rows, weights) = spline.touched(simd, f32x8::splat(simd, y), f32x8::splat(simd, 2.0));
        let radius = (2.0 / shape.across).sqrt();
        let column = |x: f32| x.round().clamp(0.0, TILE_SIDE as f32) as u8;
        let footprint = SeparableFootprint {
            center: x,
            columns: [column(x - radius), column(x + radius)],
            first_row: rows[0] as usize,
            weights: weights.map(|weights| weights[0]),
            color: [1.0, 0.5, 0.0, 3.0],
        };
        let profile =
            Polynomial::<8, false> { coefficients: sections.profile(), edge: 1.0, faces: [0.0; 2] };
        if by_three {
            footprint.add_to::<S, 3>(simd, coefficients, shape, &profile);
        } else {
            footprint.add_to::<S, 4>(simd, coefficients, shape, &profile);
        }
        let side = TILE_SIDE as u8;
        sheet.touched = Blocks::meeting(&PixelBox { min: [0; 2], end: [side; 2] });
        spline.reconstruct(simd, sheet, coefficients);
    }

    /// For footprints of every size, also outside of the tile; and what is left behind is nothing.
    #[test]
    fn separable_is_what_b_spline_holds() {
        for_each_seed(1, |mut rng| {
            let sections = gaussian();
            let level = Level::new();
            let (mut worst, mut sum, mut n) = (0.0_f32, 0.0, 0.0);
            for _ in 0..2000 {
                let [width, height] = [0; 2].map(|_| 3.7 + 40.0 * rng.f32() * rng.f32());
                let shape = PixelShape {
                    across: 2.0 / (width * width),
                    along: 2.0 / (height * height),
                    ..PixelShape::default()
                };
                let at =
                    |radius: f32, random: f32| (TILE_SIDE as f32 + 2.0 * radius) * random - radius;
                let center = [at(width, rng.f32()), at(height, rng.f32())];
                let (mut sheet, mut coefficients) = Default::default();
                let by_three = rng.bool();
                let onto = (&mut sheet, &mut coefficients);
                dispatch!(level, simd => splat(simd, &shape, &sections, center, by_three, onto));
                assert!(coefficients.0.iter().flatten().all(|quad| quad.0 == [0.0; 16]));
                for (row, quads) in sheet.sums.iter().enumerate() {
                    for column in 0..TILE_SIDE {
                        let part = |pixel: usize, center: f32, radius: f32| {
                            f64::from((pixel as f32 + 0.5 - center) / radius)
                        };
                        let across = sections.profile_at(part(column, center[0], width));
                        let along = sections.profile_at(part(row, center[1], height));
                        let peak = sections.profile_at(0.0).powi(2);
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
        });
    }
}
