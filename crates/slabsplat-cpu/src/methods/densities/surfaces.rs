//! The isosurfaces of all layers, nearest first (model §12).
//!
//! ```text
//! for each layer: the surfaces that rays pass between two sheets          (isosurfaces.rs)
//! for each eight pixels: lay them over each other, by depth               (passed.rs)
//! composite what came of it, as any sheet
//! ```

use super::isosurfaces::Isosurfaces;
use super::passed;
use super::rings::{RetainedSheets, Rings, Scratch};
use super::sheets::Limits;
use crate::methods::slabs::{SlabOnTile, SlabSums};
use crate::pixels::tile::Tile;
use fearless_simd::Simd;
use slabsplat_core::Compositing;

/// Draws surfaces.
pub(super) struct Surfaces<'a> {
    /// Of each layer.
    pub(super) layers: Vec<Isosurfaces<'a>>,
    pub(super) cutoff: f32,
}

impl RetainedSheets for Surfaces<'_> {
    fn limits(&self, layer: usize) -> &Limits {
        &self.layers[layer].limits
    }

    fn front(&self, slab: usize) -> f32 {
        self.layers[0].depths.of_nodes(slab)[0]
    }

    /// A surface may lie anywhere between two sheets.
    fn splits_slabs(&self) -> bool {
        true
    }

    #[inline(always)]
    fn show_middle<S: Simd>(
        &self,
        simd: S,
        SlabOnTile { slab: last, regions }: SlabOnTile<'_>,
        SlabSums { of_layer: sheet, .. }: SlabSums<'_>,
        tile: &mut Tile,
        rings: &Rings,
        Scratch { passed, .. }: &mut Scratch,
    ) {
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
