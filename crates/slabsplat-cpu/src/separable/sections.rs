//! The sections of voxels that may be drawn by separable footprints, prepared eight at a time and splatted
//! onto the coefficients of a B-spline.
//!
//! ```text
//! for every eight voxels of a class that the slab may cut:
//!     how much of each lies in the slab, a factor, and where its middle lies: polynomials of both faces
//!     the columns that its footprint may touch; four rows of coefficients, and its weight in each
//!     for each that is drawn and meets an open block:
//!         four rows of coefficients += weight·factor·g(x)·colour (footprint.rs)
//! once a slab: rows of pixels += rows of coefficients, by the spline (b_spline.rs)
//! ```
//!
//! The same as `sections/batch.rs` and `sections/splat.rs` do for others, but for what makes it cheap: all
//! sections of a frame have one shape, and whole footprints another if slabs are tilted. They differ by a
//! factor and, then, in place.

use super::b_spline::{Coefficients, N_TOUCHED, WORST_ERROR};
use super::footprint::SeparableFootprint;
use super::shear;
use super::slab::SeparableSlab;
use crate::footprints::weights::{Polynomial, nine};
use crate::pixels::blocks::BLOCKS_ACROSS;
use crate::pixels::quad::QUAD;
use crate::pixels::rectangle::{MARGIN, PixelBox, column, pixel};
use crate::pixels::sheet::Sheet;
use crate::pixels::tile::Tile;
use crate::sections::cut::{Components, Cuts, SlabCut, Voxels, bits};
use crate::sections::shared::{Kind, Sections};
use crate::voxels::by_sheet::N_AT_ONCE;
use fearless_simd::{Simd, f32x4, f32x8, mask32x8, prelude::*};
use slabsplat_backend::{ByIdentity, Cached};
use slabsplat_core::{Cancelled, FrameHandle};
use slabsplat_kernel::{ErrorBudget, SectionTable, SeparableSections, SeparableShapes};
use std::sync::Arc;

/// Separable sections of the last plan's tables, cached for the next one.
#[derive(Debug, Default)]
pub(crate) struct SeparableTables(Cached<[ByIdentity<SectionTable>; 2], SeparableSections>);

/// How the sections of voxels in a slab are drawn by separable footprints: whole ones, or what slabs cut.
#[derive(Clone, Copy)]
pub(crate) struct AsSeparable<'a> {
    pub(crate) sections: &'a SeparableSections,
    pub(crate) slab: &'a SeparableSlab,
    /// How far right and down a section's middle lies, in pixels, if the mean of what it holds lies one index
    /// unit behind the voxel, across the slab.
    pub(crate) drift: [f32; 2],
}

/// Footprints of no more pixels from left to right lie on three quads, three times in four or more often.
const WIDEST_OF_THREE: f32 = 10.0;

/// What eight voxels have in so many slabs.
struct SeparableBatch<const N_SLABS: usize> {
    /// Which of them are drawn, a bit each.
    drawn: u64,
    /// Centres, in columns of coefficients.
    centers: [f32; N_AT_ONCE],
    /// Left, top, right, bottom.
    pixels: [[u32; N_AT_ONCE]; 4],
    /// Columns of coefficients, from the first to behind the last.
    columns: [[u32; N_AT_ONCE]; 2],
    /// The first row of coefficients.
    first_rows: [u32; N_AT_ONCE],
    /// How much each row of coefficients takes.
    weights: [[f32; N_AT_ONCE]; N_TOUCHED],
    /// How much of them lies in each slab.
    factors: [[f32; N_AT_ONCE]; N_SLABS],
}

