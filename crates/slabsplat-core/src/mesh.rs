//! A surface of triangles, with lines and points beside it.

use glam::DVec3;
use thiserror::Error;

/// Triangles, lines and points over shared vertices, none of which is impossible to draw.
///
/// ```
/// use slabsplat_core::glam::DVec3;
/// use slabsplat_core::{Mesh, MeshParts};
///
/// let positions = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::NAN];
/// let triangles = vec![[0, 1, 2], [0, 1, 3], [0, 1, 1], [0, 1, 9]];
/// let mesh = Mesh::new(MeshParts::new(positions).triangles(triangles))?;
/// assert_eq!(mesh.triangles(), [[0, 1, 2]]);
/// let dropped = mesh.dropped();
/// assert_eq!([dropped.n_without_vertices, dropped.n_not_finite, dropped.n_flat], [1; 3]);
/// # Ok::<(), slabsplat_core::MeshError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    parts: MeshParts,
    dropped: DroppedElements,
    bounds: Option<[DVec3; 2]>,
}

/// What a mesh is made of.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct MeshParts {
    /// Where vertices are, as the file has them.
    pub positions: Vec<DVec3>,
    /// The three vertices of each triangle; seen from its front they go round to the left.
    pub triangles: Vec<[u32; 3]>,
    /// Both ends of each line, which is seen as a tube.
    pub lines: Vec<[u32; 2]>,
    /// Those vertices that are seen as balls.
    pub points: Vec<u32>,
    /// A normal for each vertex, of any length; none at all for flat faces. What is not finite counts as 0.
    /// They mean nothing to lines and points.
    pub normals: Vec<[f32; 3]>,
    /// Red, green and blue of each vertex, 0 to 1, or none at all. What lies beyond is clamped, NaN to 0.
    pub colors: Vec<[f32; 3]>,
}

/// How many triangles, lines and points cannot be drawn, by the first reason that applies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct DroppedElements {
    /// Those with a corner that no vertex is.
    pub n_without_vertices: usize,
    /// Those with a corner that is NaN or infinite.
    pub n_not_finite: usize,
    /// Triangles whose corners lie on a line, or on a point.
    pub n_flat: usize,
}

/// Why there is no such mesh.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum MeshError {
    /// There are as many of something as there are vertices, or none.
    #[error("a mesh of {n_vertices} vertices cannot have {n} {what}")]
    WrongNumber {
        /// Normals or colours.
        what: &'static str,
        /// How many of them there are.
        n: usize,
        /// How many there should be, if any.
        n_vertices: usize,
    },
    /// It would be flattened, or be nowhere.
    #[error("a mesh cannot be placed by a matrix that is not finite or flattens it")]
    BadPlace,
}

impl MeshParts {
    /// Vertices, and nothing that is seen yet.
    pub fn new(positions: Vec<DVec3>) -> Self {
        Self { positions, ..Self::default() }
    }

    /// The same with these triangles.
    #[must_use]
    pub fn triangles(self, triangles: Vec<[u32; 3]>) -> Self {
        Self { triangles, ..self }
    }

    /// The same with these lines.
    #[must_use]
    pub fn lines(self, lines: Vec<[u32; 2]>) -> Self {
        Self { lines, ..self }
    }

    /// The same with these points.
    #[must_use]
    pub fn points(self, points: Vec<u32>) -> Self {
        Self { points, ..self }
    }

    /// The same with a normal for each vertex.
    #[must_use]
    pub fn normals(self, normals: Vec<[f32; 3]>) -> Self {
        Self { normals, ..self }
    }

    /// The same with a colour for each vertex.
    #[must_use]
    pub fn colors(self, colors: Vec<[f32; 3]>) -> Self {
        Self { colors, ..self }
    }
}

impl Mesh {
    /// Those triangles, lines and points that can be drawn.
    ///
    /// # Errors
    /// If there are normals or colours for other than all vertices.
    pub fn new(mut parts: MeshParts) -> Result<Self, MeshError> {
        let n_vertices = parts.positions.len();
        for (what, n) in [("normals", parts.normals.len()), ("colours", parts.colors.len())] {
            if n != 0 && n != n_vertices {
                return Err(MeshError::WrongNumber { what, n, n_vertices });
            }
        }
        parts.normals.iter_mut().for_each(|normal| *normal = of_length_one(*normal));
        for channel in parts.colors.iter_mut().flatten() {
            *channel = if channel.is_nan() { 0.0 } else { channel.clamp(0.0, 1.0) };
        }
        let mut dropped = DroppedElements::default();
        let positions = &parts.positions;
        parts.triangles.retain(|triangle| dropped.spares_triangle(positions, *triangle));
        parts.lines.retain(|line| dropped.corners(positions, *line).is_some());
        parts.points.retain(|point| dropped.corners(positions, [*point]).is_some());
        let mut mesh = Self { parts, dropped, bounds: None };
        mesh.bounds = mesh.bounds_in(|corner| corner);
        Ok(mesh)
    }

