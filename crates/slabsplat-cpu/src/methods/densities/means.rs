//! The mean density on a ray (model §12).
//!
//! A mean needs no sheets but to know where there is next to nothing on a ray: `Σ V/Σ L` over all of them are
//! sums of whole footprints. So those are splatted, where rays are parallel and no region cuts them, and then
//! sheets for the few blocks in which a ray may only graze the volume (`grazed.rs`).

use super::rings::{Rings, Scratch};
use super::sheets::{AT_ONCE, Limits};
use crate::methods::slabs::{Sheets, SlabOnTile, SlabSums};
use crate::pixels::blocks::BLOCK_SIDE;
use crate::pixels::quad::{QUAD, Quad};
use crate::pixels::sheet::Sheet;
use crate::pixels::tile::Tile;
use crate::pixels::tile_region::TileRegion;
use fearless_simd::{Simd, f32x4, prelude::*};
use slabsplat_core::SlabGrid;

/// Layers go through the slabs one by one: none hides another.
const ONLY: usize = 0;

/// Sums sheets.
pub(super) struct Means<'a> {
    pub(super) slabs: &'a SlabGrid,
    pub(super) limits: Limits,
    /// One over the length of a ray, in `unit`s, with which a sheet counts in full.
    pub(super) per_full_length: f32,
}

/// Sums whole footprints, whatever slabs they were put into.
pub(super) struct WholeMeans;

impl Means<'_> {
    /// Adds what the first or the second two channels of sums hold, of a sheet between two faces.
    #[inline(always)]
    fn add<S: Simd>(
        &self,
        simd: S,
        (sums, channels, faces): (&Sheet, usize, [f32; 2]),
        tile: &mut Tile,
        region: Option<&TileRegion>,
    ) {
        let blocks = sums.touched.and(tile.open);
        let blocks = region.map_or(blocks, |region| blocks.and(region.showing(faces)));
        for [column, block_row] in blocks.iter() {
            for row in block_row * BLOCK_SIDE..(block_row + 1) * BLOCK_SIDE {
                let shares = match region {
                    Some(region) => region.shares(row, column * QUAD, faces),
                    None => [1.0; QUAD],
                };
                let of_sheet = sums.sums[row][column].channels();
                let [weighted, length] = [&of_sheet[2 * channels], &of_sheet[2 * channels + 1]];
                let (weighted, length) =
                    (f32x4::from_slice(simd, weighted), f32x4::from_slice(simd, length));
                self.add_four(simd, [weighted, length], shares, &mut tile.pixels[row][column]);
            }
        }
    }

    /// Adds what a sheet holds of four pixels, as far as the region does.
    #[inline(always)]
    fn add_four<S: Simd>(
        &self,
        simd: S,
        [weighted, length]: [f32x4<S>; 2],
        shares: [f32; QUAD],
        pixels: &mut Quad,
    ) {
        let zero = f32x4::splat(simd, 0.0);
        let shares = f32x4::from_slice(simd, &shares);
        let [lo, hi] = self.limits.values;
        let counts =
            length.simd_gt(f32x4::splat(simd, self.limits.least_length)) & shares.simd_gt(zero);
        let length = counts.select(length, zero);
        let weighted = weighted.max(length * lo).min(length * hi);
        let weight = (length * self.per_full_length).min(f32x4::splat(simd, 1.0));
        let [found, much, counting, _] = pixels.channels_mut();
        shares.mul_add(weighted, f32x4::from_slice(simd, found)).store_slice(found);
        shares.mul_add(length, f32x4::from_slice(simd, much)).store_slice(much);
        weight.max(f32x4::from_slice(simd, counting)).store_slice(counting);
    }
}

impl Sheets for Means<'_> {
    type Retained = Rings;
    type Scratch = Scratch;

    const AT_ONCE: usize = AT_ONCE;
    const N_BEHIND: usize = 0;

    /// Rays do not end: no plan has one density that stands for all beside meshes.
    fn front(&self, _: usize) -> f32 {
        f32::NEG_INFINITY
    }

    fn splits_slabs(&self) -> bool {
        true
    }

    #[inline(always)]
    fn show<S: Simd>(
        &self,
        simd: S,
        SlabOnTile { slab, regions }: SlabOnTile<'_>,
        SlabSums { of_layer, .. }: SlabSums<'_>,
        tile: &mut Tile,
        _: &mut Rings,
        _: &mut Scratch,
    ) {
        if of_layer.touched.is_empty() {
            return;
        }
        for channels in 0..AT_ONCE {
            let faces = self.slabs.faces(slab + channels).map(|depth| depth as f32);
            self.add(simd, (of_layer, channels, faces), tile, regions.of(ONLY));
        }
        of_layer.clear();
    }

    fn scratch_bytes(scratch: &Scratch) -> usize {
        scratch.resident_bytes()
    }
}

impl Sheets for WholeMeans {
    type Retained = Rings;
    type Scratch = Scratch;

    const AT_ONCE: usize = 1;
    const N_BEHIND: usize = 0;

    fn front(&self, _: usize) -> f32 {
        f32::NEG_INFINITY
    }

    fn splits_slabs(&self) -> bool {
        true
    }

    #[inline(always)]
    fn show<S: Simd>(
        &self,
        simd: S,
        _: SlabOnTile<'_>,
        SlabSums { of_layer, .. }: SlabSums<'_>,
        tile: &mut Tile,
        _: &mut Rings,
        _: &mut Scratch,
    ) {
        for [column, block_row] in of_layer.touched.iter() {
            for row in block_row * BLOCK_SIDE..(block_row + 1) * BLOCK_SIDE {
                let sums = of_layer.sums[row][column].channels();
                let pixels = tile.pixels[row][column].channels_mut();
                for (pixels, sums) in pixels.iter_mut().zip(sums).take(2) {
                    let sum = f32x4::from_slice(simd, pixels) + f32x4::from_slice(simd, sums);
                    sum.store_slice(pixels);
                }
            }
        }
        of_layer.clear();
    }

    fn scratch_bytes(scratch: &Scratch) -> usize {
        scratch.resident_bytes()
    }
}
