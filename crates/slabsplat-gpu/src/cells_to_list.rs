//! Which cells of a layer the host is to list, and how long what it has listed serves (model §16).

use slabsplat_backend::{CellsPlan, LayerPlan};
use slabsplat_core::glam::DVec3;
use slabsplat_kernel::CellLimits;

/// What decides which bricks of cells of a level are listed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CellsToList {
    pub(crate) limits: CellLimits,
    pub(crate) lit: [f64; 2],
    /// The share of bricks whose turn has come.
    pub(crate) share: f64,
}

/// A frame's share of bricks is one of so many, or none.
const N_SHARES: f64 = 16.0;

/// By what share of a plan's limits lists are made, and the least of a later plan's by which these still are
/// what it asks for: as rays cross unequal steps, kernels are more or less deep.
const SHARE_OF_LIMITS: f64 = 0.95;
const LEAST_SHARE_OF_LIMITS: f64 = 0.7;

/// What a layer's cells are to be listed by, if they are.
pub(crate) fn cells_to_list(layer: &LayerPlan<'_>) -> Vec<CellsToList> {
    let to_list = |cells: &CellsPlan<'_>| {
        let share = (cells.share_at(nearest_depth(&cells.plan)) * N_SHARES).floor() / N_SHARES;
        CellsToList { limits: cells.limits.share(SHARE_OF_LIMITS), lit: cells.lit, share }
    };
    layer.cells().map(to_list).collect()
}

/// Whether what was listed by the first may be drawn where the others are asked for.
pub(crate) fn serve(listed: &[CellsToList], asked: &[CellsToList]) -> bool {
    let serves = |listed: &CellsToList, asked: &CellsToList| {
        let most = asked.limits.share(1.0 / SHARE_OF_LIMITS);
        let least = most.share(LEAST_SHARE_OF_LIMITS);
        listed.share == asked.share
            && listed.lit == asked.lit
            && listed.limits.by_mean_normals == asked.limits.by_mean_normals
            && listed.limits.are_within(&most)
            && least.are_within(&listed.limits)
    };
    listed.len() == asked.len() && listed.iter().zip(asked).all(|(a, b)| serves(a, b))
}

/// The least depth of any kernel, were the volume a ball; not before the near depth.
fn nearest_depth(plan: &LayerPlan<'_>) -> f64 {
    let grid = plan.volume.grid();
    let from_index = plan.view.from_index(grid);
    let corners = [DVec3::new(1.0, 1.0, 1.0), DVec3::new(-1.0, 1.0, 1.0)];
    let corners =
        corners.into_iter().chain([DVec3::new(1.0, -1.0, 1.0), DVec3::new(1.0, 1.0, -1.0)]);
    let half_diagonal =
        corners.map(|sides| (from_index.matrix * (sides * from_index.center_in_index)).length());
    let radius = half_diagonal.fold(0.0, f64::max);
    (from_index.center_in_view.z - radius - plan.half_depth).max(plan.view.near_depth())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_to_list_serve_within_limits() {
        let limits =
            CellLimits { contrast: 1.0, noise: 1.0, extinction: 1.0, by_mean_normals: 1.0 };
        let of =
            |share: f64| [CellsToList { limits: limits.share(share), lit: [1.0; 2], share: 1.0 }];
        let serving = [0.9, 0.96, 1.0, 1.2, 1.3, 1.5].map(|asked| serve(&of(1.0), &of(asked)));
        assert_eq!(serving, [false, true, true, true, true, false]);
        assert!(!serve(&of(1.0), &[]));
    }
}
