//! Scene files ([`scene_keys`](crate::scene_keys)): everything that decides a pixel, as TOML.
//!
//! Reading order: this file (what a scene file says), `document` and `settings_section` (how it spells it),
//! `layers` and `sections` (what that means), `classify` (which values are visible), `camera`, `film`,
//! `labels` and `label_table`, `region`, `transfer_image` (a transfer function from a picture), `diagnostic`
//! (what a file does wrong, and in which line); `completed` (a scene file that leaves nothing open),
//! `written` and `paths` (its text).

mod document;

mod classify;
mod layers;
mod sections;
mod settings_section;

mod camera;
mod film;
mod label_table;
mod labels;
mod region;

mod mesh;
mod transfer_image;

mod diagnostic;

mod boxes;
mod completed;
mod paths;
mod written;

use std::fmt;
use std::path::{Path, PathBuf};

use slabsplat_core::{
    Finish, ImageDesc, Isosurface, Light, Phong, PiecewiseLinear, RenderSettings, Shading,
    TransferFunction, TransferFunction2d,
};

pub use boxes::VolumeBoxes;
pub use camera::CameraDesc;
pub use film::{FilmFile, KeyFile, KeyLayerFile, KeyLook, TurnFile};
pub use labels::{LabelBoxes, LabelColors, LabelsFile};
pub use mesh::MeshFile;
pub use region::RegionDesc;
pub use transfer_image::TransferImageFile;
pub(crate) use written::text_of;
pub use written::{scene_text, write_scene};

use crate::store::Store;
use crate::transfer::{FitError, TransferFit, TransferSource};
use crate::volume::read_raw_from;
use crate::{
    ContentHash, IoError, LoadedVolume, RawDesc, VolumeFormat, VolumeOptions, builtin_volume,
    read_transfer, read_volume_with, text,
};
use diagnostic::{Diagnostic, from_toml};
use document::Document;
use layers::LookFiles;
use paths::folder_of;

/// What a scene file says. What it leaves to the volumes is `None`: transfer functions, and the camera's
/// parts.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SceneFile {
    /// The volumes that are seen.
    pub layers: Vec<LayerFile>,
    /// Opaque meshes among them; there is at least one of either.
    pub meshes: Vec<MeshFile>,
    /// Where they are seen from.
    pub camera: CameraDesc,
    /// What shines on them.
    pub lights: Vec<Light>,
    /// Size and background of the picture.
    pub image: ImageDesc,
    /// How it is made.
    pub settings: RenderSettings,
    /// What becomes of the frame before it is a picture.
    pub finish: Finish,
    /// How it changes, if it does.
    pub film: Option<FilmFile>,
    /// The name of the backend that makes it; it is not checked here.
    pub backend: String,
    /// What else is to be found from the volumes.
    pub unsaid: Unsaid,
}

/// What a scene leaves open, beside transfer functions and the camera's parts. A file leaves none of it open:
/// what it does not say has a default.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Unsaid {
    /// What shines: the scene's lights do not count.
    pub lights: bool,
    /// What is behind it all: the image's background does not count.
    pub background: bool,
    /// What light does to layers and meshes: their shading does not count.
    pub shading: bool,
}

impl Unsaid {
    /// All of it is left open.
    pub const ALL: Self = Self { lights: true, background: true, shading: true };
}

/// What a scene file says of a layer.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct LayerFile {
    /// What it is called, for people.
    pub name: Option<String>,
    /// The volume.
    pub volume: VolumeSource,
    /// Which volume, where the file holds several.
    pub options: VolumeOptions,
    /// Voxel sides that overrule the volume file's.
    pub spacing: Option<[f64; 3]>,
    /// Which values are visible, and in which colour.
    pub transfer: Option<TransferFunction>,
    /// How that becomes what its volume is shown with.
    pub fit: TransferFit,
    /// What the file holds, if it has no header; `spacing` overrules its spacing.
    pub raw: Option<RawDesc>,
    /// Of the volume that the scene was made of, which need not be the one that is there now.
    pub hash: Option<ContentHash>,
    /// What decides instead, by values and gradients together.
    pub transfer_2d: Option<TransferFunction2d>,
    /// The file that `transfer_2d` was read from, if it was.
    pub transfer_image: Option<TransferImageFile>,
    /// What opacities are multiplied with, by the length of the gradient per voxel step.
    pub gradient_opacity: Option<PiecewiseLinear<1>>,
    /// What its voxels belong to.
    pub labels: Option<LabelsFile>,
    /// What is shown instead in the mode `isosurfaces`.
    pub isosurfaces: Vec<Isosurface>,
    /// What light does to them.
    pub shading: Shading,
    /// Where they are seen.
    pub region: RegionDesc,
}

/// Where a volume comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum VolumeSource {
    /// A file in any format that [`read_volume`](crate::read_volume) knows.
    File(PathBuf),
    /// One of [`BUILTIN_NAMES`](crate::BUILTIN_NAMES).
    Builtin {
        /// Which.
        name: String,
        /// Voxels a side, if not the usual number.
        size: Option<usize>,
    },
}

