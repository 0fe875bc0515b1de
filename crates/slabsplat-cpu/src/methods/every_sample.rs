//! The original method (§1): whole footprints, composited one voxel at a time. There are no sheets; each
//! footprint's pixels go straight behind the tile's.

use super::{Stage, whole_voxels};
use crate::footprints::polynomials::FootprintPolynomials;
use crate::footprints::whole::WholeFootprints;
use crate::pixels::sheet::Sheet;
use crate::pixels::tile::Tile;
use crate::pixels::tiles::Tiles;
use crate::progress::Progress;
use crate::stopwatch::Stopwatch;
use crate::voxels::voxel::Voxel;
use fearless_simd::{Simd, dispatch};
use slabsplat_core::Cancelled;
use slabsplat_kernel::FootprintTable;
use slabsplat_traverse::{DepthOrder, TileBuckets, Workspaces};
use std::sync::Arc;

/// Voxels between two looks at which blocks are saturated: a look costs about as much as a voxel.
const LOOK_EVERY: usize = 256;

/// What is cached from frame to frame.
#[derive(Debug, Default)]
pub(crate) struct Buffers {
    polynomials: FootprintPolynomials,
    /// All relevant voxels.
    voxels: Vec<Voxel<()>>,
    order: DepthOrder,
    splats: TileBuckets,
    /// Of one voxel at a time; empty between them.
    sheets: Workspaces<Sheet>,
}

/// Renders into empty tiles.
pub(crate) fn render(
    stage: &Stage<'_>,
    table: &Arc<FootprintTable>,
    tiles: &mut Tiles,
    Buffers { polynomials, voxels, order, splats, sheets }: &mut Buffers,
    watch: &mut Stopwatch<'_>,
) -> Result<(), Cancelled> {
    whole_voxels::shade(stage, |_| (), voxels)?;
    watch.done("shade")?;
    order.update(stage.layer.volume.grid(), &stage.layer.view, stage.list(), stage.frame)?;
    watch.done("sort")?;
    let voxel = |splat: usize| &voxels[order.idx_of(splat)];
    whole_voxels::toss(stage, &tiles.grid, order.len(), |s| voxel(s).point, splats)?;
    watch.done("toss")?;
    let polynomials = polynomials.of(table);
    let footprints = WholeFootprints { raster: &stage.raster, polynomials };
    tiles.for_each(Progress::of_all(stage.frame), sheets, |tile_idx, tile, sheet| {
        let here = splats.on_tile(tile_idx).map(voxel);
        dispatch!(stage.level, simd => render_voxels(simd, stage, &footprints, here, tile, sheet));
    });
    watch.done("splat")
}

/// Composites the tile's voxels, front to back, until the tile is saturated.
#[inline(always)]
fn render_voxels<'a, S: Simd>(
    simd: S,
    stage: &Stage<'_>,
    footprints: &WholeFootprints<'_>,
    voxels: impl Iterator<Item = &'a Voxel<()>>,
    tile: &mut Tile,
    sheet: &mut Sheet,
) {
    for (nth, voxel) in voxels.enumerate() {
        if nth % LOOK_EVERY == 0 {
            if stage.frame.is_cancelled() {
                return;
            }
            tile.close_saturated_blocks(stage.plan.opacity_cutoff);
        }
        if let Some(pixels) = footprints.add(simd, voxel, tile, sheet) {
            tile.put_box_behind(simd, stage.plan.compositing, sheet, &pixels);
        }
    }
    tile.close_saturated_blocks(stage.plan.opacity_cutoff);
}

impl Buffers {
    pub(crate) fn resident_bytes(&self) -> usize {
        self.voxels.capacity() * size_of::<Voxel<()>>()
            + self.order.resident_bytes()
            + self.splats.resident_bytes()
            + self.sheets.sum_of(|_| Sheet::BYTES)
    }
}
