//! What of a layer is visible, as cells of some voxels with the extinction in each.
//!
//! A pass over the volume, once for whatever number of directions: 96 cells along the longest axis are 1 % of
//! a picture each, and of a larger cell no more than 3³ voxels are looked at.

use crate::small_samples::SmallSamples;
use rayon::prelude::*;
use slabsplat_core::glam::{BVec3, DVec3};
use slabsplat_core::{
    Grid, Isosurface, LabelMap, Layer, Mode, Sample, TransferFunction, extinction, with_samples,
};
use std::iter::StepBy;
use std::ops::Range;
use std::sync::OnceLock;

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
        let grid = layer.volume.grid();
        let layout = CellLayout::new(layer, grid, mode);
        let labels = layer.labels.as_ref().map(slabsplat_core::Labels::map);
        let [nx, ny, _] = grid.dims();
        let of_layer = |cell_z: usize| {
            let mut sums = layout.sums();
            for z in layout.planes(cell_z) {
                let plane = z * nx * ny..(z + 1) * nx * ny;
                let labels = labels.map(|map| (map, plane.start));
                with_samples!(layer.volume.samples(), |samples| {
                    layout.add(&mut sums, &(0..ny), &samples[plane], labels);
                });
            }
            layout.extinctions(&sums)
        };
        let extinctions = (0..layout.n_layers()).into_par_iter().map(of_layer);
        layout.cells(&extinctions.collect::<Vec<_>>().concat())
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
    pub(crate) fn of_grid(grid: &Grid) -> Self {
        let steps = grid.world_from_index().matrix3;
        let half_edges = [steps.x_axis, steps.y_axis, steps.z_axis].map(|step| step * KERNEL_STEPS);
        Self::of_points(grid.corners_in_world(), half_edges)
    }

    fn of_points(points: impl Iterator<Item = DVec3>, half_edges: [DVec3; 3]) -> Self {
        let cells = points.map(|middle| Cell { middle, weight: f64::INFINITY }).collect();
        Self { cells, half_edges }
    }
}

/// How the voxels of a layer are parted into cells, and what is summed of them: plane by plane, so that they
/// need not be in memory together.
pub(crate) struct CellLayout<'a> {
    look: Look<'a>,
    grid: Grid,
    /// Voxels along the sides of a cell.
    sides: [usize; 3],
    n_cells: [usize; 3],
    /// The extinction of each sample, where there are fewer of these than voxels.
    tabled: OnceLock<Option<Tabled>>,
}

struct Tabled {
    small: SmallSamples,
    extinctions: Vec<f64>,
}

/// What is known of a cell some of whose planes have been looked at.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CellSum {
    extinction: f64,
    n: u32,
    /// The least and the largest value.
    range: [f64; 2],
}

impl CellSum {
    fn add(&mut self, value: f64, extinction: impl FnOnce() -> f64) {
        self.n += 1;
        if !value.is_nan() {
            self.range = [value.min(self.range[0]), value.max(self.range[1])];
            self.extinction += extinction();
        }
    }
}

impl<'a> CellLayout<'a> {
    /// Of a layer whose volume is on that grid, or stands for one that is.
    pub(crate) fn new(layer: &'a Layer, grid: &Grid, mode: Mode) -> Self {
        let dims = grid.dims();
        let side = dims.iter().copied().max().unwrap_or(1).div_ceil(N_CELLS);
        // Flat voxels have more of them in a cell.
        let steps = grid.spacing().map(|step| step / grid.unit());
        let sides =
            [0, 1, 2].map(|axis| ((side as f64 / steps[axis]).round() as usize).clamp(1, side));
        let n_cells = [0, 1, 2].map(|axis| dims[axis].div_ceil(sides[axis]));
        let look = Look::new(layer, mode);
        Self { look, grid: *grid, sides, n_cells, tabled: OnceLock::new() }
    }

    /// How many layers of cells there are along z.
    pub(crate) fn n_layers(&self) -> usize {
        self.n_cells[2]
    }

    /// How many planes of voxels a layer of cells has.
    #[cfg(feature = "files")]
    pub(crate) fn depth(&self) -> usize {
        self.sides[2]
    }

    /// Cells of a layer along z.
    pub(crate) fn n_in_layer(&self) -> usize {
        self.n_cells[0] * self.n_cells[1]
    }

    /// The voxels of a cell along an axis.
    fn voxels(&self, axis: usize, cell: usize) -> Range<usize> {
        let first = cell * self.sides[axis];
        first..(first + self.sides[axis]).min(self.grid.dims()[axis])
    }

    /// Those of them that are looked at.
    fn samples(&self, axis: usize, cell: usize) -> StepBy<Range<usize>> {
        let voxels = self.voxels(axis, cell);
        let stride = voxels.len().div_ceil(N_SAMPLES);
        voxels.step_by(stride)
    }

    /// The planes of voxels that are looked at for a layer of cells.
    pub(crate) fn planes(&self, cell_z: usize) -> impl Iterator<Item = usize> + use<> {
        self.samples(2, cell_z)
    }

