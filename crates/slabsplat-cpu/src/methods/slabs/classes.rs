//! Classes of voxels: those of one wait for equally many slabs and are drawn in one way.
//!
//! A tile keeps them apart, so that a slab does not look at voxels that it cannot hold, and a loop has one
//! kind of section.

use crate::sections::shared::Kind;
use crate::sections::span::SpannedVoxel;

/// Classes of spans: one slab, up to three, more.
const N_SPAN_CLASSES: usize = 3;

/// First come the classes that may be drawn by separable footprints, by their spans, then the others.
pub(super) const N_CLASSES: usize = 2 * N_SPAN_CLASSES;

/// What decides the class of a voxel, and what a class is like.
pub(super) struct Classes {
    /// Voxels of no more extinction may be drawn by separable footprints.
    pub(super) most_of_separable: f32,
    /// Whether sections may be merged; a voxel with one slab is then drawn whole.
    pub(super) is_merged: bool,
    /// How voxels are drawn that are not whole.
    pub(super) kind: Kind,
    /// How many slabs before a slab any voxel may start that is drawn in it.
    pub(super) n_before: usize,
}

impl Classes {
    #[inline(always)]
    pub(super) fn of(&self, voxel: &SpannedVoxel) -> usize {
        let by_span = match voxel.sheets.n_more() {
            0 => 0,
            1..=2 => 1,
            _ => 2,
        };
        if voxel.color[3] <= self.most_of_separable { by_span } else { N_SPAN_CLASSES + by_span }
    }

    /// Whether voxels of a class may be drawn by separable footprints.
    pub(super) fn may_be_separable(class: usize) -> bool {
        class < N_SPAN_CLASSES
    }

    /// What the sections of a class are like.
    pub(super) fn kind_of(&self, class: usize) -> Kind {
        match class % N_SPAN_CLASSES {
            0 if self.is_merged => Kind::Whole,
            _ => self.kind,
        }
    }

    /// How many slabs before a slab the voxels of a class may start that are drawn in it.
    pub(super) fn n_before(&self, class: usize) -> usize {
        [0, 2, self.n_before][class % N_SPAN_CLASSES].min(self.n_before)
    }
}
