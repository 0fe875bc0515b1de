//! Splatting without the blur (Mueller, Möller & Crawfis, IEEE Visualization '99): sheets hold densities, which are
//! classified and shaded pixel by pixel. `docs/algorithm.md` has the model.
//!
//! ```text
//! for each tile, in parallel:
//!     for each slab from the eye:
//!         splat the slab's sections: length += H, weighted value += H·v
//!         for each open pixel of the slab before:
//!             density = weighted value / length; opacity by the transfer function
//!             if there is any: gradient from this sheet and both its neighbours, light, composite
//! ```
//!
//! 1. A voxel is splatted only if it has a part in a pixel that may show (`selection`).
//! 2. A tile is summed with a border of one pixel, for the gradients. That is a seventh more at 32 pixels a side, and
//!    tiles need nothing of each other.
//! 3. A sheet has two numbers a pixel, and three sheets of a tile take 28 KiB.
//!
//! The price: every pixel and slab that shows is shaded, which in a haze is far more than there are voxels.
//!
//! What is shared with the other methods is where a footprint lies (`raster`), and the toss: their sheets hold colours.
//!
//! # Reading order
//!
//! `selection` and `margin`; `values`; `buckets`; `tile`, `sheet`, `open`; `classify`, `gradient`, `rays`.

mod margin;
mod selection;
mod values;

mod buckets;

mod open;
mod sheet;
mod tile;

mod classify;
mod gradient;
mod rays;

#[cfg(test)]
mod tests;

use crate::raster::Raster;
use crate::stopwatch::Stopwatch;
use crate::workspace::Workspaces;
use classify::{Classifier, ranges_with_room};
use gradient::Spacing;
use rayon::prelude::*;
use rays::Rays;
use slabsplat_backend::{Frame, FrameCost, FramePlan, FrameStats};
use slabsplat_core::glam::DVec3;
use slabsplat_core::{Image, IsoRange, SlabGrid, Volume, over};
use slabsplat_kernel::CubicSectionTable;
use slabsplat_traverse::{TileBuckets, TileGrid, TileRect};
use std::sync::Arc;
use tile::{Tile, Workspace};
use values::{ValueScale, finite_range};

/// Pixels along the side of a tile.
const TILE_SIDE: usize = 32;

const PIXELS_PER_TILE: usize = TILE_SIDE * TILE_SIDE;

/// Pixels around a tile that are summed with it.
const BORDER: f32 = 1.0;

/// A gradient counts in full from this part of the range of values on, per `unit`: less is the noise of a plateau,
/// and a normal must not turn about within it.
const FAINT_GRADIENT: f64 = 1.0 / 256.0;

/// What is kept from frame to frame.
#[derive(Debug, Default)]
pub(crate) struct Buffers {
    of: Option<OfVolume>,
    points: Vec<[f32; 3]>,
    values: Vec<f32>,
    splats: TileBuckets,
    /// Of all tiles, one after the other.
    pixels: Vec<[f32; 4]>,
    workspaces: Workspaces<Workspace>,
}

#[derive(Debug)]
struct OfVolume {
    volume: Arc<Volume>,
    finite: Option<[f64; 2]>,
    /// The voxels selected for the last ranges and margin.
    voxels: Vec<u32>,
    selected_by: Option<(Vec<IsoRange>, [usize; 3])>,
}

/// A frame before its image.
struct Stage<'a> {
    plan: &'a FramePlan<'a>,
    slabs: &'a SlabGrid,
    table: &'a CubicSectionTable,
    raster: Raster,
    rays: Rays,
    tiles: TileGrid,
    classifier: Classifier<'a>,
    /// A kernel that is k slabs thick meets up to ⌈k⌉ + 1 of them: so many before the one in which it ends.
    n_slabs_before: usize,
    /// Of a gradient, see [`FAINT_GRADIENT`]; scaled, per world unit.
    faint: f64,
    /// Right, up, depth from the grid's centre, per voxel.
    points: &'a [[f32; 3]],
    /// Per voxel, scaled.
    values: &'a [f32],
}

