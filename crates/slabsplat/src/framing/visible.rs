//! What of a layer is visible, as cells of some voxels with the extinction in each.
//!
//! A pass over the volume, once for whatever number of directions: 96 cells along the longest axis are 1 % of
//! a picture each, and of a larger cell no more than 3³ voxels are looked at.

use rayon::prelude::*;
use slabsplat_core::glam::{BVec3, DVec3};
use slabsplat_core::{Isosurface, Layer, Mode, Sample, TransferFunction, extinction, with_samples};

/// Cells along the longest axis.
const N_CELLS: usize = 96;

/// Voxels of a cell that are looked at, along each axis.
const N_SAMPLES: usize = 3;

/// Voxel steps that a kernel is seen beyond its voxel.
const KERNEL_STEPS: f64 = 0.6;

/// Part of a layer, or of a mesh.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cell {
    pub(crate) middle: DVec3,
    /// Extinction times volume, in squares of world units: what it takes from parallel light in all.
    pub(crate) weight: f64,
}

/// Cells of one size.
#[derive(Clone, Debug)]
pub(crate) struct Cells {
    pub(crate) cells: Vec<Cell>,
    /// Half the edges of each, and what kernels cover beyond them.
    half_edges: [DVec3; 3],
}

impl Cells {
    /// How far a cell reaches from its middle along a direction of length 1.
    pub(crate) fn reach(&self, direction: DVec3) -> f64 {
        self.half_edges.iter().map(|edge| edge.dot(direction).abs()).sum()
    }

    /// The longest way through a cell.
    pub(crate) fn size(&self) -> f64 {
        2.0 * self.half_edges.iter().map(|edge| edge.length_squared()).sum::<f64>().sqrt()
    }

    /// Those of a layer that show something.
    pub(crate) fn of_layer(layer: &Layer, mode: Mode) -> Self {
        with_samples!(layer.volume.samples(), |samples| of_samples(layer, mode, samples))
    }

    /// The corners of a box, which nobody looks through.
    pub(crate) fn of_box([min, max]: [DVec3; 2]) -> Self {
        let corners = (0..8).map(|corner: u8| {
            let is_far = [0, 1, 2].map(|axis| corner >> axis & 1 == 1);
            DVec3::select(BVec3::from_array(is_far), max, min)
        });
        Self::of_points(corners, [DVec3::ZERO; 3])
    }

    /// The corner voxels of a layer's grid.
    pub(crate) fn of_grid(layer: &Layer) -> Self {
        let grid = layer.volume.grid();
        let steps = grid.world_from_index().matrix3;
        let half_edges = [steps.x_axis, steps.y_axis, steps.z_axis].map(|step| step * KERNEL_STEPS);
        Self::of_points(grid.corners_in_world(), half_edges)
    }

    fn of_points(points: impl Iterator<Item = DVec3>, half_edges: [DVec3; 3]) -> Self {
        let cells = points.map(|middle| Cell { middle, weight: f64::INFINITY }).collect();
        Self { cells, half_edges }
    }
}

fn of_samples<T: Sample>(layer: &Layer, mode: Mode, samples: &[T]) -> Cells {
    let grid = layer.volume.grid();
    let dims = grid.dims();
    let side = dims.iter().copied().max().unwrap_or(1).div_ceil(N_CELLS);
    // Flat voxels have more of them in a cell.
    let steps = grid.spacing().map(|step| step / grid.unit());
    let sides = [0, 1, 2].map(|axis| ((side as f64 / steps[axis]).round() as usize).clamp(1, side));
    let n_cells = [0, 1, 2].map(|axis| dims[axis].div_ceil(sides[axis]));
    let look = Look::new(layer, mode);
    let world_from_index = grid.world_from_index();
    let m = world_from_index.matrix3;
    let voxel_volume = m.determinant().abs() / grid.unit();

    let of_layer = |z: usize| {
        let mut cells = Vec::new();
        for (x, y) in (0..n_cells[1]).flat_map(|y| (0..n_cells[0]).map(move |x| (x, y))) {
            let first = [x * sides[0], y * sides[1], z * sides[2]];
            let last = [0, 1, 2].map(|axis| (first[axis] + sides[axis]).min(dims[axis]) - 1);
            let extinction = look.mean_extinction(samples, first, last);
            if 0.0 < extinction {
                let n: usize = [0, 1, 2].iter().map(|&axis| last[axis] - first[axis] + 1).product();
                let ends = [first, last].map(|end| DVec3::from_array(end.map(|c| c as f64)));
                let middle = world_from_index.transform_point3(ends[0].midpoint(ends[1]));
                cells.push(Cell { middle, weight: extinction * voxel_volume * n as f64 });
            }
        }
        cells.retain(|cell| layer.region.contains(cell.middle));
        cells
    };
    let cells = (0..n_cells[2]).into_par_iter().map(of_layer).collect::<Vec<_>>().concat();
    let half = |axis: usize| 0.5 * sides[axis] as f64 + KERNEL_STEPS - 0.5;
    let half_edges = [m.x_axis * half(0), m.y_axis * half(1), m.z_axis * half(2)];
    Cells { cells, half_edges }
}

