//! The volume cut into bricks of 8³ voxels, which is how relevant voxels are stored and culled.
//!
//! A brick is small enough that its voxels share much (whether they are relevant, whether they are in
//! view, what a cache line brings), and large enough that what is stored of it weighs nothing.

use crate::VoxelRecord;
use slabsplat_core::Grid;
use std::ops::Range;

/// Voxels along each side of a brick.
pub const BRICK_SIDE: usize = 8;

/// Rows of voxels along x in a brick.
pub(crate) const N_ROWS: usize = BRICK_SIDE * BRICK_SIDE;

/// A brick that holds relevant voxels: which one it is, and where in the list its voxels are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Brick {
    /// The brick's number: its index among all bricks of the volume, x fastest.
    pub brick_idx: u32,
    /// Its first voxel's index in the list.
    pub first: u32,
    /// How many relevant voxels it holds, 1 … 512.
    pub n_voxels: u16,
}

/// How a grid is cut into bricks. The last brick along an axis may hold fewer than 8 voxels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BrickGrid {
    dims: [usize; 3],
    n_along: [usize; 3],
    first: [usize; 3],
}

impl Brick {
    /// The indices of its voxels in the list.
    #[inline]
    pub fn voxels(&self) -> Range<usize> {
        let first = self.first as usize;
        first..first + usize::from(self.n_voxels)
    }
}

impl BrickGrid {
    /// The bricks of `grid`, of which the first begins with its first voxel.
    pub fn new(grid: &Grid) -> Self {
        let dims = grid.dims();
        let first = grid.first_in_whole().map(|first| first / BRICK_SIDE);
        Self { dims, n_along: dims.map(|n| n.div_ceil(BRICK_SIDE)), first }
    }

    /// Voxels along x, y and z.
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// Bricks along x, y and z.
    pub fn n_along(&self) -> [usize; 3] {
        self.n_along
    }

    /// Bricks in all.
    pub fn n_bricks(&self) -> usize {
        self.n_along.iter().product()
    }

    /// Where a brick is among bricks along x, y and z.
    #[inline]
    pub fn coords(&self, brick_idx: u32) -> [usize; 3] {
        // 32-bit divisions: a number of a brick fits, and they take a third of the time.
        let [n_x, n_y] = [self.n_along[0] as u32, self.n_along[1] as u32];
        let row = brick_idx / n_x;
        [brick_idx % n_x, row % n_y, row / n_y].map(|coord| coord as usize)
    }

    /// Where a brick is among all bricks of the whole that the grid is part of ([`Grid::whole`]).
    #[inline]
    pub fn coords_in_whole(&self, brick_idx: u32) -> [usize; 3] {
        let coords = self.coords(brick_idx);
        [0, 1, 2].map(|axis| coords[axis] + self.first[axis])
    }

    /// Those of some bricks of the whole that are here, along each axis.
    pub(crate) fn here(&self, in_whole: &[Range<usize>; 3]) -> [Range<usize>; 3] {
        [0, 1, 2].map(|axis| {
            let Range { start, end } = &in_whole[axis];
            let here = |at: usize| at.saturating_sub(self.first[axis]).min(self.n_along[axis]);
            here(*start)..here(*end)
        })
    }

    /// The number of the brick that is there.
    #[inline]
    pub fn brick_idx(&self, [x, y, z]: [usize; 3]) -> u32 {
        let [n_x, n_y, _] = self.n_along;
        ((z * n_y + y) * n_x + x) as u32
    }

    /// The coordinates of a brick's first voxel, the one nearest to voxel `(0, 0, 0)`.
    #[inline]
    pub fn origin(&self, brick_idx: u32) -> [usize; 3] {
        self.coords(brick_idx).map(|coord| coord * BRICK_SIDE)
    }

    /// Voxels along each side of the brick that begins at `origin`: 8, or what is left at the end of an
    /// axis.
    #[inline]
    pub fn size_at(&self, origin: [usize; 3]) -> [usize; 3] {
        std::array::from_fn(|axis| BRICK_SIDE.min(self.dims[axis] - origin[axis]))
    }

    /// The coordinates of a voxel.
    #[inline]
    pub fn voxel_coords(&self, brick: &Brick, record: VoxelRecord) -> [usize; 3] {
        let (origin, offset) = (self.origin(brick.brick_idx), record.coords_in_brick());
        std::array::from_fn(|axis| origin[axis] + offset[axis])
    }

    /// The indices in memory of voxels of a brick, x fastest.
    #[inline(always)]
    pub fn voxel_indices<'a>(
        &self,
        brick: &Brick,
        records: &'a [VoxelRecord],
    ) -> impl Iterator<Item = usize> + use<'a> {
        let [n_x, n_y, _] = self.dims;
        let start = self.voxel_idx(self.origin(brick.brick_idx));
        records.iter().map(move |record| {
            let [x, y, z] = record.coords_in_brick();
            start + (z * n_y + y) * n_x + x
        })
    }

    /// The voxel's index in memory, x fastest.
    #[inline]
    pub fn voxel_idx(&self, coords: [usize; 3]) -> usize {
        (coords[2] * self.dims[1] + coords[1]) * self.dims[0] + coords[0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn brick_grid_covers_every_voxel_once() {
        for dims in [[8, 8, 8], [1, 1, 1], [9, 16, 17], [20, 1, 3]] {
            let grid = Grid::with_spacing(dims, [1.0; 3]).unwrap();
            let bricks = BrickGrid::new(&grid);
            let mut n_seen = vec![0; grid.n_voxels()];
            for brick_idx in 0..bricks.n_bricks() as u32 {
                let origin = bricks.origin(brick_idx);
                assert_eq!(bricks.brick_idx(bricks.coords(brick_idx)), brick_idx);
                let [n_x, n_y, n_z] = bricks.size_at(origin);
                let brick = Brick { brick_idx, first: 0, n_voxels: 0 };
                let mut records: Vec<VoxelRecord> =
                    (0..512).map(|slot| VoxelRecord { slot, normal: [0; 3] }).collect();
                records.retain(|record| {
                    let [x, y, z] = record.coords_in_brick();
                    x < n_x && y < n_y && z < n_z
                });
                let indices = bricks.voxel_indices(&brick, &records);
                for (idx, &record) in indices.zip(&records) {
                    assert_eq!(idx, bricks.voxel_idx(bricks.voxel_coords(&brick, record)));
                    n_seen[idx] += 1;
                }
            }
            assert!(n_seen.iter().all(|&n| n == 1), "{dims:?}");
        }
    }
}
