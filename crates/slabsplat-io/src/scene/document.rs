//! A scene file as it is spelt: its sections, keys and defaults. `sections` turns each into what it
//! means.

use std::path::PathBuf;

use serde::Deserialize;
use slabsplat_core::{
    Compositing, ImageDesc, Light, Lookup, Method, Normalization, Phong, RenderSettings,
};

use super::camera::ProjectionKind;
use super::choice::{choice, light, maybe_choice};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Document {
    pub(super) volume: Option<VolumeSection>,
    pub(super) classify: Option<ClassifySection>,
    #[serde(default)]
    pub(super) shading: ShadingSection,
    #[serde(default)]
    pub(super) camera: CameraSection,
    #[serde(default)]
    pub(super) image: ImageSection,
    #[serde(default)]
    pub(super) render: RenderSection,
}

/// Either `path` or `generate`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct VolumeSection {
    pub(super) path: Option<PathBuf>,
    pub(super) generate: Option<String>,
    /// Voxels a side, with `generate`.
    pub(super) size: Option<usize>,
    pub(super) spacing: Option<[f64; 3]>,
}

/// Points, a preset or a file. Without `color`, all that is visible is white.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ClassifySection {
    pub(super) opacity: Option<Vec<[f64; 2]>>,
    pub(super) color: Option<Vec<[f64; 4]>>,
    pub(super) preset: Option<String>,
    pub(super) file: Option<PathBuf>,
}

#[derive(Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct ShadingSection {
    pub(super) model: String,
    pub(super) ambient: f64,
    pub(super) diffuse: f64,
    pub(super) specular: f64,
    pub(super) shininess: f64,
    pub(super) two_sided: bool,
    #[serde(deserialize_with = "light")]
    pub(super) light: Light,
}

#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct CameraSection {
    #[serde(deserialize_with = "maybe_choice")]
    pub(super) projection: Option<ProjectionKind>,
    pub(super) eye: Option<[f64; 3]>,
    pub(super) target: Option<[f64; 3]>,
    pub(super) up: Option<[f64; 3]>,
    pub(super) view_height: Option<f64>,
    /// Degrees.
    pub(super) fov_y: Option<f64>,
}

#[derive(Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct ImageSection {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) background: [f32; 4],
}

#[derive(Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct RenderSection {
    #[serde(deserialize_with = "choice")]
    pub(super) method: Method,
    pub(super) kernel: String,
    pub(super) slab_width: f64,
    #[serde(deserialize_with = "choice")]
    pub(super) compositing: Compositing,
    #[serde(deserialize_with = "choice")]
    pub(super) normalization: Normalization,
    pub(super) base_slab_width: f64,
    pub(super) sections: u32,
    pub(super) radial_samples: u32,
    #[serde(deserialize_with = "choice")]
    pub(super) lookup: Lookup,
    pub(super) opacity_cutoff: f64,
    pub(super) tolerance: f64,
    pub(super) backend: String,
}

impl Default for ShadingSection {
    fn default() -> Self {
        let Phong { ambient, diffuse, specular, shininess, two_sided, light } = Phong::default();
        let model = "phong".to_owned();
        Self { model, ambient, diffuse, specular, shininess, two_sided, light }
    }
}

impl Default for ImageSection {
    fn default() -> Self {
        let ImageDesc { width, height, background } = ImageDesc::default();
        Self { width, height, background }
    }
}

impl Default for RenderSection {
    fn default() -> Self {
        let settings = RenderSettings::default();
        Self {
            method: settings.method,
            kernel: settings.kernel.0.into_owned(),
            slab_width: settings.slab_width,
            compositing: settings.compositing,
            normalization: settings.normalization,
            base_slab_width: settings.base_slab_width,
            sections: settings.sections,
            radial_samples: settings.radial_samples,
            lookup: settings.lookup,
            opacity_cutoff: settings.opacity_cutoff,
            tolerance: settings.tolerance,
            backend: "cpu".to_owned(),
        }
    }
}