    /// Those of a layer of cells of which nothing was looked at.
    pub(crate) fn sums(&self) -> Vec<CellSum> {
        let range = [f64::INFINITY, f64::NEG_INFINITY];
        vec![CellSum { extinction: 0.0, n: 0, range }; self.n_in_layer()]
    }

    fn tabled<T: Sample>(&self) -> Option<&Tabled> {
        let table = || {
            let small = SmallSamples::fewer_than(self.grid.n_voxels(), T::TYPE)?;
            let values = small.values(self.look.layer.volume.scaling());
            let extinctions = values.map(|value| self.look.extinction(value, None)).collect();
            Some(Tabled { small, extinctions })
        };
        self.tabled.get_or_init(table).as_ref()
    }

    /// Looks at some rows of a plane of voxels, of which samples are given, and labels with the first of
    /// theirs: those of a cell come in their order.
    pub(crate) fn add<T: Sample>(
        &self,
        sums: &mut [CellSum],
        rows: &Range<usize>,
        samples: &[T],
        labels: Option<(&LabelMap, usize)>,
    ) {
        let [nx, _, _] = self.grid.dims();
        let scaling = self.look.layer.volume.scaling();
        let tabled = self.tabled::<T>().filter(|_| labels.is_none());
        let label_at = |idx: usize| {
            labels.map(|(map, first)| map.labels()[usize::from(map.indices()[first + idx])])
        };
        let columns: Vec<_> = (0..self.n_cells[0]).map(|cell| self.samples(0, cell)).collect();
        for cell_y in rows.start / self.sides[1]..rows.end.div_ceil(self.sides[1]) {
            for y in self.samples(1, cell_y).filter(|y| rows.contains(y)) {
                let row = (y - rows.start) * nx;
                let sums = &mut sums[cell_y * self.n_cells[0]..];
                for (of_cell, columns) in sums.iter_mut().zip(&columns) {
                    // By itself, so that it stays in registers.
                    let mut sum = *of_cell;
                    for x in columns.clone() {
                        let sample = samples[row + x];
                        let value = scaling.apply(sample.to_f64());
                        sum.add(value, || match tabled {
                            Some(Tabled { small, extinctions }) => {
                                extinctions[small.idx_of(sample)]
                            }
                            None => self.look.extinction(value, label_at(row + x)),
                        });
                    }
                    *of_cell = sum;
                }
            }
        }
    }

    /// The mean extinction of a layer's cells.
    pub(crate) fn extinctions(&self, sums: &[CellSum]) -> Vec<f64> {
        sums.iter().map(|sum| self.look.mean_extinction(sum)).collect()
    }

    /// The cells that show something, of the extinctions of all layers.
    pub(crate) fn cells(&self, extinctions: &[f64]) -> Cells {
        let world_from_index = self.grid.world_from_index();
        let m = world_from_index.matrix3;
        let voxel_volume = m.determinant().abs() / self.grid.unit();
        let visible = extinctions.iter().enumerate().filter(|(_, extinction)| 0.0 < **extinction);
        let cells = visible.map(|(cell_idx, extinction)| {
            let [nx, ny, _] = self.n_cells;
            let cell = [cell_idx % nx, cell_idx / nx % ny, cell_idx / nx / ny];
            let voxels = [0, 1, 2].map(|axis| self.voxels(axis, cell[axis]));
            let n: usize = voxels.iter().map(Range::len).product();
            let first = voxels.each_ref().map(|range| range.start as f64);
            let last = voxels.each_ref().map(|range| (range.end - 1) as f64);
            let middle = DVec3::from_array(first).midpoint(DVec3::from_array(last));
            let middle = world_from_index.transform_point3(middle);
            Cell { middle, weight: extinction * voxel_volume * n as f64 }
        });
        let region = &self.look.layer.region;
        let cells = cells.filter(|cell| region.contains(cell.middle)).collect();
        let half = |axis: usize| 0.5 * self.sides[axis] as f64 + KERNEL_STEPS - 0.5;
        let half_edges = [m.x_axis * half(0), m.y_axis * half(1), m.z_axis * half(2)];
        Cells { cells, half_edges }
    }
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

    /// Of a cell whose voxels have been looked at.
    fn mean_extinction(&self, sum: &CellSum) -> f64 {
        if self.isosurfaces.is_empty() {
            return sum.extinction / f64::from(sum.n);
        }
        // Between neighbours that are apart the surface may be in the next cell, which is as good.
        let [least, largest] = sum.range;
        let is_cut = |surface: &&Isosurface| least <= surface.value() && surface.value() <= largest;
        self.isosurfaces.iter().filter(is_cut).map(|surface| extinction(surface.opacity())).sum()
    }

    /// Of a voxel of that value, and of a label.
    fn extinction(&self, value: f64, label: Option<i64>) -> f64 {
        let of = |transfer: &TransferFunction| extinction(transfer.opacity(value));
        if let (Some(labels), Some(label)) = (&self.layer.labels, label) {
            let style = labels.style(label);
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
