//! A scene file as it is spelt: its sections, keys and defaults. `sections` turns each into what it
//! means.

use std::path::PathBuf;

use serde::Deserialize;
use slabsplat_core::{ImageDesc, Isosurface, Light, Phong, ProjectionKind, RenderSettings};

use super::settings_section::SettingsSection;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Document {
    pub(super) volume: Option<VolumeSection>,
    pub(super) mesh: Option<MeshSection>,
    pub(super) classify: Option<ClassifySection>,
    pub(super) labels: Option<LabelsSection>,
    pub(super) shading: Option<SettingsSection<Phong>>,
    pub(super) region: Option<RegionSection>,
    pub(super) layers: Option<Vec<LayerSection>>,
    #[serde(default)]
    pub(super) camera: CameraSection,
    pub(super) lights: Option<Vec<Light>>,
    #[serde(default)]
    pub(super) image: ImageDesc,
    #[serde(default)]
    pub(super) render: SettingsSection<RenderSettings>,
}

/// What the sections of a scene with one layer say, of one of several.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LayerSection {
    pub(super) name: Option<String>,
    pub(super) visible: Option<bool>,
    pub(super) volume: Option<VolumeSection>,
    pub(super) mesh: Option<MeshSection>,
    pub(super) classify: Option<ClassifySection>,
    pub(super) labels: Option<LabelsSection>,
    pub(super) shading: Option<SettingsSection<Phong>>,
    pub(super) region: Option<RegionSection>,
}

/// Either `path` or `generate`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct VolumeSection {
    pub(super) path: Option<PathBuf>,
    pub(super) generate: Option<String>,
    /// Voxels a side, with `generate`.
    pub(super) size: Option<usize>,
    /// Which volume, with `path`.
    pub(super) series: Option<usize>,
    pub(super) channel: Option<usize>,
    pub(super) time: Option<usize>,
    pub(super) level: Option<usize>,
    /// In which colours voxels of several values are drawn, and what their opacity is made of.
    pub(super) colors: Option<String>,
    pub(super) opacity_from: Option<String>,
    pub(super) spacing: Option<[f64; 3]>,
}

/// Instead of a volume.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MeshSection {
    pub(super) path: Option<PathBuf>,
    pub(super) color: Option<[f64; 3]>,
    /// What takes the file's coordinates to the world, by rows.
    pub(super) affine: Option<[[f64; 4]; 3]>,
}

/// Points, a preset, a file, or boxes or a picture of values and gradients. Without `color`, all that is
/// visible is white. Beside them, isosurfaces.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ClassifySection {
    pub(super) opacity: Option<Vec<[f64; 2]>>,
    pub(super) color: Option<Vec<[f64; 4]>>,
    pub(super) preset: Option<String>,
    /// Of ParaView or 3D Slicer.
    pub(super) file: Option<PathBuf>,
    /// Instead of other colours.
    pub(super) colormap: Option<String>,
    /// What a preset, a file or a colour map is stretched to; or percentiles.
    pub(super) window: Option<[f64; 2]>,
    pub(super) percentile: Option<[f64; 2]>,
    pub(super) opacity_scale: Option<f64>,
    pub(super) unit_distance: Option<f64>,
    pub(super) boxes: Option<Vec<BoxSection>>,
    pub(super) image: Option<TransferImageSection>,
    /// What opacity is multiplied with, by the length of the gradient.
    pub(super) gradient_opacity: Option<Vec<[f64; 2]>>,
    #[serde(default)]
    pub(super) isosurfaces: Vec<Isosurface>,
}

/// A box of values and gradients; of all gradients if it does not say.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct BoxSection {
    pub(super) values: [f64; 2],
    pub(super) gradients: Option<[f64; 2]>,
    pub(super) opacity: Option<f64>,
    pub(super) color: Option<[f64; 3]>,
    /// Over how much of values and of gradients it fades.
    pub(super) fade: Option<[f64; 2]>,
}

/// A picture, and the values and gradients at its edges.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TransferImageSection {
    pub(super) file: PathBuf,
    pub(super) values: [f64; 2],
    pub(super) gradients: [f64; 2],
}

/// A volume of labels, and how these look.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LabelsSection {
    pub(super) path: PathBuf,
    /// A file, or `auto`.
    pub(super) colors: Option<PathBuf>,
    pub(super) only: Option<Vec<i64>>,
    #[serde(default)]
    pub(super) styles: Vec<LabelStyleSection>,
}

/// How some labels look.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LabelStyleSection {
    pub(super) of: Vec<i64>,
    pub(super) color: Option<[f64; 3]>,
    pub(super) opacity: Option<f64>,
    pub(super) classify: Option<ClassifySection>,
}

/// A box, planes, or both.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct RegionSection {
    /// The least and the greatest corner.
    #[serde(rename = "box")]
    pub(super) ends: Option<[[f64; 3]; 2]>,
    /// Whether these are voxels.
    pub(super) index: bool,
    /// Normals and distances.
    pub(super) planes: Vec<[f64; 4]>,
    pub(super) invert: bool,
    pub(super) lit: bool,
}

#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct CameraSection {
    pub(super) projection: Option<ProjectionKind>,
    pub(super) eye: Option<[f64; 3]>,
    pub(super) target: Option<[f64; 3]>,
    pub(super) up: Option<[f64; 3]>,
    pub(super) view_height: Option<f64>,
    /// Degrees.
    pub(super) fov_y: Option<f64>,
}
