//! The sections of voxels that may be drawn as products (`knots.rs`), prepared eight at a time and splatted.

use crate::by_sheet::{N_AT_ONCE, Run};
use crate::image_aligned::prepare::{Kind, MARGIN, pixel};
use crate::image_aligned::sections::{SlabCut, bits};
use crate::knots::{N_TOUCHED, Product, RowSpline};
use crate::sheet::Sheet;
use crate::splat::PixelBox;
use crate::tile::Tile;
use crate::weights::Polynomial;
use fearless_simd::{Simd, f32x8, prelude::*};
use slabsplat_kernel::SectionProducts;

/// What eight voxels have in a slab.
struct Eight {
    drawn: u64,
    columns: [f32; N_AT_ONCE],
    /// Left, top, right, bottom.
    pixels: [[u32; N_AT_ONCE]; 4],
    first_rows: [u32; N_AT_ONCE],
    weights: [[f32; N_AT_ONCE]; N_TOUCHED],
}

impl SlabCut<'_> {
    /// Adds the sections of voxels to the knots of the sheet.
    #[inline(always)]
    pub(crate) fn splat_products<S: Simd>(
        &self,
        simd: S,
        kind: Kind,
        products: &SectionProducts,
        spline: &RowSpline,
        voxels: Run<'_>,
        tile: &mut Tile,
        sheet: &mut Sheet,
    ) {
        let profile = Polynomial::<8, false> { coefficients: products.profile(), edge: 1.0 };
        for first in (0..voxels.len).step_by(N_AT_ONCE) {
            let eight = self.prepare_products(simd, kind, products, spline, voxels, first, tile);
            for idx in bits(eight.drawn) {
                let [left, top, right, bottom] = eight.pixels.each_ref().map(|p| p[idx] as u8);
                let pixels = PixelBox { min: [left, top], end: [right, bottom] };
                let Some(blocks) = tile.accept(&pixels) else { continue };
                sheet.touched.add(blocks);
                let product = Product {
                    center: eight.columns[idx],
                    columns: [left, right],
                    first_row: eight.first_rows[idx] as usize,
                    weights: eight.weights.each_ref().map(|weights| weights[idx]),
                    color: voxels.color(first + idx),
                };
                product.splat(simd, &mut sheet.knots, &self.shape, &profile);
            }
        }
    }

    #[inline(always)]
    fn prepare_products<S: Simd>(
        &self,
        simd: S,
        kind: Kind,
        products: &SectionProducts,
        spline: &RowSpline,
        voxels: Run<'_>,
        first: usize,
        tile: &Tile,
    ) -> Eight {
        let slabs = self.slabs;
        let ([right, up, depth], spans) = voxels.at_once(simd, first);
        let mut drawn = u64::MAX >> (64 - (voxels.len - first).min(N_AT_ONCE));
        let mut factors = [products.whole(); N_AT_ONCE];
        if kind != Kind::Whole {
            let ([front, back], is_folded, is_drawn) = self.faces_of(simd, depth, spans);
            let nearest = front.max(-back);
            let is_cut = nearest.simd_lt(f32x8::splat(simd, slabs.reach_in_index));
            drawn &= is_drawn.to_bitmask() & is_cut.to_bitmask();
            let mut places = [0.0; N_AT_ONCE];
            slabs.rows_of(simd, front, back, is_folded).store_slice(&mut places);
            let is_folded = is_folded.to_bitmask();
            for (idx, (factor, place)) in factors.iter_mut().zip(places).enumerate() {
                *factor = products.factor(is_folded >> idx & 1 == 1, place);
            }
        }
        let centers = self.centers_of(simd, right, up, tile);
        let mut pixels = [[0; N_AT_ONCE]; 4];
        for (axis, center) in centers.into_iter().enumerate() {
            let half = slabs.raster.radius * self.shape.half_extent[axis] + MARGIN;
            let (first, end) = (pixel(simd, center - half), pixel(simd, center + half));
            drawn &= first.simd_lt(end).to_bitmask();
            first.store_slice(&mut pixels[axis]);
            end.store_slice(&mut pixels[axis + 2]);
        }
        let factor = f32x8::from_slice(simd, &factors) * self.shape.gain;
        let (first_rows, weights) = spline.touched(simd, centers[1], factor);
        let mut columns = [0.0; N_AT_ONCE];
        centers[0].store_slice(&mut columns);
        Eight { drawn, columns, pixels, first_rows, weights }
    }
}
