//! The scene of a file, with everything left out filled in.

use crate::Automatic;
use crate::automatic::{Extent, fitting_camera};
use slabsplat_backend::PlanError;
use slabsplat_core::glam::DVec3;
use slabsplat_core::{CameraError, Grid, Layer, MeshLayer, RegionError, Scene, Volume};
use slabsplat_io::{IoError, LayerFile, LoadedVolume, MemoryNeed, SceneFile, check_memory};
use std::sync::Arc;
use thiserror::Error;

/// A scene, ready to be rendered.
#[derive(Clone, Debug)]
pub struct OpenScene {
    /// What is seen, and how.
    pub scene: Scene,
    /// The name of the backend that the scene asks for.
    pub backend: String,
    /// What was guessed or left out when the volume was read, for people.
    pub warnings: Vec<String>,
    /// What was opened, with what was chosen of files that hold several volumes.
    pub sources: SceneFile,
}

/// Why a scene cannot be opened.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum OpenError {
    /// A volume, labels or their colours cannot be read.
    #[error(transparent)]
    Io(#[from] IoError),
    /// The camera's parts do not make a camera.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// A region is none.
    #[error(transparent)]
    Region(#[from] RegionError),
    /// There is nothing to draw.
    #[error(transparent)]
    Plan(#[from] PlanError),
}

impl OpenScene {
    /// Loads the volumes and meshes of `file` and fills in what the file leaves out.
    ///
    /// # Errors
    /// If a volume or a mesh cannot be read, or all volumes have no room in memory, or the camera or a region
    /// makes no sense.
    pub fn open(file: &SceneFile) -> Result<Self, OpenError> {
        check_memory(MemoryNeed::of_layers(&file.layers))?;
        let loaded = LayerFile::load_volumes(&file.layers, LayerFile::load_volume)?;
        Self::with_volumes(loaded, file)
    }

    /// The scene as it is now, as a scene file that leaves nothing open: volumes and meshes come from where
    /// they came from, all else is as `scene` has it. [`slabsplat_io::write_scene`] writes it, and
    /// [`slabsplat_io::Provenance`] puts it into a picture.
    ///
    /// # Errors
    /// If a layer has labels that are from no file.
    ///
    /// # Panics
    /// If layers or meshes were added or taken away.
    pub fn to_file(&self) -> Result<SceneFile, IoError> {
        let mut file = self.sources.completed(&self.scene)?;
        file.backend.clone_from(&self.backend);
        Ok(file)
    }

    /// The scene of `file` with volumes that are already there, one for each layer; labels and meshes are
    /// read.
    ///
    /// # Errors
    /// If the camera or a region makes no sense, or labels or meshes cannot be read.
    ///
    /// # Panics
    /// If there are more volumes or fewer.
    pub fn with_volumes(loaded: Vec<LoadedVolume>, file: &SceneFile) -> Result<Self, OpenError> {
        assert_eq!(loaded.len(), file.layers.len(), "there is one volume for each layer");
        let mut all_warnings = Vec::new();
        let mut sources = file.clone();
        for (source, loaded) in sources.layers.iter_mut().zip(&loaded) {
            source.options.choose(&loaded.choices);
        }
        let layers = loaded.into_iter().zip(&file.layers).map(|(loaded, of_file)| {
            let LoadedVolume { volume, warnings, .. } = loaded;
            all_warnings.extend(warnings);
            all_warnings.extend(of_file.warning_of(&volume));
            layer(volume, of_file, &mut all_warnings)
        });
        let layers = layers.collect::<Result<Vec<_>, _>>()?;
        let mut meshes = Vec::with_capacity(file.meshes.len());
        for mesh in &file.meshes {
            let (mesh, warnings) = mesh.load()?;
            meshes.push(mesh);
            all_warnings.extend(warnings);
        }
        if layers.is_empty() && meshes.is_empty() {
            return Err(PlanError::NoLayers.into());
        }
        let grids: Vec<Grid> = layers.iter().map(|layer| *layer.volume.grid()).collect();
        let boxes: Vec<[DVec3; 2]> = meshes.iter().filter_map(MeshLayer::bounds).collect();
        // Of a mesh without triangles nothing is seen from anywhere.
        let nowhere = [[DVec3::ZERO, DVec3::ONE]];
        let is_empty = grids.is_empty() && boxes.is_empty();
        let seen = Extent { grids: &grids, boxes: if is_empty { &nowhere } else { &boxes } };
        let fallback = fitting_camera(seen, &file.image, file.camera.is_perspective())?;
        let scene = Scene::of_meshes(meshes, file.camera.complete(&fallback)?)
            .layers(layers)
            .lights(file.lights.clone())
            .image(file.image)
            .settings(file.settings.clone());
        Ok(Self { scene, backend: file.backend.clone(), warnings: all_warnings, sources })
    }
}

fn layer(
    volume: Arc<Volume>,
    file: &LayerFile,
    all_warnings: &mut Vec<String>,
) -> Result<Layer, OpenError> {
    let automatic = || Automatic::new(volume.clone()).transfer().clone();
    let transfer = file.transfer.clone().unwrap_or_else(automatic);
    let region = file.region.on(volume.grid())?;
    let layer = Layer::new(volume, transfer)
        .transfer_2d(file.transfer_2d.clone())
        .gradient_opacity(file.gradient_opacity.clone())
        .isosurfaces(file.isosurfaces.clone())
        .shading(file.shading)
        .region(region);
    let Some(labels) = &file.labels else { return Ok(layer) };
    let (labels, warnings) = labels.load(layer.volume.grid())?;
    all_warnings.extend(warnings);
    Ok(layer.labels(labels))
}
