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
//! Nothing here is shared with the other methods but where a footprint lies (`raster`): their sheets hold colours.
//!
//! # Reading order
//!
//! `selection` and `margin`; `values`; `toss`, `buckets`; `tile`, `sheet`, `open`; `classify`, `gradient`, `rays`.

mod margin;
mod selection;
mod values;

mod buckets;
mod toss;

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
use classify::{Classifier, ranges_with_room};
use gradient::Spacing;
use rayon::prelude::*;
use rays::Rays;
use slabsplat_backend::{Frame, FrameCost, FramePlan, FrameStats};
use slabsplat_core::glam::DVec3;
use slabsplat_core::{Image, IsoRange, SlabGrid, Volume};
use slabsplat_kernel::CubicSectionTable;
use std::sync::Arc;
use tile::{Scratch, Tile};
use toss::{TileRect, Tiles, Toss};
use values::{ValueScale, finite_range};

/// Pixels along the side of a tile.
const TILE_SIDE: usize = 32;

/// A gradient counts in full from this part of the range of values on, per `unit`: less is the noise of a plateau,
/// and a normal must not turn about within it.
const FAINT_GRADIENT: f64 = 1.0 / 256.0;

/// What is kept from frame to frame.
#[derive(Debug, Default)]
pub(crate) struct Buffers {
    of: Option<OfVolume>,
    points: Vec<[f32; 3]>,
    values: Vec<f32>,
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
    tiles: Tiles,
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
    let Buffers { of, points, values } = buffers;
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
        tiles: Tiles {
            image_size: plan.view.image_size().map(|side| side as usize),
            side: TILE_SIDE,
        },
        classifier: Classifier::new(plan, scale),
        n_slabs_before: (2.0 * f64::from(raster.reach) / slabs.thickness()).ceil() as usize,
        // Never 0, which a gradient of 0 would be divided by.
        faint: (FAINT_GRADIENT * range / plan.volume.grid().unit()).max(f64::MIN_POSITIVE),
        points,
        values,
    };
    let toss = Toss::new(&stage.tiles, points.len(), |voxel| stage.touched(voxel as u32));
    watch.done("toss");
    let (image, stats) = stage.render(&toss);
    watch.done("splat");
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
        let Self { of, points, values } = self;
        let bytes = of.as_ref().map_or(0, |of| size_of_val(&of.voxels[..]))
            + points.capacity() * size_of::<[f32; 3]>()
            + values.capacity() * size_of::<f32>();
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

    /// The tiles on which a voxel's sections fall. A section's place and size change monotonically with its slab's
    /// depth, so that the first and the last bound all of them.
    fn touched(&self, voxel: u32) -> Option<TileRect> {
        let [first, last] = self.slabs_of(voxel);
        let is_drawn = |slab: &usize| self.plan.view.draws_slab(self.slabs.faces(*slab));
        let first = (first..=last).find(is_drawn)?;
        let [near, far] = [first, last].map(|slab| {
            let shape = self.raster.shape_at(self.slabs.middle(slab));
            self.raster.bounds(&shape, self.points[voxel as usize])
        });
        let min = [0, 1].map(|axis| near[0][axis].min(far[0][axis]));
        let max = [0, 1].map(|axis| near[1][axis].max(far[1][axis]));
        self.tiles.touched([min, max])
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

    /// Renders every tile that has voxels, the fullest first, and puts them together.
    fn render(&self, toss: &Toss) -> (Image, FrameStats) {
        let mut tile_idxs: Vec<usize> =
            (0..self.tiles.n_tiles()).filter(|&idx| 0 < toss.n_on_tile(idx)).collect();
        tile_idxs.sort_by_cached_key(|&idx| std::cmp::Reverse(toss.n_on_tile(idx)));
        let tiles: Vec<Tile<'_>> = tile_idxs
            .into_par_iter()
            .with_max_len(1)
            .map_init(Scratch::default, |scratch, tile_idx| {
                let mut tile = Tile::new(self, tile_idx);
                scratch.voxels.clear();
                scratch.voxels.extend(toss.on_tile(tile_idx));
                tile.render(scratch);
                tile
            })
            .collect();
        self.assemble(&tiles)
    }

    fn assemble(&self, tiles: &[Tile<'_>]) -> (Image, FrameStats) {
        let [width, height] = self.plan.view.image_size();
        let behind = self.plan.image.premultiplied_background();
        let mut image = Image::filled(width, height, behind);
        let mut stats = FrameStats {
            n_voxels: self.points.len() as u64,
            n_tiles: tiles.len() as u64,
            ..FrameStats::default()
        };
        for tile in tiles {
            tile.copy_to(&mut image, behind);
            stats.n_splats += tile.stats.n_splats;
            stats.n_culled += tile.stats.n_culled;
            stats.n_full_tiles += u64::from(tile.stats.is_full);
        }
        (image, stats)
    }
}
