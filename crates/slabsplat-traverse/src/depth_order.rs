//! Voxels by depth, for `every-sample` (paper §4: "with respect to their distance from the viewing
//! plane").
//!
//! Whole planes of voxels are equally deep in many views, up to rounding, and the order among them shows.
//! So depths are rounded to a grid that is coarser than the rounding errors, and equals are sorted
//! by their position in the picture: the result does not depend on how voxels are stored.

use crate::RelevantList;
use crate::in_pieces::{resize_for_frame, sort_for_frame};
use slabsplat_core::glam::DVec3;
use slabsplat_core::{Cancelled, FrameHandle, Grid, View};

/// Steps of the rounding grid per `unit`.
const STEPS_PER_UNIT: f64 = (1 << 20) as f64;

/// The voxels of a list in the order of depth, front to back; then bottom to top, left to right. Made to be
/// used again.
#[derive(Clone, Debug, Default)]
pub struct DepthOrder {
    /// Depth, up and right in steps of the rounding grid, and the index in the list; sorted.
    keys: Vec<([i64; 3], u32)>,
}

impl DepthOrder {
    /// Makes it that of `list` as `view` sees it, for a frame.
    ///
    /// # Errors
    /// If that is cancelled; the order is then of no meaning.
    pub fn update(
        &mut self,
        grid: &Grid,
        view: &View,
        list: &RelevantList,
        frame: &FrameHandle,
    ) -> Result<(), Cancelled> {
        let view_from_index = view.from_index(grid);
        let steps_per_world = STEPS_PER_UNIT / grid.unit();
        resize_for_frame(&mut self.keys, list.len(), frame)?;
        list.fill_by_brick(&mut self.keys, |brick, records, keys| {
            if frame.is_cancelled() {
                return;
            }
            for ((key, &record), idx) in keys.iter_mut().zip(records).zip(brick.first..) {
                let in_index = list.voxel_coords(brick, record).map(|c| c as f64);
                let at = view_from_index.transform(DVec3::from_array(in_index));
                *key = ([at.z, at.y, at.x].map(|c| (c * steps_per_world).round() as i64), idx);
            }
        });
        sort_for_frame(&mut self.keys, frame);
        frame.check()
    }

    /// How many voxels there are.
    pub fn len(&self) -> usize {
        self.keys.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.keys.is_empty()
    }

    /// The index in the list of the `nth` voxel from the front.
    #[inline]
    pub fn idx_of(&self, nth: usize) -> usize {
        self.keys[nth].1 as usize
    }

    /// Bytes held.
    pub fn resident_bytes(&self) -> usize {
        self.keys.capacity() * size_of::<([i64; 3], u32)>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::BrickRanges;
    use slabsplat_core::{Camera, ImageDesc, IsoRange, Projection, Scaling, Volume};

    /// The order of two voxels above each other, of which the upper one is nearer by so many `unit`s.
    fn order_of_two(unit: f64, nearer: f64) -> [usize; 2] {
        let grid = Grid::with_spacing([1, 2, 1], [unit; 3]).unwrap();
        let target = grid.center_in_world();
        // Looking down on them by a tiny angle.
        let eye = target + 100.0 * unit * DVec3::new(0.0, nearer, 1.0);
        let projection = Projection::Orthographic { view_height: 4.0 * unit };
        let camera = Camera::new(eye, target, DVec3::Y, projection).unwrap();
        let view = View::new(&grid, &camera, &ImageDesc::default()).unwrap();
        let volume = Volume::new(grid, vec![1_u8; 2].into(), Scaling::IDENTITY).unwrap();
        let mut list = RelevantList::default();
        list.update(&volume, &BrickRanges::new(&volume), &[IsoRange { lo: 1.0, hi: 1.0 }], None);
        let mut order = DepthOrder::default();
        order.update(&grid, &view, &list, &FrameHandle::new()).unwrap();
        [order.idx_of(0), order.idx_of(1)]
    }

    /// Steps of depth are parts of a `unit`, whatever its length.
    #[test]
    fn depth_order_is_told_in_units() {
        let step = 1.0 / STEPS_PER_UNIT;
        for unit in [1e-3, 0.3, 1.0, 40.0, 1e5] {
            assert_eq!(order_of_two(unit, 4.0 * step), [1, 0], "{unit}: the nearer one first");
            assert_eq!(order_of_two(unit, -4.0 * step), [0, 1], "{unit}: the nearer one first");
            assert_eq!(
                order_of_two(unit, 0.2 * step),
                [0, 1],
                "{unit}: a tie, the lower one first"
            );
        }
    }

    #[test]
    fn depth_order_breaks_ties_by_position() {
        let grid = Grid::with_spacing([2, 2, 2], [1.0; 3]).unwrap();
        let target = grid.center_in_world();
        // 45°: voxels 1 and 4 (and 3 and 6) are equally deep but for rounding.
        let eye = target + DVec3::new(10.0, 0.0, 10.0);
        let projection = Projection::Orthographic { view_height: 4.0 };
        let camera = Camera::new(eye, target, DVec3::Y, projection).unwrap();
        let view = View::new(&grid, &camera, &ImageDesc::default()).unwrap();
        let volume = Volume::new(grid, vec![1_u8; 8].into(), Scaling::IDENTITY).unwrap();
        let mut list = RelevantList::default();
        list.update(&volume, &BrickRanges::new(&volume), &[IsoRange { lo: 1.0, hi: 1.0 }], None);
        let mut order = DepthOrder::default();
        order.update(&grid, &view, &list, &FrameHandle::new()).unwrap();
        let idxs: Vec<usize> = (0..order.len()).map(|nth| order.idx_of(nth)).collect();
        assert_eq!(idxs, [5, 7, 4, 1, 6, 3, 0, 2]);
        assert!(DepthOrder::default().is_empty() && !order.is_empty());
        assert!((8 * 4 * size_of::<i64>()..512).contains(&order.resident_bytes()));
    }
}
