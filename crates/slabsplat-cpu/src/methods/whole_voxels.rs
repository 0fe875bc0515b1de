//! What the two traditional methods share: all relevant voxels at once, tossed by their whole footprints.

use super::Stage;
use crate::voxels::voxel::Voxel;
use slabsplat_core::Cancelled;
use slabsplat_traverse::{BRICK_SIDE, TileBuckets, TileGrid, TileRect, resize_for_frame};

const VOXELS_PER_BRICK: usize = BRICK_SIDE * BRICK_SIDE * BRICK_SIDE;

/// Shades and projects all relevant voxels; `sheet_of` returns the sheet of a voxel by its coordinates.
pub(super) fn shade<S: Copy + Default + Send + Sync>(
    stage: &Stage<'_>,
    sheet_of: impl Fn([usize; 3]) -> S + Sync,
    voxels: &mut Vec<Voxel<S>>,
) -> Result<(), Cancelled> {
    let Stage { bricks, lighting, frame, .. } = stage;
    let list = stage.list();
    resize_for_frame(voxels, list.len(), frame)?;
    list.fill_by_brick(voxels, |brick, records, voxels| {
        if frame.is_cancelled() {
            return;
        }
        let mut points = [[0.0; 3]; VOXELS_PER_BRICK];
        bricks.project_brick(brick, records, &mut points[..records.len()]);
        let mut colors = [[0.0; 4]; VOXELS_PER_BRICK];
        lighting.shade_brick(brick, records, &mut colors[..records.len()]);
        let shaded = points.into_iter().zip(colors);
        for ((voxel, &record), (point, color)) in voxels.iter_mut().zip(records).zip(shaded) {
            let sheets = sheet_of(list.voxel_coords(brick, record));
            *voxel = Voxel { point, sheets, color };
        }
    });
    frame.check()
}

/// Tosses `n_splats` voxels onto the tiles that their footprints touch, in the order in which `point` returns
/// where they are.
pub(super) fn toss(
    Stage { raster, frame, .. }: &Stage<'_>,
    tiles: &TileGrid,
    n_splats: usize,
    point: impl Fn(usize) -> [f32; 3] + Sync,
    splats: &mut TileBuckets,
) -> Result<(), Cancelled> {
    let rect_of = |splat| {
        let point = point(splat);
        if point[2] < raster.near {
            return TileRect::EMPTY;
        }
        let [min, max] = raster.bounds(&raster.shape_at(point[2].into())).at(point);
        tiles.pixels_within(min, max).map_or(TileRect::EMPTY, |pixels| tiles.tiles_of(&pixels))
    };
    splats.toss(tiles, n_splats, rect_of, frame)
}