impl fmt::Display for VolumeSource {
    /// The path, or `builtin:` and the name.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(path) => write!(f, "{}", path.display()),
            Self::Builtin { name, .. } => write!(f, "builtin:{name}"),
        }
    }
}

/// Reads a scene file; [`scene_keys`](crate::scene_keys) has all that it may say. Relative paths in it start
/// from its folder. The volume is not read yet.
///
/// # Errors
/// If the file cannot be read, is not TOML, has a key that is not known, or a value that cannot be.
/// The message names the key and the line.
pub fn read_scene(path: impl AsRef<Path>) -> Result<SceneFile, IoError> {
    let path = path.as_ref();
    parse_scene(&text::read(path)?, path)
}

/// The scene that a text says, as [`read_scene`] of a file that holds it would be; there need not be one of
/// that name.
///
/// ```
/// let scene = slabsplat_io::parse_scene("volume = { generate = \"cube\" }", "from the web")?;
/// assert_eq!(scene.image.width, 512);
/// let error = slabsplat_io::parse_scene("volum = 1", "from the web").unwrap_err().to_string();
/// assert!(error.starts_with("from the web:1: "));
/// # Ok::<(), slabsplat_io::IoError>(())
/// ```
///
/// # Errors
/// As [`read_scene`].
pub fn parse_scene(text: &str, path: impl AsRef<Path>) -> Result<SceneFile, IoError> {
    let path = path.as_ref();
    let in_file = |diagnostic: Diagnostic| diagnostic.in_file(path, text);
    let (mut scene, look_files) = parsed(text, path).map_err(in_file)?;
    for (layer, files) in scene.layers.iter_mut().zip(look_files) {
        let LookFiles { transfer, has_shading, transfer_image } = files;
        if let Some(path) = transfer {
            layer.begin_with(read_transfer(&path)?, has_shading);
            let wrong = |error: FitError| Diagnostic::at("classify", "", error.to_string());
            layer.check_fit().map_err(|error| in_file(wrong(error)))?;
        }
        if let Some(image) = transfer_image {
            layer.transfer_2d = Some(image.load()?);
            layer.transfer_image = Some(image);
        }
    }
    Ok(scene)
}

/// The scene that a stranger's text says, of which no file is looked at: not even those that
/// [`parse_scene`] reads at once, as they say how layers look. Of a two-dimensional transfer function in a
/// picture there is only the picture's name.
///
/// ```
/// let text = "volume = { path = \"a.nii\" }\nclassify = { file = \"/etc/passwd\" }";
/// let error = slabsplat_io::parse_scene_alone(text, "from the web").unwrap_err().to_string();
/// assert!(error.contains("no file is read"), "{error}");
/// ```
///
/// # Errors
/// As [`read_scene`], and if a layer has its transfer function from a file.
pub fn parse_scene_alone(text: &str, path: impl AsRef<Path>) -> Result<SceneFile, IoError> {
    let path = path.as_ref();
    let in_file = |diagnostic: Diagnostic| diagnostic.in_file(path, text);
    let (mut scene, look_files) = parsed(text, path).map_err(in_file)?;
    for (layer, files) in scene.layers.iter_mut().zip(look_files) {
        if files.transfer.is_some() {
            let what = "no file is read for this scene: give opacity and color instead";
            return Err(in_file(Diagnostic::at("classify", "file", what)));
        }
        layer.transfer_image = files.transfer_image;
    }
    Ok(scene)
}

/// What a text says, and which files say how layers look.
fn parsed(text: &str, path: &Path) -> Result<(SceneFile, Vec<LookFiles>), Diagnostic> {
    let document: Document = toml::from_str(text).map_err(|error| from_toml(&error, text))?;
    document.into_scene(folder_of(path))
}

impl SceneFile {
    /// A scene that leaves everything to a volume and to the defaults.
    pub fn of_volume(volume: VolumeSource) -> Self {
        Self { layers: vec![LayerFile::of_volume(volume)], ..Self::of_nothing() }
    }

    /// A scene of a mesh alone.
    pub fn of_mesh(path: impl Into<PathBuf>) -> Self {
        Self { meshes: vec![MeshFile::new(path)], ..Self::of_nothing() }
    }

    /// Whether the transfer functions that it has are those that volumes are shown with, and none is still to
    /// be fitted to its volume.
    pub fn is_fitted(&self) -> bool {
        self.layers.iter().all(|layer| layer.fit == TransferFit::default())
            && self.film.as_ref().is_none_or(FilmFile::is_fitted)
    }

    fn of_nothing() -> Self {
        Self {
            layers: Vec::new(),
            meshes: Vec::new(),
            camera: CameraDesc::default(),
            lights: vec![Light::default()],
            image: ImageDesc::default(),
            settings: RenderSettings::default(),
            finish: Finish::default(),
            film: None,
            backend: "auto".to_owned(),
            unsaid: Unsaid::ALL,
        }
    }
}

