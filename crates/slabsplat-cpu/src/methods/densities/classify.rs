//! From the sheets of a tile to its pixels: classification between them, light, compositing.

use super::super::lit_faces::LitFaces;
use super::integrals::Integrals;
use super::nodes::{AtNodes, N_NODES, OnPart, Parts, Rays8};
use super::parts::{Lies, PartShader};
use super::rays::Rays;
use super::sheets::{
    AT_ONCE, DensitySheet, LANES, Limits, N_BESIDE, N_SHEETS, Retained, Ring, Scratch,
};
use crate::methods::slabs::Sheets;
use crate::pixels::blocks::{BLOCK_SIDE, BLOCKS_ACROSS};
use crate::pixels::ended_rays::SlabToEndIn;
use crate::pixels::quad::QUAD;
use crate::pixels::rectangle::TILE_SIDE;
use crate::pixels::sheet::Sheet;
use crate::pixels::tile::Tile;
use crate::pixels::tile_region::TileRegion;
use fearless_simd::{Simd, f32x8, prelude::*};
use slabsplat_backend::{FramePlan, LayerPlan, Slabs};
use slabsplat_core::{SlabGrid, View};
use slabsplat_traverse::BlinnPhong8;

/// A gradient counts in full from this part of the range of values on, per `unit`: less is the noise of a
/// plateau, and a normal must not turn about within it.
const FAINT_GRADIENT: f64 = 1.0 / 256.0;

/// Classifies and shades what lies between sheets.
pub(super) struct Classifier<'a> {
    shader: PartShader<'a>,
    cutoff: f32,
    slabs: &'a SlabGrid,
    view: View,
    limits: Limits,
}

/// Blocks that eight pixels on end lie in.
const BLOCKS_PER_GROUP: usize = LANES / BLOCK_SIDE;

impl<'a> Classifier<'a> {
    /// For values of which the finite ones have that scaled extent.
    pub(super) fn new(
        plan: &FramePlan<'_>,
        layer: &'a LayerPlan<'_>,
        slabs: &'a Slabs,
        integrals: &'a Integrals,
        extent: f64,
        border: usize,
        limits: Limits,
    ) -> Self {
        let faint = FAINT_GRADIENT * extent / layer.volume.grid().unit();
        Self {
            shader: PartShader {
                integrals,
                compositing: plan.compositing,
                light: layer
                    .light
                    .as_ref()
                    .map(|light| BlinnPhong8::new(&light.seen_along(layer.view.axes()))),
                rays: Rays::new(&layer.view, border),
                // Never 0, which a gradient of 0 would be divided by.
                faint: (faint as f32).max(f32::MIN_POSITIVE),
                per_sheet: (1.0 / slabs.grid.thickness()) as f32,
                faces: LitFaces::of(layer),
                view: layer.view,
                border,
            },
            cutoff: plan.opacity_cutoff,
            slabs: &slabs.grid,
            view: layer.view,
            limits,
        }
    }

    /// Classifies what lies between the two sheets in the middle, if `last` is the slab of the last one, and
    /// puts it behind what the tile holds. `sums` is empty.
    #[inline(never)]
    fn classify<S: Simd>(
        &self,
        simd: S,
        last: usize,
        ring: &Ring,
        sums: &mut Sheet,
        tile: (&mut Tile, Option<&TileRegion>),
    ) {
        simd.vectorize(
            #[inline(always)]
            || self.classify_inlined(simd, last, ring, sums, tile),
        );
    }

    #[inline(always)]
    fn classify_inlined<S: Simd>(
        &self,
        simd: S,
        last: usize,
        ring: &Ring,
        sums: &mut Sheet,
        (tile, region): (&mut Tile, Option<&TileRegion>),
    ) {
        let ends = self.ends_of_part(last);
        let sheets = ring.up_to(last);
        let mut blocks = sheets[N_BESIDE].held();
        blocks.add(sheets[N_BESIDE + 1].held());
        let blocks = blocks.and(tile.open);
        let blocks = region.map_or(blocks, |region| blocks.and(region.showing(ends)));
        let pixels = self.pixel_sizes(last);
        for block_row in 0..BLOCKS_ACROSS {
            let columns = blocks.row(block_row);
            for group in 0..TILE_SIDE / LANES {
                // A bit for each of the group's two blocks.
                let of_group = columns >> (group * BLOCKS_PER_GROUP) & 0b11;
                if of_group == 0 {
                    continue;
                }
                for row in block_row * BLOCK_SIDE..(block_row + 1) * BLOCK_SIDE {
                    let open = open_lanes(tile, row, group, of_group);
                    if open != 0 {
                        let parts = self.parts(simd, &sheets, [row, group * LANES], open, &pixels);
                        if let Some(parts) = parts {
                            let [x, y] = tile.origin;
                            let lies = Lies { first_pixel: [x + group * LANES, y + row], ends };
                            self.sum(simd, &parts, [row, group], lies, sums);
                        }
                    }
                }
            }
        }
        if let Some(region) = region {
            region.cut(sums, ends);
        }
        let (compositing, cutoff) = (self.shader.compositing, self.cutoff);
        tile.end_rays_in(SlabToEndIn { compositing, faces: ends, cutoff }, sums);
        tile.put_behind(simd, compositing, sums, cutoff);
        if let Some(region) = region {
            tile.close_all(region.over_from(ends[1]));
        }
    }

