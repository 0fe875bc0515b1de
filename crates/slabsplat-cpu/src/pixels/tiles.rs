//! The image as tiles, retained from frame to frame.

use super::rectangle::TILE_SIDE;
use super::tile::Tile;
use crate::progress::Progress;
use rayon::prelude::*;
use slabsplat_backend::FrameStats;
use slabsplat_core::{Cancelled, FrameHandle, Image};
use slabsplat_traverse::{TileGrid, Workspaces};
use std::sync::atomic::{AtomicUsize, Ordering};

/// All tiles of an image, row by row.
#[derive(Debug)]
pub(crate) struct Tiles {
    pub(crate) grid: TileGrid,
    pub(crate) tiles: Vec<Tile>,
    image_size: [u32; 2],
}

impl Tiles {
    /// Tiles with `border` pixels of their neighbours' on each side.
    pub(crate) fn new(
        image_size: [u32; 2],
        border: usize,
        frame: &FrameHandle,
    ) -> Result<Self, Cancelled> {
        let grid = TileGrid::new(image_size, TILE_SIDE, border);
        let mut tiles = Vec::with_capacity(grid.n_tiles());
        for tile_idx in 0..grid.n_tiles() {
            frame.check()?;
            tiles.push(Tile::new(grid.origin(tile_idx), image_size, border));
        }
        Ok(Self { grid, tiles, image_size })
    }

    /// Makes them empty again, unless nobody wants them.
    pub(crate) fn clear(&mut self, frame: &FrameHandle) {
        self.tiles.par_iter_mut().filter(|_| !frame.is_cancelled()).for_each(Tile::clear);
    }

    /// Puts what is in front of all into empty tiles, and closes what is saturated by that.
    pub(crate) fn begin_with(&mut self, in_front: &Image, cutoff: f32) {
        self.tiles.par_iter_mut().for_each(|tile| tile.begin_with(in_front, cutoff));
    }

    /// Makes their pixels empty again; what was counted stays.
    pub(crate) fn reopen(&mut self) {
        self.tiles.par_iter_mut().for_each(Tile::reopen);
    }

    /// Ends all rays at surfaces before a depth, where nothing is left to be composited before that.
    pub(crate) fn end_rays_before(&mut self, depth: f32, cutoff: f32) {
        if self.tiles.iter().any(|tile| tile.surfaces.any_before(depth)) {
            self.tiles.par_iter_mut().for_each(|tile| tile.end_rays_before(depth, cutoff));
        }
    }

    /// Calls `work` with every tile, in parallel, until the frame is cancelled.
    pub(crate) fn for_each<W: Default + Send>(
        &mut self,
        progress: Progress<'_>,
        workspaces: &mut Workspaces<W>,
        work: impl Fn(usize, &mut Tile, &mut W) + Sync,
    ) {
        let mut nothing = vec![(); self.tiles.len()];
        let work = |tile_idx, tile: &mut Tile, (): &mut (), workspace: &mut W| {
            work(tile_idx, tile, workspace);
        };
        self.for_each_with(progress, &mut nothing, workspaces, work);
    }

    /// The same, with something more of each tile.
    pub(crate) fn for_each_with<T: Send, W: Default + Send>(
        &mut self,
        progress: Progress<'_>,
        of_tiles: &mut [T],
        workspaces: &mut Workspaces<W>,
        work: impl Fn(usize, &mut Tile, &mut T, &mut W) + Sync,
    ) {
        let workspaces = workspaces.for_all_threads();
        let (n_tiles, n_done) = (self.tiles.len(), AtomicUsize::new(0));
        let tiles = self.tiles.par_iter_mut().zip(of_tiles).enumerate().with_max_len(1);
        tiles.for_each(|(tile_idx, (tile, of_tile))| {
            if progress.frame.is_cancelled() {
                return;
            }
            work(tile_idx, tile, of_tile, &mut workspaces.of_this_thread());
            progress.part(n_done.fetch_add(1, Ordering::Relaxed), n_tiles).finish();
        });
    }

    /// The picture, before what is `behind` it; of no meaning if the frame is cancelled.
    pub(crate) fn image(&self, behind: [f32; 4], frame: &FrameHandle) -> Image {
        let [width, height] = self.image_size;
        let mut image = Image::filled(width, height, [0.0; 4]);
        let rows = image.pixels_mut().par_chunks_mut(width as usize * self.grid.step() as usize);
        rows.zip(self.tiles.par_chunks(self.grid.n_x)).for_each(|(rows, tiles)| {
            let wanted = tiles.iter().take_while(|_| !frame.is_cancelled());
            wanted.for_each(|tile| tile.copy_to(rows, width as usize, behind));
        });
        image
    }

    /// What was drawn, but for what does not concern tiles.
    pub(crate) fn stats(&self) -> FrameStats {
        let mut stats = FrameStats::default();
        for tile in &self.tiles {
            stats.n_splats += tile.stats.n_splats;
            stats.n_culled += tile.stats.n_culled;
            stats.n_tiles += u64::from(0 < tile.stats.n_splats);
            stats.n_saturated_tiles += u64::from(tile.is_saturated());
        }
        stats
    }

    pub(crate) fn resident_bytes(&self) -> usize {
        let bytes = |tile: &Tile| {
            size_of::<Tile>() + size_of_val(&*tile.pixels) + tile.surfaces.resident_bytes()
        };
        self.tiles.iter().map(bytes).sum()
    }
}
