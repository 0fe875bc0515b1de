//! Which rays a volume is more than grazed by: those of which whole footprints say all that sheets would.
//!
//! By how much a mean counts (model §12) depends on how much the sheet holds that holds most of the ray.
//! Together the sheets hold `Σ L`, and there are `n` at most that may hold anything; so one of them holds
//! `Σ L/n` at least, and if that is as much as a sheet counts in full with, the mean does.

use super::sheets::Limits;
use crate::pixels::blocks::BLOCK_SIDE;
use crate::pixels::quad::QUAD;
use crate::pixels::tile::Tile;
use crate::pixels::tiles::Tiles;
use rayon::prelude::*;
use slabsplat_backend::LayerPlan;
use slabsplat_backend::densities::FULL_PART;
use slabsplat_core::glam::{DMat3, DVec3};
use slabsplat_core::{SlabGrid, View};

/// How far parallel rays go through a volume.
pub(super) struct ParallelRays {
    view: View,
    index_from_view: DMat3,
    center_in_view: DVec3,
    /// Half of the box, in index space, that holds each ray where it passes a voxel within its footprint.
    half_extents: DVec3,
    /// How much further the sheets go in depth that such voxels are in, in world units.
    beyond: f64,
    unit: f64,
}

/// Sums are rounded, and what is splatted by default is not exact.
const ROUNDING: f64 = 1.0 + 1e-3;

impl ParallelRays {
    pub(super) fn new(layer: &LayerPlan<'_>, slabs: &SlabGrid) -> Self {
        let LayerPlan { view, shape, radius, half_depth, .. } = *layer;
        let grid = layer.volume.grid();
        let from_index = view.from_index(grid);
        // Footprints are stretched where pixels are larger than voxels.
        let stretch = view.stretch(view.pixels_per_world(0.0));
        let [right, up] = shape.half_extent;
        let footprint = right.hypot(up) * radius * stretch;
        let per_world = grid.index_from_world().matrix3;
        let margin = DVec3::from_array([0, 1, 2].map(|axis| per_world.row(axis).length()));
        Self {
            view,
            index_from_view: from_index.matrix.inverse(),
            center_in_view: from_index.transform(grid.center_in_index()),
            half_extents: grid.center_in_index() + margin * footprint,
            beyond: 2.0 * (half_depth + slabs.thickness()),
            unit: grid.unit(),
        }
    }

    /// How much of the ray through a point of the image those sheets are that may hold any of it, at most, in
    /// `unit`s.
    fn length(&self, pixel: [f64; 2]) -> f64 {
        let ray = self.view.ray(pixel);
        let start = self.index_from_view * (ray.start - self.center_in_view);
        let step = self.index_from_view * ray.step;
        let (mut near, mut far) = (f64::NEG_INFINITY, f64::INFINITY);
        for axis in 0..3 {
            let (start, step, half) = (start[axis], step[axis], self.half_extents[axis]);
            if step != 0.0 {
                let ends = [(-half - start) / step, (half - start) / step];
                near = near.max(ends[0].min(ends[1]));
                far = far.min(ends[0].max(ends[1]));
            }
        }
        ((far - near).max(0.0) + self.beyond) / self.unit
    }

    /// Finishes and closes the blocks of which no ray only grazes the volume, given their sums of whole
    /// footprints, and empties the others.
    pub(super) fn settle(&self, limits: &Limits, tiles: &mut Tiles) {
        tiles.tiles.par_iter_mut().for_each(|tile| self.settle_tile(limits, tile));
    }

    fn settle_tile(&self, limits: &Limits, tile: &mut Tile) {
        for [column, row] in tile.open.iter() {
            let rows = row * BLOCK_SIDE..(row + 1) * BLOCK_SIDE;
            let positions = rows.flat_map(|row| (0..QUAD).map(move |pixel| (row, pixel)));
            let is_settled = positions.clone().all(|(row, pixel)| {
                let [_, length, _, opacity] = tile.pixels[row][column].pixel(pixel);
                let at = [tile.origin[0] + column * QUAD + pixel, tile.origin[1] + row];
                let is_outside = 1.0 <= opacity;
                is_outside || length == 0.0 || self.is_more_than_grazed(at, length)
            });
            for (row, pixel) in positions {
                let quad = &mut tile.pixels[row][column];
                let [weighted, length, _, opacity] = quad.pixel(pixel);
                let counting = if 0.0 < length { 1.0 } else { 0.0 };
                let [lo, hi] = limits.values.map(|value| value * length);
                let sums = [weighted.max(lo).min(hi), length, counting];
                let [weighted, length, counting] = if is_settled { sums } else { [0.0; 3] };
                quad.set_pixel(pixel, [weighted, length, counting, opacity]);
            }
            if is_settled {
                tile.close([column, row]);
            }
        }
    }

    /// Whether any sheet counts in full on the ray of a pixel, if they hold so much of it together.
    fn is_more_than_grazed(&self, pixel: [usize; 2], length: f32) -> bool {
        let center = pixel.map(|idx| idx as f64 + 0.5);
        ROUNDING * FULL_PART * self.length(center) <= f64::from(length)
    }
}
