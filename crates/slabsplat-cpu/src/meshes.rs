//! Opaque meshes, rasterised into the tiles: where the rays of samples end (model §14).

use crate::pixels::surfaces::Surfaces;
use crate::pixels::tiles::Tiles;
use crate::stopwatch::Stopwatch;
use slabsplat_backend::MeshesPlan;
use slabsplat_core::Cancelled;
use slabsplat_mesh::Rasterizer;

/// Notes in all tiles where rays end.
pub(crate) fn render(
    plan: Option<&MeshesPlan<'_>>,
    tiles: &mut Tiles,
    rasterizer: &mut Rasterizer,
    watch: &mut Stopwatch<'_>,
) -> Result<(), Cancelled> {
    let Some(plan) = plan else {
        tiles.tiles.iter_mut().for_each(|tile| tile.surfaces = Surfaces::default());
        *rasterizer = Rasterizer::default();
        return Ok(());
    };
    let border = tiles.grid.border();
    let plan = (plan, watch.frame());
    rasterizer.for_each_tile(plan, &tiles.grid, &mut tiles.tiles, |tile, hits| {
        tile.surfaces.clear();
        hits.for_each_pixel(|pixel, hits| {
            tile.surfaces.add(pixel.map(|at| border + at), hits);
        });
        tile.surfaces.finish();
    })?;
    watch.done("meshes")
}
