//! Cells as light falls on them, sixteen at a time.

use super::brick::CellBrick;
use super::record::CellRecord;
use crate::VoxelRecord;

/// Up to sixteen cells of a brick, component by component; where there are fewer, the others are of no
/// meaning, but finite.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cells16 {
    /// Extinctions per voxel step, as in [`CellValues`](crate::CellValues).
    pub extinctions: [f32; Cells16::N],
    /// Red, green and blue before light, 0 … 1.
    pub colors: [[f32; Cells16::N]; 3],
    /// Mean normals, x, y and z.
    pub normals: [[f32; Cells16::N]; 3],
    /// The shares of voxels without a normal.
    pub undirected: [f32; Cells16::N],
    /// The second moments of their normals (xx, yy, zz, xy, xz, yz), if these are known.
    pub moments: Option<[[f32; Cells16::N]; 6]>,
}

impl Cells16 {
    /// So many. A cell's numbers follow from each other: of eight at a time, one vector, each waits for the
    /// one before.
    pub const N: usize = 16;

    /// Those of a brick in the slots of up to sixteen records, where it has cells. Without a branch on cells,
    /// for whatever vectors the caller is compiled for.
    #[inline(always)]
    pub fn of(brick: &CellBrick, records: &[VoxelRecord]) -> Self {
        let mut idxs = [0; Self::N];
        for (idx, record) in idxs.iter_mut().zip(records) {
            *idx = brick.idx_of(record.slot);
        }
        let mut cells = [CellRecord::default(); Self::N];
        for (cell, idx) in cells.iter_mut().zip(idxs) {
            *cell = brick.cells()[idx];
        }
        let mut all = Self::default();
        for (i, cell) in cells.into_iter().enumerate() {
            let values = cell.values(brick.largest());
            all.extinctions[i] = values.extinction;
            all.undirected[i] = values.undirected;
            for axis in 0..3 {
                all.colors[axis][i] = values.color[axis];
                all.normals[axis][i] = values.normal[axis];
            }
        }
        if !brick.moments().is_empty() {
            let mut moments = [[0.0; Self::N]; 6];
            for i in 0..Self::N {
                let of_cell = brick.moments()[idxs[i]].values();
                moments.iter_mut().zip(of_cell).for_each(|(moments, it)| moments[i] = it);
            }
            all.moments = Some(moments);
        }
        all
    }
}
