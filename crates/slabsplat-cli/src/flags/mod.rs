//! A flag for every key of a scene file. What a flag says overrides what the file says.
//!
//! One struct for one table of the file; each lays its flags over that part of the scene. `table` makes the
//! flags of what is a row in a table of settings.

mod annotations;
mod camera;
mod film;
mod labels;
mod lights;
mod look;
mod output;
mod parts;
mod raw;
mod region;
mod running;
mod settings;
mod table;
mod transfer;
pub(crate) mod values;

pub(crate) use film::FilmFlags;
pub(crate) use output::{
    OutputFlags, PictureFlags, Target, Written, check_folder, check_scene_name, is_same_file,
};
pub(crate) use raw::RawFlags;
pub(crate) use running::RunningFlags;
pub(crate) use transfer::TransferFlags;

use crate::input;
use crate::progress::Progress;
use crate::stdin;
use crate::terminal;
use anyhow::{Context, Result, bail};
use clap::Args;
#[cfg(feature = "viewer")]
use slabsplat::io::ProgressCallback;
use slabsplat::io::{MeshFile, SceneFile};
use slabsplat::{
    Aim, Camera, DividedDesc, DividedScene, NoBackend, OpenError, OpenScene, Renderer, Scene,
};
use std::path::{Path, PathBuf};

/// What is drawn, and all flags about how.
#[derive(Args)]
pub(crate) struct SceneFlags {
    /// A scene file (.toml), a picture that slabsplat made, a volume file, a mesh (.ply, .stl, .obj), a
    /// built-in volume as builtin:NAME or builtin:NAME:SIZE, or - for a volume on standard input
    #[arg(value_name = "INPUT", help_heading = "Input")]
    input: PathBuf,

    #[command(flatten)]
    how: HowFlags,
}

/// All flags about how something is drawn, whatever it is.
#[derive(Args)]
#[command(next_help_heading = "Input")]
pub(crate) struct HowFlags {
    /// Something else in the same picture: a scene file's layers, a volume file, or a built-in volume; flags
    /// that say what a layer is like are about INPUT's
    #[arg(long = "layer", value_name = "FILE")]
    layers: Vec<PathBuf>,

    /// An opaque mesh in the same picture, or lines or points: .ply, .stl or .obj; may be given several times
    #[arg(long = "mesh", value_name = "FILE")]
    meshes: Vec<PathBuf>,

    #[command(flatten)]
    camera: camera::CameraFlags,

    #[command(flatten)]
    look: look::LookFlags,

    #[command(flatten)]
    lights: lights::LightFlags,

    #[command(flatten)]
    region: region::RegionFlags,

    #[command(flatten)]
    labels: labels::LabelFlags,

    #[command(flatten)]
    raw: RawFlags,

    #[command(flatten)]
    annotations: annotations::AnnotationFlags,

    #[command(flatten)]
    settings: settings::SettingsFlags,
}

/// What must be so before anything is read.
type Check<'a> = &'a dyn Fn(&SceneFile) -> Result<()>;

/// What finds the camera of a scene that is open.
type Frame<'a> = &'a dyn Fn(&mut OpenScene, &SceneFile, &Aim) -> Result<(), OpenError>;

impl HowFlags {
    /// The backend that a flag names.
    #[cfg(feature = "viewer")]
    pub(crate) fn backend(&self) -> Option<&str> {
        self.settings.backend()
    }
}

impl SceneFlags {
    /// What is named, with the flags laid over it; no volume is read.
    pub(crate) fn file(&self) -> Result<SceneFile> {
        let mut file = input::scene_file(&self.input)?;
        self.how.camera.lay_over(&mut file)?;
        self.how.annotations.lay_over(&mut file)?;
        self.how.settings.lay_over(&mut file, self.how.look.mode())?;
        self.how.look.lay_over(&mut file)?;
        self.how.lights.lay_over(&mut file)?;
        self.how.labels.lay_over(&mut file)?;
        self.how.region.lay_over(&mut file)?;
        Ok(file)
    }

