//! A scene file as it is spelt: its sections, keys and defaults. `sections` turns each into what it
//! means, and `written` back.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use slabsplat_core::{
    Annotations, Isosurface, Light, Phong, ProjectionKind, RenderSettings, SampleType, TransferBox,
};

use super::film::FilmSection;
use super::settings_section::SettingsSection;
use crate::{Background, ContentHash};

#[derive(Deserialize, Serialize)]
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
    pub(super) image: ImageSection,
    #[serde(default, skip_serializing_if = "Annotations::is_empty")]
    pub(super) annotations: Annotations,
    #[serde(default)]
    pub(super) render: SettingsSection<RenderSettings>,
    pub(super) film: Option<FilmSection>,
}

/// What the sections of a scene with one layer say, of one of several.
#[derive(Default, Deserialize, Serialize)]
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
#[derive(Deserialize, Serialize)]
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
    /// Of the volume that the scene was made of.
    pub(super) hash: Option<ContentHash>,
    /// What the file holds, if it has no header.
    pub(super) raw: Option<RawSection>,
}

/// Samples without a header.
#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawSection {
    pub(super) dims: [usize; 3],
    #[serde(rename = "type")]
    pub(super) sample_type: SampleType,
    #[serde(default)]
    pub(super) big_endian: bool,
    #[serde(default)]
    pub(super) header_bytes: u64,
}

/// Instead of a volume.
#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MeshSection {
    pub(super) path: Option<PathBuf>,
    /// Of the mesh that the scene was made of.
    pub(super) hash: Option<ContentHash>,
    pub(super) color: Option<[f64; 3]>,
    pub(super) line_width: Option<f64>,
    pub(super) point_size: Option<f64>,
    /// What takes the file's coordinates to the world, by rows.
    pub(super) affine: Option<[[f64; 4]; 3]>,
}

/// Points, a preset, a file, or boxes or a picture of values and gradients. Without `color`, all that is
/// visible is white. Beside them, isosurfaces.
#[derive(Default, Deserialize, Serialize)]
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
    pub(super) boxes: Option<Vec<TransferBox>>,
    pub(super) image: Option<TransferImageSection>,
    /// What opacity is multiplied with, by the length of the gradient.
    pub(super) gradient_opacity: Option<Vec<[f64; 2]>>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) isosurfaces: Vec<Isosurface>,
}

/// A picture, by its file or its pixels, and the values and gradients at its edges.
#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TransferImageSection {
    pub(super) file: Option<PathBuf>,
    pub(super) values: [f64; 2],
    pub(super) gradients: [f64; 2],
    /// Pixels in a row.
    pub(super) width: Option<usize>,
    /// Red, green, blue and opacity, the top row first.
    pub(super) pixels: Option<Vec<[f32; 4]>>,
}

/// A volume of labels, and how these look.
#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LabelsSection {
    pub(super) path: PathBuf,
    /// Of the labels that the scene was made of.
    pub(super) hash: Option<ContentHash>,
    /// A file, `auto` or `none`.
    pub(super) colors: Option<PathBuf>,
    pub(super) only: Option<Vec<i64>>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) styles: Vec<LabelStyleSection>,
}

/// How some labels look.
#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LabelStyleSection {
    pub(super) of: Vec<i64>,
    pub(super) color: Option<[f64; 3]>,
    pub(super) opacity: Option<f64>,
    pub(super) classify: Option<ClassifySection>,
}

/// A box, planes, or both.
#[derive(Default, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct RegionSection {
    /// The least and the greatest corner.
    #[serde(rename = "box")]
    pub(super) ends: Option<[[f64; 3]; 2]>,
    /// Whether these are voxels.
    pub(super) index: bool,
    /// Normals and distances.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) planes: Vec<[f64; 4]>,
    pub(super) invert: bool,
    pub(super) lit: bool,
}

#[derive(Default, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct CameraSection {
    pub(super) projection: Option<ProjectionKind>,
    pub(super) eye: Option<[f64; 3]>,
    pub(super) target: Option<[f64; 3]>,
    pub(super) up: Option<[f64; 3]>,
    pub(super) view_height: Option<f64>,
    /// Degrees.
    pub(super) fov_y: Option<f64>,
    /// The same where no number of degrees is that angle.
    pub(super) fov_y_radians: Option<f64>,
}

/// Size and background of the picture, and samples of its pixels.
#[derive(Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct ImageSection {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) background: Background,
    /// What it goes over to at the lower edge, if `background` does not say it.
    pub(super) background_below: Option<Background>,
    pub(super) samples: u32,
}
