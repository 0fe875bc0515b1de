//! Where the last six sheets of a tile lie.

use super::sheets::{N_BESIDE, N_SHEETS};
use slabsplat_core::{SlabGrid, View};

/// Depths of sheets, by the slab of the last one.
#[derive(Clone, Copy)]
pub(super) struct Depths<'a> {
    pub(super) slabs: &'a SlabGrid,
    pub(super) view: View,
}

impl Depths<'_> {
    /// The middles of the two sheets in the middle, where they have their nodes.
    pub(super) fn of_nodes(&self, last: usize) -> [f32; 2] {
        // Sheets before the first are empty.
        let middle = |back: usize| {
            let slab = last as f64 - back as f64;
            (self.slabs.middle(0) + slab * self.slabs.thickness()) as f32
        };
        [middle(N_BESIDE + 1), middle(N_BESIDE)]
    }

    /// World units between the pixels of all six.
    pub(super) fn pixel_sizes(&self, last: usize) -> [f32; N_SHEETS] {
        std::array::from_fn(|idx| {
            let slab = (last + 1 + idx).saturating_sub(N_SHEETS);
            // Sheets before the near depth are empty, and have no pixels.
            let depth = self.slabs.middle(slab).max(self.view.near_depth());
            (1.0 / self.view.pixels_per_world(depth)) as f32
        })
    }
}
