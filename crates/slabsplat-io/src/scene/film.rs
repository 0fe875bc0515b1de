//! `[film]`: key frames of a scene, by the keys that the scene itself has.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use slabsplat_core::{Easing, Isosurface, TransferFunction, TurnAxis};

use super::diagnostic::Diagnostic;
use super::document::{CameraSection, ClassifySection, RegionSection};
use super::{CameraDesc, LayerFile, RegionDesc, VolumeSource};
use crate::transfer::TransferFit;

/// How a scene changes, as a scene file says it.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct FilmFile {
    /// Frames a second.
    pub frames_per_second: Option<f64>,
    /// How long it is; by default until the last key.
    pub seconds: Option<f64>,
    /// Whether it goes back to its beginning.
    pub is_loop: bool,
    /// How time passes behind keys that do not say it, and before the first.
    pub easing: Easing,
    /// The key frames, in order.
    pub keys: Vec<KeyFile>,
    /// How it turns before camera and lights, instead of key frames.
    pub turn: Option<TurnFile>,
}

/// A film of a thing that turns.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct TurnFile {
    /// About what.
    #[serde(default)]
    pub axis: TurnAxis,
    /// How far; to and fro, from one side to the other.
    pub degrees: f64,
    /// Whether it goes to and fro.
    #[serde(default, rename = "rock")]
    pub is_rocking: bool,
}

impl TurnFile {
    /// Most turns of a film.
    pub const MAX_DEGREES: f64 = 360_000.0;

    /// A turn about that axis.
    pub fn new(axis: TurnAxis, degrees: f64, is_rocking: bool) -> Self {
        Self { axis, degrees, is_rocking }
    }
}

/// How things are at a moment; all that is left out continues.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct KeyFile {
    /// Seconds from the beginning.
    pub at_secs: f64,
    /// How time passes until the next key.
    pub easing: Option<Easing>,
    /// Where the scene is seen from; what it leaves out is as before.
    pub camera: Option<CameraDesc>,
    /// How far the camera has gone to its own right.
    pub azimuth_degrees: Option<f64>,
    /// Width of slabs, in voxel steps.
    pub slab_width: Option<f64>,
    /// What changes of layers.
    pub layers: Vec<KeyLayerFile>,
}

/// How a layer is at a moment.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct KeyLayerFile {
    /// Which of the scene file's layers.
    pub layer_idx: usize,
    /// Which values are visible, and in which colour.
    pub look: Option<KeyLook>,
    /// The densities at which it has surfaces.
    pub isosurfaces: Option<Vec<Isosurface>>,
    /// Where it is seen.
    pub region: Option<RegionDesc>,
    /// What its opacities are multiplied with.
    pub opacity_scale: Option<f64>,
}

/// What a layer looks like at a moment.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct KeyLook {
    /// Which values are visible; without, those of the layer.
    pub transfer: Option<TransferFunction>,
    /// How that becomes what the volume is shown with.
    pub fit: TransferFit,
}

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FilmSection {
    fps: Option<f64>,
    seconds: Option<f64>,
    #[serde(default, rename = "loop")]
    is_loop: bool,
    easing: Option<Easing>,
    turn: Option<TurnFile>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    keys: Vec<KeySection>,
}

#[derive(Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct KeySection {
    at: f64,
    easing: Option<Easing>,
    azimuth: Option<f64>,
    slab_width: Option<f64>,
    opacity_scale: Option<f64>,
    camera: Option<CameraSection>,
    classify: Option<ClassifySection>,
    region: Option<RegionSection>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    layers: Vec<KeyLayerSection>,
}

/// What a key of a scene with one layer says, of one of several.
#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct KeyLayerSection {
    layer: LayerName,
    opacity_scale: Option<f64>,
    classify: Option<ClassifySection>,
    region: Option<RegionSection>,
}

#[derive(Deserialize, Serialize)]
#[serde(untagged, expecting = "expected a layer's name, or its number from 0 on")]
enum LayerName {
    Number(usize),
    Name(String),
}

/// What a document lists as a layer, by which keys name it.
pub(super) struct Listed {
    pub(super) name: Option<String>,
    pub(super) what: ListedKind,
}

#[derive(Clone, Copy)]
pub(super) enum ListedKind {
    /// A layer of the scene.
    Layer(usize),
    Mesh,
    Hidden,
}

