//! The box of axes, and how its edges are seen.
//!
//! The box is that of the world's axes, so that coordinates are the world's, however a grid stands. Of its
//! edges those at which only faces meet that look to the eye are left out: they would lie before the volume.
//! Those between a face that does and one that does not are the outline, along which coordinates stand, as
//! nothing of the volume is outside of it.

use slabsplat_core::glam::DVec3;
use slabsplat_core::{Grid, Scene};

use crate::lengths::Unit;
use crate::screen::Screen;

/// The least and the greatest corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds(pub(super) [DVec3; 2]);

/// An edge of a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Edge {
    pub(super) axis: usize,
    pub(super) ends: [DVec3; 2],
    /// How many of the two faces that meet there look to the eye.
    pub(super) n_front: usize,
}

/// Parts of a face's ray and normal by which it looks to the eye; what is seen along has no front.
const FRONT_COSINE: f64 = 1e-6;

impl Bounds {
    /// Of all volumes and meshes; `None` if there are none.
    pub(super) fn of(scene: &Scene) -> Option<Self> {
        let volumes = scene.layers.iter().flat_map(|layer| voxel_corners(layer.volume.grid()));
        let meshes = scene.meshes.iter().filter_map(slabsplat_core::MeshLayer::bounds).flatten();
        let points = volumes.chain(meshes).map(|point| [point, point]);
        points.reduce(|[min, max], [at, _]| [min.min(at), max.max(at)]).map(Self)
    }

    pub(super) fn size(&self) -> DVec3 {
        self.0[1] - self.0[0]
    }

    pub(super) fn middle(&self) -> DVec3 {
        self.0[0].midpoint(self.0[1])
    }

    /// What coordinates are in.
    pub(super) fn unit(&self, is_metric: bool) -> Unit {
        Unit::of_axis(self.size().max_element(), is_metric)
    }

    /// Whether a face looks to the eye: that of an axis at its least or its greatest.
    fn is_front(&self, screen: &Screen, axis: usize, is_greatest: bool) -> bool {
        let end = self.0[usize::from(is_greatest)];
        let mut point = self.middle();
        point[axis] = end[axis];
        let outwards = DVec3::AXES[axis] * if is_greatest { 1.0 } else { -1.0 };
        let ray = screen.ray_to(point);
        ray.dot(outwards) < -FRONT_COSINE * ray.length()
    }

    pub(super) fn edges(&self, screen: &Screen) -> Vec<Edge> {
        let edge = |axis: usize, is_greatest: [bool; 2]| {
            let across = [(axis + 1) % 3, (axis + 2) % 3];
            let mut ends = self.0;
            let mut n_front = 0;
            for (across, is_greatest) in across.into_iter().zip(is_greatest) {
                let at = self.0[usize::from(is_greatest)][across];
                ends.iter_mut().for_each(|end| end[across] = at);
                n_front += usize::from(self.is_front(screen, across, is_greatest));
            }
            Edge { axis, ends, n_front }
        };
        let corners = [[false, false], [false, true], [true, false], [true, true]];
        (0..3).flat_map(|axis| corners.map(|corner| edge(axis, corner))).collect()
    }
}

/// The corners of all voxels together, half a step beyond where the outermost sit.
fn voxel_corners(grid: &Grid) -> impl Iterator<Item = DVec3> + use<> {
    let (world_from_index, n_voxels) = (grid.world_from_index(), grid.dims().map(|n| n as f64));
    (0..8).map(move |corner: u8| {
        let is_last = [0, 1, 2].map(|axis| f64::from(corner >> axis & 1));
        world_from_index.transform_point3(DVec3::from(is_last) * DVec3::from(n_voxels) - 0.5)
    })
}
