//! Opaque meshes, rasterised into the tiles: where the rays of samples end (model §14).

use crate::pixels::surfaces::Surfaces;
use crate::pixels::tiles::Tiles;
use crate::stopwatch::Stopwatch;
use crate::workspaces::Workspaces;
use slabsplat_backend::MeshesPlan;
use slabsplat_mesh::{Rasterizer, TileHits};

/// What is cached from frame to frame.
#[derive(Debug, Default)]
pub(crate) struct Buffers {
    rasterizer: Rasterizer,
    workspaces: Workspaces<TileHits>,
}

/// Notes in all tiles where rays end.
pub(crate) fn render(
    plan: Option<&MeshesPlan<'_>>,
    tiles: &mut Tiles,
    buffers: &mut Buffers,
    watch: &mut Stopwatch,
) {
    let Some(plan) = plan else {
        tiles.tiles.iter_mut().for_each(|tile| tile.surfaces = Surfaces::default());
        *buffers = Buffers::default();
        return;
    };
    let Buffers { rasterizer, workspaces } = buffers;
    rasterizer.start(plan, &tiles.grid);
    let rasterizer = &*rasterizer;
    tiles.for_each(workspaces, |tile_idx, tile, hits| {
        let (pixels, first) = tile.own_pixels();
        tile.surfaces.clear();
        rasterizer.hits_on_tile(plan, tile_idx, &pixels, hits, |at, hits| {
            tile.surfaces.add([0, 1].map(|axis| first[axis] + at[axis]), hits);
        });
        tile.surfaces.finish();
    });
    watch.done("meshes");
}

impl Buffers {
    pub(crate) fn resident_bytes(&self) -> usize {
        self.rasterizer.resident_bytes() + self.workspaces.sum_of(TileHits::resident_bytes)
    }
}
