//! The opaque meshes of a frame (model §14).

use crate::{MeshPlan, MeshesPlan, PlanError};
use slabsplat_core::glam::{DAffine3, DMat3, DVec3};
use slabsplat_core::{BlinnPhong, Grid, MeshLayer, RegionInView, Scene, Shading, View};

/// Without a volume, the box around all meshes is so many `unit`s in diagonal.
const UNITS_ACROSS: f64 = 1024.0;

/// The meshes of a scene, if it has any, in one of the views of its volumes: the one with the least `unit`.
pub(crate) fn in_view<'a>(
    scene: &'a Scene,
    views: impl Iterator<Item = (f64, View)>,
) -> Result<Option<MeshesPlan<'a>>, PlanError> {
    if scene.meshes.is_empty() {
        return Ok(None);
    }
    let finest = views.reduce(|a, b| if b.0 < a.0 { b } else { a });
    let view = finest.map_or_else(|| view_of_meshes(scene), |(_, view)| Ok(view))?;
    let mut meshes = Vec::with_capacity(scene.meshes.len());
    for layer in &scene.meshes {
        let light = match layer.shading {
            Shading::None => None,
            Shading::Phong(phong) => {
                let phong = phong.checked()?;
                Some(BlinnPhong::new(phong, &scene.lights, view.axes().forward))
            }
        };
        let is_cut = !layer.region.is_everywhere();
        let region = is_cut.then(|| RegionInView::new(&layer.region, &view));
        meshes.push(MeshPlan { layer, light, region });
    }
    Ok(Some(MeshesPlan { view, meshes }))
}

/// The view of meshes alone.
fn view_of_meshes(scene: &Scene) -> Result<View, PlanError> {
    let boxes = scene.meshes.iter().filter_map(MeshLayer::bounds);
    let bounds = boxes.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)]);
    let [min, max] = bounds.unwrap_or([DVec3::ZERO, DVec3::ONE]);
    let step = DMat3::from_diagonal(DVec3::splat((max - min).length() / UNITS_ACROSS));
    let world_from_index = DAffine3::from_mat3_translation(step, 0.5 * (min + max));
    let grid = Grid::new([1; 3], world_from_index).map_err(|_| PlanError::MeshesTooLarge)?;
    Ok(View::new(&grid, &scene.camera, &scene.image)?)
}
