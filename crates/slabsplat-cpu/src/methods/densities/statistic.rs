//! One density for all on its ray: the largest, the least or the mean (model §12).
//!
//! ```text
//! for each sheet: at its node, or at the peak of the parabola through it and the nodes beside it,
//!     if that is larger than what the pixel has: keep it
//! at the end: the pixel is the opacity and the colour of what it has
//! ```
//!
//! Until then a tile's pixels hold what was found, scaled, in their first channel; in their second how much,
//! which is 1, or for a mean the length that it was taken over; in their third by how much it counts.

use super::groups::{BLOCKS_PER_GROUP, Group, groups_in};
use super::nodes::Rays8;
use super::rings::{Rings, Scratch};
use super::sheets::{AT_ONCE, DensitySheet, LANES, Limits, N_BESIDE, N_SHEETS, Ring};
use crate::methods::slabs::{Sheets, SlabOnTile, SlabSums};
use crate::pixels::quad::QUAD;
use crate::pixels::tile::Tile;
use crate::pixels::tile_region::TileRegion;
use crate::pixels::tiles::Tiles;
use fearless_simd::Simd;
use rayon::prelude::*;
use slabsplat_backend::densities::ValueScale;
use slabsplat_core::{SlabGrid, Statistic, TransferFunction};

/// Layers go through the slabs one by one: none hides another.
const ONLY: usize = 0;

/// Finds the density of a layer that stands for all.
pub(super) struct Gatherer<'a> {
    pub(super) statistic: Statistic,
    pub(super) slabs: &'a SlabGrid,
    pub(super) limits: Limits,
    /// One over the length of a ray, in `unit`s, with which a sheet counts in full.
    pub(super) per_full_length: f32,
}

impl Gatherer<'_> {
    /// Looks at the first of the two sheets in the middle, if `last` is the slab of the last one.
    #[inline(never)]
    fn gather<S: Simd>(
        &self,
        simd: S,
        last: usize,
        ring: &Ring,
        tile: &mut Tile,
        region: Option<&TileRegion>,
    ) {
        simd.vectorize(
            #[inline(always)]
            || self.gather_inlined(simd, last, ring, tile, region),
        );
    }

    #[inline(always)]
    fn gather_inlined<S: Simd>(
        &self,
        simd: S,
        last: usize,
        ring: &Ring,
        tile: &mut Tile,
        region: Option<&TileRegion>,
    ) {
        let sheets = ring.up_to(last);
        let faces = self.faces(last);
        let blocks = sheets[N_BESIDE].held().and(tile.open);
        let blocks = region.map_or(blocks, |region| blocks.and(region.showing(faces)));
        for group in groups_in(blocks) {
            let Group { row, column, .. } = group;
            let mut shares = [1.0; LANES];
            if let Some(region) = region {
                let (halves, _) = shares.as_chunks_mut::<QUAD>();
                for (half, shares) in halves.iter_mut().enumerate() {
                    *shares = region.shares(row, column + half * QUAD, faces);
                }
            }
            self.gather_eight(simd, &sheets, [row, column], shares, tile);
        }
    }

    #[inline(always)]
    fn gather_eight<S: Simd>(
        &self,
        simd: S,
        sheets: &[&DensitySheet; N_SHEETS],
        [row, column]: [usize; 2],
        shares: [f32; LANES],
        tile: &mut Tile,
    ) {
        let rays = Rays8::of(simd, sheets, row, column);
        let lengths: [f32; LANES] = rays.first_length().into();
        let values: [f32; LANES] = match self.statistic {
            Statistic::Maximum => rays.peak(simd, 1.0).into(),
            Statistic::Minimum => rays.peak(simd, -1.0).into(),
            Statistic::Average => rays.first_density().into(),
        };
        let quads = &mut tile.pixels[row][column / QUAD..][..BLOCKS_PER_GROUP];
        for (half, quad) in quads.iter_mut().enumerate() {
            for pixel in 0..QUAD {
                let lane = half * QUAD + pixel;
                let (length, share) = (lengths[lane], shares[lane]);
                if 0.0 < length * share {
                    let [found, much, counting, opacity] = quad.pixel(pixel);
                    let weight = (length * self.per_full_length).min(1.0);
                    let [found, much] =
                        self.with([found, much], values[lane], weight, length * share);
                    quad.set_pixel(pixel, [found, much, counting.max(weight), opacity]);
                }
            }
        }
    }

    /// What was found, and how much, with the value of one more sheet, of that weight and length.
    #[inline(always)]
    fn with(&self, [found, much]: [f32; 2], value: f32, weight: f32, length: f32) -> [f32; 2] {
        let [least, largest] = self.limits.values;
        match self.statistic {
            Statistic::Maximum => {
                let value = least + weight * (value - least);
                [if much == 0.0 { value } else { found.max(value) }, 1.0]
            }
            Statistic::Minimum => {
                let value = largest + weight * (value - largest);
                [if much == 0.0 { value } else { found.min(value) }, 1.0]
            }
            Statistic::Average => {
                let much = much + length;
                [found + (value - found) * (length / much), much]
            }
        }
    }

    /// The faces of that sheet.
    fn faces(&self, last: usize) -> [f32; 2] {
        let slab = last as f64 - (N_BESIDE + 1) as f64;
        let front = self.slabs.front(0) + slab * self.slabs.thickness();
        [front, front + self.slabs.thickness()].map(|depth| depth as f32)
    }
}

