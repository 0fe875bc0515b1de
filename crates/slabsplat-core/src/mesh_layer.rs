//! A surface that a scene shows (model §14).

use crate::{Mesh, MeshError, Phong, Region, Shading};
use glam::{DAffine3, DVec3};
use std::sync::Arc;

/// An opaque mesh, where it is, and what light does to it.
///
/// Two layers are equal if they hold the same mesh, in memory ([`Arc::ptr_eq`]), and show it alike.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct MeshLayer {
    /// Whose triangles are shown. A mesh never changes.
    pub mesh: Arc<Mesh>,
    /// Red, green and blue, 0 to 1, of all of it; if there is none, that of its vertices, or else a light
    /// grey.
    pub color: Option<[f64; 3]>,
    /// What light does to it.
    pub shading: Shading,
    /// Where it is seen. What a region cuts open is open.
    pub region: Region,
    world_from_mesh: DAffine3,
}

impl MeshLayer {
    /// Of a mesh that nobody has coloured.
    pub const DEFAULT_COLOR: [f64; 3] = [0.8, 0.8, 0.8];

    /// All of a mesh, where it says that it is, lit by a headlight.
    pub fn new(mesh: impl Into<Arc<Mesh>>) -> Self {
        Self {
            mesh: mesh.into(),
            color: None,
            shading: Shading::Phong(Phong::default()),
            region: Region::default(),
            world_from_mesh: DAffine3::IDENTITY,
        }
    }

    /// The same in one colour; channels are clamped to 0 … 1.
    #[must_use]
    pub fn color(self, [r, g, b]: [f64; 3]) -> Self {
        Self { color: Some([r, g, b].map(|channel| channel.clamp(0.0, 1.0))), ..self }
    }

    /// The same in another light.
    #[must_use]
    pub fn shading(self, shading: Shading) -> Self {
        Self { shading, ..self }
    }

    /// The same, seen nowhere else.
    #[must_use]
    pub fn region(self, region: Region) -> Self {
        Self { region, ..self }
    }

    /// The same elsewhere.
    ///
    /// # Errors
    /// If the matrix is not finite, or flattens it.
    pub fn placed(self, world_from_mesh: DAffine3) -> Result<Self, MeshError> {
        let is_sound = world_from_mesh.is_finite() && world_from_mesh.inverse().is_finite();
        if !is_sound || world_from_mesh.matrix3.determinant() == 0.0 {
            return Err(MeshError::BadPlace);
        }
        Ok(Self { world_from_mesh, ..self })
    }

    /// Takes the mesh's own space to the world's.
    pub fn world_from_mesh(&self) -> DAffine3 {
        self.world_from_mesh
    }

    /// The least box of the world around it; `None` if it has no triangles.
    pub fn bounds(&self) -> Option<[DVec3; 2]> {
        let triangles = 0..self.mesh.triangles().len();
        let corners = triangles.flat_map(|triangle| self.mesh.corners(triangle));
        let in_world = corners.map(|corner| [self.world_from_mesh.transform_point3(corner); 2]);
        in_world.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)])
    }
}

impl PartialEq for MeshLayer {
    fn eq(&self, other: &Self) -> bool {
        let Self { mesh, color, shading, region, world_from_mesh } = other;
        Arc::ptr_eq(&self.mesh, mesh)
            && self.color == *color
            && self.shading == *shading
            && self.region == *region
            && self.world_from_mesh == *world_from_mesh
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{MeshParts, Plane};
    use glam::DMat3;

    #[test]
    fn mesh_layer_is_what_is_set() {
        let parts = MeshParts {
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::new(0.0, 2.0, 3.0)],
            triangles: vec![[0, 1, 2]],
            ..MeshParts::default()
        };
        let mesh = Arc::new(Mesh::new(parts).unwrap());
        let plain = MeshLayer::new(mesh.clone());
        assert_eq!(plain, MeshLayer::new(mesh.clone()));
        assert_ne!(plain, MeshLayer::new((*mesh).clone()), "another mesh in memory");
        assert_ne!(plain, plain.clone().color([0.8; 3]));
        assert_ne!(plain, plain.clone().shading(Shading::None));
        let region = Region::new(vec![Plane::new(DVec3::X, 1.0).unwrap()]);
        assert_ne!(plain, plain.clone().region(region));
        assert_eq!(plain.clone().color([2.0, -1.0, 0.5]).color, Some([1.0, 0.0, 0.5]));
        let mirrored = DMat3::from_diagonal(DVec3::new(-1.0, -1.0, 1.0));
        let placed = DAffine3::from_mat3_translation(mirrored, DVec3::Z);
        let elsewhere = plain.clone().placed(placed).unwrap();
        assert_ne!(plain, elsewhere);
        assert_eq!(elsewhere.bounds(), Some([DVec3::new(-1.0, -2.0, 1.0), 4.0 * DVec3::Z]));
        assert_eq!(MeshLayer::new(Mesh::default()).bounds(), None);
        for bad in [DVec3::new(1.0, 0.0, 1.0), DVec3::NAN, DVec3::INFINITY] {
            let flat = DAffine3::from_mat3(DMat3::from_diagonal(bad));
            assert_eq!(plain.clone().placed(flat), Err(MeshError::BadPlace), "{bad}");
        }
    }
}
