//! A k-d tree of boxes that are already there.

use slabsplat::{Grid, PartTree};
use std::ops::Range;
use thiserror::Error;

/// First and last voxels along x, y and z, the last not included.
pub type VoxelBox = [Range<usize>; 3];

/// Why boxes cannot be drawn one behind the other.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum BoxError {
    /// A box reaches out of the grid, or is the wrong way around.
    #[error("the box {voxels:?} of rank {rank} is not in a grid of {dims:?} voxels")]
    Outside {
        /// Whose.
        rank: usize,
        /// Its voxels.
        voxels: VoxelBox,
        /// Those of the grid.
        dims: [usize; 3],
    },
    /// Ranks have other grids.
    #[error("the grid of rank {rank} is not that of rank 0")]
    OtherGrid {
        /// Whose.
        rank: usize,
    },
    /// No plane parts the boxes, they overlap, or voxels are in none.
    #[error("the boxes of the ranks within {0:?} overlap, leave a gap, or are parted by no plane")]
    NoTree(VoxelBox),
}

/// A box, and its grid, by which ranks find out whether they have the same.
pub(super) fn to_bytes(own: &VoxelBox, grid: &Grid) -> Vec<u8> {
    let ends = own.iter().flat_map(|range| [range.start as u64, range.end as u64]);
    let dims = grid.dims().map(|n| n as u64);
    let map = grid.world_from_index().to_cols_array().map(f64::to_bits);
    ends.chain(dims).chain(map).flat_map(u64::to_le_bytes).collect()
}

/// The boxes of all.
pub(super) fn from_bytes(all: &[Vec<u8>], grid: &Grid) -> Result<Vec<VoxelBox>, BoxError> {
    const OF_BOX: usize = 6 * 8;
    let dims = grid.dims();
    let boxes = all.iter().enumerate().map(|(rank, bytes)| {
        let other = BoxError::OtherGrid { rank };
        let (voxels, rest) = bytes.split_at_checked(OF_BOX).ok_or(other.clone())?;
        if all[0].get(OF_BOX..) != Some(rest) {
            return Err(other);
        }
        let at = |idx: usize| {
            let numbers = voxels.as_chunks().0;
            usize::try_from(u64::from_le_bytes(numbers[idx])).unwrap_or(usize::MAX)
        };
        let voxels = [0, 1, 2].map(|axis| at(2 * axis)..at(2 * axis + 1));
        let is_in = voxels.iter().zip(dims).all(|(of, n)| of.start <= of.end && of.end <= n);
        if is_in { Ok(voxels) } else { Err(BoxError::Outside { rank, voxels, dims }) }
    });
    boxes.collect()
}

/// A tree whose leaves are those boxes that are not empty.
pub(super) fn tree(grid: &Grid, boxes: &[VoxelBox]) -> Result<PartTree, BoxError> {
    let boxes: Vec<&VoxelBox> =
        boxes.iter().filter(|of| of.iter().all(|range| !range.is_empty())).collect();
    let mut failed = None;
    let tree = PartTree::new(grid, grid.center_in_world(), |voxels| {
        let within: Vec<&VoxelBox> = boxes.iter().copied().filter(|of| meets(of, voxels)).collect();
        if failed.is_some() || within == [voxels] {
            return None;
        }
        let cut = cut(voxels, &within);
        if cut.is_none() {
            failed = Some(voxels.clone());
        }
        cut
    });
    failed.map_or(Ok(tree), |voxels| Err(BoxError::NoTree(voxels)))
}

pub(super) fn meets(a: &VoxelBox, b: &VoxelBox) -> bool {
    a.iter().zip(b).all(|(a, b)| a.start.max(b.start) < a.end.min(b.end))
}

/// Where no box is cut, as near to the middle as that is.
fn cut(voxels: &VoxelBox, within: &[&VoxelBox]) -> Option<(usize, usize)> {
    let cuts = (0..3).flat_map(|axis| {
        let ends = within.iter().map(move |of| of[axis].start);
        let is_between = move |at: &usize| {
            let Range { start, end } = voxels[axis];
            start < *at
                && *at < end
                && within.iter().all(|of| of[axis].end <= *at || *at <= of[axis].start)
        };
        ends.filter(is_between).map(move |at| (axis, at))
    });
    cuts.min_by_key(|(axis, at)| {
        let near = within.iter().filter(|of| of[*axis].end <= *at).count();
        (2 * near).abs_diff(within.len())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(dims: [usize; 3], boxes: &[VoxelBox], is_tree: bool) {
        let grid = Grid::with_spacing(dims, [1.0; 3]).unwrap();
        assert_eq!(tree(&grid, boxes).is_ok(), is_tree, "{boxes:?}");
    }

    #[test]
    fn boxes_of_a_tree_are_taken_and_others_refused() {
        check([4, 4, 4], &[[0..4, 0..4, 0..4]], true);
        check([4, 4, 4], &[[0..2, 0..4, 0..4], [2..4, 0..4, 0..4], [0..0, 0..0, 0..0]], true);
        check([4, 4, 4], &[[0..2, 0..4, 0..4], [2..4, 0..4, 0..3]], false);
        check([4, 4, 4], &[[0..3, 0..4, 0..4], [2..4, 0..4, 0..4]], false);
        check([4, 4, 4], &[[0..3, 0..4, 0..4]], false);
        // A pinwheel around a middle that nobody can see past in order.
        let pinwheel = [[0..2, 0..1], [2..3, 0..2], [1..3, 2..3], [0..1, 1..3], [1..2, 1..2]];
        let pinwheel = pinwheel.map(|[x, y]| [x, y, 0..1]);
        check([3, 3, 1], &pinwheel, false);
        let mut regular = Vec::new();
        for idx in 0..12 {
            let [i, j, k] = [idx % 3, idx / 3 % 2, idx / 6];
            regular.push([i * 4..i * 4 + 4, j * 5..j * 5 + 5, k * 3..k * 3 + 3]);
        }
        check([12, 10, 6], &regular, true);
    }

    #[test]
    fn boxes_outside_are_refused() {
        let grid = Grid::with_spacing([4, 4, 4], [1.0; 3]).unwrap();
        let other = Grid::with_spacing([4, 4, 4], [2.0; 3]).unwrap();
        let bytes = |of: VoxelBox| to_bytes(&of, &grid);
        let inside = bytes([0..4, 1..2, 3..3]);
        assert_eq!(from_bytes(std::slice::from_ref(&inside), &grid), Ok(vec![[0..4, 1..2, 3..3]]));
        let outside = from_bytes(&[inside.clone(), bytes([0..5, 1..2, 3..3])], &grid);
        assert!(matches!(outside, Err(BoxError::Outside { rank: 1, .. })));
        let of_other = from_bytes(&[inside, to_bytes(&[0..4, 1..2, 3..3], &other)], &grid);
        assert_eq!(of_other, Err(BoxError::OtherGrid { rank: 1 }));
        assert!(from_bytes(&[vec![1, 2, 3]], &grid).is_err());
    }
}
