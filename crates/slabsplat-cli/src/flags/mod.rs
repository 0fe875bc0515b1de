//! A flag for every key of a scene file. What a flag says overrides what the file says.
//!
//! One struct for one table of the file; each lays its flags over that part of the scene. `table` makes the
//! flags of what is a row in a table of settings.

mod camera;
mod labels;
mod lights;
mod look;
mod parts;
mod raw;
mod region;
mod settings;
mod table;
mod transfer;
pub(crate) mod values;

pub(crate) use raw::RawFlags;
pub(crate) use transfer::TransferFlags;

use crate::input;
use crate::progress::Progress;
use crate::terminal;
use anyhow::{Context, Result};
use clap::Args;
use slabsplat::io::MeshFile;
use slabsplat::{OpenScene, Renderer, Scene};
use std::path::{Path, PathBuf};

/// What is drawn, and all flags about how.
#[derive(Args)]
pub(crate) struct SceneFlags {
    /// A scene file (.toml), a volume file, a mesh (.ply, .stl, .obj), a built-in volume as builtin:NAME or
    /// builtin:NAME:SIZE, or - for a volume on standard input
    #[arg(value_name = "INPUT")]
    input: PathBuf,

    /// Something else in the same picture: a scene file's layers, a volume file, or a built-in volume; flags
    /// that say what a layer is like are about INPUT's
    #[arg(long = "layer", value_name = "FILE")]
    layers: Vec<PathBuf>,

    /// An opaque mesh in the same picture: .ply, .stl or .obj; may be given several times
    #[arg(long = "mesh", value_name = "FILE")]
    meshes: Vec<PathBuf>,

    #[command(flatten)]
    raw: RawFlags,

    #[command(flatten)]
    look: look::LookFlags,

    #[command(flatten)]
    lights: lights::LightFlags,

    #[command(flatten)]
    labels: labels::LabelFlags,

    #[command(flatten)]
    region: region::RegionFlags,

    #[command(flatten)]
    camera: camera::CameraFlags,

    #[command(flatten)]
    settings: settings::SettingsFlags,
}

impl SceneFlags {
    /// Reads what is named, and lays the flags over it.
    fn open(&self) -> Result<OpenScene> {
        let mut file = input::scene_file(&self.input)?;
        self.camera.lay_over(&mut file)?;
        let aim = self.camera.aim()?;
        self.settings.lay_over(&mut file, self.look.mode())?;
        self.look.lay_over(&mut file)?;
        self.lights.lay_over(&mut file)?;
        self.labels.lay_over(&mut file)?;
        self.region.lay_over(&mut file)?;
        let n_own = file.layers.len();
        self.in_scene(|| {
            for path in &self.layers {
                let other = input::scene_file(path)?;
                file.layers.extend(other.layers);
                file.meshes.extend(other.meshes);
            }
            file.meshes.extend(self.meshes.iter().map(MeshFile::new));
            let loaded = input::load(&mut file, &self.raw)?;
            loaded[..n_own].iter().try_for_each(|volume| self.look.check_against(volume))?;
            let mut opened = OpenScene::unframed(loaded, &file)?;
            opened.frame(&file, &aim)?;
            Ok(opened)
        })
    }

    /// Reads what is named, and makes it ready to be rendered.
    pub(crate) fn renderer(&self, progress: &Progress) -> Result<(Renderer, Scene)> {
        let (renderer, opened) = self.open_with_renderer(progress)?;
        Ok((renderer, opened.scene))
    }

    /// The same with what was found of the volumes.
    pub(crate) fn open_with_renderer(&self, progress: &Progress) -> Result<(Renderer, OpenScene)> {
        let opened = self.open()?;
        terminal::warn_all(&opened.warnings);
        progress.stage("starting the backend");
        let renderer = self.in_scene(|| Ok(Renderer::open(&opened.backend, terminal::warn)?))?;
        Ok((renderer, opened))
    }

    /// Names the scene file in errors that only show when its values are used.
    pub(crate) fn in_scene<T>(&self, work: impl FnOnce() -> Result<T>) -> Result<T> {
        let result = work();
        if input::is_scene(&self.input) {
            return result.with_context(|| self.input.display().to_string());
        }
        result
    }

    /// Whether somebody may have said what gradients do to opacity.
    pub(crate) fn says_gradients(&self) -> bool {
        input::is_scene(&self.input) || self.look.says_gradients()
    }

    /// What is drawn, as it was named.
    pub(crate) fn input(&self) -> &Path {
        &self.input
    }

    /// The method that a flag names; the scene's does not count.
    pub(crate) fn method(&self) -> Option<slabsplat::Method> {
        self.settings.method()
    }
}
