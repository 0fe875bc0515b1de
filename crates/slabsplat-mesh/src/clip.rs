//! What of a triangle lies behind the near depth.

use crate::vertices::Corner;
use slabsplat_core::View;

/// Whether all of a triangle lies at the near depth or behind it, and where numbers can hold it: so it is
/// with nearly all triangles, and they need not be cut.
pub(crate) fn is_behind_near(triangle: &[Corner; 3], view: &View) -> bool {
    let near = view.near_depth();
    triangle.iter().all(|it| near <= it.point.z && it.at.iter().all(|c| c.is_finite()))
}

/// The rectangle of the image around corners: its least and its greatest corner. There is none around none.
pub(crate) fn bounds_of(corners: &[Corner]) -> Option<[[f64; 2]; 2]> {
    let corners = corners.iter().map(|corner| [corner.at; 2]);
    corners.reduce(|[min, max], [a, b]| {
        [[0, 1].map(|axis| min[axis].min(a[axis])), [0, 1].map(|axis| max[axis].max(b[axis]))]
    })
}

/// A convex polygon of three or four corners, or of none.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Polygon {
    corners: [Corner; 4],
    n_corners: usize,
}

impl Polygon {
    /// The part of a triangle at the near depth and behind it. Nothing, if numbers cannot hold where it is.
    pub(crate) fn behind_near(triangle: [Corner; 3], view: &View) -> Self {
        let near = view.near_depth();
        let mut polygon = Self::default();
        for (idx, corner) in triangle.iter().enumerate() {
            let next = &triangle[(idx + 1) % 3];
            let (is_behind, is_next_behind) = (near <= corner.point.z, near <= next.point.z);
            if is_behind {
                polygon.push(*corner);
            }
            if is_behind != is_next_behind {
                // From the same end, whichever way round: triangles that share the edge share the point.
                let (from, to) = if is_behind { (corner, next) } else { (next, corner) };
                polygon.push(crossing(from, to, view));
            }
        }
        let is_somewhere = polygon.corners().iter().all(|it| it.at.iter().all(|c| c.is_finite()));
        if is_somewhere { polygon } else { Self::default() }
    }

    fn push(&mut self, corner: Corner) {
        self.corners[self.n_corners] = corner;
        self.n_corners += 1;
    }

    pub(crate) fn corners(&self) -> &[Corner] {
        &self.corners[..self.n_corners]
    }

    /// The triangles that it consists of.
    pub(crate) fn triangles(&self) -> impl Iterator<Item = [Corner; 3]> {
        let corners = self.corners;
        (2..self.n_corners).map(move |last| [corners[0], corners[last - 1], corners[last]])
    }
}

/// Where the way from a corner behind the near depth to one before it meets that.
fn crossing(from: &Corner, to: &Corner, view: &View) -> Corner {
    let near = view.near_depth();
    let share = (near - from.point.z) / (to.point.z - from.point.z);
    let point = from.point + share * (to.point - from.point);
    Corner::of(point.with_z(near), view)
}