pub(crate) fn render(
    plan: &FramePlan<'_>,
    slabs: &SlabGrid,
    table: &CubicSectionTable,
    buffers: &mut Buffers,
) -> Frame {
    let mut watch = Stopwatch::start();
    let raster = Raster::new(plan);
    let Buffers { of, points, values, splats, pixels, workspaces } = buffers;
    let of = of_volume(of, plan.volume);
    let scale = ValueScale::new(of.finite, plan.transfer);
    of.select(ranges_with_room(plan, &scale), margin::margin(plan, &raster, slabs));
    watch.done("list");
    place(plan, &of.voxels, points);
    let value = |&voxel_idx: &u32| scale.scaled(plan.volume.value(voxel_idx as usize));
    of.voxels.par_iter().with_min_len(1 << 12).map(value).collect_into_vec(values);
    watch.done("project");
    let range = of.finite.map_or(0.0, |range| scale.extent(range));
    let stage = Stage {
        plan,
        slabs,
        table,
        raster,
        rays: Rays::new(&plan.view),
        tiles: TileGrid::new(plan.view.image_size(), TILE_SIDE),
        classifier: Classifier::new(plan, scale),
        n_slabs_before: (2.0 * f64::from(raster.reach) / slabs.thickness()).ceil() as usize,
        // Never 0, which a gradient of 0 would be divided by.
        faint: (FAINT_GRADIENT * range / plan.volume.grid().unit()).max(f64::MIN_POSITIVE),
        points,
        values,
    };
    splats.toss(&stage.tiles, points.len(), |voxel| stage.tiles_of(voxel as u32));
    watch.done("toss");
    let stats = stage.render(splats, pixels, workspaces);
    watch.done("splat");
    let image = stage.image(pixels);
    watch.done("image");
    let cost = FrameCost { stages: watch.stages(), resident_bytes: buffers.resident_bytes() };
    Frame { image, stats, cost }
}

/// What is kept of `volume`, or made anew.
fn of_volume<'a>(kept: &'a mut Option<OfVolume>, volume: &Arc<Volume>) -> &'a mut OfVolume {
    if !kept.as_ref().is_some_and(|of| Arc::ptr_eq(&of.volume, volume)) {
        *kept = None;
    }
    kept.get_or_insert_with(|| OfVolume {
        volume: volume.clone(),
        finite: finite_range(volume),
        voxels: Vec::new(),
        selected_by: None,
    })
}

/// Writes where the voxels are in view space.
fn place(plan: &FramePlan<'_>, voxels: &[u32], points: &mut Vec<[f32; 3]>) {
    let grid = plan.volume.grid();
    let view_from_index = plan.view.from_index(grid);
    let point = |&voxel_idx: &u32| {
        let [i, j, k] = grid.voxel_coords(voxel_idx as usize).map(|c| c as f64);
        view_from_index.transform(DVec3::new(i, j, k)).as_vec3().to_array()
    };
    voxels.par_iter().with_min_len(1 << 12).map(point).collect_into_vec(points);
}

impl OfVolume {
    fn select(&mut self, ranges: Vec<IsoRange>, margin: [usize; 3]) {
        let wanted = Some((ranges, margin));
        if self.selected_by == wanted {
            return;
        }
        if let Some((ranges, margin)) = &wanted {
            self.voxels = selection::select(&self.volume, ranges, *margin);
        }
        self.selected_by = wanted;
    }
}

impl Buffers {
    fn resident_bytes(&self) -> u64 {
        let Self { of, points, values, splats, pixels, workspaces } = self;
        let bytes = of.as_ref().map_or(0, |of| size_of_val(&of.voxels[..]))
            + points.capacity() * size_of::<[f32; 3]>()
            + values.capacity() * size_of::<f32>()
            + splats.resident_bytes()
            + pixels.capacity() * size_of::<[f32; 4]>()
            + workspaces.sum_of(Workspace::resident_bytes);
        bytes as u64
    }
}

