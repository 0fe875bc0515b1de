//! The isosurfaces of all layers, nearest first (model §12).
//!
//! ```text
//! for each layer: the surfaces that rays pass between two sheets          (isosurfaces.rs)
//! for each eight pixels: lay them over each other, by depth               (passed.rs)
//! composite what came of it, as any sheet
//! ```

use super::isosurfaces::Isosurfaces;
use super::passed;
use super::rings::{Rings, Scratch};
use super::sheets::{AT_ONCE, N_BESIDE};
use crate::methods::slabs::{Sheets, SlabOnTile, SlabSums};
use crate::pixels::tile::Tile;
use fearless_simd::Simd;
use slabsplat_core::Compositing;

/// Draws surfaces.
pub(super) struct Surfaces<'a> {
    /// Of each layer.
    pub(super) layers: Vec<Isosurfaces<'a>>,
    pub(super) cutoff: f32,
}

impl Sheets for Surfaces<'_> {
    type Retained = Rings;
    type Scratch = Scratch;

    const AT_ONCE: usize = AT_ONCE;
    const N_BEHIND: usize = N_BESIDE + 1;

    fn front(&self, slab: usize) -> f32 {
        self.layers[0].depths.of_nodes(slab)[0]
    }

    /// A surface may lie anywhere between two sheets.
    fn splits_slabs(&self) -> bool {
        true
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
        rings.take(simd, (slab, layer), of_layer, &self.layers[layer].limits, scratch);
    }

    #[inline(always)]
    fn show<S: Simd>(
        &self,
        simd: S,
        SlabOnTile { slab, regions }: SlabOnTile<'_>,
        SlabSums { of_layer: sheet, .. }: SlabSums<'_>,
        tile: &mut Tile,
        rings: &mut Rings,
        Scratch { passed, .. }: &mut Scratch,
    ) {
        if rings.are_none() {
            return;
        }
        for last in slab..slab + AT_ONCE {
            passed.clear();
            for (idx, layer) in self.layers.iter().enumerate() {
                if let Some(ring) = rings.of(idx) {
                    layer.find(simd, (last, ring), (&*tile, regions.of(idx)), passed);
                }
            }
            passed::write(passed, 1 < self.layers.len(), sheet);
            tile.put_behind(simd, Compositing::Associated, sheet, self.cutoff);
        }
    }

    fn release(&self, rings: &mut Rings, scratch: &mut Scratch) {
        rings.release(scratch);
    }

    fn scratch_bytes(scratch: &Scratch) -> usize {
        scratch.resident_bytes()
    }
}