/// How visible a layer's voxels are.
struct Look<'a> {
    layer: &'a Layer,
    /// Whether it is isosurfaces that are shown.
    isosurfaces: &'a [Isosurface],
    /// The least and the largest visible value of the layer's transfer function.
    range: [f64; 2],
}

impl<'a> Look<'a> {
    fn new(layer: &'a Layer, mode: Mode) -> Self {
        let isosurfaces = if mode == Mode::Isosurfaces { &layer.isosurfaces[..] } else { &[] };
        let ranges = match &layer.transfer_2d {
            Some(transfer) => transfer.iso_ranges(),
            None => layer.transfer.iso_ranges(),
        };
        let nothing = [f64::INFINITY, f64::NEG_INFINITY];
        let range = ranges.iter().fold(nothing, |[lo, hi], r| [lo.min(r.lo), hi.max(r.hi)]);
        Self { layer, isosurfaces, range }
    }

    /// Over the voxels from `first` to `last`, or some of them.
    fn mean_extinction<T: Sample>(
        &self,
        samples: &[T],
        first: [usize; 3],
        last: [usize; 3],
    ) -> f64 {
        let scaling = self.layer.volume.scaling();
        let grid = self.layer.volume.grid();
        let stride = |axis: usize| (last[axis] - first[axis] + 1).div_ceil(N_SAMPLES);
        let along = |axis: usize| (first[axis]..=last[axis]).step_by(stride(axis));
        let (mut sum, mut n, mut least, mut largest) = (0.0, 0, f64::INFINITY, f64::NEG_INFINITY);
        for z in along(2) {
            for y in along(1) {
                for x in along(0) {
                    let voxel_idx = grid.voxel_idx([x, y, z]);
                    let value = scaling.apply(samples[voxel_idx].to_f64());
                    n += 1;
                    if !value.is_nan() {
                        (least, largest) = (value.min(least), value.max(largest));
                        sum += self.extinction(value, voxel_idx);
                    }
                }
            }
        }
        if self.isosurfaces.is_empty() {
            return sum / f64::from(n);
        }
        // Between neighbours that are apart the surface may be in the next cell, which is as good.
        let is_cut = |surface: &&Isosurface| least <= surface.value() && surface.value() <= largest;
        self.isosurfaces.iter().filter(is_cut).map(|surface| extinction(surface.opacity())).sum()
    }

    fn extinction(&self, value: f64, voxel_idx: usize) -> f64 {
        let of = |transfer: &TransferFunction| extinction(transfer.opacity(value));
        if let Some(labels) = &self.layer.labels {
            let map = labels.map();
            let style = labels.style(map.labels()[usize::from(map.indices()[voxel_idx])]);
            return style.transfer_in(&self.layer.transfer).map_or(0.0, of) * style.opacity;
        }
        let [lo, hi] = self.range;
        if value < lo || hi < value {
            return 0.0;
        }
        match &self.layer.transfer_2d {
            // Whichever gradient there is: what is seen of the least faint of them is framed.
            Some(_) => 1.0,
            None => of(&self.layer.transfer),
        }
    }
}