impl Stage<'_> {
    /// The first and the last slab that the kernel of a voxel meets.
    #[inline]
    fn slabs_of(&self, voxel: u32) -> [usize; 2] {
        let (depth, reach) = (self.points[voxel as usize][2], self.raster.reach);
        self.slabs.meeting(f64::from(depth - reach), f64::from(depth + reach))
    }

    /// How many sections the voxels have in the slabs behind one.
    fn n_sections_behind(&self, slab: usize, voxels: &[u32]) -> u64 {
        let n_behind = |&voxel: &u32| {
            let [first, last] = self.slabs_of(voxel);
            (last + 1).saturating_sub(first.max(slab + 1)) as u64
        };
        voxels.iter().map(n_behind).sum()
    }

    /// The tiles on which a voxel's sections fall, or beside which: in the border that is summed with them. A section's
    /// place and size change monotonically with its slab's depth, so that the first and the last bound all of them.
    fn tiles_of(&self, voxel: u32) -> TileRect {
        let [first, last] = self.slabs_of(voxel);
        let is_drawn = |slab: &usize| self.plan.view.draws_slab(self.slabs.faces(*slab));
        let Some(first) = (first..=last).find(is_drawn) else { return TileRect::EMPTY };
        let [near, far] = [first, last].map(|slab| {
            let shape = self.raster.shape_at(self.slabs.middle(slab));
            self.raster.bounds(&shape, self.points[voxel as usize])
        });
        let min = [0, 1].map(|axis| near[0][axis].min(far[0][axis]) - BORDER);
        let max = [0, 1].map(|axis| near[1][axis].max(far[1][axis]) + BORDER);
        let pixels = self.tiles.pixels_within(min, max);
        pixels.map_or(TileRect::EMPTY, |pixels| self.tiles.tiles_of(&pixels))
    }

    /// How many columns and rows of a tile are inside the image.
    fn inside(&self, origin: [usize; 2]) -> [usize; 2] {
        let size = self.plan.view.image_size();
        [0, 1].map(|axis| TILE_SIDE.min(size[axis] as usize - origin[axis]))
    }

    /// How far the neighbours of a slab's pixels are apart.
    fn spacing_at(&self, slab: usize) -> Spacing {
        Spacing {
            pixel: 1.0 / self.plan.view.pixels_per_world(self.slabs.middle(slab)),
            slab: self.slabs.thickness(),
            lean: [0.0; 2],
            faint: self.faint,
        }
    }

    /// Renders every tile that has voxels, the fullest first.
    fn render(
        &self,
        splats: &TileBuckets,
        pixels: &mut Vec<[f32; 4]>,
        workspaces: &mut Workspaces<Workspace>,
    ) -> FrameStats {
        pixels.clear();
        pixels.resize(self.tiles.n_tiles() * PIXELS_PER_TILE, [0.0; 4]);
        let tiles = pixels.chunks_mut(PIXELS_PER_TILE).enumerate();
        let mut tiles: Vec<_> = tiles.filter(|(idx, _)| 0 < splats.n_on_tile(*idx)).collect();
        tiles.sort_by_cached_key(|(idx, _)| std::cmp::Reverse(splats.n_on_tile(*idx)));
        let (n_tiles, n_voxels) = (tiles.len() as u64, self.points.len() as u64);
        let workspaces = workspaces.for_all_threads();
        let stats = tiles.into_par_iter().with_max_len(1).map(|(tile_idx, pixels)| {
            let Workspace { open, scratch } = &mut *workspaces.of_this_thread();
            let mut tile = Tile::new(self, tile_idx, open, pixels);
            scratch.voxels.clear();
            scratch.voxels.extend(splats.on_tile(tile_idx).map(|voxel| voxel as u32));
            tile.render(scratch);
            tile.stats
        });
        let stats = stats.reduce(FrameStats::default, |a, b| FrameStats {
            n_splats: a.n_splats + b.n_splats,
            n_culled: a.n_culled + b.n_culled,
            n_full_tiles: a.n_full_tiles + b.n_full_tiles,
            ..a
        });
        FrameStats { n_tiles, n_voxels, ..stats }
    }

    /// The picture that the tiles make up.
    fn image(&self, pixels: &[[f32; 4]]) -> Image {
        let [width, height] = self.plan.view.image_size();
        let behind = self.plan.image.premultiplied_background();
        let mut image = Image::filled(width, height, [0.0; 4]);
        for (tile_idx, tile) in pixels.chunks(PIXELS_PER_TILE).enumerate() {
            let [x, y] = self.tiles.origin(tile_idx);
            let [n_columns, n_rows] = self.inside([x, y]);
            for (row, front) in tile.chunks(TILE_SIDE).take(n_rows).enumerate() {
                let onto = &mut image.pixels_mut()[(y + row) * width as usize + x..][..n_columns];
                onto.iter_mut().zip(front).for_each(|(pixel, front)| *pixel = over(*front, behind));
            }
        }
        image
    }
}
