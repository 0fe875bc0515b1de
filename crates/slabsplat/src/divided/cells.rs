//! How coarse cells boxes are drawn by (model §16), and how large boxes are then.
//!
//! Whether a brick of cells is drawn depends on all of it, so that a box is read with all bricks that it
//! shows anything of: those of the coarsest level have 64 voxels along each side. Where that makes more to be
//! read than it saves, finer cells are drawn, of all boxes alike.

use super::budget::{Budget, LayerInBoxes};
use super::shares::Shares;
use super::{DividedError, Exchange};
use slabsplat_core::{PartSupport, PartTree, Samples};

/// How many voxels more than without cells may be read for them, as a part of these: one of so many. With a
/// fourteenth a haze of 10⁹ voxels took 0.84 of the time, with two sevenths 1.04, and what is opaque 1.2.
const OF_MORE: u64 = 8;

/// Boxes for a level of cells.
pub(super) struct Boxes {
    pub(super) tree: PartTree,
    /// What is left of the memory.
    pub(super) left_bytes: u64,
    /// Around a box, layer by layer.
    pub(super) supports: Vec<PartSupport>,
    /// Voxels that are read for all own boxes.
    n_read: u64,
}

impl Boxes {
    /// Those of all shares, with the coarsest cells for which none of them reads too much; `layers` have the
    /// coarsest by which anything of them may be drawn.
    ///
    /// # Errors
    /// If not even the smallest boxes fit, or the others are not there.
    pub(super) fn new(
        budget: &Budget,
        layers: &[LayerInBoxes<'_>],
        (shares, has_chunks): (&mut Shares, bool),
        others: &mut dyn Exchange,
    ) -> Result<Self, DividedError> {
        let by_voxels = Self::of_level(budget, layers, 0, (&mut *shares, has_chunks));
        let most = layers.iter().map(|of| of.support.coarsest).max().unwrap_or(0);
        let n_most = by_voxels.as_ref().map_or(0, |boxes| boxes.n_read + boxes.n_read / OF_MORE);
        let own = (1..=most).rev().find(|level| {
            let boxes = Self::of_level(budget, layers, *level, (&mut *shares, has_chunks));
            boxes.is_ok_and(|boxes| boxes.n_read <= n_most)
        });
        // All have to draw the same cells, and hear of it even if one has no room.
        let all = others.all(Ok(Samples::U8(vec![own.unwrap_or(0) as u8])))?;
        by_voxels?;
        let level = all.iter().map(|of| match of {
            Samples::U8(level) => level.first().copied().ok_or(DividedError::Differing),
            _ => Err(DividedError::Differing),
        });
        let levels = level.collect::<Result<Vec<u8>, _>>()?;
        let level = levels.into_iter().min().unwrap_or(0);
        Self::of_level(budget, layers, level.into(), (shares, has_chunks))
    }

    fn of_level(
        budget: &Budget,
        layers: &[LayerInBoxes<'_>],
        level: u32,
        (shares, has_chunks): (&mut Shares, bool),
    ) -> Result<Self, DividedError> {
        let with_cells =
            |of: &LayerInBoxes<'_>| of.support.with_cells(level.min(of.support.coarsest));
        let supports: Vec<PartSupport> = layers.iter().map(with_cells).collect();
        let layers = layers.iter().zip(&supports);
        let layers: Vec<LayerInBoxes<'_>> =
            layers.map(|(of, support)| LayerInBoxes { support: *support, ..*of }).collect();
        let (tree, left_bytes) = budget.boxes(&layers, (shares, has_chunks))?;
        let own = tree.seen_by(budget.camera()).into_iter();
        let own = own.filter(|of| shares.are_own(&of.voxels));
        let n_near = |dims: [usize; 3]| dims.iter().map(|n| *n as u64).product::<u64>();
        let n_read =
            own.flat_map(|of| layers.iter().map(|layer| n_near(layer.dims_near(&tree, of)))).sum();
        Ok(Self { tree, left_bytes, supports, n_read })
    }
}