    /// Reads what is named, and lays the flags over it.
    pub(crate) fn open(&self) -> Result<OpenScene> {
        self.open_framed(&|_| Ok(()), &|opened, file, aim| opened.frame(file, aim))
    }

    /// The same for pictures of another size; `hear` hears how far reading is, and may stop it.
    #[cfg(feature = "viewer")]
    pub(crate) fn open_for(
        &self,
        [width, height]: [u32; 2],
        hear: ProgressCallback,
    ) -> Result<OpenScene> {
        let mut file = self.file()?;
        if let Some(first) = file.layers.first_mut() {
            first.options.progress = Some(hear);
        }
        self.open_file(file, &|opened, file, aim| {
            let image = &mut opened.scene.image;
            (image.width, image.height) = (width, height);
            opened.frame(file, aim)
        })
    }

    fn open_framed(&self, check: Check<'_>, frame: Frame<'_>) -> Result<OpenScene> {
        let file = self.file()?;
        check(&file)?;
        self.open_file(file, frame)
    }

    fn open_file(&self, mut file: SceneFile, frame: Frame<'_>) -> Result<OpenScene> {
        let aim = self.how.camera.aim()?;
        let n_own = file.layers.len();
        self.in_scene(|| {
            self.add_others(&mut file)?;
            let loaded = input::load(&mut file, &self.how.raw)?;
            loaded[..n_own].iter().try_for_each(|volume| self.how.look.check_against(volume))?;
            let mut opened = OpenScene::unframed(loaded, &file)?;
            frame(&mut opened, &file, &aim)?;
            Ok(opened)
        })
    }

    /// Adds what other files show in the same picture.
    fn add_others(&self, file: &mut SceneFile) -> Result<()> {
        for path in &self.how.layers {
            let other = input::scene_file(path)?;
            file.layers.extend(other.layers);
            file.meshes.extend(other.meshes);
        }
        file.meshes.extend(self.how.meshes.iter().map(MeshFile::new));
        self.how.look.thicken(&mut file.meshes)
    }

    /// The scene for what it may take, of which no volume is read whole. What cannot be made of it fails by
    /// `check` before.
    pub(crate) fn divided(&self, check: Check<'_>, desc: &DividedDesc) -> Result<DividedScene> {
        let (file, aim) = self.in_parts(check)?;
        self.in_scene(|| {
            let divided = DividedScene::open_as(&file, &desc.clone().aim(aim))?;
            terminal::warn_all(&divided.opened().warnings);
            Ok(divided)
        })
    }

    /// The same with a camera that holds what is seen by others, too, which go around with the one that is
    /// found.
    pub(crate) fn divided_around(
        &self,
        check: Check<'_>,
        desc: &DividedDesc,
        views: &dyn Fn(&SceneFile, &Camera) -> Vec<Camera>,
    ) -> Result<DividedScene> {
        let (file, aim) = self.in_parts(check)?;
        self.in_scene(|| {
            let views = |camera: &Camera| views(&file, camera);
            let divided = DividedScene::open_around(&file, &desc.clone().aim(aim), &views)?;
            terminal::warn_all(&divided.opened().warnings);
            Ok(divided)
        })
    }

    /// What is named, with all flags laid over it, to be read in parts: no volume is read.
    pub(crate) fn in_parts(&self, check: Check<'_>) -> Result<(SceneFile, Aim)> {
        let mut file = self.file()?;
        check(&file)?;
        let aim = self.how.camera.aim()?;
        self.in_scene(|| {
            self.add_others(&mut file)?;
            input::describe(&mut file, &self.how.raw)?;
            if file.layers.iter().any(stdin::is_stdin) {
                bail!("a volume on standard input is in memory whole: save it to draw it in parts");
            }
            Ok((file, aim))
        })
    }

