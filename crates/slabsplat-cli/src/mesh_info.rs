//! What a mesh is, for `slabsplat info`.

use crate::columns::pairs;
use crate::plain::plain;
use serde_json::{Value, json};
use slabsplat::MeshLayer;
use slabsplat::glam::DVec3;
use slabsplat::io::LoadedMesh;

pub(crate) struct MeshInfo {
    format: &'static str,
    n_triangles: usize,
    n_lines: usize,
    n_points: usize,
    n_dropped: usize,
    n_vertices: usize,
    has_normals: bool,
    has_colors: bool,
    /// The least and the greatest corner around all of it, if there is anything.
    bounds: Option<[DVec3; 2]>,
}

impl MeshInfo {
    pub(crate) fn of(LoadedMesh { mesh, format, .. }: &LoadedMesh) -> Self {
        Self {
            format: format.name(),
            n_triangles: mesh.triangles().len(),
            n_lines: mesh.lines().len(),
            n_points: mesh.points().len(),
            n_dropped: mesh.dropped().n_all(),
            n_vertices: mesh.positions().len(),
            has_normals: mesh.vertex_normal(0).is_some(),
            has_colors: mesh.vertex_color(0).is_some(),
            bounds: MeshLayer::new(mesh.clone()).bounds(),
        }
    }

    pub(crate) fn json(&self) -> Value {
        json!({
            "format": self.format,
            "triangles": self.n_triangles,
            "lines": self.n_lines,
            "points": self.n_points,
            "left_out": self.n_dropped,
            "vertices": self.n_vertices,
            "normals": self.has_normals,
            "colors": self.has_colors,
            "min": self.bounds.map(|[min, _]| min.to_array()),
            "max": self.bounds.map(|[_, max]| max.to_array()),
        })
    }

    pub(crate) fn text(&self) -> String {
        let yes_or_no = |it: bool| if it { "yes" } else { "no" }.to_owned();
        let bounds = self.bounds.map_or("none".to_owned(), |ends| {
            let [from, to] = ends.map(|end| end.to_array().map(plain).join(", "));
            format!("{from} to {to}")
        });
        pairs([
            ("format", self.format.to_owned()),
            ("triangles", self.n_triangles.to_string()),
            ("lines", self.n_lines.to_string()),
            ("points", self.n_points.to_string()),
            ("left out", self.n_dropped.to_string()),
            ("vertices", self.n_vertices.to_string()),
            ("normals", yes_or_no(self.has_normals)),
            ("colours", yes_or_no(self.has_colors)),
            ("box", bounds),
        ])
    }
}
