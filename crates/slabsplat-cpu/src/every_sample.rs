//! The original method (§1): whole footprints, composited one voxel at a time. There are no sheets; each
//! footprint's pixels go straight behind the tile's.

use crate::axis_aligned::touched;
use crate::composite::Composite;
use crate::frame::Stage;
use crate::splat::{Footprint, for_each_run};
use crate::tile::{Scratch, Tile, TileStats, put_behind};
use slabsplat_kernel::{FootprintTable, lerp_radial};
use slabsplat_traverse::TileBuckets;

/// Voxels between two looks at which pixels are full: a look costs about as much as a voxel.
const LOOK_EVERY: u64 = 256;

/// Tosses the voxels, in their `order`, onto the tiles that their footprints touch. A splat is a place
/// in the order.
pub(crate) fn toss(stage: &Stage<'_>, order: &[u32]) -> TileBuckets {
    TileBuckets::toss(&stage.tiles, order.len(), |place| touched(stage, order[place] as usize))
}

/// Composites the tile's voxels, front to back, until the tile is full.
pub(crate) fn render_tile<C: Composite>(
    stage: &Stage<'_>,
    order: &[u32],
    table: &FootprintTable,
    tile: &mut Tile,
    scratch: &mut Scratch,
) -> TileStats {
    let mut stats = TileStats::default();
    for &place in &scratch.splats {
        let voxel = order[place as usize] as usize;
        let point = stage.points[voxel];
        let shape = stage.raster.shape_at(point[2].into());
        let color = stage.colors[voxel].map(|channel| channel * shape.gain);
        let footprint = Footprint::whole(stage, table, tile, stage.raster.pixel_of(&shape, point));
        let Tile { open, pixels, side, .. } = tile;
        for_each_run(open, &shape, &footprint, |run| {
            let pixels = &mut pixels[run.row * *side..][run.columns.clone()];
            for (column, pixel) in pixels.iter_mut().enumerate() {
                let weight = lerp_radial(table.row(), run.sample(column).position);
                put_behind(pixel, C::resolve(color.map(|channel| weight * channel)));
            }
        });
        stats.n_splats += 1;
        if stats.n_splats % LOOK_EVERY == 0 {
            stats.is_full = tile.close(stage.plan.opacity_cutoff);
            if stats.is_full {
                stats.n_culled = scratch.splats.len() as u64 - stats.n_splats;
                break;
            }
        }
    }
    stats
}
