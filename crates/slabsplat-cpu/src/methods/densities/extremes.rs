//! The largest or the least density on a ray (model §12).
//!
//! ```text
//! for each sheet, for each eight pixels that are not saturated:
//!     at its node, or at the peak of the parabola through it and the nodes beside it:
//!         if that decides, and is larger than what the pixel has: keep it
//! close the blocks of which all pixels are saturated
//! ```
//!
//! What lies behind closed blocks is culled, as behind opaque ones. A pixel that nothing can change need not
//! have the largest density of all: `saturation.rs`.
//!
//! Voxels that cannot raise what pixels have are not culled: the parabola goes beyond the densities that it
//! is made of by up to 11/48 of what they differ by, so that next to no voxel of a scan can be told to be
//! one ([measured]).
//!
//! [measured]: https://github.com/slabsplat/slabsplat/blob/main/docs/performance.md

use super::groups::{BLOCKS_PER_GROUP, Group, groups_in};
use super::nodes::Rays8;
use super::rings::{RetainedSheets, Rings, Scratch};
use super::saturation::Saturation;
use super::sheets::{DensitySheet, Eight, LANES, Limits, N_BESIDE, N_SHEETS, Ring};
use crate::methods::slabs::{SlabOnTile, SlabSums};
use crate::pixels::blocks::{BLOCK_SIDE, Blocks};
use crate::pixels::quad::{QUAD, Quad};
use crate::pixels::tile::Tile;
use crate::pixels::tile_region::TileRegion;
use fearless_simd::{Simd, f32x4, f32x8, prelude::*};
use slabsplat_core::SlabGrid;

/// Layers go through the slabs one by one: none hides another.
const ONLY: usize = 0;

/// Finds the extreme density of a layer.
pub(super) struct Extremes<'a> {
    /// 1 for the largest, −1 for the least.
    pub(super) up: f32,
    /// What a sheet counts as that holds next to nothing. What is worse does not count.
    pub(super) worst: f32,
    /// One over how much better it must be to count in full.
    pub(super) per_rise: f32,
    pub(super) saturation: Saturation,
    pub(super) slabs: &'a SlabGrid,
    pub(super) limits: Limits,
    /// One over the length of a ray, in `unit`s, with which a sheet counts in full.
    pub(super) per_full_length: f32,
}

impl Extremes<'_> {
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
            self.gather_eight(simd, &sheets, [row, column], &shares, tile);
        }
        self.close_saturated(simd, blocks, tile);
    }

    #[inline(always)]
    fn gather_eight<S: Simd>(
        &self,
        simd: S,
        sheets: &[&DensitySheet; N_SHEETS],
        [row, column]: [usize; 2],
        shares: &[f32; LANES],
        tile: &mut Tile,
    ) {
        let rays = Rays8::of(simd, sheets, row, column);
        let zero = f32x8::splat(simd, 0.0);
        let is_there = (rays.first_length() * f32x8::from_slice(simd, shares)).simd_gt(zero);
        let one = f32x8::splat(simd, 1.0);
        let worst = f32x8::splat(simd, self.worst);
        let better_by = rays.peak(simd, self.up) - worst;
        let decides = (better_by * (self.up * self.per_rise)).max(zero).min(one);
        let weights = (rays.first_length() * self.per_full_length).min(one) * decides;
        let values: Eight = weights.mul_add(better_by, worst).into();
        let weights: Eight = is_there.select(weights, zero).into();
        let quads = &mut tile.pixels[row][column / QUAD..][..BLOCKS_PER_GROUP];
        for (half, quad) in quads.iter_mut().enumerate() {
            let lanes = half * QUAD..(half + 1) * QUAD;
            let value = f32x4::from_slice(simd, &values[lanes.clone()]);
            let weight = f32x4::from_slice(simd, &weights[lanes]);
            self.keep(simd, quad, value, weight);
        }
    }

    /// Keeps the better of what four pixels have and the values of a sheet, where it counts at all.
    #[inline(always)]
    fn keep<S: Simd>(&self, simd: S, quad: &mut Quad, value: f32x4<S>, weight: f32x4<S>) {
        let [found, much, counting, _] = quad.channels_mut();
        let zero = f32x4::splat(simd, 0.0);
        let (old, old_much) = (f32x4::from_slice(simd, found), f32x4::from_slice(simd, much));
        let old_counting = f32x4::from_slice(simd, counting);
        let better = (old * self.up).max(value * self.up) * self.up;
        let better = old_much.simd_gt(zero).select(better, value);
        let counts = weight.simd_gt(zero);
        counts.select(better, old).store_slice(found);
        counts.select(f32x4::splat(simd, 1.0), old_much).store_slice(much);
        old_counting.max(weight).store_slice(counting);
    }

    /// Closes those blocks of which all pixels are saturated.
    #[inline(always)]
    fn close_saturated<S: Simd>(&self, simd: S, blocks: Blocks, tile: &mut Tile) {
        for [column, row] in blocks.iter() {
            let mut rows = tile.pixels[row * BLOCK_SIDE..(row + 1) * BLOCK_SIDE].iter();
            if rows.all(|row| self.are_saturated(simd, &row[column])) {
                tile.close([column, row]);
            }
        }
    }

    /// Whether four pixels are, or are not the tile's.
    #[inline(always)]
    fn are_saturated<S: Simd>(&self, simd: S, quad: &Quad) -> bool {
        let Saturation { bound, least_counting } = self.saturation;
        let [found, much, counting, opacity] = quad.channels();
        let found = f32x4::from_slice(simd, found) * self.up;
        let is_good = found.simd_ge(f32x4::splat(simd, bound));
        let is_there = f32x4::from_slice(simd, much).simd_gt(f32x4::splat(simd, 0.0));
        let counting = f32x4::from_slice(simd, counting);
        let counts = counting.simd_ge(f32x4::splat(simd, least_counting));
        let opacity = f32x4::from_slice(simd, opacity);
        let is_outside = opacity.simd_ge(f32x4::splat(simd, 1.0));
        (is_good & is_there & counts | is_outside).all_true()
    }

    /// The faces of the first of the two sheets in the middle.
    fn faces(&self, last: usize) -> [f32; 2] {
        let slab = last as f64 - (N_BESIDE + 1) as f64;
        let front = self.slabs.front(0) + slab * self.slabs.thickness();
        [front, front + self.slabs.thickness()].map(|depth| depth as f32)
    }
}

impl RetainedSheets for Extremes<'_> {
    fn limits(&self, _: usize) -> &Limits {
        &self.limits
    }

    /// Rays do not end: no plan has one density that stands for all beside meshes.
    fn front(&self, _: usize) -> f32 {
        f32::NEG_INFINITY
    }

    /// A sheet is in a region whose middle is.
    fn splits_slabs(&self) -> bool {
        false
    }

    #[inline(always)]
    fn show_middle<S: Simd>(
        &self,
        simd: S,
        SlabOnTile { slab: last, regions }: SlabOnTile<'_>,
        _: SlabSums<'_>,
        tile: &mut Tile,
        rings: &Rings,
        _: &mut Scratch,
    ) {
        if let Some(ring) = rings.of(ONLY) {
            self.gather(simd, last, ring, tile, regions.of(ONLY));
        }
    }
}
