//! Which methods and modes draw which scenes.

use crate::PlanError;
use slabsplat_core::{Isosurface, Layer, Method, Mode, RenderSettings, Scene, VoxelColors};

/// Whether a mode shows densities, whatever the method.
pub(crate) fn is_of_densities(mode: Mode) -> bool {
    mode.compositing().is_none()
}

/// Whether the method, be it that of the scene or another, can draw such a scene.
pub(crate) fn check_method(scene: &Scene, method: Method) -> Result<(), PlanError> {
    let mode = scene.settings.mode;
    let has_slabs = match method {
        Method::ImageAligned | Method::PostClassified => true,
        Method::AxisAligned | Method::EverySample => false,
    };
    check_voxels(scene, method)?;
    if !scene.meshes.is_empty() {
        if !has_slabs {
            return Err(PlanError::NoMeshes { what: format!("the method {method}") });
        }
        if is_of_densities(mode) {
            return Err(PlanError::NoMeshes { what: format!("the mode {mode}") });
        }
    }
    if !has_slabs && scene.layers.iter().any(|layer| !layer.region.is_everywhere()) {
        return Err(PlanError::NoRegions(method));
    }
    if !has_slabs && is_of_densities(mode) {
        return Err(PlanError::NoDensities { mode, method });
    }
    let n_layers = scene.layers.len();
    if !has_slabs && 1 < n_layers {
        return Err(PlanError::OneLayer { method, n_layers });
    }
    if mode == Mode::Isosurfaces && 0 < n_layers {
        check_isosurfaces(&scene.layers)?;
    }
    Ok(())
}

/// That a scene is drawn in parts ([model §17](slabsplat_core::model)).
///
/// # Errors
/// If it is not, which says why.
pub fn check_parts(scene: &Scene) -> Result<(), PlanError> {
    let RenderSettings { method, mode, .. } = scene.settings;
    let what = if is_of_densities(mode) {
        format!("the mode {mode}")
    } else if method != Method::ImageAligned {
        format!("the method {method}")
    } else if !scene.meshes.is_empty() {
        "meshes".to_owned()
    } else {
        return Ok(());
    };
    Err(PlanError::NotInParts { what })
}

/// Whether the method can tell voxels, where these have labels or opacities of their own.
fn check_voxels(scene: &Scene, method: Method) -> Result<(), PlanError> {
    let mode = scene.settings.mode;
    let densities = match method {
        _ if is_of_densities(mode) => Some(format!("the mode {mode}")),
        Method::PostClassified => Some(format!("the method {method}")),
        Method::ImageAligned | Method::AxisAligned | Method::EverySample => None,
    };
    for layer in &scene.layers {
        let of_voxels = [
            ("two-dimensional transfer functions", layer.transfer_2d.is_some()),
            (
                "colours of voxels (colors = \"none\", or --colors none, leaves them out)",
                layer.colors.is_some(),
            ),
            ("labels", layer.labels.is_some()),
            ("opacity by gradients", layer.gradient_opacity.is_some()),
        ];
        let of_voxels = of_voxels.into_iter().find_map(|(name, is_there)| is_there.then_some(name));
        if let (Some(what), Some(of_voxels)) = (&densities, of_voxels) {
            return Err(PlanError::OfVoxelsAlone { what: what.clone(), of_voxels });
        }
        let volume = layer.volume.grid().dims();
        if let Some(colors) = layer.colors.as_ref().map(VoxelColors::dims)
            && colors != volume
        {
            return Err(PlanError::ColorsOfAnotherGrid { colors, volume });
        }
        if let Some(labels) = &layer.labels {
            let labels = labels.map().dims();
            if labels != volume {
                return Err(PlanError::LabelsOfAnotherGrid { labels, volume });
            }
        }
    }
    Ok(())
}

/// Whether there are surfaces to draw, those of a layer each of another value.
fn check_isosurfaces(layers: &[Layer]) -> Result<(), PlanError> {
    if layers.iter().all(|layer| layer.isosurfaces.is_empty()) {
        return Err(PlanError::NoIsosurfaces);
    }
    for Layer { isosurfaces, .. } in layers {
        for (idx, value) in isosurfaces.iter().map(Isosurface::value).enumerate() {
            if isosurfaces[..idx].iter().any(|other| other.value() == value) {
                return Err(PlanError::IsosurfaceTwice(value));
            }
        }
    }
    Ok(())
}
