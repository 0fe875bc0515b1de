//! Cells as light falls on them, eight at a time.

use super::brick::CellBrick;
use super::record::CellRecord;
use crate::VoxelRecord;

/// Up to eight cells of a brick, component by component; where there are fewer than eight, the others are of
/// no meaning, but finite.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cells8 {
    /// Extinctions per voxel step, as in [`CellValues`](crate::CellValues).
    pub extinctions: [f32; 8],
    /// Red, green and blue before light, 0 … 1.
    pub colors: [[f32; 8]; 3],
    /// Mean normals, x, y and z.
    pub normals: [[f32; 8]; 3],
    /// The shares of voxels without a normal.
    pub undirected: [f32; 8],
    /// The second moments of their normals (xx, yy, zz, xy, xz, yz), if these are known.
    pub moments: Option<[[f32; 8]; 6]>,
}

impl Cells8 {
    /// Those of a brick in the slots of up to eight records, where it has cells. Without a branch on cells,
    /// for whatever vectors the caller is compiled for.
    #[inline(always)]
    pub fn of(brick: &CellBrick, records: &[VoxelRecord]) -> Self {
        let mut idxs = [0; 8];
        for (idx, record) in idxs.iter_mut().zip(records) {
            *idx = brick.idx_of(record.slot);
        }
        let mut cells = [CellRecord::default(); 8];
        for (cell, idx) in cells.iter_mut().zip(idxs) {
            *cell = brick.cells()[idx];
        }
        let mut eight = Self::default();
        for i in 0..8 {
            let values = cells[i].values(brick.largest());
            eight.extinctions[i] = values.extinction;
            eight.undirected[i] = values.undirected;
            for axis in 0..3 {
                eight.colors[axis][i] = values.color[axis];
                eight.normals[axis][i] = values.normal[axis];
            }
        }
        if !brick.moments().is_empty() {
            let mut moments = [[0.0; 8]; 6];
            for i in 0..8 {
                let of_cell = brick.moments()[idxs[i]].values();
                moments.iter_mut().zip(of_cell).for_each(|(all, of_cell)| all[i] = of_cell);
            }
            eight.moments = Some(moments);
        }
        eight
    }
}