impl FilmFile {
    /// Whether the transfer functions of its keys are those that volumes are shown with.
    pub(super) fn is_fitted(&self) -> bool {
        let layers = self.keys.iter().flat_map(|key| &key.layers);
        let mut looks = layers.filter_map(|layer| layer.look.as_ref());
        looks.all(|look| look.transfer.is_some() && look.fit == TransferFit::default())
    }
}

impl FilmSection {
    pub(super) fn into_file(self, listed: &[Listed]) -> Result<FilmFile, Diagnostic> {
        let Self { fps, seconds, is_loop, easing, turn, keys } = self;
        for (key, value) in [("fps", fps), ("seconds", seconds)] {
            if let Some(value) = value.filter(|value| !value.is_normal() || *value < 0.0) {
                let what = format!("{key} must be a positive number, not {value}");
                return Err(Diagnostic::at("film", key, what));
            }
        }
        if let Some(turn) = &turn {
            check_turn(turn)?;
            if is_loop || easing.is_some() || !keys.is_empty() {
                let what = "a film is made by turn or by keys, loop and easing: leave one out";
                return Err(Diagnostic::at("film", "turn", what));
            }
        }
        let mut before = f64::NEG_INFINITY;
        let mut files = Vec::with_capacity(keys.len());
        for (idx, key) in keys.into_iter().enumerate() {
            let at_secs = key.at;
            if !(at_secs.is_finite() && 0.0 <= at_secs && before < at_secs) {
                let what =
                    format!("at is {at_secs}: keys begin at 0, each is later than the one before");
                return Err(Diagnostic::at("", "at", what).in_key(idx));
            }
            before = at_secs;
            files.push(key.into_file(listed).map_err(|error| error.in_key(idx))?);
        }
        let easing = easing.unwrap_or_default();
        Ok(FilmFile { frames_per_second: fps, seconds, is_loop, easing, keys: files, turn })
    }

    pub(super) fn of(film: &FilmFile) -> Self {
        Self {
            fps: film.frames_per_second,
            seconds: film.seconds,
            is_loop: film.is_loop,
            easing: film.turn.is_none().then_some(film.easing),
            turn: film.turn,
            keys: film.keys.iter().map(KeySection::of).collect(),
        }
    }
}

fn check_turn(turn: &TurnFile) -> Result<(), Diagnostic> {
    let max = TurnFile::MAX_DEGREES;
    if (-max..=max).contains(&turn.degrees) {
        return Ok(());
    }
    let what = format!("degrees of a turn are up to {max} either way, and not {}", turn.degrees);
    Err(Diagnostic::at("film", "turn", what))
}

impl KeySection {
    fn into_file(self, listed: &[Listed]) -> Result<KeyFile, Diagnostic> {
        let Self {
            at,
            easing,
            azimuth,
            slab_width,
            opacity_scale,
            camera,
            classify,
            region,
            layers,
        } = self;
        let mut sections = layers;
        let own = [
            ("opacity_scale", opacity_scale.is_some()),
            ("classify", classify.is_some()),
            ("region", region.is_some()),
        ];
        if let Some(own) = own.into_iter().find_map(|(name, is_there)| is_there.then_some(name)) {
            if listed.len() != 1 || !sections.is_empty() {
                let what = format!(
                    "{own} belongs below [[film.keys.layers]], with the layer that it is about"
                );
                return Err(Diagnostic::at("", own, what));
            }
            let layer = LayerName::Number(0);
            sections.push(KeyLayerSection { layer, opacity_scale, classify, region });
        }
        let layers = sections.into_iter().map(|section| section.into_file(listed));
        let layers = layers.collect::<Result<Vec<_>, _>>()?;
        let layers: Vec<KeyLayerFile> = layers.into_iter().flatten().collect();
        let is_twice = |(idx, layer): (usize, &KeyLayerFile)| {
            layers[..idx].iter().any(|other| other.layer_idx == layer.layer_idx)
        };
        if layers.iter().enumerate().any(is_twice) {
            return Err(Diagnostic::at("layers", "", "two entries are about one layer"));
        }
        Ok(KeyFile {
            at_secs: at,
            easing,
            camera: camera.map(CameraSection::into_desc).transpose()?,
            azimuth_degrees: azimuth,
            slab_width,
            layers,
        })
    }

