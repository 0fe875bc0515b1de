//! The traditional sheet buffer (§3.1): whole footprints summed in the grid's slices. It pops when the
//! view passes 45°, which is why the paper was written.

use crate::composite::Composite;
use crate::frame::Stage;
use crate::splat::{Footprint, Sample, splat};
use crate::tile::{Scratch, Tile, TileStats};
use slabsplat_core::SliceOrder;
use slabsplat_kernel::{FootprintTable, lerp_radial};
use slabsplat_traverse::{TileBuckets, TileRect};

/// Tosses every voxel onto the tiles that its footprint touches.
pub(crate) fn toss(stage: &Stage<'_>) -> TileBuckets {
    TileBuckets::toss(&stage.tiles, stage.points.len(), |voxel| touched(stage, voxel))
}

/// The tiles that a voxel's whole footprint touches; `None` if it lies before the near plane.
pub(crate) fn touched(stage: &Stage<'_>, voxel: usize) -> Option<TileRect> {
    let point = stage.points[voxel];
    if point[2] < stage.raster.near {
        return None;
    }
    let [min, max] = stage.raster.bounds(&stage.raster.shape_at(point[2].into()), point);
    stage.tiles.touched(min, max)
}

/// The sheet of every voxel, by its place in the list.
pub(crate) fn sheets(stage: &Stage<'_>, order: &SliceOrder) -> Vec<u32> {
    let mut sheets = vec![0; stage.voxels.len()];
    stage.voxels.fill_by_brick(&mut sheets, |brick, records, sheets| {
        for (sheet, &record) in sheets.iter_mut().zip(records) {
            *sheet = order.sheet_of(stage.voxels.voxel_coords(brick, record)) as u32;
        }
    });
    sheets
}

/// Splats and composites the tile's slices, front to back, until the tile is full.
pub(crate) fn render_tile<C: Composite>(
    stage: &Stage<'_>,
    sheets: &[u32],
    table: &FootprintTable,
    tile: &mut Tile,
    scratch: &mut Scratch,
) -> TileStats {
    let Scratch { splats, buckets, sheet, .. } = scratch;
    let mut stats = TileStats::default();
    buckets.toss(splats, |voxel| sheets[voxel as usize] as usize);
    let Some([first, last]) = buckets.slab_range() else { return stats };
    sheet.resize(tile.side);
    for slice in first..=last {
        for &voxel in buckets.starting_in(slice, slice) {
            let point = stage.points[voxel as usize];
            let shape = stage.raster.shape_at(point[2].into());
            let color = stage.colors[voxel as usize].map(|channel| channel * shape.gain);
            let footprint =
                Footprint::whole(stage, table, tile, stage.raster.pixel_of(&shape, point));
            if footprint.is_open(&tile.open, &shape) {
                let weight = |at: Sample| lerp_radial(table.row(), at.position);
                splat(sheet, &tile.open, &shape, &footprint, color, weight);
                stats.n_splats += 1;
            } else {
                stats.n_culled += 1;
            }
        }
        tile.put_behind::<C>(sheet);
        stats.is_full = tile.close(stage.plan.opacity_cutoff);
        if stats.is_full {
            stats.n_culled += buckets.starting_in(slice + 1, last).len() as u64;
            break;
        }
    }
    stats
}

impl Footprint {
    /// A whole footprint whose centre lies at `[x, y]` pixels from the image's upper left corner.
    pub(crate) fn whole(
        stage: &Stage<'_>,
        table: &FootprintTable,
        tile: &Tile,
        [x, y]: [f32; 2],
    ) -> Self {
        Self {
            center: [x - tile.origin[0] as f32, y - tile.origin[1] as f32],
            radius: stage.raster.radius,
            rho_max: stage.raster.radius,
            samples_per_index: table.samples_per_index(),
        }
    }
}
