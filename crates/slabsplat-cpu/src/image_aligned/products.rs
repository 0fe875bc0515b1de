//! The sections of voxels that may be drawn as products, prepared eight at a time and splatted onto knots.
//!
//! The same as `prepare.rs` and `sections.rs` do for others, but for what makes it cheap: all sections have one shape, and
//! differ by a factor.

use crate::by_sheet::{N_AT_ONCE, Run};
use crate::image_aligned::prepare::{Kind, MARGIN, pixel};
use crate::image_aligned::sections::{SlabCut, bits};
use crate::knots::{N_TOUCHED, RowSpline};
use crate::product::Product;
use crate::sheet::Sheet;
use crate::splat::PixelBox;
use crate::tile::Tile;
use crate::weights::Polynomial;
use fearless_simd::{Simd, f32x8, prelude::*, u32x8};
use slabsplat_kernel::SectionProducts;

/// How the sections in a slab are drawn as products.
#[derive(Clone, Copy)]
pub(crate) struct AsProducts<'a> {
    pub(crate) products: &'a SectionProducts,
    pub(crate) spline: &'a RowSpline,
}

/// Footprints of no more pixels from left to right lie on three quads, three times in four or more often.
const WIDEST_OF_THREE: f32 = 10.0;

/// What eight voxels have in a slab.
struct Eight {
    /// Which of them are drawn, a bit each.
    drawn: u64,
    /// Centres, in pixels from the tile's left side.
    centers: [f32; N_AT_ONCE],
    /// Left, top, right, bottom.
    pixels: [[u32; N_AT_ONCE]; 4],
    /// The first row of knots.
    first_rows: [u32; N_AT_ONCE],
    /// How much each row of knots takes.
    weights: [[f32; N_AT_ONCE]; N_TOUCHED],
}

impl SlabCut<'_> {
    /// Adds the sections of voxels to the knots of the sheet.
    #[inline(always)]
    pub(crate) fn splat_products<S: Simd>(
        &self,
        simd: S,
        kind: Kind,
        how: AsProducts<'_>,
        voxels: Run<'_>,
        tile: &mut Tile,
        sheet: &mut Sheet,
    ) {
        let width = 2.0 * self.slabs.raster.radius * self.shape.half_extent[0];
        if width <= WIDEST_OF_THREE {
            self.splat_in_windows::<S, 3>(simd, kind, how, voxels, tile, sheet);
        } else {
            self.splat_in_windows::<S, 4>(simd, kind, how, voxels, tile, sheet);
        }
    }

    /// The same, `WINDOW` quads at once.
    #[inline(always)]
    fn splat_in_windows<S: Simd, const WINDOW: usize>(
        &self,
        simd: S,
        kind: Kind,
        how: AsProducts<'_>,
        voxels: Run<'_>,
        tile: &mut Tile,
        sheet: &mut Sheet,
    ) {
        let coefficients = how.products.profile();
        let profile = Polynomial::<8, false> { coefficients, edge: 1.0, faces: [0.0; 2] };
        for first in (0..voxels.len).step_by(N_AT_ONCE) {
            let eight = self.prepare_products(simd, kind, how, voxels, first, tile);
            for idx in bits(eight.drawn) {
                let [left, top, right, bottom] = eight.pixels.each_ref().map(|p| p[idx] as u8);
                let pixels = PixelBox { min: [left, top], end: [right, bottom] };
                let Some(blocks) = tile.accept(&pixels) else { continue };
                sheet.touched.add(blocks);
                let product = Product {
                    center: eight.centers[idx],
                    columns: [left, right],
                    first_row: eight.first_rows[idx] as usize,
                    weights: eight.weights.each_ref().map(|weights| weights[idx]),
                    color: voxels.color(first + idx),
                };
                product.splat::<S, WINDOW>(simd, &mut sheet.knots, &self.shape, &profile);
            }
        }
    }

    #[inline(always)]
    fn prepare_products<S: Simd>(
        &self,
        simd: S,
        kind: Kind,
        how: AsProducts<'_>,
        voxels: Run<'_>,
        first: usize,
        tile: &Tile,
    ) -> Eight {
        let ([right, up, depth], spans) = voxels.at_once(simd, first);
        let mut drawn = u64::MAX >> (64 - (voxels.len - first).min(N_AT_ONCE));
        let factors = if kind == Kind::Whole {
            f32x8::splat(simd, how.products.whole())
        } else {
            let (factors, is_cut) = self.factors_of(simd, how.products, depth, spans);
            drawn &= is_cut;
            factors
        };
        let centers = self.centers_of(simd, right, up, tile);
        let mut pixels = [[0; N_AT_ONCE]; 4];
        for (axis, center) in centers.into_iter().enumerate() {
            let half = self.slabs.raster.radius * self.shape.half_extent[axis] + MARGIN;
            let (first, end) = (pixel(simd, center - half), pixel(simd, center + half));
            drawn &= first.simd_lt(end).to_bitmask();
            first.store_slice(&mut pixels[axis]);
            end.store_slice(&mut pixels[axis + 2]);
        }
        let [x, y] = centers;
        let (first_rows, weights) = how.spline.touched(simd, y, factors * self.shape.gain);
        Eight { drawn, centers: x.into(), pixels, first_rows, weights }
    }

    /// How much of eight voxels' extinction lies in the slab, and which of them it cuts, a bit each.
    #[inline(always)]
    fn factors_of<S: Simd>(
        &self,
        simd: S,
        products: &SectionProducts,
        depth: f32x8<S>,
        spans: u32x8<S>,
    ) -> (f32x8<S>, u64) {
        let ([front, back], is_folded, is_drawn) = self.faces_of(simd, depth, spans);
        let nearest = front.max(-back);
        let is_cut = nearest.simd_lt(f32x8::splat(simd, self.slabs.reach_in_index));
        let places = self.slabs.rows_of(simd, front, back, is_folded);
        let rows = places.floor();
        let first_folded = u32x8::splat(simd, products.first_folded());
        let zero = u32x8::splat(simd, 0);
        let rows_idx: u32x8<S> = rows.to_int();
        let idxs = rows_idx + is_folded.select(first_folded, zero);
        let (mut factors, mut more) = ([0.0; N_AT_ONCE], [0.0; N_AT_ONCE]);
        for (lane, idx) in <[u32; N_AT_ONCE]>::from(idxs).into_iter().enumerate() {
            [factors[lane], more[lane]] = products.factors()[idx as usize];
        }
        let (factors, more) = (f32x8::from_slice(simd, &factors), f32x8::from_slice(simd, &more));
        let factors = (places - rows).mul_add(more, factors);
        (factors, is_drawn.to_bitmask() & is_cut.to_bitmask())
    }
}
