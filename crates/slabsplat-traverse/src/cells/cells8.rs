//! Cells as light falls on them, eight at a time.

use super::brick::CellBrick;
use super::record::CellValues;

/// Up to eight cells of a brick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cells8 {
    /// What they are; where there are fewer than eight, nothing.
    pub values: [CellValues; 8],
    /// The second moments of their normals (xx, yy, zz, xy, xz, yz), if these are known.
    pub moments: Option<[[f32; 6]; 8]>,
}

impl Cells8 {
    /// Those of a brick with these indices among its [`cells`](CellBrick::cells), no more than eight.
    #[inline]
    pub fn of(brick: &CellBrick, idxs: impl Iterator<Item = usize>) -> Self {
        let mut eight = Self::default();
        let mut moments = [[0.0; 6]; 8];
        for ((idx, values), moments) in idxs.zip(&mut eight.values).zip(&mut moments) {
            *values = brick.cells()[idx].values(brick.largest());
            if let Some(of_cell) = brick.moments().get(idx) {
                *moments = of_cell.values();
            }
        }
        eight.moments = (!brick.moments().is_empty()).then_some(moments);
        eight
    }
}
