//! How separable footprints of one shape are drawn in a slab.

use super::b_spline::{Coefficients, RowSpline};
use super::shear;
use crate::footprints::raster::PixelShape;
use crate::pixels::blocks::BLOCKS_ACROSS;
use crate::pixels::sheet::Sheet;
use crate::pixels::tile::Tile;
use fearless_simd::Simd;
use slabsplat_kernel::SeparableSections;

/// Footprints of one shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SeparableSlab {
    /// Their ellipse, of which `across` counts columns of coefficients, and what weights are multiplied with.
    pub(super) shape: PixelShape,
    /// How wide they are in columns that are sheared as they are, as a part of their radius in index units.
    pub(super) half_width: f32,
    pub(super) spline: RowSpline,
    /// Columns of coefficients to a pixel, if they are sheared.
    pub(super) sheared_columns: Option<usize>,
    /// Pixels of a footprint in a world unit, of which it has more than the view if it is stretched.
    pub(crate) pixels_per_world: f32,
}

/// Columns to the radius of a sheared kernel, at least. With fewer, what the spline between columns does to a
/// footprint is more than what its end does: at 4, a centre is off by 5·10⁻³ of its peak.
const LEAST_COLUMNS: f32 = 4.75;

impl SeparableSlab {
    /// Those that are as many times as high as that gain; `None` if they are too small, too large, or sheared
    /// too much.
    pub(crate) fn new(
        mut shape: PixelShape,
        gain: f32,
        is_sheared: bool,
        sections: &SeparableSections,
    ) -> Option<Self> {
        // A stretched footprint is as much lower as its area is larger.
        let pixels_per_world = shape.scale / shape.gain.sqrt();
        shape.gain *= gain;
        let spline = RowSpline::new(&shape, sections)?;
        if !is_sheared {
            let half_width = shape.half_extent[0];
            let sheared_columns = None;
            return Some(Self { shape, half_width, spline, sheared_columns, pixels_per_world });
        }
        let radius = (2.0 / shape.across).sqrt();
        let per_pixel = if radius < LEAST_COLUMNS { shear::MOST_PER_PIXEL } else { 1 };
        let radius = radius * per_pixel as f32;
        if radius < LEAST_COLUMNS || shear::MOST_SHEAR < shape.shear.abs() {
            return None;
        }
        let variance = sections.profile_variance() as f32 * radius * radius;
        let narrower = variance / (variance - shear::VARIANCE);
        shape.across = narrower * 2.0 / (radius * radius);
        shape.gain *= narrower.sqrt();
        let half_width = radius / sections.radius() as f32;
        let sheared_columns = Some(per_pixel);
        Some(Self { shape, half_width, spline, sheared_columns, pixels_per_world })
    }

    /// Where their columns lie on a tile, if they are sheared.
    #[inline(always)]
    pub(super) fn columns(&self, tile: &Tile) -> Option<shear::Columns> {
        self.sheared_columns.map(|per_pixel| shear::Columns::of(self.shape.shear, per_pixel, tile))
    }

    /// Quads of coefficients that a tile has.
    pub(crate) fn n_quads(&self) -> usize {
        let width = if self.sheared_columns.is_some() { shear::WIDTH } else { BLOCKS_ACROSS };
        self.spline.n_rows() * width
    }

