//! What each section of a scene file means. Diagnostics name the section and key.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::path::Path;
use std::str::FromStr;

use slabsplat_core::glam::DVec3;
use slabsplat_core::{
    Annotations, Finish, ImageDesc, LabelStyle, Light, Phong, Plane, Region, RenderSettings,
    Shading,
};

use super::camera::CameraDesc;
use super::diagnostic::Diagnostic;
use super::document::{
    CameraSection, ClassifySection, ImageSection, LabelStyleSection, LabelsSection, RawSection,
    RegionSection, VolumeSection,
};
use super::paths::in_folder;
use super::settings_section::SettingsSection;
use super::{LabelColors, LabelsFile, RegionDesc, VolumeSource};
use crate::{Background, Endian, RawDesc, VolumeOptions};

impl VolumeSection {
    pub(super) fn checked_spacing(&self) -> Result<Option<[f64; 3]>, Diagnostic> {
        match self.spacing {
            Some(spacing) if spacing.iter().any(|s| !s.is_normal() || *s < 0.0) => {
                Err(Diagnostic::at("volume", "spacing", "spacing must be three positive numbers"))
            }
            spacing => Ok(spacing),
        }
    }

    pub(super) fn options(&self) -> Result<VolumeOptions, Diagnostic> {
        let &Self { series, channel, time, level, .. } = self;
        let colors = word(self.colors.as_deref(), "colors")?;
        let opacity_from = word(self.opacity_from.as_deref(), "opacity_from")?;
        let options = VolumeOptions::default();
        Ok(VolumeOptions { series, channel, time, level, colors, opacity_from, ..options })
    }

    /// What the file holds, if it has no header.
    pub(super) fn raw(&self) -> Result<Option<RawDesc>, Diagnostic> {
        if self.raw.is_some() && self.path.is_none() {
            let what = "raw tells what a file holds: it goes with path";
            return Err(Diagnostic::at("volume", "raw", what));
        }
        Ok(self.raw.as_ref().map(RawSection::to_desc))
    }

    pub(super) fn into_source(self, folder: &Path) -> Result<VolumeSource, Diagnostic> {
        match (self.path, self.generate) {
            (Some(path), None) if self.size.is_none() => {
                Ok(VolumeSource::File(in_folder(folder, &path)))
            }
            (None, Some(name)) => Ok(VolumeSource::Builtin { name, size: self.size }),
            (Some(_), None) => {
                Err(Diagnostic::at("volume", "size", "size goes with generate, not with path"))
            }
            (Some(_), Some(_)) => {
                let what = "[volume] has both path and generate: leave one out";
                Err(Diagnostic::at("volume", "generate", what))
            }
            (None, None) => Err(Diagnostic::at("volume", "", "[volume] needs a path, or generate")),
        }
    }
}

/// One of a few words that a key of `[volume]` may have.
fn word<T: FromStr<Err = String>>(
    said: Option<&str>,
    key: &'static str,
) -> Result<Option<T>, Diagnostic> {
    let parsed = said.map(str::parse).transpose();
    parsed.map_err(|what: String| Diagnostic::at("volume", key, format!("{key}: {what}")))
}

impl RawSection {
    fn to_desc(&self) -> RawDesc {
        RawDesc {
            dims: self.dims,
            sample_type: self.sample_type,
            endian: if self.big_endian { Endian::Big } else { Endian::Little },
            spacing: [1.0; 3],
            header_bytes: self.header_bytes,
        }
    }
}

impl LabelsSection {
    pub(super) fn into_file(self, folder: &Path) -> Result<LabelsFile, Diagnostic> {
        let Self { path, hash, colors, only, styles: sections } = self;
        let mut styles = BTreeMap::new();
        for section in sections {
            let LabelStyleSection { of, color, opacity, classify } = section;
            let mut style = LabelStyle::default().opacity(opacity.unwrap_or(1.0));
            style.transfer = classify.map(ClassifySection::into_label_transfer).transpose()?;
            style.color = color;
            for label in of {
                if styles.insert(label, style.clone()).is_some() {
                    let what = format!("two styles are of label {label}");
                    return Err(Diagnostic::at("labels", "styles", what));
                }
            }
        }
        let colors = colors.map(|name| LabelColors::named(&name, folder));
        Ok(LabelsFile { path: folder.join(path), hash, colors, styles, only })
    }
}

impl SettingsSection<Phong> {
    pub(super) fn into_shading(self) -> Result<Shading, Diagnostic> {
        let phong = self.settings.checked();
        let phong =
            phong.map_err(|error| Diagnostic::at("shading", error.name, error.to_string()))?;
        Shading::of_model(self.other.as_deref(), phong)
            .map_err(|error| Diagnostic::at("shading", Shading::MODEL_KEY, error.to_string()))
    }
}

