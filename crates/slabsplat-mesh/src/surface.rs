//! The lit colour at which a ray ends.

use crate::vertices::Vertex;
use slabsplat_backend::MeshPlan;
use slabsplat_core::glam::{DMat3, DVec3};
use slabsplat_core::{MeshLayer, ViewRay};

/// A triangle that was hit.
pub(crate) struct Surface<'a> {
    pub(crate) of_mesh: &'a MeshPlan<'a>,
    /// Its number in the mesh.
    pub(crate) triangle: usize,
    pub(crate) vertices: [&'a Vertex; 3],
    pub(crate) world_from_normal: DMat3,
}

impl Surface<'_> {
    /// Whether it looks the same everywhere.
    pub(crate) fn is_even(&self) -> bool {
        let MeshLayer { mesh, color, .. } = self.of_mesh.layer;
        mesh.normals(self.triangle).is_none()
            && (color.is_some() || mesh.colors(self.triangle).is_none())
    }

    /// Its colour where a ray meets it.
    pub(crate) fn color(&self, ray: &ViewRay) -> [f32; 3] {
        let MeshLayer { mesh, color, .. } = self.of_mesh.layer;
        let shares = self.shares(ray);
        let color = color.unwrap_or_else(|| {
            let of_corners = mesh.colors(self.triangle);
            of_corners.map_or(MeshLayer::DEFAULT_COLOR, |colors| mean(shares, colors).to_array())
        });
        let color = DVec3::from_array(color);
        let light = self.of_mesh.light.as_ref();
        let lit = light.map_or(color, |light| light.lit(color, self.normal(shares)));
        lit.as_vec3().to_array()
    }

    /// In world space, of length 1 or 0.
    fn normal(&self, shares: [f64; 3]) -> DVec3 {
        let MeshLayer { mesh, .. } = self.of_mesh.layer;
        if mesh.normals(self.triangle).is_some() {
            return mean(shares, self.vertices.map(|vertex| vertex.normal)).normalize_or_zero();
        }
        (self.world_from_normal * mesh.face_normal(self.triangle)).normalize_or_zero()
    }

    /// How much its corners count where a ray meets it (Möller & Trumbore, "Fast, Minimum Storage
    /// Ray-Triangle Intersection", Journal of Graphics Tools 2(1), 1997).
    fn shares(&self, ray: &ViewRay) -> [f64; 3] {
        let [a, b, c] = self.vertices.map(|vertex| vertex.corner.point);
        let (right, left) = (b - a, c - a);
        let across = ray.step.cross(left);
        let volume = right.dot(across);
        let from_corner = ray.start - a;
        let second = (from_corner.dot(across) / volume).clamp(0.0, 1.0);
        let third = (ray.step.dot(from_corner.cross(right)) / volume).clamp(0.0, 1.0 - second);
        // A triangle seen from the side has no volume with the ray.
        if volume == 0.0 { [1.0, 0.0, 0.0] } else { [1.0 - second - third, second, third] }
    }
}

fn mean(shares: [f64; 3], of_corners: [[f32; 3]; 3]) -> DVec3 {
    let weighted = shares
        .into_iter()
        .zip(of_corners)
        .map(|(share, it)| share * DVec3::from_array(it.map(f64::from)));
    weighted.sum()
}
