//! From the sheets of a tile to its pixels: classification between them, light, compositing.

use super::super::lit_faces::LitFaces;
use super::depths::Depths;
use super::groups::groups_in;
use super::integrals::Integrals;
use super::nodes::{AtNodes, Ends, N_NODES, OnPart, Parts, Rays8};
use super::normals::Normals;
use super::parts::{Lies, PartShader};
use super::sheets::{AT_ONCE, DensitySheet, Limits, N_BESIDE, N_SHEETS, Retained, Ring, Scratch};
use crate::methods::slabs::Sheets;
use crate::pixels::ended_rays::SlabToEndIn;
use crate::pixels::sheet::Sheet;
use crate::pixels::tile::Tile;
use crate::pixels::tile_region::TileRegion;
use fearless_simd::{Simd, f32x8, prelude::*};
use slabsplat_backend::{FramePlan, LayerPlan, Slabs};
use slabsplat_traverse::BlinnPhong8;

/// Classifies and shades what lies between sheets.
pub(super) struct Classifier<'a> {
    shader: PartShader<'a>,
    cutoff: f32,
    depths: Depths<'a>,
    limits: Limits,
}

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
        Self {
            shader: PartShader {
                integrals,
                compositing: plan.compositing,
                light: layer
                    .light
                    .as_ref()
                    .map(|light| BlinnPhong8::seen_along(light, layer.view.axes())),
                normals: Normals::new(layer, &slabs.grid, extent, border),
                faces: LitFaces::of(layer),
                view: layer.view,
                border,
            },
            cutoff: plan.opacity_cutoff,
            depths: Depths { slabs: &slabs.grid, view: layer.view },
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
        let ends = self.depths.of_nodes(last);
        let sheets = ring.up_to(last);
        let mut blocks = sheets[N_BESIDE].held();
        blocks.add(sheets[N_BESIDE + 1].held());
        let blocks = blocks.and(tile.open);
        let blocks = region.map_or(blocks, |region| blocks.and(region.showing(ends)));
        let pixels = self.depths.pixel_sizes(last);
        for group in groups_in(blocks) {
            let open = group.open(tile);
            if open != 0 {
                let parts = self.parts(simd, &sheets, [group.row, group.column], open, &pixels);
                if let Some(parts) = parts {
                    let lies = Lies { first_pixel: group.first_pixel(tile), ends };
                    group.write(&self.shader.sums(simd, &parts, lies), parts.seen, sums);
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
        let (lengths, densities) = (rays.length(), rays.densities(Ends::AsHeld));
        let zero = f32x8::splat(simd, 0.0);
        let is_there = lengths.simd_gt(zero).to_bitmask();
        let seen = self.may_show(simd, densities) & is_there & open;
        if seen == 0 {
            return None;
        }
        let slopes = if self.shader.light.is_some() {
            rays.slopes(simd, sheets, [row, column], pixels, Ends::AsHeld)
        } else {
            [OnPart { ends: [zero; N_NODES], bulge: zero }; 3]
        };
        Some(Parts { lengths, densities, slopes, seen })
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
}

impl Sheets for Classifier<'_> {
    type Retained = Retained;
    type Scratch = Scratch;

    const AT_ONCE: usize = AT_ONCE;
    const N_BEHIND: usize = N_BESIDE + 1;
    const CUTS_SUMS: bool = false;

    fn front(&self, slab: usize) -> f32 {
        self.depths.of_nodes(slab)[0]
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
