//! Cells of voxels, drawn instead of these (model §16).
//!
//! ```text
//! for each brick of 8³ cells that holds relevant voxels:
//!     a cell is drawn if any of its voxels is relevant
//!     its colour = the sum of theirs, classified and lit, over the voxels along an edge of it
//! ```
//!
//! 1. Sheets sum extinction, and colour times extinction. Such sums are made of voxels first, which gives the
//!    same sum, and one footprint goes for all of a cell.
//! 2. Nothing is cached but the list of voxels. To light a voxel takes a small part of the time that its
//!    footprints would, and what depends on neither the view nor the light would take much memory.

use super::slabs::Voxels;
use slabsplat_backend::LayerPlan;
use slabsplat_traverse::{BRICK_SIDE, Brick, BrickGrid, VoxelRecord};
use std::ops::Range;

/// Cells of the voxels of `V`.
pub(super) struct Cells<V> {
    voxels: V,
    level: u32,
    voxel_bricks: BrickGrid,
    cell_bricks: BrickGrid,
    /// The bricks of cells that hold any, in memory order.
    bricks: Vec<Brick>,
}

/// Slots in a brick.
const N_SLOTS: usize = BRICK_SIDE.pow(3);

impl<V: Voxels> Cells<V> {
    /// The cells that a plan is of.
    pub(super) fn new(voxels: V, plan: &LayerPlan<'_>) -> Self {
        let (of_cells, level) = (plan.grid(), plan.level);
        let [voxel_bricks, cell_bricks] = [plan.volume.grid(), &of_cells].map(BrickGrid::new);
        let mut cells = Self { voxels, level, voxel_bricks, cell_bricks, bricks: Vec::new() };
        cells.bricks = cells.listed();
        cells
    }

    fn listed(&self) -> Vec<Brick> {
        let mut holds_any = vec![false; self.cell_bricks.n_bricks()];
        for brick in self.voxels.bricks() {
            let [x, y, z] = self.voxel_bricks.coords(brick.brick_idx).map(|at| at >> self.level);
            holds_any[self.cell_bricks.brick_idx([x, y, z]) as usize] = true;
        }
        let held = (0_u32..).zip(holds_any).filter(|(_, holds_any)| *holds_any);
        held.map(|(brick_idx, _)| Brick { brick_idx, first: 0, n_voxels: 0 }).collect()
    }

    /// The bricks of voxels in a brick of cells, and where the first of their cells is in it.
    fn children(&self, cells: &Brick) -> impl Iterator<Item = (&Brick, [usize; 3])> {
        let n_along = self.voxel_bricks.n_along();
        let first = self.cell_bricks.coords(cells.brick_idx).map(|at| at << self.level);
        let side = 1 << self.level;
        let along = |axis: usize| first[axis]..n_along[axis].min(first[axis] + side);
        let [xs, ys, zs] = [0, 1, 2].map(along);
        let rows = zs.flat_map(move |z| ys.clone().map(move |y| (y, z)));
        rows.flat_map(move |(y, z)| {
            let idx_of = |x: usize| self.voxel_bricks.brick_idx([x, y, z]);
            let in_row = idx_of(xs.start)..idx_of(xs.end - 1) + 1;
            self.bricks_between(in_row)
        })
        .map(move |brick| {
            let at = self.voxel_bricks.coords(brick.brick_idx);
            let cells_along = BRICK_SIDE >> self.level;
            (brick, [0, 1, 2].map(|axis| (at[axis] - first[axis]) * cells_along))
        })
    }

    /// The bricks of voxels with these numbers, as far as there are any.
    fn bricks_between(&self, idxs: Range<u32>) -> &[Brick] {
        let bricks = self.voxels.bricks();
        let start = bricks.partition_point(|brick| brick.brick_idx < idxs.start);
        let n_met = bricks[start..].iter().take_while(|brick| brick.brick_idx < idxs.end).count();
        &bricks[start..start + n_met]
    }

    /// The slot of a voxel's cell in a brick where that of the first is `[x, y, z]`.
    #[inline]
    fn cell_of(&self, record: &VoxelRecord, [x, y, z]: [usize; 3]) -> usize {
        let [i, j, k] = record.coords_in_brick().map(|at| at >> self.level);
        ((z + k) * BRICK_SIDE + y + j) * BRICK_SIDE + x + i
    }
}

impl<V: Voxels> Voxels for Cells<V> {
    fn bricks(&self) -> &[Brick] {
        &self.bricks
    }

    fn n_voxels(&self, brick: &Brick) -> u64 {
        self.children(brick).map(|(brick, _)| self.voxels.n_voxels(brick)).sum()
    }

    /// They have no normals: their voxels are lit.
    fn records_of<'a>(
        &'a self,
        brick: &Brick,
        room: &'a mut Vec<VoxelRecord>,
    ) -> &'a [VoxelRecord] {
        let mut is_there = [false; N_SLOTS];
        for (brick, first) in self.children(brick) {
            for record in self.voxels.records_of(brick, room) {
                is_there[self.cell_of(record, first) % N_SLOTS] = true;
            }
        }
        room.clear();
        let slots = (0_u16..).zip(is_there).filter(|(_, is_there)| *is_there);
        room.extend(slots.map(|(slot, _)| VoxelRecord { slot, ..VoxelRecord::default() }));
        room
    }

    fn color(&self, brick: &Brick, records: &[VoxelRecord], colors: &mut [[f32; 4]]) {
        let (mut sums, mut of_voxels) = ([[0.0; 4]; N_SLOTS], [[0.0; 4]; N_SLOTS]);
        let mut room = Vec::new();
        for (brick, first) in self.children(brick) {
            let voxels = self.voxels.records_of(brick, &mut room);
            let of_voxels = &mut of_voxels[..voxels.len()];
            self.voxels.color(brick, voxels, of_voxels);
            for (record, color) in voxels.iter().zip(of_voxels) {
                let sum: &mut [f32; 4] = &mut sums[self.cell_of(record, first) % N_SLOTS];
                sum.iter_mut().zip(color).for_each(|(sum, channel)| *sum += *channel);
            }
        }
        // A step of cells has as many voxels, and kernels of cells have as much less in them.
        let per_row = 1.0 / f32::from(1_u16 << self.level);
        for (record, color) in records.iter().zip(colors) {
            let sum = &sums[usize::from(record.slot) % N_SLOTS];
            for (channel, sum) in color.iter_mut().zip(sum) {
                *channel = sum * per_row;
            }
        }
    }
}
