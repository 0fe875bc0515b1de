//! Which cells of a layer the host is to list (model §16): the same however the camera turns.

use slabsplat_backend::{CellsPlan, LayerPlan};
use slabsplat_core::glam::DVec3;
use slabsplat_kernel::{CellLimits, LitDifferences, ShareByCells};

/// What decides which bricks of cells of a level are listed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CellsToList {
    pub(crate) limits: CellLimits,
    pub(crate) lit: LitDifferences,
    /// The share of bricks whose turn has come.
    pub(crate) share: ShareByCells,
}

/// A frame's share of bricks is one of so many, or none.
const N_SHARES: u32 = 16;

/// What a layer's cells are to be listed by, if they are.
pub(crate) fn cells_to_list(layer: &LayerPlan<'_>) -> Vec<CellsToList> {
    let to_list = |cells: &CellsPlan<'_>| {
        let share = cells.share_at(nearest_depth(&cells.plan)).in_parts_of(N_SHARES);
        CellsToList { limits: cells.limits, lit: cells.lit, share }
    };
    layer.cells().map(to_list).collect()
}

/// The least depth of any kernel, were the volume a ball and kernels as deep as they are from any side; not
/// before the near depth.
fn nearest_depth(plan: &LayerPlan<'_>) -> f64 {
    let grid = plan.volume.grid();
    let deepest = plan.radius * grid.longest_in_world();
    let from_index = plan.view.from_index(grid);
    let corners = [DVec3::new(1.0, 1.0, 1.0), DVec3::new(-1.0, 1.0, 1.0)];
    let corners =
        corners.into_iter().chain([DVec3::new(1.0, -1.0, 1.0), DVec3::new(1.0, 1.0, -1.0)]);
    let half_diagonal =
        corners.map(|sides| (from_index.matrix * (sides * grid.center_in_index())).length());
    let radius = half_diagonal.fold(0.0, f64::max);
    (from_index.transform(grid.center_in_index()).z - radius - deepest).max(plan.view.near_depth())
}
