//! The traditional sheet buffer (§3.1): whole footprints summed in the grid's slices. It pops when the
//! view passes 45°, which is why the paper was written.

use crate::frame::Stage;
use crate::tile::Tile;
use crate::voxel::Voxel;
use crate::whole::Whole;
use crate::workspace::Workspace;
use fearless_simd::{Simd, dispatch};

/// Splats and composites the slices of a tile's voxels, front to back, until the tile is full.
pub(crate) fn render_tile<'a>(
    stage: &Stage<'_>,
    whole: &Whole<'_>,
    n_slices: usize,
    voxels: impl Iterator<Item = &'a Voxel> + Clone,
    tile: &mut Tile,
    workspace: &mut Workspace,
) {
    let runs = voxels.map(std::slice::from_ref);
    workspace.voxels.sort(1, 0..n_slices, runs, |voxel| (0, voxel.sheets as usize));
    dispatch!(stage.level, simd => render_slices(simd, stage, whole, tile, workspace));
}

#[inline(always)]
fn render_slices<S: Simd>(
    simd: S,
    stage: &Stage<'_>,
    whole: &Whole<'_>,
    tile: &mut Tile,
    Workspace { voxels, sheet, .. }: &mut Workspace,
) {
    let slices = voxels.sheets();
    for slice in slices.clone() {
        for voxel in voxels.starting_in(0, slice..slice + 1).iter() {
            whole.splat(simd, &voxel, tile, sheet);
        }
        tile.put_behind(simd, stage.plan.compositing, sheet, stage.plan.opacity_cutoff);
        if tile.is_full() {
            tile.stats.n_culled += voxels.starting_in(0, slice + 1..slices.end).len as u64;
            break;
        }
    }
}
