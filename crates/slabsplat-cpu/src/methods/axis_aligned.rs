//! The traditional sheet buffer (§3.1): whole footprints summed in the grid's slices. It pops when the
//! view passes 45°, which is why the paper was written.

use super::{Stage, whole_voxels};
use crate::footprints::polynomials::FootprintPolynomials;
use crate::footprints::whole::WholeFootprints;
use crate::pixels::sheet::Sheet;
use crate::pixels::tile::Tile;
use crate::pixels::tiles::Tiles;
use crate::progress::Progress;
use crate::stopwatch::Stopwatch;
use crate::voxels::by_sheet::BySheet;
use crate::voxels::voxel::Voxel;
use fearless_simd::{Simd, dispatch};
use slabsplat_core::{Cancelled, SliceOrder};
use slabsplat_kernel::FootprintTable;
use slabsplat_traverse::{TileBuckets, Workspaces};
use std::sync::Arc;

/// What is cached from frame to frame.
#[derive(Debug, Default)]
pub(crate) struct Buffers {
    polynomials: FootprintPolynomials,
    /// All relevant voxels, each with its slice.
    voxels: Vec<Voxel<u32>>,
    splats: TileBuckets,
    workspaces: Workspaces<Workspace>,
}

/// What a thread needs.
#[derive(Debug, Default)]
struct Workspace {
    /// Voxels of a tile.
    voxels: BySheet<Voxel<u32>>,
    /// Empty between tiles.
    sheet: Sheet,
}

/// Renders into empty tiles.
pub(crate) fn render(
    stage: &Stage<'_>,
    order: &SliceOrder,
    table: &Arc<FootprintTable>,
    tiles: &mut Tiles,
    Buffers { polynomials, voxels, splats, workspaces }: &mut Buffers,
    watch: &mut Stopwatch<'_>,
) -> Result<(), Cancelled> {
    whole_voxels::shade(stage, |coords| order.sheet_of(coords) as u32, voxels)?;
    watch.done("shade")?;
    let point = |splat: usize| voxels[splat].point;
    whole_voxels::toss(stage, &tiles.grid, voxels.len(), point, splats)?;
    watch.done("toss")?;
    let polynomials = polynomials.of(table);
    let footprints = WholeFootprints { raster: &stage.raster, polynomials };
    tiles.for_each(Progress::of_all(stage.frame), workspaces, |tile_idx, tile, workspace| {
        let here = splats.on_tile(tile_idx).map(|splat| std::slice::from_ref(&voxels[splat]));
        let slice_of = |voxel: &Voxel<u32>| (0, voxel.sheets as usize);
        workspace.voxels.sort(1, 0..order.n_slices, here, slice_of, stage.frame);
        dispatch!(stage.level, simd => render_slices(simd, stage, &footprints, tile, workspace));
    });
    watch.done("splat")
}

/// Splats and composites the slices of a tile's voxels, front to back, until the tile is saturated.
#[inline(always)]
fn render_slices<S: Simd>(
    simd: S,
    stage: &Stage<'_>,
    footprints: &WholeFootprints<'_>,
    tile: &mut Tile,
    Workspace { voxels, sheet }: &mut Workspace,
) {
    let slices = voxels.sheets();
    for slice in slices.clone() {
        if stage.frame.is_cancelled() {
            break;
        }
        for voxel in voxels.starting_in(0, slice..slice + 1).iter() {
            footprints.add(simd, voxel, tile, sheet);
        }
        tile.put_behind(simd, stage.plan.compositing, sheet, stage.plan.opacity_cutoff);
        if tile.is_saturated() {
            tile.stats.n_culled += voxels.starting_in(0, slice + 1..slices.end).len as u64;
            break;
        }
    }
}

impl Buffers {
    pub(crate) fn resident_bytes(&self) -> usize {
        self.voxels.capacity() * size_of::<Voxel<u32>>()
            + self.splats.resident_bytes()
            + self.workspaces.sum_of(|w| w.voxels.resident_bytes() + Sheet::BYTES)
    }
}
