//! What a section needs before its pixels can be visited, for eight voxels at a time: where it lies, how far
//! its disc reaches, which rows of the table it blends.
//!
//! ```text
//! for eight voxels at once:
//!     where the slab's faces cut each; whether it is drawn here
//!     the disc in which a slab cuts a ball: ρ_max² = R² − (distance to the nearer face)²; at a slant the
//!     band that a slab has of an ellipse (band.rs)
//!     the section's position in its table, in rows
//!     the pixels that the disc may touch on the tile
//! ```
//!
//! It takes a square root and a chain of other steps. Side by side they cost little, and the inner loop finds
//! everything ready.

use super::band::Bands;
use super::cut::{Components, Cuts, SlabCut, Voxels};
use super::shared::{Kind, Sections};
use crate::footprints::raster::PixelShape;
use crate::pixels::rectangle::{MARGIN, PixelBox, pixel};
use crate::pixels::tile::Tile;
use crate::voxels::by_sheet::N_AT_ONCE;
use fearless_simd::{Simd, f32x8, prelude::*};

/// What eight voxels have in a slab.
pub(crate) struct SectionBatch {
    /// Which of them are drawn, a bit each.
    pub(crate) drawn: u64,
    /// Centres, in pixels from the tile's upper left corner.
    pub(crate) centers: [[f32; N_AT_ONCE]; 2],
    /// Columns and rows, from the first to behind the last: left, top, right, bottom.
    pub(crate) pixels: [[u32; N_AT_ONCE]; 4],
    /// Index units from the voxels to the faces that cut them.
    pub(crate) faces: [[f32; N_AT_ONCE]; 2],
    /// Whether other faces were skipped, a bit each.
    pub(crate) is_merged: u64,
    /// Where their discs end, `2·(ρ/R)² − 1`.
    pub(crate) edges: [f32; N_AT_ONCE],
    /// Where in their table they are, in rows.
    pub(crate) rows: [f32; N_AT_ONCE],
}

impl SlabCut<'_> {
    /// Prepares the voxels from `first` on.
    #[inline(always)]
    pub(super) fn prepare<S: Simd>(
        &self,
        simd: S,
        kind: Kind,
        run: Voxels<'_>,
        first: usize,
        tile: &Tile,
    ) -> SectionBatch {
        let voxels = Components::of(simd, run.at_once(first));
        let n_left = (run.len - first).min(N_AT_ONCE);
        let mut batch = SectionBatch { drawn: u64::MAX >> (64 - n_left), ..SectionBatch::EMPTY };
        let centers = self.centers_of(simd, &voxels, tile);
        let Sections { raster, half_depth_in_index, .. } = self.sections;
        if kind == Kind::Whole {
            let radius = f32x8::splat(simd, raster.radius);
            batch.place_discs(simd, &self.shape, radius, centers);
        } else {
            let cuts = self.cuts_of(simd, &voxels);
            let rho_max = batch.cut(simd, self, &cuts);
            if raster.is_tilted {
                let bands = Bands::of(simd, cuts.faces, *half_depth_in_index, raster.radius);
                for (axis, center) in centers.into_iter().enumerate() {
                    let [first, end] = bands.ends(simd, &self.shape, axis);
                    batch.push(simd, axis, center, [center + first, center + end]);
                }
            } else {
                batch.place_discs(simd, &self.shape, rho_max, centers);
            }
        }
        batch
    }
}

impl SectionBatch {
    const EMPTY: Self = Self {
        drawn: 0,
        centers: [[0.0; N_AT_ONCE]; 2],
        pixels: [[0; N_AT_ONCE]; 4],
        faces: [[0.0; N_AT_ONCE]; 2],
        is_merged: 0,
        edges: [1.0; N_AT_ONCE],
        rows: [0.0; N_AT_ONCE],
    };

    /// Notes how faces cut the voxels; returns the radii of their discs.
    #[inline(always)]
    fn cut<S: Simd>(&mut self, simd: S, slab: &SlabCut<'_>, cuts: &Cuts<S>) -> f32x8<S> {
        let sections = slab.sections;
        let [front, back] = cuts.faces;
        // The disc in which a slab between two faces cuts a ball.
        let nearest = front.max(-back).max(f32x8::splat(simd, 0.0));
        let is_cut = nearest.simd_lt(f32x8::splat(simd, sections.half_depth_in_index));
        self.drawn &= (cuts.is_drawn & is_cut).to_bitmask();
        self.is_merged = cuts.is_merged.to_bitmask();
        front.store_slice(&mut self.faces[0]);
        back.store_slice(&mut self.faces[1]);
        let radius = sections.raster.radius;
        if sections.raster.is_tilted {
            // Somewhere in the footprint it is cut in its middle: its pixels are those of a band.
            return f32x8::splat(simd, radius);
        }
        let disc_squared = f32x8::splat(simd, radius * radius) - nearest * nearest;
        let edges =
            disc_squared * f32x8::splat(simd, sections.edge_per_disc) - f32x8::splat(simd, 1.0);
        edges.store_slice(&mut self.edges);
        sections.rows_of(simd, cuts.faces, cuts.is_merged).store_slice(&mut self.rows);
        disc_squared.max(f32x8::splat(simd, 0.0)).sqrt()
    }

    /// Notes the pixels that discs around `centers` may touch.
    #[inline(always)]
    fn place_discs<S: Simd>(
        &mut self,
        simd: S,
        shape: &PixelShape,
        rho_max: f32x8<S>,
        centers: [f32x8<S>; 2],
    ) {
        for (axis, center) in centers.into_iter().enumerate() {
            let half =
                rho_max * f32x8::splat(simd, shape.half_extent[axis]) + f32x8::splat(simd, MARGIN);
            self.push(simd, axis, center, [center - half, center + half]);
        }
    }

    /// Notes the pixels between the ends that sections have along an axis.
    ///
    /// No closure: `map` over the two ends is not inlined everywhere, and took a sixth of a solid cube's
    /// frame.
    #[inline(always)]
    fn push<S: Simd>(
        &mut self,
        simd: S,
        axis: usize,
        center: f32x8<S>,
        [first, end]: [f32x8<S>; 2],
    ) {
        let (first, end) = (pixel(simd, first), pixel(simd, end));
        self.drawn &= first.simd_lt(end).to_bitmask();
        first.store_slice(&mut self.pixels[axis]);
        end.store_slice(&mut self.pixels[axis + 2]);
        center.store_slice(&mut self.centers[axis]);
    }

    #[inline(always)]
    pub(super) fn pixels_of(&self, idx: usize) -> PixelBox {
        let [left, top, right, bottom] = &self.pixels;
        let min = [left[idx] as u8, top[idx] as u8];
        PixelBox { min, end: [right[idx] as u8, bottom[idx] as u8] }
    }
}