    /// Where its vertices are. Those that nothing refers to may be anything.
    pub fn positions(&self) -> &[DVec3] {
        &self.parts.positions
    }

    /// The vertices of each triangle: all there, finite, and not on one line.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.parts.triangles
    }

    /// The ends of each line: all there, and finite. A line may have no length.
    pub fn lines(&self) -> &[[u32; 2]] {
        &self.parts.lines
    }

    /// The vertex of each point: there, and finite.
    pub fn points(&self) -> &[u32] {
        &self.parts.points
    }

    /// The least box around the vertices of all triangles, lines and points; `None` if there are none.
    pub fn bounds(&self) -> Option<[DVec3; 2]> {
        self.bounds
    }

    /// The diagonal of that box, 0 if there is none.
    pub fn size(&self) -> f64 {
        self.bounds.map_or(0.0, |[min, max]| (max - min).length())
    }

    /// The least box somewhere else.
    pub(crate) fn bounds_in(&self, moved: impl Fn(DVec3) -> DVec3) -> Option<[DVec3; 2]> {
        let MeshParts { positions, triangles, lines, points, .. } = &self.parts;
        let vertices = triangles.as_flattened().iter().chain(lines.as_flattened()).chain(points);
        let corners = vertices.map(|vertex| [moved(positions[*vertex as usize]); 2]);
        corners.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)])
    }

    /// The corners of a triangle.
    #[inline]
    pub fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.parts.triangles[triangle].map(|vertex| self.parts.positions[vertex as usize])
    }

    /// The normals at its corners, each of length 1 or 0; `None` if faces are flat.
    #[inline]
    pub fn normals(&self, triangle: usize) -> Option<[[f32; 3]; 3]> {
        self.of_corners(&self.parts.normals, triangle)
    }

    /// The normal at a vertex, of length 1 or 0, if there are any.
    #[inline]
    pub fn vertex_normal(&self, vertex: usize) -> Option<[f32; 3]> {
        self.parts.normals.get(vertex).copied()
    }

    /// The colour of a vertex, if there are any.
    pub fn vertex_color(&self, vertex: usize) -> Option<[f32; 3]> {
        self.parts.colors.get(vertex).copied()
    }

    /// The colours at its corners, if vertices have any.
    #[inline]
    pub fn colors(&self, triangle: usize) -> Option<[[f32; 3]; 3]> {
        self.of_corners(&self.parts.colors, triangle)
    }

    /// The normal of a flat face, of length 1.
    pub fn face_normal(&self, triangle: usize) -> DVec3 {
        let [a, b, c] = self.corners(triangle);
        scaled_normal([a, b, c]).normalize_or_zero()
    }

    /// What was not taken of the triangles, lines and points that were given.
    pub fn dropped(&self) -> DroppedElements {
        self.dropped
    }

    fn of_corners<T: Copy>(&self, of_vertices: &[T], triangle: usize) -> Option<[T; 3]> {
        let corners = self.parts.triangles[triangle];
        (!of_vertices.is_empty()).then(|| corners.map(|vertex| of_vertices[vertex as usize]))
    }
}

impl DroppedElements {
    /// How many there are of all kinds.
    pub fn n_all(&self) -> usize {
        self.n_without_vertices + self.n_not_finite + self.n_flat
    }

    /// Whether a triangle can be drawn; counts it if not.
    fn spares_triangle(&mut self, positions: &[DVec3], triangle: [u32; 3]) -> bool {
        let Some(corners) = self.corners(positions, triangle) else { return false };
        let is_flat = scaled_normal(corners) == DVec3::ZERO;
        self.n_flat += usize::from(is_flat);
        !is_flat
    }

    /// Where the vertices of something are, if they are anywhere; counts it if not.
    fn corners<const N: usize>(
        &mut self,
        positions: &[DVec3],
        vertices: [u32; N],
    ) -> Option<[DVec3; N]> {
        let corners = vertices.map(|vertex| positions.get(vertex as usize).copied());
        if corners.contains(&None) {
            self.n_without_vertices += 1;
            return None;
        }
        let corners = corners.map(Option::unwrap_or_default);
        if !corners.iter().all(|corner| corner.is_finite()) {
            self.n_not_finite += 1;
            return None;
        }
        Some(corners)
    }
}

