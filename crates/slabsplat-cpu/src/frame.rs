//! One frame from plan to picture: the stages, in their order.

use crate::composite::{Associated, Composite, Extinction, Separate};
use crate::raster::Raster;
use crate::relevant::Relevant;
use crate::stopwatch::Stopwatch;
use crate::tile::{Scratch, TILE_SIDE, Tile, TileStats};
use crate::{axis_aligned, every_sample, image_aligned, post_classified};
use rayon::prelude::*;
use slabsplat_backend::{Frame, FrameCost, FramePlan, FrameStats, Splats};
use slabsplat_core::{Compositing, Image};
use slabsplat_traverse::{
    ShadeDesc, TileBuckets, TileGrid, VoxelRecord, depth_order, project, shade,
};

/// What is kept from frame to frame.
#[derive(Debug, Default)]
pub(crate) struct Buffers {
    relevant: Relevant,
    colors: Vec<[f32; 4]>,
    points: Vec<[f32; 3]>,
    densities: post_classified::Buffers,
}

/// The shaded and projected voxels of a frame, before the image.
pub(crate) struct Stage<'a> {
    pub(crate) plan: &'a FramePlan<'a>,
    pub(crate) voxels: &'a [VoxelRecord],
    /// What a sheet sums, per voxel.
    pub(crate) colors: &'a [[f32; 4]],
    /// Right, up, depth from the grid's centre, per voxel.
    pub(crate) points: &'a [[f32; 3]],
    pub(crate) raster: Raster,
    pub(crate) tiles: TileGrid,
}

pub(crate) fn render(plan: &FramePlan<'_>, buffers: &mut Buffers) -> Frame {
    if let Splats::Densities { slabs, table } = &plan.splats {
        return post_classified::render(plan, slabs, table, &mut buffers.densities);
    }
    let Buffers { relevant, colors, points, .. } = buffers;
    let mut watch = Stopwatch::start();
    let voxels = relevant.voxels(plan.volume, &plan.relevant);
    watch.done("list");
    let desc = ShadeDesc {
        transfer: plan.transfer,
        shading: &plan.shading,
        forward: plan.view.axes().forward,
        compositing: plan.compositing,
    };
    shade(&desc, plan.volume, voxels, colors);
    watch.done("shade");
    project(plan.volume.grid(), &plan.view, voxels, points);
    watch.done("project");
    let stage = Stage {
        plan,
        voxels,
        colors,
        points,
        raster: Raster::new(plan),
        tiles: TileGrid::new(plan.view.image_size(), TILE_SIDE),
    };
    let (image, stats) = match plan.compositing {
        Compositing::Separate => stage.render_with::<Separate>(&mut watch),
        Compositing::Associated => stage.render_with::<Associated>(&mut watch),
        Compositing::Extinction => stage.render_with::<Extinction>(&mut watch),
    };
    let cost = FrameCost { stages: watch.stages(), resident_bytes: buffers.resident_bytes() };
    Frame { image, stats, cost }
}

impl Buffers {
    fn resident_bytes(&self) -> u64 {
        let Self { relevant, colors, points, .. } = self;
        let bytes = relevant.resident_bytes()
            + colors.capacity() * size_of::<[f32; 4]>()
            + points.capacity() * size_of::<[f32; 3]>();
        bytes as u64
    }
}

impl Stage<'_> {
    fn render_with<C: Composite>(&self, watch: &mut Stopwatch) -> (Image, FrameStats) {
        let drawn = match &self.plan.splats {
            Splats::Sections { slabs, table } => {
                let splats = image_aligned::toss(self, slabs);
                watch.done("toss");
                self.render_tiles(&splats, |tile, scratch| {
                    image_aligned::render_tile::<C>(self, slabs, table, tile, scratch)
                })
            }
            Splats::Slices { order, table } => {
                let splats = axis_aligned::toss(self);
                watch.done("toss");
                self.render_tiles(&splats, |tile, scratch| {
                    axis_aligned::render_tile::<C>(self, order, table, tile, scratch)
                })
            }
            Splats::Voxels { table } => {
                let grid = self.plan.volume.grid();
                let order = depth_order(grid, &self.plan.view, self.voxels);
                watch.done("sort");
                let splats = every_sample::toss(self, &order);
                watch.done("toss");
                self.render_tiles(&splats, |tile, scratch| {
                    every_sample::render_tile::<C>(self, &order, table, tile, scratch)
                })
            }
            Splats::Densities { .. } => {
                unreachable!("bug: densities have no colours to be splatted")
            }
        };
        watch.done("splat");
        drawn
    }

    /// Renders every tile that has splats, the fullest first, and puts them together.
    fn render_tiles(
        &self,
        splats: &TileBuckets,
        render_tile: impl Fn(&mut Tile, &mut Scratch) -> TileStats + Sync,
    ) -> (Image, FrameStats) {
        let load = |&tile_idx: &usize| std::cmp::Reverse(splats.n_on_tile(tile_idx));
        let mut tile_idxs: Vec<usize> =
            (0..self.tiles.n_tiles()).filter(|&idx| 0 < splats.n_on_tile(idx)).collect();
        tile_idxs.sort_by_cached_key(load);
        let tiles: Vec<(Tile, TileStats)> = tile_idxs
            .into_par_iter()
            .with_max_len(1)
            .map_init(Scratch::default, |scratch, tile_idx| {
                let mut tile = Tile::new(&self.tiles, tile_idx, self.plan.view.image_size());
                scratch.splats.clear();
                scratch.splats.extend(splats.on_tile(tile_idx));
                let stats = render_tile(&mut tile, scratch);
                (tile, stats)
            })
            .collect();
        self.assemble(&tiles)
    }

    fn assemble(&self, tiles: &[(Tile, TileStats)]) -> (Image, FrameStats) {
        let [width, height] = self.plan.view.image_size();
        let mut image = Image::filled(width, height, [0.0; 4]);
        let mut stats = FrameStats {
            n_voxels: self.points.len() as u64,
            n_tiles: tiles.len() as u64,
            ..FrameStats::default()
        };
        for (tile, tile_stats) in tiles {
            tile.copy_to(&mut image);
            stats.n_splats += tile_stats.n_splats;
            stats.n_culled += tile_stats.n_culled;
            stats.n_full_tiles += u64::from(tile_stats.is_full);
        }
        image.lay_over(self.plan.image.background);
        (image, stats)
    }
}