    /// The depths between which the two sheets in the middle have their nodes.
    fn ends_of_part(&self, last: usize) -> [f32; 2] {
        // Sheets before the first are empty.
        let middle = |back: usize| {
            let slab = last as f64 - back as f64;
            (self.slabs.middle(0) + slab * self.slabs.thickness()) as f32
        };
        [middle(N_BESIDE + 1), middle(N_BESIDE)]
    }

    /// The parts of eight pixels on end, as far as they are open, a bit each; `None` if nothing of them may
    /// be seen.
    #[inline(always)]
    fn parts<S: Simd>(
        &self,
        simd: S,
        sheets: &[&DensitySheet; N_SHEETS],
        [row, column]: [usize; 2],
        open: u64,
        pixels: &[f32; N_SHEETS],
    ) -> Option<Parts<S>> {
        let rays = Rays8::of(simd, sheets, row, column);
        let (lengths, densities) = (rays.length(), rays.densities());
        let zero = f32x8::splat(simd, 0.0);
        let is_there = lengths.simd_gt(zero).to_bitmask();
        let seen = self.may_show(simd, densities) & is_there & open;
        if seen == 0 {
            return None;
        }
        let slopes = if self.shader.light.is_some() {
            rays.slopes(simd, sheets, [row, column], pixels)
        } else {
            [OnPart { ends: [zero; N_NODES], bulge: zero }; 3]
        };
        Some(Parts { lengths, densities, slopes, seen })
    }

    /// Writes the sums of parts onto a sheet.
    #[inline(always)]
    fn sum<S: Simd>(
        &self,
        simd: S,
        parts: &Parts<S>,
        [row, group]: [usize; 2],
        lies: Lies,
        sheet: &mut Sheet,
    ) {
        let sums = self.shader.sums(simd, parts, lies);
        let quads = &mut sheet.sums[row][group * BLOCKS_PER_GROUP..][..BLOCKS_PER_GROUP];
        for (half, quad) in quads.iter_mut().enumerate() {
            // What is not touched must stay empty.
            if parts.seen >> (half * QUAD) & 0b1111 == 0 {
                continue;
            }
            let column = group * BLOCKS_PER_GROUP + half;
            sheet.touched.add_one([column, row / BLOCK_SIDE]);
            let (channels, _) = quad.0.as_chunks_mut::<QUAD>();
            for (channel, sums) in channels.iter_mut().zip(&sums) {
                channel.copy_from_slice(&sums[half * QUAD..][..QUAD]);
            }
        }
    }

    /// In which lanes anything shows between two densities, a bit each.
    #[inline(always)]
    fn may_show<S: Simd>(&self, simd: S, [a, b]: AtNodes<S>) -> u64 {
        let (least, largest) = (a.min(b), a.max(b));
        let shown = self.shader.integrals.visible().iter().map(|[lo, hi]| {
            let shows =
                largest.simd_ge(f32x8::splat(simd, *lo)) & least.simd_le(f32x8::splat(simd, *hi));
            shows.to_bitmask()
        });
        shown.fold(0, |shown, more| shown | more)
    }

    /// World units between the pixels of six sheets.
    fn pixel_sizes(&self, last: usize) -> [f32; N_SHEETS] {
        std::array::from_fn(|idx| {
            let slab = (last + 1 + idx).saturating_sub(N_SHEETS);
            // Sheets before the near depth are empty, and have no pixels.
            let depth = self.slabs.middle(slab).max(self.view.near_depth());
            (1.0 / self.view.pixels_per_world(depth)) as f32
        })
    }
}

/// The lanes of a group of eight pixels whose blocks are meant and which are not opaque.
#[inline(always)]
fn open_lanes(tile: &Tile, row: usize, group: usize, blocks: u64) -> u64 {
    let mut open = 0;
    for block in 0..LANES / QUAD {
        let opacities = tile.pixels[row][group * LANES / QUAD + block].opacities();
        let is_meant = blocks >> block & 1;
        for (lane, opacity) in opacities.into_iter().enumerate() {
            open |= (u64::from(opacity < 1.0) & is_meant) << (block * QUAD + lane);
        }
    }
    open
}

impl Sheets for Classifier<'_> {
    type Retained = Retained;
    type Scratch = Scratch;

    const AT_ONCE: usize = AT_ONCE;
    const N_BEHIND: usize = N_BESIDE + 1;
    const CUTS_SUMS: bool = false;

    fn front(&self, slab: usize) -> f32 {
        self.ends_of_part(slab)[0]
    }

    fn splits_slabs(&self) -> bool {
        self.shader.compositing.sums_extinction()
    }

    #[inline(always)]
    fn take<S: Simd>(
        &self,
        simd: S,
        slab: usize,
        sheet: &mut Sheet,
        (tile, region): (&mut Tile, Option<&TileRegion>),
        retained: &mut Retained,
        rings: &mut Scratch,
    ) {
        if sheet.touched.is_empty() && retained.is_none() {
            return;
        }
        let ring = retained.get_or_insert_with(|| rings.pop().unwrap_or_default());
        ring.push(simd, slab, sheet, &self.limits);
        for last in slab..slab + AT_ONCE {
            self.classify(simd, last, ring, sheet, (tile, region));
        }
    }

    fn release(&self, retained: &mut Retained, rings: &mut Scratch) {
        Ring::release(retained, rings);
    }

    fn scratch_bytes(rings: &Scratch) -> usize {
        rings.len() * Ring::BYTES
    }
}
