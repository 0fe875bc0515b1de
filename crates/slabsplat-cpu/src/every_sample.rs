//! The original method (§1): whole footprints, composited one voxel at a time. There are no sheets; each
//! footprint's pixels go straight behind the tile's.

use crate::frame::Stage;
use crate::sheet::Sheet;
use crate::tile::Tile;
use crate::voxel::Voxel;
use crate::whole::Whole;
use fearless_simd::{Simd, dispatch};

/// Voxels between two looks at which blocks are full: a look costs about as much as a voxel.
const LOOK_EVERY: usize = 256;

/// Composites the tile's voxels, front to back, until the tile is full.
pub(crate) fn render_tile<'a>(
    stage: &Stage<'_>,
    whole: &Whole<'_>,
    voxels: impl Iterator<Item = &'a Voxel>,
    tile: &mut Tile,
    sheet: &mut Sheet,
) {
    dispatch!(stage.level, simd => render_voxels(simd, stage, whole, voxels, tile, sheet));
}

#[inline(always)]
fn render_voxels<'a, S: Simd>(
    simd: S,
    stage: &Stage<'_>,
    whole: &Whole<'_>,
    voxels: impl Iterator<Item = &'a Voxel>,
    tile: &mut Tile,
    sheet: &mut Sheet,
) {
    for (place, voxel) in voxels.enumerate() {
        if place % LOOK_EVERY == 0 {
            tile.close_full_blocks(stage.plan.opacity_cutoff);
        }
        if let Some(pixels) = whole.splat(simd, voxel, tile, sheet) {
            tile.put_box_behind(simd, stage.plan.compositing, sheet, &pixels);
        }
    }
    tile.close_full_blocks(stage.plan.opacity_cutoff);
}
