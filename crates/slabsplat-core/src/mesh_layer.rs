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
    /// Whose triangles, lines and points are shown. A mesh never changes.
    pub mesh: Arc<Mesh>,
    /// Red, green and blue, 0 to 1, of all of it; if there is none, that of its vertices, or else a light
    /// grey.
    pub color: Option<[f64; 3]>,
    /// How thick the tubes are that lines are shown as, in world units; if nothing is said, 1/400 of the
    /// mesh's size. Of a width that is not a number above 0 nothing is seen.
    pub line_width: Option<f64>,
    /// The diameter of the balls that points are shown as, in world units; if nothing is said, 1/100 of the
    /// mesh's size. Of one that is not a number above 0 nothing is seen.
    pub point_size: Option<f64>,
    /// What light does to it.
    pub shading: Shading,
    /// Where it is seen. What a region cuts open is open.
    pub region: Region,
    world_from_mesh: DAffine3,
}

/// A mesh is as large as so many lines are thick, and as so many points, unless somebody says otherwise.
const LINES_ACROSS: f64 = 400.0;
const POINTS_ACROSS: f64 = 100.0;

impl MeshLayer {
    /// Of a mesh that nobody has coloured.
    pub const DEFAULT_COLOR: [f64; 3] = [0.8, 0.8, 0.8];

    /// All of a mesh, where it says that it is, lit by a headlight.
    pub fn new(mesh: impl Into<Arc<Mesh>>) -> Self {
        Self {
            mesh: mesh.into(),
            color: None,
            line_width: None,
            point_size: None,
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

    /// The same with lines as thick, in world units.
    #[must_use]
    pub fn line_width(self, width: f64) -> Self {
        Self { line_width: Some(width), ..self }
    }

    /// The same with points as large, in world units.
    #[must_use]
    pub fn point_size(self, size: f64) -> Self {
        Self { point_size: Some(size), ..self }
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

    /// The radius of tubes, in world units.
    pub fn line_radius(&self) -> f64 {
        0.5 * self.line_width.unwrap_or_else(|| self.size_in_world() / LINES_ACROSS)
    }

    /// The radius of balls, in world units.
    pub fn point_radius(&self) -> f64 {
        0.5 * self.point_size.unwrap_or_else(|| self.size_in_world() / POINTS_ACROSS)
    }

    /// A mesh that is a single point is one world unit large.
    fn size_in_world(&self) -> f64 {
        let size = if self.mesh.size() == 0.0 { 1.0 } else { self.mesh.size() };
        size * self.world_from_mesh.matrix3.determinant().abs().cbrt()
    }

    /// A box of the world around it, the least one but for how thick lines and points are; `None` if it has
    /// nothing to be seen.
    pub fn bounds(&self) -> Option<[DVec3; 2]> {
        let placement = self.world_from_mesh;
        let is_moved = placement != DAffine3::IDENTITY;
        let in_world = || self.mesh.bounds_in(|corner| placement.transform_point3(corner));
        // Millions of vertices take tens of milliseconds.
        let bounds = if is_moved { in_world() } else { self.mesh.bounds() };
        bounds.map(|[min, max]| [min - self.thickness(), max + self.thickness()])
    }

    /// How far lines and points may reach beyond their vertices.
    fn thickness(&self) -> f64 {
        let of_lines = if self.mesh.lines().is_empty() { 0.0 } else { self.line_radius() };
        let of_points = if self.mesh.points().is_empty() { 0.0 } else { self.point_radius() };
        let thickness = of_lines.max(of_points);
        if thickness.is_finite() { thickness } else { 0.0 }
    }
}

impl PartialEq for MeshLayer {
    fn eq(&self, other: &Self) -> bool {
        let Self { mesh, color, line_width, point_size, shading, region, world_from_mesh } = other;
        Arc::ptr_eq(&self.mesh, mesh)
            && self.color == *color
            && self.line_width == *line_width
            && self.point_size == *point_size
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
        assert_ne!(plain, plain.clone().line_width(2.0));
        assert_ne!(plain, plain.clone().point_size(2.0));
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
        let lines = MeshParts {
            positions: vec![DVec3::ZERO, 8.0 * DVec3::X],
            lines: vec![[0, 1]],
            ..MeshParts::default()
        };
        let thin = MeshLayer::new(Mesh::new(lines).unwrap());
        assert_eq!([thin.line_radius(), thin.point_radius()], [0.01, 0.04]);
        let thick = thin.clone().line_width(2.0).point_size(9.0);
        assert_eq!(thick.bounds(), Some([-DVec3::ONE, DVec3::new(9.0, 1.0, 1.0)]));
        let doubled = DAffine3::from_scale(DVec3::splat(2.0));
        assert!((thin.placed(doubled).unwrap().line_radius() - 0.02).abs() < 1e-15);
        assert_eq!(MeshLayer::new(Mesh::default()).point_radius(), 0.005);
        for bad in [DVec3::new(1.0, 0.0, 1.0), DVec3::NAN, DVec3::INFINITY] {
            let flat = DAffine3::from_mat3(DMat3::from_diagonal(bad));
            assert_eq!(plain.clone().placed(flat), Err(MeshError::BadPlace), "{bad}");
        }
    }
}
