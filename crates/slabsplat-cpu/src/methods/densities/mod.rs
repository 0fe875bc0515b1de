//! Splatting without the blur (Mueller, Möller & Crawfis, IEEE Visualization '99): sheets hold densities,
//! which are classified and shaded pixel by pixel. Model §8.
//!
//! ```text
//! for each tile, in parallel:
//!     for each slab from the eye:
//!         add the slab's sections: length += H, weighted value += H·v
//!         for each open pixel of the slab before:
//!             density = weighted value / length; opacity by the transfer function
//!             if there is any: gradient from this sheet and both its neighbours, light, composite
//! ```
//!
//! 1. A voxel is splatted only if it has a part in a pixel that may show (`selection`).
//! 2. A tile is summed with a border of one pixel, for the gradients. That is a seventh more at 32 pixels a
//!    side, and tiles need nothing of each other.
//! 3. A sheet has two numbers a pixel, and three sheets of a tile take 28 KiB.
//!
//! The price: every pixel and slab that shows is shaded, which in a haze is far more than there are voxels.
//!
//! What is shared with the other methods is where a footprint lies (`raster`), the toss, tiles and the light:
//! their sheets hold colours.
//!
//! # Reading order
//!
//! `selection` and `margin`; `values`, `voxel`; `summed`, `sheet`; `classify`, `gradient`, `rays`;
//! `density_frame`, `tile`.

mod margin;
mod selection;
mod values;
mod voxel;

mod sheet;
mod summed;

mod classify;
mod gradient;
mod rays;

mod density_frame;
mod tile;

#[cfg(test)]
mod tests;

use crate::pixels::tiles::Tiles;
use crate::stopwatch::Stopwatch;
use crate::workspaces::Workspaces;
use classify::ranges_with_room;
use density_frame::DensityFrame;
use slabsplat_backend::{ByIdentity, Cached, DensitySplats, FramePlan};
use slabsplat_core::{IsoRange, Volume};
use slabsplat_traverse::TileBuckets;
use tile::Workspace;
use values::finite_range;
use voxel::DensityVoxel;

/// What is cached from frame to frame.
#[derive(Debug, Default)]
pub(crate) struct Buffers {
    finite: Cached<ByIdentity<Volume>, Option<[f64; 2]>>,
    /// Places in memory of the voxels that were selected.
    selected: Cached<SelectedBy, Vec<u32>>,
    tossed: Tossed,
    workspaces: Workspaces<Workspace>,
}

/// What a selection of voxels depends on: the volume, the visible ranges, and the margin.
type SelectedBy = (ByIdentity<Volume>, Vec<IsoRange>, [usize; 3]);

/// The voxels that are splatted, and the tiles on which each falls.
#[derive(Debug, Default)]
struct Tossed {
    voxels: Vec<DensityVoxel>,
    by_tile: TileBuckets,
}

/// Renders into empty tiles; returns how many voxels may have a part in what is seen.
pub(crate) fn render(
    plan: &FramePlan<'_>,
    splats: &DensitySplats,
    tiles: &mut Tiles,
    buffers: &mut Buffers,
    watch: &mut Stopwatch,
) -> u64 {
    let Buffers { finite, selected, tossed, workspaces } = buffers;
    let finite = *finite.made_of(ByIdentity::of(plan.volume), |_| finite_range(plan.volume));
    let frame = DensityFrame::new(plan, splats, finite);
    let ranges = ranges_with_room(plan, &frame.scale);
    let margin = margin::margin(plan, &frame.raster, &frame.slabs.grid);
    let selected_by = (ByIdentity::of(plan.volume), ranges, margin);
    let selected = selected.made_of(selected_by, |(_, ranges, margin)| {
        selection::select(plan.volume, ranges, *margin)
    });
    watch.done("list");
    draw(&frame, selected, tiles, tossed, workspaces, watch);
    selected.len() as u64
}

/// Draws the selected voxels, given by their places in memory.
fn draw(
    frame: &DensityFrame<'_>,
    selected: &[u32],
    tiles: &mut Tiles,
    Tossed { voxels, by_tile }: &mut Tossed,
    workspaces: &mut Workspaces<Workspace>,
    watch: &mut Stopwatch,
) {
    voxel::project(frame.plan, &frame.scale, selected, voxels);
    watch.done("project");
    by_tile.toss(&tiles.grid, voxels.len(), |voxel| frame.tiles_of(&voxels[voxel], &tiles.grid));
    watch.done("toss");
    tiles.for_each(workspaces, |tile_idx, tile, workspace| {
        let runs = by_tile.on_tile(tile_idx).map(|voxel| std::slice::from_ref(&voxels[voxel]));
        let first_slab = |voxel: &DensityVoxel| frame.slabs_of(voxel)[0];
        let first_slabs = runs.clone().flatten().map(first_slab);
        let ends = first_slabs.clone().min().zip(first_slabs.max());
        let first_slabs = ends.map_or(0..0, |(first, last)| first..last + 1);
        workspace.voxels.sort(1, first_slabs, runs, |voxel| (0, first_slab(voxel)));
        frame.render_tile(tile, workspace);
    });
    watch.done("splat");
}

impl Buffers {
    pub(crate) fn resident_bytes(&self) -> usize {
        self.selected.value().map_or(0, |voxels| size_of_val(&voxels[..]))
            + self.tossed.voxels.capacity() * size_of::<DensityVoxel>()
            + self.tossed.by_tile.resident_bytes()
            + self.workspaces.sum_of(Workspace::resident_bytes)
    }
}
