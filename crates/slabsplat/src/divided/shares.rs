//! Which box belongs to which share, and where a k-d tree is cut for that.

use super::balance::WorkCells;
use std::ops::Range;

/// Voxels along x, y and z.
pub(super) type VoxelBox = [Range<usize>; 3];

/// The boxes of all shares.
#[derive(Debug)]
pub(super) struct Shares {
    own: usize,
    cells: Option<WorkCells>,
    /// None for shares that are more than there are boxes.
    pub(super) boxes: Vec<Option<VoxelBox>>,
}

impl Shares {
    /// So many, of which the tree will be cut by the work in those cells.
    pub(super) fn new(n_shares: usize, own: usize, cells: WorkCells) -> Self {
        Self { own, cells: Some(cells), boxes: vec![None; n_shares] }
    }

    /// One alone.
    pub(super) fn whole() -> Self {
        Self { own: 0, cells: None, boxes: vec![None] }
    }

    /// Whose box that one is in.
    pub(super) fn holding(&self, voxels: &VoxelBox) -> Option<usize> {
        self.boxes.iter().position(|of| of.as_ref().is_some_and(|of| holds(of, voxels)))
    }

    /// All voxels of this share.
    pub(super) fn own_box(&self) -> Option<VoxelBox> {
        self.boxes[self.own].clone()
    }

    /// Whether a box is this share's.
    pub(super) fn are_own(&self, voxels: &VoxelBox) -> bool {
        self.holding(voxels) == Some(self.own)
    }

    /// Begins to cut a tree anew.
    pub(super) fn deal(&mut self) -> Deal<'_> {
        self.boxes.fill(None);
        let all = 0..self.boxes.len();
        Deal { shares: self, waiting: vec![all] }
    }
}

/// Whether a box has all voxels of another one.
pub(super) fn holds(of: &VoxelBox, other: &VoxelBox) -> bool {
    of.iter().zip(other).all(|(of, other)| of.start <= other.start && other.end <= of.end)
}

/// A tree that is being cut, from the root, near sides first.
pub(super) struct Deal<'a> {
    shares: &'a mut Shares,
    /// The shares that boxes are for which are still to come, the next one last.
    waiting: Vec<Range<usize>>,
}

impl Deal<'_> {
    /// Where to cut the next box: between shares, and within the own one as `own_cut` says.
    pub(super) fn cut(
        &mut self,
        voxels: &VoxelBox,
        own_cut: impl FnOnce(&VoxelBox) -> Option<(usize, usize)>,
    ) -> Option<(usize, usize)> {
        let of = self.waiting.pop().expect("a node has two sides");
        if 1 < of.len()
            && let Some(cut) = self.shares.cells.as_ref()?.cut(voxels, of.len())
        {
            let middle = of.start + cut.n_near;
            self.waiting.extend([middle..of.end, of.start..middle]);
            return Some((cut.axis, cut.at));
        }
        // If it is too small for all of them, the first has it.
        self.shares.boxes[of.start].get_or_insert_with(|| voxels.clone());
        if of.start != self.shares.own {
            return None;
        }
        let alone = of.start..of.start + 1;
        let cut = own_cut(voxels);
        if cut.is_some() {
            self.waiting.extend([alone.clone(), alone]);
        }
        cut
    }
}
