//! Scene files (SPEC §8): TOML in which everything that decides a pixel can be said.
//!
//! `keys` is the list of keys with their defaults; `classify`, `presets` and `color_map` make the
//! transfer function; `camera` is a camera of which parts may be missing.

mod camera;
mod classify;
mod color_map;
mod keys;
mod presets;

use std::path::{Path, PathBuf};

use slabsplat_core::{ImageDesc, Phong, RenderSettings, Shading, TransferFunction};

pub use camera::{CameraDesc, ProjectionKind};
pub use color_map::read_color_map;
pub use presets::{PRESET_NAMES, preset};

use crate::{IoError, LoadedVolume, VolumeFormat, builtin_volume, read_volume, text};

/// A scene as a file gives it: what is missing is left to whoever has seen the volume.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneFile {
    /// Where the volume comes from.
    pub volume: VolumeSource,
    /// World length of a step along each axis, if the volume's own is not to be used.
    pub spacing: Option<[f64; 3]>,
    /// Opacity and colour; `None` if the file does not say.
    pub transfer: Option<TransferFunction>,
    /// What light does to them.
    pub shading: Shading,
    /// Where they are seen from, as far as the file says.
    pub camera: CameraDesc,
    /// Size and background of the picture.
    pub image: ImageDesc,
    /// How it is made.
    pub settings: RenderSettings,
    /// The name of the backend.
    pub backend: String,
}

/// Where a volume comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum VolumeSource {
    /// A file in any format that can be read.
    File(PathBuf),
    /// One of [`BUILTIN_NAMES`](crate::BUILTIN_NAMES).
    Builtin {
        /// Its name.
        name: String,
        /// Voxels a side; `None` for the built-in's own size.
        size: Option<usize>,
    },
}

/// The backend that a scene asks for if it names none.
const DEFAULT_BACKEND: &str = "auto";

impl SceneFile {
    /// A scene that says nothing but where its volume comes from.
    pub fn new(volume: VolumeSource) -> Self {
        Self {
            volume,
            spacing: None,
            transfer: None,
            shading: Shading::Phong(Phong::default()),
            camera: CameraDesc::default(),
            image: ImageDesc::default(),
            settings: RenderSettings::default(),
            backend: DEFAULT_BACKEND.to_owned(),
        }
    }

    /// Reads or makes the volume, and gives it the scene's spacing.
    ///
    /// # Errors
    /// If the volume cannot be read, or the spacing cannot be used.
    pub fn load_volume(&self) -> Result<LoadedVolume, IoError> {
        let loaded = match &self.volume {
            VolumeSource::File(path) => read_volume(path)?,
            VolumeSource::Builtin { name, size } => LoadedVolume {
                volume: builtin_volume(name, *size)?,
                format: VolumeFormat::Builtin,
                warnings: Vec::new(),
            },
        };
        self.respaced(loaded)
    }

    /// Gives a volume the scene's spacing, if it has one.
    ///
    /// # Errors
    /// If the spacing cannot be used.
    pub fn respaced(&self, loaded: LoadedVolume) -> Result<LoadedVolume, IoError> {
        let Some(spacing) = self.spacing else { return Ok(loaded) };
        let path = match &self.volume {
            VolumeSource::File(path) => path.clone(),
            VolumeSource::Builtin { name, .. } => PathBuf::from(name),
        };
        loaded.with_spacing(spacing).map_err(|source| IoError::Grid { path, source })
    }
}

/// Reads a scene file. Paths in it are relative to it.
///
/// # Errors
/// If the file cannot be read, has a key that is not known (the error names key and line), or a value
/// that cannot be used.
pub fn read_scene(path: &Path) -> Result<SceneFile, IoError> {
    let text = text::read(path)?;
    let keys: keys::SceneKeys =
        toml::from_str(&text).map_err(|err| toml_error(path, &text, &err))?;
    keys.into_scene(path)
}

fn toml_error(path: &Path, text: &str, err: &toml::de::Error) -> IoError {
    let line = err.span().map(|span| 1 + text[..span.start].matches('\n').count());
    // One line, in the words that the documentation uses.
    let what = err.message().lines().collect::<Vec<_>>().join(" ");
    let what =
        what.replace("unknown field", "unknown key").replace("expected f64", "expected a number");
    IoError::Scene { path: path.to_owned(), line, what }
}

#[cfg(test)]
mod tests;