impl LayerFile {
    /// A layer that leaves everything to its volume and to the defaults.
    pub fn of_volume(volume: VolumeSource) -> Self {
        Self {
            name: None,
            volume,
            options: VolumeOptions::default(),
            spacing: None,
            raw: None,
            hash: None,
            transfer: None,
            fit: TransferFit::default(),
            transfer_2d: None,
            transfer_image: None,
            gradient_opacity: None,
            labels: None,
            isosurfaces: Vec::new(),
            shading: Shading::Phong(Phong::default()),
            region: RegionDesc::default(),
        }
    }

    /// The transfer function of a source; of the light that the source has, if there `has_shading` nothing is
    /// said of it already. What else is said of how a transfer function fits stays.
    pub fn begin_with(&mut self, source: TransferSource, has_shading: bool) {
        if let Some(shading) = source.shading.filter(|_| !has_shading) {
            self.shading = shading;
        }
        let (transfer, fit) = TransferFit::of_source(source);
        let TransferFit { stretch, colormap, opacity, color, opacity_scale, unit_distance, .. } =
            std::mem::take(&mut self.fit);
        self.transfer = Some(transfer);
        let unit_distance = unit_distance.or(fit.unit_distance);
        self.fit =
            TransferFit { stretch, colormap, opacity, color, opacity_scale, unit_distance, ..fit };
    }

    /// That its transfer function can be fitted to a volume.
    ///
    /// # Errors
    /// If a number of how it fits cannot be, or a window has nothing to move.
    pub fn check_fit(&self) -> Result<(), FitError> {
        self.fit.check(self.transfer.is_some())
    }

    /// Whether its volume is that of the other layer, so that one may serve both.
    pub fn shares_volume(&self, other: &Self) -> bool {
        self.volume == other.volume
            && self.options == other.options
            && self.spacing == other.spacing
            && self.raw == other.raw
    }

    /// The volumes of all layers, by `load`; one that several of them show is loaded once.
    ///
    /// # Errors
    /// As `load`.
    pub fn load_volumes<E>(
        layers: &[Self],
        mut load: impl FnMut(&Self) -> Result<LoadedVolume, E>,
    ) -> Result<Vec<LoadedVolume>, E> {
        let mut volumes: Vec<LoadedVolume> = Vec::with_capacity(layers.len());
        for layer in layers {
            let before = layers.iter().zip(&volumes).find(|(other, _)| layer.shares_volume(other));
            volumes.push(match before {
                Some((_, loaded)) => LoadedVolume { warnings: Vec::new(), ..loaded.clone() },
                None => load(layer)?,
            });
        }
        Ok(volumes)
    }

    /// Reads or makes the volume, with the layer's spacing if it has one.
    ///
    /// # Errors
    /// As [`read_volume_with`] and [`builtin_volume`]; or if the spacing cannot be.
    pub fn load_volume(&self) -> Result<LoadedVolume, IoError> {
        if let (VolumeSource::File(path), Some(raw)) = (&self.volume, &self.raw) {
            let spacing = self.spacing.unwrap_or(raw.spacing);
            let raw = RawDesc { spacing, ..*raw };
            return read_raw_from(Store::Disk, path, &raw, &self.options);
        }
        self.spaced(self.volume.load(&self.options)?)
    }

    /// A volume of the file with the layer's spacing, if it has one.
    fn spaced(&self, loaded: LoadedVolume) -> Result<LoadedVolume, IoError> {
        match self.spacing {
            None => Ok(loaded),
            Some(spacing) => loaded
                .with_spacing(spacing)
                .map_err(|source| IoError::Grid { path: self.volume.path(), source }),
        }
    }
}

impl VolumeSource {
    /// Reads or makes the volume.
    ///
    /// # Errors
    /// As [`read_volume_with`] and [`builtin_volume`].
    pub fn load(&self, options: &VolumeOptions) -> Result<LoadedVolume, IoError> {
        match self {
            Self::File(path) => read_volume_with(path, options),
            Self::Builtin { name, size } => {
                if options.voxels.is_some() {
                    let what = "a built-in volume is made whole, and not box by box: slabsplat convert \
                            saves it as .raw, .nii or .zarr";
                    return Err(IoError::unsupported(Path::new(name), what));
                }
                let volume = builtin_volume(name, *size)?.into();
                let loaded = LoadedVolume::new(volume, VolumeFormat::Builtin, Vec::new());
                options.check(Path::new(name), &loaded.choices)?;
                Ok(loaded)
            }
        }
    }

    /// What stands for the volume in a message.
    fn path(&self) -> PathBuf {
        match self {
            Self::File(path) => path.clone(),
            Self::Builtin { name, .. } => PathBuf::from(name),
        }
    }
}

#[cfg(test)]
mod tests;
