//! Scenes as text, by the same sections and keys by which they are read.

use std::collections::BTreeMap;
use std::path::Path;

use slabsplat_core::glam::DAffine3;
use slabsplat_core::{
    LabelStyle, Phong, PiecewiseLinear, Shading, TransferFunction, TransferFunction2d,
    TransferImage,
};

use super::document::{
    CameraSection, ClassifySection, Document, ImageSection, LabelStyleSection, LabelsSection,
    LayerSection, MeshSection, RawSection, RegionSection, TransferImageSection, VolumeSection,
};
use super::film::FilmSection;
use super::settings_section::SettingsSection;
use super::{
    CameraDesc, LabelColors, LabelsFile, LayerFile, MeshFile, RegionDesc, SceneFile, Unsaid,
    VolumeSource,
};
use crate::picture::atomic;
use crate::{Endian, IoError, RawDesc};

/// What a scene file begins with.
const HEADING: &str = concat!("# A scene of slabsplat ", env!("CARGO_PKG_VERSION"), ".\n\n");

/// Writes a scene file that [`read_scene`](crate::read_scene) reads as just that scene. Relative paths, which
/// start from the working directory, are written as they are from the file's folder.
///
/// # Errors
/// As [`scene_text`], and if the file cannot be written.
pub fn write_scene(path: impl AsRef<Path>, scene: &SceneFile) -> Result<(), IoError> {
    let path = path.as_ref();
    let text = scene_text(scene, path)?;
    atomic::write(path, |file| std::io::Write::write_all(file, text.as_bytes()))
}

/// The text of a scene file of that name: [`parse_scene`](crate::parse_scene) reads it as just that scene,
/// but that paths may lead to the same files by another way.
///
/// # Errors
/// If the scene shows nothing, or a path is no text in UTF-8; or if it leaves something open that a text
/// could not say: what is [`unsaid`](SceneFile::unsaid), or a transfer function that is still to be fitted to
/// its volume. [`SceneFile::completed`] is a scene that leaves nothing open.
pub fn scene_text(scene: &SceneFile, path: impl AsRef<Path>) -> Result<String, IoError> {
    let path = path.as_ref();
    text_of(&scene.clone().seen_from(path), path)
}

/// The text of a scene, with its paths as they are.
pub(crate) fn text_of(scene: &SceneFile, path: &Path) -> Result<String, IoError> {
    let failed = |what: String| IoError::SceneText { path: path.to_owned(), what };
    if scene.layers.is_empty() && scene.meshes.is_empty() {
        return Err(failed("it shows nothing".to_owned()));
    }
    if scene.unsaid != Unsaid::default() || !scene.is_fitted() {
        let what = "it leaves open what is found from its volumes: `completed` fills that in";
        return Err(failed(what.to_owned()));
    }
    let text = toml::to_string(&Document::of(scene)).map_err(|error| failed(error.to_string()))?;
    Ok(HEADING.to_owned() + &text)
}

impl Document {
    fn of(scene: &SceneFile) -> Self {
        let layers = scene.layers.iter().map(LayerSection::of);
        let mut sections: Vec<_> =
            layers.chain(scene.meshes.iter().map(LayerSection::of_mesh)).collect();
        let is_single = sections.len() == 1 && sections[0].name.is_none();
        let top = if is_single { sections.remove(0) } else { LayerSection::default() };
        let LayerSection { name: _, visible: _, volume, mesh, classify, labels, shading, region } =
            top;
        Self {
            volume,
            mesh,
            classify,
            labels,
            shading,
            region,
            layers: (!is_single).then_some(sections),
            camera: CameraSection::of(&scene.camera),
            lights: Some(scene.lights.clone()),
            image: ImageSection::of(&scene.image, &scene.finish),
            annotations: scene.finish.annotations.clone(),
            render: SettingsSection {
                settings: scene.settings.clone(),
                other: Some(scene.backend.clone()),
            },
            film: scene.film.as_ref().map(FilmSection::of),
        }
    }
}

impl LayerSection {
    fn of(layer: &LayerFile) -> Self {
        Self {
            name: layer.name.clone(),
            volume: Some(VolumeSection::of(layer)),
            classify: ClassifySection::of(layer),
            labels: layer.labels.as_ref().map(LabelsSection::of),
            shading: Some(of_shading(layer.shading)),
            region: RegionSection::of(&layer.region),
            ..Self::default()
        }
    }

    fn of_mesh(mesh: &MeshFile) -> Self {
        Self {
            name: mesh.name.clone(),
            mesh: Some(MeshSection {
                path: Some(mesh.path.clone()),
                hash: mesh.hash,
                color: mesh.color,
                line_width: mesh.line_width,
                point_size: mesh.point_size,
                affine: rows_of(mesh.world_from_mesh),
            }),
            shading: Some(of_shading(mesh.shading)),
            region: RegionSection::of(&mesh.region),
            ..Self::default()
        }
    }
}

fn rows_of(world_from_mesh: DAffine3) -> Option<[[f64; 4]; 3]> {
    let DAffine3 { matrix3: m, translation } = world_from_mesh;
    let row = |idx: usize| [m.x_axis[idx], m.y_axis[idx], m.z_axis[idx], translation[idx]];
    (world_from_mesh != DAffine3::IDENTITY).then(|| [0, 1, 2].map(row))
}

fn of_shading(shading: Shading) -> SettingsSection<Phong> {
    let (model, settings) = match shading {
        Shading::None => ("none", Phong::default()),
        Shading::Phong(phong) => ("phong", phong),
    };
    SettingsSection { settings, other: Some(model.to_owned()) }
}

