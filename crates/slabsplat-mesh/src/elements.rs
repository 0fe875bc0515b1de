//! The triangles, lines and points of all meshes of a frame, under one number each.

use crate::clip::{Polygon, bounds_of, is_behind_near};
use crate::surface::Surface;
use crate::tube::{Shape, Tube};
use crate::vertices::Vertex;
use slabsplat_backend::{MeshPlan, MeshesPlan};
use slabsplat_core::glam::DMat3;
use slabsplat_core::{View, ViewRay};

/// A frame whose vertices are projected.
#[derive(Debug)]
pub(crate) struct Frame<'a> {
    pub(crate) plan: &'a MeshesPlan<'a>,
    /// Of all meshes.
    pub(crate) vertices: &'a [Vertex],
    /// As many as the plan has.
    pub(crate) meshes: &'a [OfMesh],
}

/// What all elements of a mesh share.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OfMesh {
    /// Its first vertex and its first element, among those of all meshes.
    pub(crate) first_vertex: usize,
    first_element: usize,
    world_from_normal: DMat3,
    line_radius: f64,
    point_radius: f64,
}

/// What a ray can end at.
pub(crate) enum Element<'a> {
    Triangle(Surface<'a>),
    Tube(Tube<'a>),
}

/// How many vertices and elements there are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Numbers {
    pub(crate) n_vertices: usize,
    pub(crate) n_elements: usize,
}

impl OfMesh {
    /// Appends those of a plan; how much they have together.
    pub(crate) fn append(plan: &MeshesPlan<'_>, meshes: &mut Vec<Self>) -> Numbers {
        let mut numbers = Numbers::default();
        for MeshPlan { layer, .. } in &plan.meshes {
            meshes.push(Self {
                first_vertex: numbers.n_vertices,
                first_element: numbers.n_elements,
                world_from_normal: layer.world_from_mesh().matrix3.inverse().transpose(),
                line_radius: layer.line_radius(),
                point_radius: layer.point_radius(),
            });
            let mesh = &layer.mesh;
            numbers.n_vertices += mesh.positions().len();
            numbers.n_elements += mesh.triangles().len() + mesh.lines().len() + mesh.points().len();
        }
        numbers
    }
}

impl<'a> Frame<'a> {
    /// An element by its number among those of all meshes: of each its triangles come first, then its lines.
    #[inline]
    pub(crate) fn element(&self, element: u32) -> Element<'a> {
        let element = element as usize;
        let mesh_idx = self.meshes.partition_point(|it| it.first_element <= element) - 1;
        let (of_mesh, shared) = (&self.plan.meshes[mesh_idx], &self.meshes[mesh_idx]);
        let (mesh, idx) = (&of_mesh.layer.mesh, element - shared.first_element);
        let vertex = |vertex: u32| &self.vertices[shared.first_vertex + vertex as usize];
        if let Some(corners) = mesh.triangles().get(idx) {
            let world_from_normal = shared.world_from_normal;
            let vertices = corners.map(vertex);
            return Element::Triangle(Surface {
                of_mesh,
                triangle: idx,
                vertices,
                world_from_normal,
            });
        }
        let idx = idx - mesh.triangles().len();
        let (vertices, radius) = match mesh.lines().get(idx) {
            Some(ends) => (*ends, shared.line_radius),
            None => ([mesh.points()[idx - mesh.lines().len()]; 2], shared.point_radius),
        };
        let ends = vertices.map(|it| vertex(it).corner.point);
        Element::Tube(Tube { of_mesh, vertices, shape: Shape { ends, radius } })
    }
}

impl Element<'_> {
    /// The rectangle of the image in which it may be seen, if there is any.
    pub(crate) fn bounds(&self, view: &View) -> Option<[[f64; 2]; 2]> {
        match self {
            Self::Triangle(surface) => {
                let corners = surface.vertices.map(|vertex| vertex.corner);
                if is_behind_near(&corners, view) {
                    return bounds_of(&corners);
                }
                bounds_of(Polygon::behind_near(corners, view).corners())
            }
            Self::Tube(tube) => tube.shape.bounds(view),
        }
    }

    /// Whether it looks the same everywhere.
    pub(crate) fn is_even(&self) -> bool {
        match self {
            Self::Triangle(surface) => surface.is_even(),
            Self::Tube(_) => false,
        }
    }

    /// Its colour where a ray meets it.
    pub(crate) fn color(&self, ray: &ViewRay, depth: f64, view: &View) -> [f32; 3] {
        match self {
            Self::Triangle(surface) => surface.color(ray),
            Self::Tube(tube) => tube.color(ray, depth, view),
        }
    }
}
