//! The sections of voxels that may be drawn by separable footprints, prepared eight at a time and splatted
//! onto the coefficients of a B-spline.
//!
//! ```text
//! for every eight voxels of a class that the slab may cut:
//!     how much of each lies in the slab: a factor, from two numbers of a table
//!     the columns that its footprint may touch; four rows of coefficients, and its weight in each
//!     for each that is drawn and meets an open block:
//!         four rows of coefficients += weight·factor·g(x)·colour (footprint.rs)
//! once a slab: rows of pixels += rows of coefficients, by the spline (b_spline.rs)
//! ```
//!
//! The same as `sections/batch.rs` and `sections/splat.rs` do for others, but for what makes it cheap: all
//! sections have one shape, and differ by a factor.

use super::b_spline::{Coefficients, N_TOUCHED, RowSpline, WORST_ERROR};
use super::footprint::SeparableFootprint;
use crate::footprints::weights::Polynomial;
use crate::pixels::rectangle::{MARGIN, PixelBox, pixel};
use crate::pixels::sheet::Sheet;
use crate::pixels::tile::Tile;
use crate::sections::cut::{Components, SlabCut, Voxels, bits};
use crate::sections::shared::Kind;
use crate::voxels::by_sheet::N_AT_ONCE;
use fearless_simd::{Simd, f32x8, prelude::*, u32x8};
use slabsplat_backend::{ByIdentity, Cached};
use slabsplat_kernel::{ErrorBudget, SectionTable, SeparableSections};
use std::sync::Arc;

/// Separable sections of the last plan's tables, cached for the next one.
#[derive(Debug, Default)]
pub(crate) struct SeparableTables(Cached<[ByIdentity<SectionTable>; 2], SeparableSections>);

/// How the sections in a slab are drawn by separable footprints.
#[derive(Clone, Copy)]
pub(crate) struct AsSeparable<'a> {
    pub(crate) sections: &'a SeparableSections,
    pub(crate) spline: &'a RowSpline,
}

/// Footprints of no more pixels from left to right lie on three quads, three times in four or more often.
const WIDEST_OF_THREE: f32 = 10.0;

/// What eight voxels have in a slab.
struct SeparableBatch {
    /// Which of them are drawn, a bit each.
    drawn: u64,
    /// Centres, in pixels from the tile's left side.
    centers: [f32; N_AT_ONCE],
    /// Left, top, right, bottom.
    pixels: [[u32; N_AT_ONCE]; 4],
    /// The first row of coefficients.
    first_rows: [u32; N_AT_ONCE],
    /// How much each row of coefficients takes.
    weights: [[f32; N_AT_ONCE]; N_TOUCHED],
}

impl SeparableTables {
    /// Those of two tables, of slabs and with what lies beyond faces, if the kernel is separable.
    pub(crate) fn of(&mut self, tables: [&Arc<SectionTable>; 2]) -> Option<&SeparableSections> {
        let key = tables.map(ByIdentity::of);
        let [slabs, merged] = tables;
        let sections = &*self.0.made_of(key, |_| SeparableSections::new(slabs, merged));
        (sections.error() < ErrorBudget::SEPARABLE_KERNEL).then_some(sections)
    }
}

/// The most extinction of a voxel whose sections may be drawn by separable footprints.
pub(crate) fn most_extinction(sections: &SeparableSections, budget: ErrorBudget) -> f32 {
    let peak = f64::from(sections.whole()) * sections.profile_at(0.0).powi(2);
    (budget.separable() / (sections.error() + WORST_ERROR * peak)) as f32
}