impl<const N_SLABS: usize> SeparableBatch<N_SLABS> {
    /// What a sheet sums of one of the voxels.
    #[inline(always)]
    fn color<S: Simd>(
        &self,
        simd: S,
        idx: usize,
        slabs: &[SlabCut<'_>; N_SLABS],
        voxel: &[f32; 4],
    ) -> [f32; 4] {
        let mut factors = f32x4::splat(simd, 0.0);
        for (of_slab, slab) in self.factors.iter().zip(slabs) {
            let channels = f32x4::from_slice(simd, &slab.channels);
            // Rows have the factor of a single slab.
            let factor = if N_SLABS == 1 { 1.0 } else { of_slab[idx] };
            factors = channels.mul_add(f32x4::splat(simd, factor), factors);
        }
        (f32x4::from_slice(simd, voxel) * factors).into()
    }
}

impl SeparableTables {
    /// Those of two tables, of slabs and with what lies beyond faces, if the kernel is separable.
    pub(crate) fn of(
        &mut self,
        tables: [&Arc<SectionTable>; 2],
        frame: &FrameHandle,
    ) -> Result<Option<&SeparableSections>, Cancelled> {
        let key = tables.map(ByIdentity::of);
        let [slabs, merged] = tables;
        let made = |_: &_| SeparableSections::for_frame(slabs, merged, frame);
        let sections = &*self.0.try_made_of(key, made)?;
        Ok((sections.error() < ErrorBudget::SEPARABLE_KERNEL).then_some(sections))
    }
}

/// The most extinction of a voxel whose sections may be drawn by separable footprints.
pub(crate) fn most_extinction(
    sections: &SeparableSections,
    shapes: &SeparableShapes,
    budget: ErrorBudget,
) -> f32 {
    let peak = f64::from(sections.whole()) * sections.profile_at(0.0).powi(2);
    (budget.separable() / (shapes.error + WORST_ERROR * peak)) as f32
}

impl AsSeparable<'_> {
    /// Whether footprints have the same shape as others of the slab.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        std::ptr::eq(self.slab, other.slab)
    }

    /// Adds the sections of voxels in a slab to the coefficients, or those in slabs that follow each other
    /// and cut sections of one shape with their middles at one position.
    #[inline(always)]
    pub(crate) fn add_sections<S: Simd, const N_SLABS: usize>(
        self,
        simd: S,
        (slabs, kind): (&[SlabCut<'_>; N_SLABS], Kind),
        voxels: Voxels<'_>,
        tile: &mut Tile,
        (sheet, coefficients): (&mut Sheet, &mut Coefficients),
    ) {
        let width = 2.0 * slabs[0].sections.raster.radius * self.slab.half_width;
        let (slabs, onto) = ((slabs, kind), (sheet, coefficients));
        if self.slab.sheared_columns.is_some() {
            self.add_in_windows::<S, N_SLABS, 4, { shear::WIDTH }>(simd, slabs, voxels, tile, onto);
        } else if width <= WIDEST_OF_THREE {
            self.add_in_windows::<S, N_SLABS, 3, BLOCKS_ACROSS>(simd, slabs, voxels, tile, onto);
        } else {
            self.add_in_windows::<S, N_SLABS, 4, BLOCKS_ACROSS>(simd, slabs, voxels, tile, onto);
        }
    }

    /// The same, `WINDOW` quads at once, of `WIDTH` in a row of coefficients.
    #[inline(always)]
    fn add_in_windows<S: Simd, const N_SLABS: usize, const WINDOW: usize, const WIDTH: usize>(
        self,
        simd: S,
        (slabs, kind): (&[SlabCut<'_>; N_SLABS], Kind),
        voxels: Voxels<'_>,
        tile: &mut Tile,
        (sheet, coefficients): (&mut Sheet, &mut Coefficients),
    ) {
        let profile = self.sections.profile();
        let profile = Polynomial::<8, false> { coefficients: profile, edge: 1.0, faces: [0.0; 2] };
        let (rows, touched) = coefficients.rows_mut();
        for first in (0..voxels.len).step_by(N_AT_ONCE) {
            let batch = self.prepare(simd, (slabs, kind), voxels, first, tile);
            for idx in bits(batch.drawn) {
                let [left, top, right, bottom] = batch.pixels.each_ref().map(|p| p[idx] as u8);
                let pixels = PixelBox { min: [left, top], end: [right, bottom] };
                let Some(blocks) = tile.accept(&pixels) else { continue };
                sheet.touched.add(blocks);
                let footprint = SeparableFootprint {
                    center: batch.centers[idx],
                    columns: batch.columns.each_ref().map(|columns| columns[idx] as u8),
                    first_row: batch.first_rows[idx] as usize,
                    weights: batch.weights.each_ref().map(|weights| weights[idx]),
                    color: batch.color(simd, idx, slabs, &voxels.voxel(first + idx).color),
                };
                let shape = &self.slab.shape;
                footprint.add_to::<S, WINDOW, WIDTH>(simd, (rows, touched), shape, &profile);
            }
        }
    }

    #[inline(always)]
    fn prepare<S: Simd, const N_SLABS: usize>(
        self,
        simd: S,
        (slabs, kind): (&[SlabCut<'_>; N_SLABS], Kind),
        run: Voxels<'_>,
        first: usize,
        tile: &Tile,
    ) -> SeparableBatch<N_SLABS> {
        let slab = &slabs[0];
        let SeparableSlab { shape, half_width, ref spline, .. } = *self.slab;
        let radius = slab.sections.raster.radius;
        let voxels = Components::of(simd, run.at_once(first));
        let mut drawn = u64::MAX >> (64 - (run.len - first).min(N_AT_ONCE));
        let [mut x, mut y] = slab.centers_of(simd, &voxels, tile);
        let mut factors = [f32x8::splat(simd, self.sections.whole()); N_SLABS];
        if kind != Kind::Whole {
            let mut are_cut = 0;
            for (factors, slab) in factors.iter_mut().zip(slabs) {
                let cuts = slab.cuts_of(simd, &voxels);
                let of_slab = self.factors_of(simd, slab, &cuts);
                let is_drawn = cuts.is_drawn & of_slab.is_cut;
                are_cut |= is_drawn.to_bitmask();
                *factors = of_slab.factors;
                if N_SLABS == 1 {
                    let [right, down] = self.drift;
                    x = of_slab.middles.mul_add(f32x8::splat(simd, right), x);
                    y = of_slab.middles.mul_add(f32x8::splat(simd, down), y);
                } else {
                    *factors = is_drawn.select(*factors, f32x8::splat(simd, 0.0));
                }
            }
            drawn &= are_cut;
        }
        let mut pixels = [[0; N_AT_ONCE]; 4];
        for (axis, center) in [x, y].into_iter().enumerate() {
            let half = radius * shape.half_extent[axis] + MARGIN;
            let (first, end) = (pixel(simd, center - half), pixel(simd, center + half));
            drawn &= first.simd_lt(end).to_bitmask();
            first.store_slice(&mut pixels[axis]);
            end.store_slice(&mut pixels[axis + 2]);
        }
        let mut columns = [pixels[0], pixels[2]];
        if let Some(sheared) = self.slab.columns(tile) {
            x = sheared.of_pixels(simd, [x, y]);
            let half = radius * half_width + MARGIN;
            let n_columns = shear::WIDTH * QUAD;
            column(simd, x - half, n_columns).store_slice(&mut columns[0]);
            column(simd, x + half, n_columns).store_slice(&mut columns[1]);
        }
        // Of one slab the rows' weights have the factors, of more their channels have them.
        let gain = f32x8::splat(simd, shape.gain);
        let of_rows = if N_SLABS == 1 { factors[0] * gain } else { gain };
        let (first_rows, weights) = spline.touched(simd, y, of_rows);
        let factors = factors.map(Into::into);
        SeparableBatch { drawn, centers: x.into(), pixels, columns, first_rows, weights, factors }
    }

    /// How much of eight voxels' extinction lies in the slab, and how far behind them it lies in the mean.
    #[inline(always)]
    fn factors_of<S: Simd>(self, simd: S, slab: &SlabCut<'_>, cuts: &Cuts<S>) -> Factors<S> {
        let Sections { raster, half_depth_in_index, .. } = slab.sections;
        let [front, back] = cuts.faces;
        let is_cut = front.max(-back).simd_lt(f32x8::splat(simd, *half_depth_in_index));
        // Faces are where they cut the ray through the voxel; across the slab they are nearer.
        let nearer = raster.radius / half_depth_in_index;
        let most = f32x8::splat(simd, raster.radius);
        let front = (front * nearer).max(-most).min(most);
        let back = (back * nearer).max(-most).min(most);
        let form = 2.0 / (raster.radius * raster.radius);
        let of_front = (front * form).mul_add(front, f32x8::splat(simd, -1.0));
        let of_back = (back * form).mul_add(back, f32x8::splat(simd, -1.0));
        let masses = self.sections.masses();
        let factors = back * nine(simd, masses, of_back) - front * nine(simd, masses, of_front);
        let middles = if self.drift == [0.0; 2] {
            f32x8::splat(simd, 0.0)
        } else {
            let moments = self.sections.moments();
            let moments = nine(simd, moments, of_back) - nine(simd, moments, of_front);
            // Of next to nothing rounding would put the middle anywhere.
            (moments / factors.max(f32x8::splat(simd, f32::MIN_POSITIVE))).max(front).min(back)
        };
        Factors { factors, middles, is_cut }
    }
}

/// What eight voxels have in a slab, before it is known where that lies.
struct Factors<S: Simd> {
    factors: f32x8<S>,
    /// In index units behind the voxels, across the slab.
    middles: f32x8<S>,
    is_cut: mask32x8<S>,
}