impl Sheets for Gatherer<'_> {
    type Retained = Rings;
    type Scratch = Scratch;

    const AT_ONCE: usize = AT_ONCE;
    const N_BEHIND: usize = N_BESIDE + 1;

    /// Rays do not end: no plan has one density that stands for all beside meshes.
    fn front(&self, _: usize) -> f32 {
        f32::NEG_INFINITY
    }

    fn splits_slabs(&self) -> bool {
        self.statistic == Statistic::Average
    }

    #[inline(always)]
    fn take<S: Simd>(
        &self,
        simd: S,
        SlabOnTile { slab, .. }: SlabOnTile<'_>,
        layer: usize,
        SlabSums { of_layer, .. }: SlabSums<'_>,
        rings: &mut Rings,
        scratch: &mut Scratch,
    ) {
        rings.take(simd, (slab, layer), of_layer, &self.limits, scratch);
    }

    #[inline(always)]
    fn show<S: Simd>(
        &self,
        simd: S,
        SlabOnTile { slab, regions }: SlabOnTile<'_>,
        _: SlabSums<'_>,
        tile: &mut Tile,
        rings: &mut Rings,
        _: &mut Scratch,
    ) {
        let Some(ring) = rings.of(ONLY) else { return };
        for last in slab..slab + AT_ONCE {
            self.gather(simd, last, ring, tile, regions.of(ONLY));
        }
    }

    fn release(&self, rings: &mut Rings, scratch: &mut Scratch) {
        rings.release(scratch);
    }

    fn scratch_bytes(scratch: &Scratch) -> usize {
        scratch.resident_bytes()
    }
}

/// Makes pixels of what was found.
pub(super) fn classify(tiles: &mut Tiles, transfer: &TransferFunction, scale: &ValueScale) {
    tiles.tiles.par_iter_mut().for_each(|tile| {
        for quad in tile.pixels.iter_mut().flatten() {
            for pixel in 0..QUAD {
                let [found, _, counting, opacity] = quad.pixel(pixel);
                // Pixels that are not the tile's are opaque from the start.
                if opacity == 0.0 {
                    quad.set_pixel(pixel, shown(transfer, scale, found).map(|c| counting * c));
                }
            }
        }
    });
}

/// Premultiplied colour and opacity of a scaled density.
fn shown(transfer: &TransferFunction, scale: &ValueScale, found: f32) -> [f32; 4] {
    let value = scale.value(found.into());
    let opacity = transfer.opacity(value);
    let [r, g, b] = transfer.color(value);
    [opacity * r, opacity * g, opacity * b, opacity].map(|channel| channel as f32)
}
