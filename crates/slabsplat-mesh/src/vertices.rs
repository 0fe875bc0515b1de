//! The vertices of all meshes of a frame, in the view and in the image.

use rayon::prelude::*;
use slabsplat_backend::{MeshPlan, MeshesPlan};
use slabsplat_core::glam::{DMat3, DVec3};
use slabsplat_core::{FrameHandle, View};

/// A corner of a triangle, at the near depth or behind it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Corner {
    /// In view space.
    pub(crate) point: DVec3,
    /// In pixels from the upper left corner of the image.
    pub(crate) at: [f64; 2],
    /// Pixels per world unit there: what is even over a triangle in space is so in the image times this.
    pub(crate) scale: f64,
}

/// A vertex of a mesh.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Vertex {
    /// Only its point means anything before the near depth.
    pub(crate) corner: Corner,
    /// In world space, of length 1 or 0; of no meaning if the mesh has none.
    pub(crate) normal: [f32; 3],
}

/// Vertices that a thread projects at a time.
const CHUNK_LEN: usize = 1 << 12;

impl Corner {
    /// A point of view space that is not before the near depth.
    pub(crate) fn of(point: DVec3, view: &View) -> Self {
        let scale = view.pixels_per_world(point.z);
        let [width, height] = view.image_size().map(f64::from);
        let at = [0.5 * width + point.x * scale, 0.5 * height - point.y * scale];
        Self { point, at, scale }
    }
}

/// Projects the vertices of a mesh into as many.
pub(crate) fn project(
    (plan, handle): (&MeshesPlan<'_>, &FrameHandle),
    of_mesh: &MeshPlan<'_>,
    vertices: &mut [Vertex],
) {
    let view = &plan.view;
    let (mesh, near) = (&of_mesh.layer.mesh, view.near_depth());
    let axes = view.axes();
    let view_from_world = DMat3::from_cols(axes.right, axes.up, axes.forward).transpose();
    let world_from_mesh = of_mesh.layer.world_from_mesh();
    let world_from_normal = world_from_mesh.matrix3.inverse().transpose();
    let origin = view.origin_in_world();
    let chunks = vertices.par_chunks_mut(CHUNK_LEN).enumerate();
    chunks.for_each(|(chunk, vertices)| {
        if handle.is_cancelled() {
            return;
        }
        for (vertex, idx) in vertices.iter_mut().zip(chunk * CHUNK_LEN..) {
            let in_world = world_from_mesh.transform_point3(mesh.positions()[idx]);
            let point = view_from_world * (in_world - origin);
            let corner = if near <= point.z {
                Corner::of(point, view)
            } else {
                Corner { point, ..Corner::default() }
            };
            let normal = mesh.vertex_normal(idx).map_or([0.0; 3], |normal| {
                let normal = DVec3::from_array(normal.map(f64::from));
                (world_from_normal * normal).normalize_or_zero().as_vec3().to_array()
            });
            *vertex = Vertex { corner, normal };
        }
    });
}
