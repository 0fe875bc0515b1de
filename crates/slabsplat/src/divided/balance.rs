//! How much work is where, as far as overviews tell, and where a box is cut such that both sides have as much
//! for each who draws there.

use slabsplat_core::glam::DVec3;
use slabsplat_core::{Grid, IsoRange, Layer, Scene};
use std::ops::Range;

/// The work in cells of the largest grid: its relevant voxels, of all layers.
#[derive(Debug)]
pub(super) struct WorkCells {
    dims: [usize; 3],
    /// Voxels along the side of a cell, a multiple of a brick's.
    side: usize,
    /// Voxels of the grid.
    n_voxels: [usize; 3],
    work: Vec<f32>,
}

/// Where a box is cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Cut {
    pub(super) axis: usize,
    /// The first voxel of the far side.
    pub(super) at: usize,
    /// Of those who share the box, how many are on the near side.
    pub(super) n_near: usize,
}

/// The least side of a cell: a brick's.
const LEAST_SIDE: usize = 8;

/// Cells, at most.
const MOST_CELLS: usize = 1 << 21;

/// The work of a voxel that is read and shows nothing, in that of one that is drawn.
const OF_EMPTY_VOXEL: f32 = 1.0 / 32.0;

/// How much a cut across the shortest side may be better balanced, as a part of the work, and is not taken.
const FOR_LONG_SIDES: f64 = 0.1;

impl WorkCells {
    /// Of a scene whose layers have overviews of those grids for volumes.
    pub(super) fn of(scene: &Scene, grids: &[Grid]) -> Self {
        let largest = grids.iter().max_by_key(|grid| grid.n_voxels());
        let grid = largest.expect("a scene in parts has layers");
        let mut cells = Self::empty(grid.dims());
        for (layer, whole) in scene.layers.iter().zip(grids) {
            cells.add(layer, whole, grid);
        }
        cells
    }

    /// With nothing but voxels that are read.
    fn empty(n_voxels: [usize; 3]) -> Self {
        let dims_of = |side: usize| n_voxels.map(|n| n.div_ceil(side));
        let side = (0..)
            .map(|power| LEAST_SIDE << power)
            .find(|side| dims_of(*side).iter().product::<usize>() <= MOST_CELLS)
            .expect("in the end there is one cell");
        let dims = dims_of(side);
        let of_cell = OF_EMPTY_VOXEL * (side as f32).powi(3);
        Self { dims, side, n_voxels, work: vec![of_cell; dims.iter().product()] }
    }

    /// Counts the relevant voxels of a layer, each of its overview for all that it stands for.
    fn add(&mut self, layer: &Layer, whole: &Grid, grid: &Grid) {
        let (volume, overview) = (&layer.volume, layer.volume.grid());
        let ranges = relevant(layer);
        let index_from_index = grid.index_from_world() * overview.world_from_index();
        let work = (whole.n_voxels() as f64 / overview.n_voxels() as f64) as f32;
        let has_region = !layer.region.is_everywhere();
        for voxel_idx in 0..overview.n_voxels() {
            let value = volume.value(voxel_idx);
            if !ranges.iter().any(|range| range.lo <= value && value <= range.hi) {
                continue;
            }
            let at = DVec3::from_array(overview.voxel_coords(voxel_idx).map(|c| c as f64));
            let shows = || layer.region.contains(overview.world_from_index().transform_point3(at));
            if !has_region || shows() {
                let cell_idx = self.cell_at(index_from_index.transform_point3(at));
                self.work[cell_idx] += work;
            }
        }
    }

    /// The cell of a point in index space, or the nearest.
    fn cell_at(&self, at: DVec3) -> usize {
        let [i, j, k] = [0, 1, 2]
            .map(|axis| ((at[axis].max(0.0) / self.side as f64) as usize).min(self.dims[axis] - 1));
        (k * self.dims[1] + j) * self.dims[0] + i
    }

    /// Cuts a box for so many, two at least; nothing if it is one voxel.
    pub(super) fn cut(&self, voxels: &[Range<usize>; 3], n: usize) -> Option<Cut> {
        let n_near = n / 2;
        let part = n_near as f64 / n as f64;
        let longest = voxels.iter().map(Range::len).max()? as f64;
        let between_cells = (0..3).filter_map(|axis| {
            let (at, off) = self.cut_across(voxels, axis, part)?;
            let shortness = 1.0 - voxels[axis].len() as f64 / longest;
            Some((off + FOR_LONG_SIDES * shortness, Cut { axis, at, n_near }))
        });
        let best = between_cells.min_by(|(a, _), (b, _)| a.total_cmp(b));
        let cut = best.map(|(_, cut)| cut).or_else(|| {
            // Of a cell that is shared nobody knows where its work is.
            let axis = (0..3).rev().max_by_key(|axis| voxels[*axis].len())?;
            let Range { start, end } = voxels[axis];
            let at = start + (part * (end - start) as f64).round() as usize;
            (1 < end - start).then(|| Cut { axis, at: at.clamp(start + 1, end - 1), n_near })
        })?;
        // Nobody gets a side that has no voxel left for him while the other side has.
        let n_voxels = |range: Range<usize>| {
            let others = (0..3).filter(|axis| *axis != cut.axis).map(|axis| voxels[axis].len());
            range.len() * others.product::<usize>()
        };
        let near = n_voxels(voxels[cut.axis].start..cut.at);
        let far = n_voxels(cut.at..voxels[cut.axis].end);
        let n_near = n_near.max(n.saturating_sub(far)).min(near).min(n - 1);
        Some(Cut { n_near, ..cut })
    }