/// A normal of some length, 0 if the corners lie on a line. Squares of long or short edges would leave the
/// range of numbers, and differences of far corners, too.
fn scaled_normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    let scaled = |edge: DVec3| edge / edge.abs().max_element();
    let half = |corner: DVec3| 0.5 * corner;
    let normal = scaled(half(b) - half(a)).cross(scaled(half(c) - half(a)));
    // An edge of no length is 0/0.
    if normal.is_nan() { DVec3::ZERO } else { normal }
}

/// One that has that length already, but for rounding, stays as it is.
fn of_length_one(normal: [f32; 3]) -> [f32; 3] {
    let wide = DVec3::from_array(normal.map(f64::from));
    if (wide.length() - 1.0).abs() < ROUNDING {
        return normal;
    }
    wide.try_normalize().unwrap_or(DVec3::ZERO).as_vec3().to_array()
}

/// What 32-bit normals may be longer or shorter than 1.
const ROUNDING: f64 = 1e-6;

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(corners: [DVec3; 3]) -> Mesh {
        let parts = MeshParts {
            positions: corners.to_vec(),
            triangles: vec![[0, 1, 2]],
            ..MeshParts::default()
        };
        Mesh::new(parts).unwrap()
    }

    #[test]
    fn mesh_keeps_what_has_an_area() {
        for scale in [1e-300, 1e-9, 1.0, 1e150, 1e308] {
            let corners = [DVec3::ZERO, DVec3::X, DVec3::new(0.3, 1.0, 0.0)].map(|v| scale * v);
            assert_eq!(triangle(corners).face_normal(0), DVec3::Z, "{scale}");
            let far = corners.map(|corner| corner - scale * DVec3::Z);
            assert_eq!(triangle(far).triangles().len(), 1, "{scale}");
        }
        // A needle.
        let needle = triangle([DVec3::ZERO, DVec3::X, DVec3::new(0.5, 1e-12, 0.0)]);
        assert_eq!(needle.face_normal(0), DVec3::Z);
    }

    #[test]
    fn mesh_drops_what_has_none() {
        let check = |corners: [DVec3; 3], expected: [usize; 2]| {
            let DroppedElements { n_not_finite, n_flat, .. } = triangle(corners).dropped();
            assert_eq!([n_not_finite, n_flat], expected, "{corners:?}");
        };
        let [x, y] = [DVec3::X, DVec3::Y];
        check([x, x, x], [0, 1]);
        check([x, y, x], [0, 1]);
        check([y, x, x], [0, 1]);
        check([DVec3::ZERO, x, 3.0 * x], [0, 1]);
        check([DVec3::ZERO, x, DVec3::NAN], [1, 0]);
        check([DVec3::INFINITY, x, x], [1, 0]);
    }

    #[test]
    fn mesh_keeps_lines_and_points_that_are_somewhere() {
        let parts = MeshParts {
            positions: vec![DVec3::ZERO, DVec3::new(3.0, 4.0, 0.0), DVec3::NAN, DVec3::MAX],
            lines: vec![[0, 1], [1, 1], [0, 2], [0, 9]],
            points: vec![1, 2, 9],
            ..MeshParts::default()
        };
        let mesh = Mesh::new(parts).unwrap();
        assert_eq!((mesh.lines(), mesh.points()), (&[[0, 1], [1, 1]][..], &[1][..]));
        let DroppedElements { n_without_vertices, n_not_finite, n_flat } = mesh.dropped();
        assert_eq!([n_without_vertices, n_not_finite, n_flat], [2, 2, 0]);
        assert_eq!(mesh.size(), 5.0, "of what is used");
        assert_eq!(Mesh::default().size(), 0.0);
    }

    #[test]
    fn mesh_takes_normals_and_colors_of_all_vertices_or_none() {
        let parts = MeshParts {
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
            triangles: vec![[2, 0, 1]],
            lines: Vec::new(),
            points: Vec::new(),
            normals: vec![[0.0, 0.0, 5.0], [f32::NAN; 3], [0.0; 3]],
            colors: vec![[0.5, -1.0, f32::NAN], [2.0, 0.25, 1.0], [0.0; 3]],
        };
        let mesh = Mesh::new(parts.clone()).unwrap();
        assert_eq!(mesh.normals(0), Some([[0.0; 3], [0.0, 0.0, 1.0], [0.0; 3]]));
        assert_eq!(mesh.colors(0), Some([[0.0; 3], [0.5, 0.0, 0.0], [1.0, 0.25, 1.0]]));
        let mut few = parts.clone();
        few.normals.pop();
        assert!(Mesh::new(few).unwrap_err().to_string().contains("2 normals"));
        let mut many = parts;
        many.colors.push([0.0; 3]);
        assert!(Mesh::new(many).unwrap_err().to_string().contains("4 colours"));
    }
}