    fn of(key: &KeyFile) -> Self {
        Self {
            at: key.at_secs,
            easing: key.easing,
            azimuth: key.azimuth_degrees,
            slab_width: key.slab_width,
            camera: key.camera.as_ref().map(CameraSection::of),
            layers: key.layers.iter().map(KeyLayerSection::of).collect(),
            ..Self::default()
        }
    }
}

impl KeyLayerSection {
    /// `None` if the layer is hidden.
    fn into_file(self, listed: &[Listed]) -> Result<Option<KeyLayerFile>, Diagnostic> {
        let Self { layer, opacity_scale, classify, region } = self;
        let layer_idx = match layer.found(listed)? {
            ListedKind::Layer(idx) => idx,
            ListedKind::Hidden => return Ok(None),
            ListedKind::Mesh => {
                return Err(Diagnostic::at(
                    "layers",
                    "layer",
                    "that layer is a mesh, which does not change",
                ));
            }
        };
        let (look, isosurfaces) = match classify {
            Some(section) => section.into_changes()?,
            None => (None, None),
        };
        let region = region.map(RegionSection::into_desc).transpose()?;
        Ok(Some(KeyLayerFile { layer_idx, look, isosurfaces, region, opacity_scale }))
    }

    fn of(layer: &KeyLayerFile) -> Self {
        let transfer = layer.look.as_ref().and_then(|look| look.transfer.as_ref());
        Self {
            layer: LayerName::Number(layer.layer_idx),
            opacity_scale: layer.opacity_scale,
            classify: ClassifySection::of_changes(transfer, layer.isosurfaces.as_deref()),
            region: layer
                .region
                .as_ref()
                .map(|region| RegionSection::of(region).unwrap_or_default()),
        }
    }
}

impl LayerName {
    fn found(&self, listed: &[Listed]) -> Result<ListedKind, Diagnostic> {
        let found = match self {
            Self::Number(number) => listed.get(*number),
            Self::Name(name) => listed.iter().find(|layer| layer.name.as_ref() == Some(name)),
        };
        let named = match self {
            Self::Number(number) => number.to_string(),
            Self::Name(name) => format!("{name:?}"),
        };
        found.map(|layer| layer.what).ok_or_else(|| {
            Diagnostic::at("layers", "layer", format!("the scene has no layer {named}"))
        })
    }
}

impl ClassifySection {
    /// What a key may have: whatever says how values look, and isosurfaces.
    fn into_changes(mut self) -> Result<(Option<KeyLook>, Option<Vec<Isosurface>>), Diagnostic> {
        let isosurfaces = std::mem::take(&mut self.isosurfaces);
        let isosurfaces = (!isosurfaces.is_empty()).then_some(isosurfaces);
        let look = match isosurfaces.is_some() && !self.says_values() {
            true => None,
            false => Some(self.into_look()?),
        };
        Ok((look, isosurfaces))
    }

    /// `None` if nothing changes.
    fn of_changes(
        transfer: Option<&TransferFunction>,
        isosurfaces: Option<&[Isosurface]>,
    ) -> Option<Self> {
        let of_values = transfer.map(Self::of_values);
        let Some(isosurfaces) = isosurfaces else { return of_values };
        Some(Self { isosurfaces: isosurfaces.to_vec(), ..of_values.unwrap_or_default() })
    }

    fn into_look(self) -> Result<KeyLook, Diagnostic> {
        let others = [
            ("file", self.file.is_some()),
            ("boxes", self.boxes.is_some()),
            ("image", self.image.is_some()),
            ("gradient_opacity", self.gradient_opacity.is_some()),
        ];
        if let Some((key, _)) = others.into_iter().find(|(_, is_there)| *is_there) {
            let what = format!(
                "{key} does not change in a film: of [classify] a key takes opacity, color, preset, colormap, \
                 window, percentile, opacity_scale, unit_distance and isosurfaces"
            );
            return Err(Diagnostic::at("classify", key, what));
        }
        // Of no volume, as it is laid on whichever the layer has.
        let volume = VolumeSource::File(PathBuf::new());
        let mut layer = LayerFile::of_volume(volume);
        self.lay_on(&mut layer, true)?;
        Ok(KeyLook { transfer: layer.transfer, fit: layer.fit })
    }
}