    /// Where to cut across an axis between cells, and by which part of the work that is off.
    fn cut_across(
        &self,
        voxels: &[Range<usize>; 3],
        axis: usize,
        part: f64,
    ) -> Option<(usize, f64)> {
        let layers = self.work_along(voxels, axis);
        let total: f64 = layers.iter().map(|(_, work)| work).sum();
        let mut near = 0.0;
        let cuts = layers.windows(2).map(|pair| {
            near += pair[0].1;
            (pair[1].0, (near / total - part).abs())
        });
        cuts.min_by(|(_, a), (_, b)| a.total_cmp(b))
    }

    /// The work of a box in each of the layers of cells across an axis, with the first voxel of each.
    fn work_along(&self, voxels: &[Range<usize>; 3], axis: usize) -> Vec<(usize, f64)> {
        let cells = [0, 1, 2]
            .map(|axis| voxels[axis].start / self.side..voxels[axis].end.div_ceil(self.side));
        let mut layers: Vec<(usize, f64)> =
            cells[axis].clone().map(|c| ((c * self.side).max(voxels[axis].start), 0.0)).collect();
        for k in cells[2].clone() {
            for j in cells[1].clone() {
                for i in cells[0].clone() {
                    let at = [i, j, k];
                    let work = self.work[(k * self.dims[1] + j) * self.dims[0] + i];
                    let share = self.share_in(voxels, at);
                    layers[at[axis] - cells[axis].start].1 += share * f64::from(work);
                }
            }
        }
        layers
    }

    /// The part of a cell that is in a box.
    fn share_in(&self, voxels: &[Range<usize>; 3], cell: [usize; 3]) -> f64 {
        let along = |axis: usize| {
            let start = cell[axis] * self.side;
            let end = (start + self.side).min(self.n_voxels[axis]);
            let within = end.min(voxels[axis].end).saturating_sub(start.max(voxels[axis].start));
            within as f64 / (end - start) as f64
        };
        along(0) * along(1) * along(2)
    }
}

/// The values of which voxels are drawn, as far as values alone say.
fn relevant(layer: &Layer) -> Vec<IsoRange> {
    match &layer.transfer_2d {
        Some(transfer) => transfer.iso_ranges(),
        None => layer.transfer.iso_ranges(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn boxes_of(cells: &WorkCells, voxels: [Range<usize>; 3], n: usize) -> Vec<[Range<usize>; 3]> {
        let cut = if n == 1 { None } else { cells.cut(&voxels, n) };
        let Some(Cut { axis, at, n_near }) = cut else { return vec![voxels] };
        let mut sides = [voxels.clone(), voxels];
        sides[0][axis].end = at;
        sides[1][axis].start = at;
        let [near, far] = sides;
        [boxes_of(cells, near, n_near), boxes_of(cells, far, n - n_near)].concat()
    }

    fn work_in(cells: &WorkCells, voxels: &[Range<usize>; 3]) -> f64 {
        cells.work_along(voxels, 0).iter().map(|(_, work)| work).sum()
    }

    /// A corner that is full, and all else empty.
    #[test]
    fn work_is_dealt_out_evenly() {
        let mut cells = WorkCells::empty([256, 192, 320]);
        assert_eq!((cells.side, cells.dims), (8, [32, 24, 40]));
        for k in 0..20 {
            for j in 0..12 {
                for i in 0..16 {
                    let cell_idx = cells.cell_at(8.0 * DVec3::new(i as f64, j as f64, k as f64));
                    cells.work[cell_idx] += 512.0;
                }
            }
        }
        let all = [0..256, 0..192, 0..320];
        let total = work_in(&cells, &all);
        for n in [1, 2, 3, 5, 8, 13, 64] {
            let boxes = boxes_of(&cells, all.clone(), n);
            assert_eq!(boxes.len(), n);
            let work: Vec<f64> = boxes.iter().map(|of| work_in(&cells, of)).collect();
            let most = work.iter().copied().fold(0.0, f64::max) * n as f64 / total;
            assert!((work.iter().sum::<f64>() / total - 1.0).abs() < 1e-9);
            assert!(most < if n < 10 { 1.15 } else { 1.6 }, "{n}: {most}");
        }
    }

    #[test]
    fn work_of_little_is_dealt_out_to_voxels() {
        let cells = WorkCells::empty([3, 2, 1]);
        assert_eq!(boxes_of(&cells, [0..3, 0..2, 0..1], 6).len(), 6);
        assert_eq!(boxes_of(&cells, [0..3, 0..2, 0..1], 9).len(), 6);
        assert_eq!(cells.cut(&[2..3, 1..2, 0..1], 2), None);
        let large = WorkCells::empty([4096, 4096, 4096]);
        assert_eq!(large.side, 32);
    }
}