    /// Adds what the coefficients stand for to the touched pixels of their sheet, and empties them.
    #[inline(always)]
    pub(crate) fn reconstruct<S: Simd>(
        &self,
        simd: S,
        tile: &Tile,
        sheet: &mut Sheet,
        coefficients: &mut Coefficients,
    ) {
        if coefficients.touched == 0 {
            return;
        }
        match self.columns(tile) {
            Some(columns) => columns.reconstruct(simd, &self.spline, sheet, coefficients),
            None => self.spline.reconstruct(simd, sheet, coefficients),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::footprints::weights::Polynomial;
    use crate::pixels::blocks::Blocks;
    use crate::pixels::quad::QUAD;
    use crate::pixels::rectangle::{PixelBox, TILE_SIDE};
    use crate::separable::b_spline::WORST_ERROR;
    use crate::separable::footprint::SeparableFootprint;
    use fearless_simd::{Level, dispatch, f32x8, prelude::*};
    use slabsplat_core::{Lookup, Normalization};
    use slabsplat_kernel::{SectionDesc, SectionTable, TableDesc, kernel_named};
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
        slab: &SeparableSlab,
        sections: &SeparableSections,
        [x, y]: [f32; 2],
        by_three: bool,
        (tile, sheet, coefficients): (&Tile, &mut Sheet, &mut Coefficients),
    ) {
        let SeparableSlab { shape, half_width, ref spline, sheared_columns, .. } = *slab;
        coefficients.grow(slab.n_quads());
        let factor = f32x8::splat(simd, 2.0 * shape.gain);
        let (rows, weights) = spline.touched(simd, f32x8::splat(simd, y), factor);
        let (center, n_columns) = match slab.columns(tile) {
            Some(sheared) => {
                let center = [x, y].map(|c| f32x8::splat(simd, c));
                (sheared.of_pixels(simd, center)[0], shear::WIDTH * QUAD)
            }
            None => (x, TILE_SIDE),
        };
        let radius = half_width * sections.radius() as f32;
        let column = |x: f32| x.round().clamp(0.0, n_columns as f32) as u8;
        let footprint = SeparableFootprint {
            center,
            columns: [column(center - radius), column(center + radius)],
            first_row: rows[0] as usize,
            weights: weights.map(|weights| weights[0]),
            color: [1.0, 0.5, 0.0, 3.0],
        };
        let coefficients_of_g = sections.profile();
        let profile =
            Polynomial::<8, false> { coefficients: coefficients_of_g, edge: 1.0, faces: [0.0; 2] };
        match (sheared_columns.is_some(), by_three) {
            (true, _) => footprint.add_to::<S, 4, { shear::WIDTH }>(
                simd,
                coefficients.rows_mut(),
                &shape,
                &profile,
            ),
            (false, true) => footprint.add_to::<S, 3, BLOCKS_ACROSS>(
                simd,
                coefficients.rows_mut(),
                &shape,
                &profile,
            ),
            (false, false) => footprint.add_to::<S, 4, BLOCKS_ACROSS>(
                simd,
                coefficients.rows_mut(),
                &shape,
                &profile,
            ),
        }
        let side = TILE_SIDE as u8;
        sheet.touched = Blocks::meeting(&PixelBox { min: [0; 2], end: [side; 2] });
        slab.reconstruct(simd, tile, sheet, coefficients);
    }

    /// For footprints of every size and shear, also outside of the tile; and what is left behind is nothing.
    #[test]
    fn separable_is_what_b_spline_holds() {
        for_each_seed(1, |mut rng| {
            let sections = gaussian();
            let level = Level::new();
            let (mut worst, mut sum, mut n) = (0.0_f32, 0.0, 0.0);
            for _ in 0..3000 {
                let is_sheared = rng.bool();
                let least = if is_sheared { 0.5 * LEAST_COLUMNS } else { 1.13 };
                let [width, height] = [0; 2].map(|_| least + 40.0 * rng.f32() * rng.f32());
                let shear = if is_sheared { 2.0 * rng.f32() - 1.0 } else { 0.0 };
                let shape = PixelShape {
                    across: 2.0 / (width * width),
                    shear,
                    along: 2.0 / (height * height),
                    half_extent: [width, height].map(|half| half / sections.radius() as f32),
                    gain: 1.0,
                    ..PixelShape::default()
                };
                let slab = SeparableSlab::new(shape, 1.0, is_sheared, &sections).unwrap();
                let at =
                    |radius: f32, random: f32| (TILE_SIDE as f32 + 2.0 * radius) * random - radius;
                let center = [at(width, rng.f32()), at(height, rng.f32())];
                let tile = Tile::new([0; 2].map(|_| TILE_SIDE * rng.usize(..99)), [9999; 2], 0);
                let (mut sheet, mut coefficients) = Default::default();
                let by_three = rng.bool();
                let onto = (&tile, &mut sheet, &mut coefficients);
                dispatch!(level, simd => splat(simd, &slab, &sections, center, by_three, onto));
                assert!(coefficients.quads.iter().all(|quad| quad.0 == [0.0; 16]));
                for (row, quads) in sheet.sums.iter().enumerate() {
                    for column in 0..TILE_SIDE {
                        let [x, y] = [column, row].map(|pixel| pixel as f32 + 0.5);
                        let [x, y] = [x - center[0], y - center[1]];
                        let across = sections.profile_at(f64::from((x + shear * y) / width));
                        let along = sections.profile_at(f64::from(y / height));
                        let peak = sections.profile_at(0.0).powi(2);
                        let sums = quads[column / QUAD].pixel(column % QUAD);
                        let exact = (across * along / peak) as f32;
                        let found = sums[3] / (6.0 * peak as f32);
                        assert!((sums[1] - 0.5 * sums[0]).abs() < 1e-5 && sums[2] == 0.0);
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
