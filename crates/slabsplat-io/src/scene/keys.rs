//! The keys of a scene file, as they are spelt. What is not given keeps the default of the settings' own
//! types; a key that is not here is an error.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Deserializer, de};
use slabsplat_core::glam::DVec3;
use slabsplat_core::{
    Compositing, ImageDesc, KernelName, Light, Lookup, Method, Normalization, Phong,
    RenderSettings, Shading,
};

use super::classify::Complaint;
use super::{CameraDesc, ProjectionKind, SceneFile, VolumeSource};
use crate::IoError;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SceneKeys {
    volume: VolumeKeys,
    #[serde(default)]
    classify: ClassifyKeys,
    #[serde(default)]
    shading: ShadingKeys,
    #[serde(default)]
    camera: CameraKeys,
    #[serde(default)]
    image: ImageKeys,
    #[serde(default)]
    render: RenderKeys,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct VolumeKeys {
    path: Option<PathBuf>,
    generate: Option<String>,
    size: Option<usize>,
    spacing: Option<[f64; 3]>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ClassifyKeys {
    pub(super) opacity: Option<Vec<[f64; 2]>>,
    pub(super) color: Option<Vec<[f64; 4]>>,
    pub(super) preset: Option<String>,
    pub(super) file: Option<PathBuf>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct ShadingKeys {
    model: Option<ShadingModel>,
    ambient: Option<f64>,
    diffuse: Option<f64>,
    specular: Option<f64>,
    shininess: Option<f64>,
    two_sided: Option<bool>,
    light: Option<LightKey>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
enum ShadingModel {
    Phong,
    None,
}

#[derive(Debug, Deserialize)]
#[serde(untagged, expecting = "light must be \"headlight\" or a vector of three numbers")]
enum LightKey {
    Name(String),
    Direction([f64; 3]),
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct CameraKeys {
    #[serde(default, deserialize_with = "projection")]
    projection: Option<ProjectionKind>,
    eye: Option<[f64; 3]>,
    target: Option<[f64; 3]>,
    up: Option<[f64; 3]>,
    view_height: Option<f64>,
    fov_y: Option<f64>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct ImageKeys {
    width: Option<u32>,
    height: Option<u32>,
    background: Option<[f32; 4]>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct RenderKeys {
    #[serde(default, deserialize_with = "method")]
    method: Option<Method>,
    kernel: Option<String>,
    slab_width: Option<f64>,
    #[serde(default, deserialize_with = "compositing")]
    compositing: Option<Compositing>,
    #[serde(default, deserialize_with = "normalization")]
    normalization: Option<Normalization>,
    base_slab_width: Option<f64>,
    sections: Option<u32>,
    radial_samples: Option<u32>,
    #[serde(default, deserialize_with = "lookup")]
    lookup: Option<Lookup>,
    opacity_cutoff: Option<f64>,
    backend: Option<String>,
}

impl SceneKeys {
    pub(super) fn into_scene(self, path: &Path) -> Result<SceneFile, IoError> {
        let transfer = self.classify.transfer(path);
        let try_scene = || -> Result<SceneFile, Complaint> {
            let mut scene = SceneFile::new(self.volume.source(path)?);
            scene.spacing = self.volume.spacing;
            scene.transfer = transfer?;
            scene.shading = self.shading.shading()?;
            scene.camera = self.camera.desc();
            scene.image = self.image.desc()?;
            scene.settings = self.render.settings()?;
            if let Some(backend) = self.render.backend {
                scene.backend = backend;
            }
            Ok(scene)
        };
        try_scene().map_err(|what| IoError::Scene { path: path.to_owned(), line: None, what })
    }
}

impl VolumeKeys {
    fn source(&self, scene_path: &Path) -> Result<VolumeSource, Complaint> {
        match (&self.path, &self.generate) {
            (Some(path), None) if self.size.is_none() => {
                let folder = scene_path.parent().unwrap_or(Path::new(""));
                Ok(VolumeSource::File(folder.join(path)))
            }
            (None, Some(name)) => Ok(VolumeSource::Builtin { name: name.clone(), size: self.size }),
            (Some(_), None) => Err("[volume] size goes with generate, not with path".to_owned()),
            _ => Err("[volume] needs either path or generate".to_owned()),
        }
    }
}

impl ShadingKeys {
    fn shading(&self) -> Result<Shading, Complaint> {
        if matches!(self.model, Some(ShadingModel::None)) {
            return Ok(Shading::None);
        }
        let default = Phong::default();
        let light = match &self.light {
            None => default.light,
            Some(LightKey::Name(name)) if name == "headlight" => Light::Headlight,
            Some(LightKey::Name(name)) => {
                return Err(format!(
                    "[shading] light must be \"headlight\" or a vector, not {name:?}"
                ));
            }
            Some(LightKey::Direction(towards)) => Light::towards(DVec3::from_array(*towards))
                .map_err(|err| format!("[shading] {err}"))?,
        };
        let phong = Phong {
            ambient: self.ambient.unwrap_or(default.ambient),
            diffuse: self.diffuse.unwrap_or(default.diffuse),
            specular: self.specular.unwrap_or(default.specular),
            shininess: self.shininess.unwrap_or(default.shininess),
            two_sided: self.two_sided.unwrap_or(default.two_sided),
            light,
        };
        phong.checked().map(Shading::Phong).map_err(|err| format!("[shading] {err}"))
    }
}

impl CameraKeys {
    fn desc(&self) -> CameraDesc {
        let Self { projection, eye, target, up, view_height, fov_y } = *self;
        CameraDesc { projection, eye, target, up, view_height, fov_y }
    }
}

impl ImageKeys {
    fn desc(&self) -> Result<ImageDesc, Complaint> {
        let default = ImageDesc::default();
        let desc = ImageDesc {
            width: self.width.unwrap_or(default.width),
            height: self.height.unwrap_or(default.height),
            background: self.background.unwrap_or(default.background),
        };
        desc.checked().map_err(|err| format!("[image] {err}"))
    }
}

impl RenderKeys {
    fn settings(&self) -> Result<RenderSettings, Complaint> {
        let default = RenderSettings::default();
        let kernel = self.kernel.clone().map(|name| KernelName(name.into()));
        let settings = RenderSettings {
            method: self.method.unwrap_or(default.method),
            kernel: kernel.unwrap_or(default.kernel),
            slab_width: self.slab_width.unwrap_or(default.slab_width),
            compositing: self.compositing.unwrap_or(default.compositing),
            normalization: self.normalization.unwrap_or(default.normalization),
            base_slab_width: self.base_slab_width.unwrap_or(default.base_slab_width),
            sections: self.sections.unwrap_or(default.sections),
            radial_samples: self.radial_samples.unwrap_or(default.radial_samples),
            lookup: self.lookup.unwrap_or(default.lookup),
            opacity_cutoff: self.opacity_cutoff.unwrap_or(default.opacity_cutoff),
        };
        settings.checked().map_err(|err| format!("[render] {err}"))
    }
}

/// Deserialises a choice by its name; the error lists all names.
macro_rules! by_name {
    ($function:ident, $ty:ty, $names:expr) => {
        fn $function<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<$ty>, D::Error> {
            let name = String::deserialize(deserializer)?;
            let unknown = || {
                let names: Vec<&str> = $names;
                let what = stringify!($function);
                de::Error::custom(format!("{what} {name:?} is none of {}", names.join(", ")))
            };
            <$ty>::from_name(&name).map(Some).ok_or_else(unknown)
        }
    };
}

by_name!(projection, ProjectionKind, vec!["orthographic", "perspective"]);
by_name!(method, Method, Method::ALL.iter().map(|c| c.name()).collect());
by_name!(compositing, Compositing, Compositing::ALL.iter().map(|c| c.name()).collect());
by_name!(normalization, Normalization, Normalization::ALL.iter().map(|c| c.name()).collect());
by_name!(lookup, Lookup, Lookup::ALL.iter().map(|c| c.name()).collect());
