//! From the sheets of a tile to its pixels: classification between them, light, compositing.
//!
//! ```text
//! for each layer: the parts between two sheets, classified and lit, cut by its region
//! composite their sum, as any sheet
//! ```

use super::super::lit_faces::LitFaces;
use super::depths::Depths;
use super::groups::groups_in;
use super::integrals::Integrals;
use super::nodes::{AtNodes, Ends, N_NODES, OnPart, Parts, Rays8};
use super::normals::Normals;
use super::parts::{Lies, PartShader};
use super::rings::{RetainedSheets, Rings, Scratch};
use super::sheets::{DensitySheet, Limits, N_BESIDE, N_SHEETS, Ring};
use crate::methods::slabs::{SlabOnTile, SlabSums};
use crate::pixels::blocks::BLOCK_SIDE;
use crate::pixels::ended_rays::SlabToEndIn;
use crate::pixels::quad::QUAD;
use crate::pixels::sheet::Sheet;
use crate::pixels::tile::Tile;
use crate::pixels::tile_region::TileRegion;
use fearless_simd::{Simd, f32x8, prelude::*};
use slabsplat_backend::{FramePlan, LayerPlan, Slabs};
use slabsplat_core::Compositing;
use slabsplat_traverse::BlinnPhong8;

/// Classifies and shades what lies between sheets, of all layers.
pub(super) struct Classifier<'a> {
    pub(super) layers: Vec<LayerClassifier<'a>>,
    pub(super) compositing: Compositing,
    pub(super) cutoff: f32,
}

/// Classifies and shades what lies between the sheets of a layer.
pub(super) struct LayerClassifier<'a> {
    shader: PartShader<'a>,
    depths: Depths<'a>,
    limits: Limits,
}

impl Classifier<'_> {
    /// Classifies what lies between the two sheets in the middle, if `last` is the slab of the last one, and
    /// puts it behind what the tile holds.
    #[inline(never)]
    fn classify<S: Simd>(
        &self,
        simd: S,
        last: SlabOnTile<'_>,
        rings: &Rings,
        sums: SlabSums<'_>,
        tile: &mut Tile,
    ) {
        simd.vectorize(
            #[inline(always)]
            || self.classify_inlined(simd, last, rings, sums, tile),
        );
    }

    #[inline(always)]
    fn classify_inlined<S: Simd>(
        &self,
        simd: S,
        SlabOnTile { slab: last, regions }: SlabOnTile<'_>,
        rings: &Rings,
        SlabSums { of_layer, joined }: SlabSums<'_>,
        tile: &mut Tile,
    ) {
        let ends = self.layers[0].depths.of_nodes(last);
        let are_several = 1 < self.layers.len();
        for (idx, layer) in self.layers.iter().enumerate() {
            let Some(ring) = rings.of(idx) else { continue };
            layer.add_parts(simd, (last, ring), of_layer, tile, regions.of(idx));
            if are_several {
                if !self.compositing.weights_colors() {
                    weight_colors(of_layer);
                }
                joined.take_from(of_layer);
            }
        }
        let sums = if are_several { joined } else { of_layer };
        let (compositing, cutoff) = (self.joining(), self.cutoff);
        tile.end_rays_in(SlabToEndIn { compositing, faces: ends, cutoff }, sums);
        tile.put_behind(simd, compositing, sums, cutoff);
    }

    /// What the sums of parts are composited by (model §10).
    fn joining(&self) -> Compositing {
        let are_several = 1 < self.layers.len();
        if are_several { self.compositing.of_joined_densities() } else { self.compositing }
    }
}

/// Makes what a layer alone would show in `separate` what it adds to in `associated`.
fn weight_colors(sums: &mut Sheet) {
    for [column, block_row] in sums.touched.iter() {
        for row in &mut sums.sums[block_row * BLOCK_SIDE..(block_row + 1) * BLOCK_SIDE] {
            for pixel in 0..QUAD {
                let [r, g, b, weight] = row[column].pixel(pixel);
                let [r, g, b] = [r, g, b].map(|channel| weight * channel.min(1.0));
                row[column].set_pixel(pixel, [r, g, b, weight]);
            }
        }
    }
}

impl<'a> LayerClassifier<'a> {
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
            depths: Depths { slabs: &slabs.grid, view: layer.view },
            limits,
        }
    }

    /// Writes what parts between the two sheets in the middle sum to onto an empty sheet, as far as the
    /// region holds them.
    #[inline(always)]
    fn add_parts<S: Simd>(
        &self,
        simd: S,
        (last, ring): (usize, &Ring),
        sums: &mut Sheet,
        tile: &Tile,
        region: Option<&TileRegion>,
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
                let parts = self.parts(simd, &sheets, group.position(), open, &pixels);
                if let Some(parts) = parts {
                    let lies = Lies { first_pixel: group.first_pixel(tile), ends };
                    group.write(&self.shader.sums(simd, &parts, lies), parts.seen, sums);
                }
            }
        }
        if let Some(region) = region {
            region.cut(sums, ends);
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

impl RetainedSheets for Classifier<'_> {
    fn limits(&self, layer: usize) -> &Limits {
        &self.layers[layer].limits
    }

    fn front(&self, slab: usize) -> f32 {
        self.layers[0].depths.of_nodes(slab)[0]
    }

    fn splits_slabs(&self) -> bool {
        self.compositing.sums_extinction()
    }

    #[inline(always)]
    fn show_middle<S: Simd>(
        &self,
        simd: S,
        last: SlabOnTile<'_>,
        sums: SlabSums<'_>,
        tile: &mut Tile,
        rings: &Rings,
        _: &mut Scratch,
    ) {
        self.classify(simd, last, rings, sums, tile);
    }
}