impl RegionSection {
    pub(super) fn into_desc(self) -> Result<RegionDesc, Diagnostic> {
        let Self { ends, index, planes, invert, lit } = self;
        let plane = |[x, y, z, distance]: [f64; 4]| {
            Plane::new(DVec3::new(x, y, z), distance)
                .map_err(|error| Diagnostic::at("region", "planes", error.to_string()))
        };
        let desc = RegionDesc {
            ends: ends.map(|ends| ends.map(DVec3::from_array)),
            is_index: index,
            planes: planes.into_iter().map(plane).collect::<Result<_, _>>()?,
            is_inverted: invert,
            is_lit: lit,
        };
        if let Some(ends) = desc.ends {
            Region::in_box(ends)
                .map_err(|error| Diagnostic::at("region", "box", error.to_string()))?;
        }
        Ok(desc)
    }
}

/// The lights of a scene; a headlight if it does not say.
pub(super) fn into_lights(lights: Option<Vec<Light>>) -> Result<Vec<Light>, Diagnostic> {
    let lights = lights.unwrap_or_else(|| vec![Light::default()]);
    match Light::check_all(&lights) {
        Ok(()) => Ok(lights),
        Err(error) => Err(Diagnostic::at("lights", "", error.to_string())),
    }
}

impl CameraSection {
    pub(super) fn into_desc(self) -> Result<CameraDesc, Diagnostic> {
        let Self { projection, eye, target, up, view_height, fov_y, fov_y_radians } = self;
        if let Some(height) = view_height.filter(|h| !h.is_normal() || *h < 0.0) {
            let what = format!("view_height must be a positive number, not {height}");
            return Err(Diagnostic::at("camera", "view_height", what));
        }
        if let Some(angle) = fov_y.filter(|a| !a.is_normal() || !(0.0..180.0).contains(a)) {
            let what = format!("fov_y must lie between 0 and 180 degrees, not {angle}");
            return Err(Diagnostic::at("camera", "fov_y", what));
        }
        if fov_y_radians.is_some_and(|angle| {
            fov_y.is_some() || !angle.is_normal() || !(0.0..PI).contains(&angle)
        }) {
            let what = "fov_y_radians stands instead of fov_y, and lies between 0 and pi";
            return Err(Diagnostic::at("camera", "fov_y_radians", what));
        }
        for (key, point) in [("eye", eye), ("target", target), ("up", up)] {
            if point.is_some_and(|p| p.iter().any(|c| !c.is_finite())) {
                let what = format!("{key} must be three finite numbers");
                return Err(Diagnostic::at("camera", key, what));
            }
        }
        let [eye, target, up] = [eye, target, up].map(|point| point.map(DVec3::from_array));
        Ok(CameraDesc { projection, eye, target, up, view_height, fov_y, fov_y_radians })
    }
}

impl Default for ImageSection {
    fn default() -> Self {
        Self::of(&ImageDesc::default(), &Finish::default())
    }
}

impl ImageSection {
    /// What they say, but for annotations.
    pub(super) fn of(image: &ImageDesc, finish: &Finish) -> Self {
        Self {
            width: image.width,
            height: image.height,
            background: alone(image.background),
            background_below: finish.background_below.map(alone),
            samples: finish.samples,
        }
    }

    /// The frame, and what becomes of it.
    pub(super) fn into_desc(
        self,
        annotations: Annotations,
    ) -> Result<(ImageDesc, Finish), Diagnostic> {
        let Self { width, height, background, background_below, samples } = self;
        let background_below = lower_end(background, background_below)?;
        let image = ImageDesc::new(width, height).background(background.above).checked();
        let image =
            image.map_err(|error| Diagnostic::at("image", error.field(), error.to_string()))?;
        let mut finish = Finish::default().samples(samples).annotations(annotations);
        finish.background_below = background_below;
        let finish = finish.checked();
        let finish = finish.and_then(|finish| finish.sampled(&image).map(|_| finish));
        let finish = finish.map_err(|error| {
            let [section, key] = error.key();
            Diagnostic::at(section, key, error.to_string())
        })?;
        Ok((image, finish))
    }
}

fn alone(above: [f32; 4]) -> Background {
    Background { above, below: None }
}

/// A gradient's lower end, which is said once: with the upper one or by itself.
fn lower_end(
    background: Background,
    below: Option<Background>,
) -> Result<Option<[f32; 4]>, Diagnostic> {
    let what = match (background.below, below) {
        (of_both, None) => return Ok(of_both),
        (None, Some(Background { above, below: None })) => return Ok(Some(above)),
        (Some(_), Some(_)) => "background is a gradient already: leave one of its lower ends out",
        (None, Some(_)) => "background_below is one colour, and background the other",
    };
    Err(Diagnostic::at("image", "background_below", what))
}

impl SettingsSection<RenderSettings> {
    /// The settings, and the name of the backend.
    pub(super) fn into_settings(self) -> Result<(RenderSettings, String), Diagnostic> {
        let settings = self.settings.checked();
        let settings = settings
            .map_err(|error| Diagnostic::at("render", error.setting(), error.to_string()))?;
        Ok((settings, self.other.unwrap_or_else(|| "cpu".to_owned())))
    }
}