    /// Reads what is named, and makes it ready to be rendered.
    pub(crate) fn renderer(&self, progress: &Progress) -> Result<(Renderer, Scene)> {
        let (renderer, opened) = self.opened(progress, &|_| Ok(()))?;
        Ok((renderer, opened.scene))
    }

    /// The same with where the scene came from. What cannot be made of it fails by `check`, before volumes
    /// are read.
    pub(crate) fn opened(
        &self,
        progress: &Progress,
        check: Check<'_>,
    ) -> Result<(Renderer, OpenScene)> {
        let frame: Frame<'_> = &|opened, file, aim| opened.frame(file, aim);
        self.ready(progress, self.open_framed(check, frame)?)
    }

    /// The same with a camera that holds what is seen by others, too, which go around with the one that is
    /// found.
    pub(crate) fn opened_around(
        &self,
        progress: &Progress,
        check: Check<'_>,
        views: &dyn Fn(&SceneFile, &Camera) -> Vec<Camera>,
    ) -> Result<(Renderer, OpenScene)> {
        let opened = self.open_framed(check, &|opened, file, aim| {
            opened.frame_around(file, aim, &|camera| views(file, camera))
        })?;
        self.ready(progress, opened)
    }

    fn ready(&self, progress: &Progress, opened: OpenScene) -> Result<(Renderer, OpenScene)> {
        terminal::warn_all(&opened.warnings);
        progress.stage("starting the backend");
        let renderer = self.in_scene(|| self.renderer_of(&opened.backend))?;
        Ok((renderer, opened))
    }

    /// What drew a picture elsewhere need not be here, and nobody has asked for it.
    fn renderer_of(&self, backend: &str) -> Result<Renderer> {
        match Renderer::open(backend, terminal::warn) {
            Err(NoBackend::Unavailable { .. } | NoBackend::NotBuilt { .. })
                if input::is_picture(&self.input) && !self.how.settings.names_backend() =>
            {
                let picture = self.input.display();
                terminal::warn(&format!(
                    "{picture} was drawn by {backend}, which is not here: pixels may differ"
                ));
                Ok(Renderer::open("auto", terminal::warn)?)
            }
            Err(error @ NoBackend::Unavailable { .. }) => {
                bail!("{error}; --backend auto draws by what there is")
            }
            opened => Ok(opened?),
        }
    }

    /// Names the scene file in errors that only show when its values are used.
    pub(crate) fn in_scene<T>(&self, work: impl FnOnce() -> Result<T>) -> Result<T> {
        let result = work();
        if input::is_picture(&self.input) {
            let result = result.map_err(|error| input::where_files_are(&self.input, error));
            return result.with_context(|| self.input.display().to_string());
        }
        if input::is_scene(&self.input) {
            return result.with_context(|| self.input.display().to_string());
        }
        result
    }

    /// Whether somebody may have said what gradients do to opacity.
    pub(crate) fn says_gradients(&self) -> bool {
        input::is_scene(&self.input) || self.how.look.says_gradients()
    }

    /// The same flags for something else to draw.
    pub(crate) fn of(input: PathBuf, how: HowFlags) -> Self {
        Self { input, how }
    }

    /// From now on, something else is drawn.
    pub(crate) fn set_input(&mut self, input: PathBuf) {
        self.input = input;
    }

    /// What is drawn, as it was named.
    pub(crate) fn input(&self) -> &Path {
        &self.input
    }

    /// Whether all that the flags say is in [`file`](Self::file).
    pub(crate) fn are_of_file(&self) -> bool {
        self.how.layers.is_empty()
            && self.how.meshes.is_empty()
            && self.how.raw.are_silent()
            && self.how.camera.aim().is_ok_and(|aim| aim == Aim::default())
    }

    /// The method that a flag names; the scene's does not count.
    pub(crate) fn method(&self) -> Option<slabsplat::Method> {
        self.how.settings.method()
    }
}