impl AsSeparable<'_> {
    /// Adds the sections of voxels to the coefficients.
    #[inline(always)]
    pub(crate) fn add_sections<S: Simd>(
        self,
        simd: S,
        (slab, kind): (&SlabCut<'_>, Kind),
        voxels: Voxels<'_>,
        tile: &mut Tile,
        (sheet, coefficients): (&mut Sheet, &mut Coefficients),
    ) {
        let width = 2.0 * slab.sections.raster.radius * slab.shape.half_extent[0];
        let onto = (sheet, coefficients);
        if width <= WIDEST_OF_THREE {
            self.add_in_windows::<S, 3>(simd, (slab, kind), voxels, tile, onto);
        } else {
            self.add_in_windows::<S, 4>(simd, (slab, kind), voxels, tile, onto);
        }
    }

    /// The same, `WINDOW` quads at once.
    #[inline(always)]
    fn add_in_windows<S: Simd, const WINDOW: usize>(
        self,
        simd: S,
        (slab, kind): (&SlabCut<'_>, Kind),
        voxels: Voxels<'_>,
        tile: &mut Tile,
        (sheet, coefficients): (&mut Sheet, &mut Coefficients),
    ) {
        let profile = self.sections.profile();
        let profile = Polynomial::<8, false> { coefficients: profile, edge: 1.0, faces: [0.0; 2] };
        for first in (0..voxels.len).step_by(N_AT_ONCE) {
            let batch = self.prepare(simd, (slab, kind), voxels, first, tile);
            for idx in bits(batch.drawn) {
                let [left, top, right, bottom] = batch.pixels.each_ref().map(|p| p[idx] as u8);
                let pixels = PixelBox { min: [left, top], end: [right, bottom] };
                let Some(blocks) = tile.accept(&pixels) else { continue };
                sheet.touched.add(blocks);
                let footprint = SeparableFootprint {
                    center: batch.centers[idx],
                    columns: [left, right],
                    first_row: batch.first_rows[idx] as usize,
                    weights: batch.weights.each_ref().map(|weights| weights[idx]),
                    color: voxels.voxel(first + idx).color,
                };
                footprint.add_to::<S, WINDOW>(simd, coefficients, &slab.shape, &profile);
            }
        }
    }

    #[inline(always)]
    fn prepare<S: Simd>(
        self,
        simd: S,
        (slab, kind): (&SlabCut<'_>, Kind),
        run: Voxels<'_>,
        first: usize,
        tile: &Tile,
    ) -> SeparableBatch {
        let voxels = Components::of(simd, run.at_once(first));
        let mut drawn = u64::MAX >> (64 - (run.len - first).min(N_AT_ONCE));
        let factors = if kind == Kind::Whole {
            f32x8::splat(simd, self.sections.whole())
        } else {
            let (factors, is_cut) = self.factors_of(simd, slab, &voxels);
            drawn &= is_cut;
            factors
        };
        let centers = slab.centers_of(simd, &voxels, tile);
        let mut pixels = [[0; N_AT_ONCE]; 4];
        for (axis, center) in centers.into_iter().enumerate() {
            let half = slab.sections.raster.radius * slab.shape.half_extent[axis] + MARGIN;
            let (first, end) = (pixel(simd, center - half), pixel(simd, center + half));
            drawn &= first.simd_lt(end).to_bitmask();
            first.store_slice(&mut pixels[axis]);
            end.store_slice(&mut pixels[axis + 2]);
        }
        let [x, y] = centers;
        let (first_rows, weights) = self.spline.touched(simd, y, factors * slab.shape.gain);
        SeparableBatch { drawn, centers: x.into(), pixels, first_rows, weights }
    }

    /// How much of eight voxels' extinction lies in the slab, and which of them it cuts, a bit each.
    #[inline(always)]
    fn factors_of<S: Simd>(
        self,
        simd: S,
        slab: &SlabCut<'_>,
        voxels: &Components<S>,
    ) -> (f32x8<S>, u64) {
        let cuts = slab.cuts_of(simd, voxels);
        let [front, back] = cuts.faces;
        let nearest = front.max(-back);
        let is_cut = nearest.simd_lt(f32x8::splat(simd, slab.sections.half_depth_in_index));
        let places = slab.sections.rows_of(simd, cuts.faces, cuts.is_merged);
        let rows = places.floor();
        let first_merged = u32x8::splat(simd, self.sections.first_merged());
        let zero = u32x8::splat(simd, 0);
        let rows_idx: u32x8<S> = rows.to_int();
        let idxs = rows_idx + cuts.is_merged.select(first_merged, zero);
        let (mut factors, mut more) = ([0.0; N_AT_ONCE], [0.0; N_AT_ONCE]);
        for (lane, idx) in <[u32; N_AT_ONCE]>::from(idxs).into_iter().enumerate() {
            [factors[lane], more[lane]] = self.sections.factors()[idx as usize];
        }
        let (factors, more) = (f32x8::from_slice(simd, &factors), f32x8::from_slice(simd, &more));
        let factors = (places - rows).mul_add(more, factors);
        (factors, (cuts.is_drawn & is_cut).to_bitmask())
    }
}
