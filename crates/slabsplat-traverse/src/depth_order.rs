//! Voxels by depth, for `every-sample` (paper §4: "with respect to their distance from the viewing
//! plane").
//!
//! Whole planes of voxels are equally deep in many views, up to rounding, and the order among them shows.
//! So depths are rounded to a grid that is coarser than the rounding errors, and equals are sorted
//! by their place in the picture: the result does not depend on how voxels are stored.

use crate::RelevantList;
use rayon::prelude::*;
use slabsplat_core::glam::DVec3;
use slabsplat_core::{Grid, View};

/// Steps of the rounding grid per `unit`.
const STEPS_PER_UNIT: f64 = (1 << 20) as f64;

/// The places of the list's voxels in the order of depth, front to back; then bottom to top, left to right.
pub fn depth_order(grid: &Grid, view: &View, list: &RelevantList) -> Vec<u32> {
    let view_from_index = view.from_index(grid);
    let steps_per_world = STEPS_PER_UNIT / grid.unit();
    let mut keys = vec![([0_i64; 3], 0_u32); list.len()];
    list.fill_by_brick(&mut keys, |brick, records, keys| {
        for ((key, &record), place) in keys.iter_mut().zip(records).zip(brick.first..) {
            let in_index = list.voxel_coords(brick, record).map(|c| c as f64);
            let at = view_from_index.transform(DVec3::from_array(in_index));
            *key = ([at.z, at.y, at.x].map(|c| (c * steps_per_world).round() as i64), place);
        }
    });
    keys.par_sort_unstable();
    keys.into_iter().map(|(_, place)| place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::BrickRanges;
    use slabsplat_core::{Camera, ImageDesc, IsoRange, Projection, Scaling, Volume};

    #[test]
    fn depth_order_breaks_ties_by_place() {
        let grid = Grid::with_spacing([2, 2, 2], [1.0; 3]).unwrap();
        let target = grid.center_in_world();
        // 45°: voxels 1 and 4 (and 3 and 6) are equally deep but for rounding.
        let eye = target + DVec3::new(10.0, 0.0, 10.0);
        let projection = Projection::Orthographic { view_height: 4.0 };
        let camera = Camera::new(eye, target, DVec3::Y, projection).unwrap();
        let view = View::new(&grid, &camera, &ImageDesc::default());
        let volume = Volume::new(grid, vec![1_u8; 8].into(), Scaling::IDENTITY).unwrap();
        let mut list = RelevantList::default();
        list.update(&volume, &BrickRanges::new(&volume), &[IsoRange { lo: 1.0, hi: 1.0 }]);
        assert_eq!(depth_order(&grid, &view, &list), [5, 7, 4, 1, 6, 3, 0, 2]);
    }
}
