//! Voxels summed into cells.

use super::moments::{Moments, of_normal};
use super::record::CellValues;
use crate::{BRICK_SIDE, NORMAL_STEPS, VoxelRecord};

/// Slots in a brick.
pub(super) const N_SLOTS: usize = BRICK_SIDE.pow(3);

/// The slot of a voxel's cell in a brick of cells that each hold `2^level` voxels along every axis, where the
/// first cell of the voxel's own brick is at `first`.
#[inline]
pub(super) fn cell_slot(record: &VoxelRecord, level: u32, [x, y, z]: [usize; 3]) -> usize {
    let [i, j, k] = record.coords_in_brick().map(|at| at >> level);
    (((z + k) * BRICK_SIDE + y + j) * BRICK_SIDE + x + i) % N_SLOTS
}

/// Sums of one cell: extinction `μ`, and `μ` times red, green, blue; `μ` times the normal; `μ` of voxels
/// without one; `μ` times the squares of red, green, blue; `μ²`.
type Sum = [f32; 12];

/// The sums of a brick of cells, once they have been cleared; before, they take no memory.
#[derive(Clone, Debug, Default)]
pub(super) struct CellSums(Vec<Sum>);

/// The sums of a brick's moments; while there are none, as of most bricks of a haze, they are not even zeros.
#[derive(Clone, Debug, Default)]
pub(super) struct MomentSums(Vec<[f32; 6]>);

impl MomentSums {
    pub(super) fn clear(&mut self) {
        self.0.clear();
    }

    /// Adds voxels as [`CellSums::add`] does.
    pub(super) fn add(
        &mut self,
        level: u32,
        first: [usize; 3],
        records: &[VoxelRecord],
        colors: &[[f32; 4]],
    ) {
        self.0.resize(N_SLOTS, [0.0; 6]);
        for (record, [.., mu]) in records.iter().zip(colors) {
            let sum = &mut self.0[cell_slot(record, level, first)];
            for (sum, moment) in sum.iter_mut().zip(of_normal(normal_of(record))) {
                *sum += mu * moment;
            }
        }
    }

    /// Those of the cell in a slot, whose voxels have that extinction together.
    pub(super) fn of_cell(&self, slot: usize, extinction: f32) -> Moments {
        Moments::new(self.0[slot].map(|sum| sum / extinction), slot)
    }
}

#[inline(always)]
fn normal_of(record: &VoxelRecord) -> [f32; 3] {
    record.normal.map(|steps| f32::from(steps) * (1.0 / NORMAL_STEPS))
}

impl CellSums {
    pub(super) fn clear(&mut self) {
        self.0.clear();
        self.0.resize(N_SLOTS, Sum::default());
    }

    /// Adds voxels of a brick, with red, green, blue and extinction of each, where a cell holds `2^level`
    /// along every axis and the first of theirs is at `first`.
    pub(super) fn add(
        &mut self,
        level: u32,
        first: [usize; 3],
        records: &[VoxelRecord],
        colors: &[[f32; 4]],
    ) {
        for (record, &[r, g, b, mu]) in records.iter().zip(colors) {
            let slot = cell_slot(record, level, first);
            let [n_x, n_y, n_z] = normal_of(record);
            let undirected = if record.normal == [0; 3] { 1.0 } else { 0.0 };
            let of_voxel = [1.0, r, g, b, n_x, n_y, n_z, undirected, r * r, g * g, b * b, mu];
            let sum = &mut self.0[slot];
            for (sum, number) in sum.iter_mut().zip(of_voxel) {
                *sum += mu * number;
            }
        }
    }

    /// The sum of a cell's extinctions.
    pub(super) fn extinction(&self, slot: usize) -> f32 {
        self.0[slot][0]
    }

    /// What blocks of 2³ cells have together, of all in which anything is visible, wherever they begin:
    /// extinction per voxel step, and means over it as [`Sum`] has them.
    pub(super) fn blocks(&self, level: u32) -> impl Iterator<Item = (f32, [f32; 11])> {
        let per_voxel = 1.0 / f32::from(1_u16 << (3 * (level + 1)));
        let mut blocks = self.0.clone();
        for stride in [1, BRICK_SIDE, BRICK_SIDE * BRICK_SIDE] {
            for slot in 0..N_SLOTS - stride {
                let next = blocks[slot + stride];
                blocks[slot].iter_mut().zip(next).for_each(|(sum, of_next)| *sum += of_next);
            }
        }
        let is_block = |slot: usize| {
            let at = [slot, slot / BRICK_SIDE, slot / BRICK_SIDE.pow(2)];
            at.iter().all(|at| at % BRICK_SIDE != BRICK_SIDE - 1)
        };
        let blocks = blocks.into_iter().enumerate().filter(move |(slot, _)| is_block(*slot));
        let visible = blocks.filter(|(_, [mu, ..])| 0.0 < *mu);
        visible.map(move |(_, [mu, weighted @ ..])| (mu * per_voxel, weighted.map(|sum| sum / mu)))
    }

    /// The cells in which anything is visible, with their slots.
    pub(super) fn cells(&self, level: u32) -> impl Iterator<Item = (usize, CellValues)> {
        let per_row = 1.0 / f32::from(1_u16 << level);
        self.0.iter().enumerate().filter(|(_, sum)| 0.0 < sum[0]).map(move |(slot, sum)| {
            let [mu, ref weighted @ ..] = *sum;
            let [r, g, b, x, y, z, undirected, ..] = weighted.map(|sum| sum / mu);
            let values = CellValues {
                extinction: mu * per_row,
                color: [r, g, b],
                normal: [x, y, z],
                undirected,
            };
            (slot, values)
        })
    }
}
