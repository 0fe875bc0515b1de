//! A scene file and the volume that it names, with everything left out filled in.

use crate::Automatic;
use crate::automatic::fitting_camera;
use slabsplat_core::{CameraError, Scene, Volume};
use slabsplat_io::{IoError, LoadedVolume, SceneFile};
use thiserror::Error;

/// A volume and a scene of it, ready to be rendered.
#[derive(Clone, Debug)]
pub struct OpenScene {
    /// The volume.
    pub volume: Volume,
    /// What is made of it.
    pub scene: Scene,
    /// The name of the backend that the scene asks for.
    pub backend: String,
    /// What was guessed or left out when the volume was read, for people.
    pub warnings: Vec<String>,
}

/// Why a scene cannot be opened.
#[derive(Debug, Error)]
pub enum OpenError {
    /// The volume cannot be read.
    #[error(transparent)]
    Io(#[from] IoError),
    /// The camera's parts do not make a camera.
    #[error(transparent)]
    Camera(#[from] CameraError),
}

impl OpenScene {
    /// Loads the volume of `file` and fills in what the file leaves out.
    ///
    /// # Errors
    /// If the volume cannot be read, or the camera makes no sense.
    pub fn open(file: &SceneFile) -> Result<Self, OpenError> {
        Self::with_volume(file.load_volume()?, file)
    }

    /// The scene of `file` with a volume that is already there.
    ///
    /// # Errors
    /// If the camera makes no sense.
    pub fn with_volume(loaded: LoadedVolume, file: &SceneFile) -> Result<Self, OpenError> {
        let LoadedVolume { volume, warnings, .. } = loaded;
        let fallback = fitting_camera(volume.grid(), &file.image, file.camera.is_perspective());
        let automatic = || Automatic::new(&volume).transfer().clone();
        let scene = Scene::new(
            file.transfer.clone().unwrap_or_else(automatic),
            file.camera.complete(&fallback)?,
        )
        .shading(file.shading)
        .image(file.image)
        .settings(file.settings.clone());
        Ok(Self { volume, scene, backend: file.backend.clone(), warnings })
    }
}