impl VolumeSection {
    fn of(layer: &LayerFile) -> Self {
        let options = &layer.options;
        let (path, generate, size) = match &layer.volume {
            VolumeSource::File(path) => (Some(path), None, None),
            VolumeSource::Builtin { name, size } => (None, Some(name.clone()), *size),
        };
        let path = path.map(|path| match &options.array {
            None => path.clone(),
            Some(name) => {
                let mut path = path.clone().into_os_string();
                path.push(format!(":{name}"));
                path.into()
            }
        });
        Self {
            path,
            generate,
            size,
            series: options.series,
            channel: options.channel,
            time: options.time,
            level: options.level,
            colors: options.colors.map(|colors| colors.to_string()),
            opacity_from: options.opacity_from.map(|source| source.to_string()),
            spacing: layer.spacing,
            hash: layer.hash,
            raw: layer.raw.as_ref().map(RawSection::of),
        }
    }
}

impl RawSection {
    fn of(raw: &RawDesc) -> Self {
        Self {
            dims: raw.dims,
            sample_type: raw.sample_type,
            big_endian: raw.endian == Endian::Big,
            header_bytes: raw.header_bytes,
        }
    }
}

impl ClassifySection {
    /// `None` if there is nothing that it would say.
    fn of(layer: &LayerFile) -> Option<Self> {
        let (boxes, image) = match &layer.transfer_2d {
            None => (None, None),
            Some(TransferFunction2d::Boxes(boxes)) => (Some(boxes.clone()), None),
            Some(TransferFunction2d::Image(image)) => {
                (None, Some(TransferImageSection::of(image, layer)))
            }
        };
        let of_values = layer.transfer.as_ref().map(Self::of_values).unwrap_or_default();
        let gradient_opacity = layer.gradient_opacity.as_ref().map(pairs);
        let section = Self {
            boxes,
            image,
            gradient_opacity,
            isosurfaces: layer.isosurfaces.clone(),
            ..of_values
        };
        let says_nothing = section.opacity.is_none()
            && section.boxes.is_none()
            && section.image.is_none()
            && section.gradient_opacity.is_none()
            && section.isosurfaces.is_empty();
        (!says_nothing).then_some(section)
    }

    pub(super) fn of_values(transfer: &TransferFunction) -> Self {
        let color = transfer.color_points().points().iter();
        Self {
            opacity: Some(pairs(transfer.opacity_points())),
            color: Some(color.map(|&(value, [r, g, b])| [value, r, g, b]).collect()),
            ..Self::default()
        }
    }
}

fn pairs(function: &PiecewiseLinear<1>) -> Vec<[f64; 2]> {
    function.points().iter().map(|&(position, [result])| [position, result]).collect()
}

impl TransferImageSection {
    /// By its file's name, if it has one.
    fn of(image: &TransferImage, layer: &LayerFile) -> Self {
        let file = layer.transfer_image.as_ref().map(|image| image.path.clone());
        let is_here = file.is_none();
        Self {
            file,
            values: image.values(),
            gradients: image.gradients(),
            width: is_here.then(|| image.width()),
            pixels: is_here.then(|| image.pixels().to_vec()),
        }
    }
}

impl LabelsSection {
    fn of(labels: &LabelsFile) -> Self {
        Self {
            path: labels.path.clone(),
            hash: labels.hash,
            colors: labels.colors.as_ref().map(LabelColors::name),
            only: labels.only.clone(),
            styles: grouped(&labels.styles),
        }
    }
}

/// A section for all labels of one style, in the order of the first of each.
fn grouped(styles: &BTreeMap<i64, LabelStyle>) -> Vec<LabelStyleSection> {
    let mut groups: Vec<(&LabelStyle, Vec<i64>)> = Vec::new();
    // Of many labels with a colour each, only neighbours are compared.
    for (&label, style) in styles {
        let recent = groups.iter_mut().rev().take(MAX_COMPARED);
        match recent.into_iter().find(|(other, _)| *other == style) {
            Some((_, labels)) => labels.push(label),
            None => groups.push((style, vec![label])),
        }
    }
    let section = |(style, of): (&LabelStyle, Vec<i64>)| LabelStyleSection {
        of,
        color: style.color,
        opacity: Some(style.opacity),
        classify: style.transfer.as_ref().map(ClassifySection::of_values),
    };
    groups.into_iter().map(section).collect()
}

/// Styles that one is compared with.
const MAX_COMPARED: usize = 64;

impl RegionSection {
    /// `None` if it is everywhere.
    pub(super) fn of(region: &RegionDesc) -> Option<Self> {
        let planes = region.planes.iter().map(|plane| {
            let [x, y, z] = plane.normal().to_array();
            [x, y, z, plane.distance()]
        });
        (*region != RegionDesc::default()).then(|| Self {
            ends: region.ends.map(|ends| ends.map(|end| end.to_array())),
            index: region.is_index,
            planes: planes.collect(),
            invert: region.is_inverted,
            lit: region.is_lit,
        })
    }
}

impl CameraSection {
    pub(super) fn of(camera: &CameraDesc) -> Self {
        let &CameraDesc { projection, eye, target, up, view_height, fov_y, fov_y_radians } = camera;
        let [eye, target, up] = [eye, target, up].map(|it| it.map(|it| it.to_array()));
        Self { projection, eye, target, up, view_height, fov_y, fov_y_radians }
    }
}

#[cfg(test)]
mod tests;
