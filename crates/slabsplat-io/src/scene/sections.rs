//! What each section of a scene file means. Complaints name the section and key.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use slabsplat_core::glam::DVec3;
use slabsplat_core::{
    ImageDesc, KernelName, Phong, RenderSettings, SettingsError, Shading, ShadingError,
    TransferError, TransferFunction,
};

use super::camera::CameraDesc;
use super::complaint::Complaint;
use super::document::{
    CameraSection, ClassifySection, Document, ImageSection, RenderSection, ShadingSection,
    VolumeSection,
};
use super::preset::preset_transfer;
use super::{SceneFile, VolumeSource};

impl Document {
    /// The colour map's file, if the scene names one.
    pub(super) fn color_map(&self, folder: &Path) -> Option<PathBuf> {
        self.classify.as_ref()?.file.as_ref().map(|file| folder.join(file))
    }

    /// All but what is in the colour map.
    pub(super) fn into_scene(self, folder: &Path) -> Result<SceneFile, Complaint> {
        let volume = self.volume.ok_or_else(|| {
            Complaint::general("the scene has no [volume]: add one with path or generate")
        })?;
        let spacing = volume.checked_spacing()?;
        let backend = self.render.backend.clone();
        Ok(SceneFile {
            volume: volume.into_source(folder)?,
            spacing,
            transfer: match self.classify {
                Some(classify) => classify.into_transfer()?,
                None => None,
            },
            shading: self.shading.into_shading()?,
            camera: self.camera.into_desc()?,
            image: self.image.into_desc()?,
            settings: self.render.into_settings()?,
            backend,
        })
    }
}

impl VolumeSection {
    fn checked_spacing(&self) -> Result<Option<[f64; 3]>, Complaint> {
        match self.spacing {
            Some(spacing) if spacing.iter().any(|s| !s.is_normal() || *s < 0.0) => {
                Err(Complaint::at("volume", "spacing", "spacing must be three positive numbers"))
            }
            spacing => Ok(spacing),
        }
    }

    fn into_source(self, folder: &Path) -> Result<VolumeSource, Complaint> {
        match (self.path, self.generate) {
            (Some(path), None) if self.size.is_none() => Ok(VolumeSource::File(folder.join(path))),
            (None, Some(name)) => Ok(VolumeSource::Builtin { name, size: self.size }),
            (Some(_), None) => {
                Err(Complaint::at("volume", "size", "size goes with generate, not with path"))
            }
            (Some(_), Some(_)) => {
                let what = "[volume] has both path and generate: leave one out";
                Err(Complaint::at("volume", "generate", what))
            }
            (None, None) => Err(Complaint::at("volume", "", "[volume] needs a path, or generate")),
        }
    }
}

impl ClassifySection {
    /// `None` if the section is empty, or the transfer function is in a file.
    fn into_transfer(self) -> Result<Option<TransferFunction>, Complaint> {
        let Self { opacity, color, preset, file } = self;
        let n_ways = usize::from(opacity.is_some() || color.is_some())
            + usize::from(preset.is_some())
            + usize::from(file.is_some());
        if 1 < n_ways {
            let what = "[classify] takes one of: opacity (and color), preset, file";
            return Err(Complaint::at("classify", "", what));
        }
        if n_ways == 0 || file.is_some() {
            return Ok(None);
        }
        if let Some(name) = preset {
            let transfer = preset_transfer(&name);
            return transfer
                .map(Some)
                .map_err(|error| Complaint::at("classify", "preset", error.to_string()));
        }
        let opacity = opacity
            .ok_or_else(|| Complaint::at("classify", "color", "color needs opacity beside it"))?;
        let color = color.unwrap_or_else(|| vec![[0.0, 1.0, 1.0, 1.0]]);
        transfer(&opacity, &color).map(Some)
    }
}

fn transfer(opacity: &[[f64; 2]], color: &[[f64; 4]]) -> Result<TransferFunction, Complaint> {
    let opacity = opacity.iter().map(|&[value, alpha]| (value, [alpha])).collect();
    let color = color.iter().map(|&[value, r, g, b]| (value, [r, g, b])).collect();
    TransferFunction::new(opacity, color).map_err(|error| {
        let (TransferError::Empty { what: key }
        | TransferError::NotFinite { what: key, .. }
        | TransferError::Unsorted { what: key, .. }
        | TransferError::OutOfRange { what: key, .. }) = error;
        Complaint::at("classify", key, error.to_string())
    })
}

impl ShadingSection {
    fn into_shading(self) -> Result<Shading, Complaint> {
        let Self { model, ambient, diffuse, specular, shininess, two_sided, light } = self;
        let phong = Phong { ambient, diffuse, specular, shininess, two_sided, light };
        let phong = phong.checked().map_err(|error| {
            let key = match error {
                ShadingError::BadCoefficient { name, .. } => name,
                ShadingError::BadLight(_) => "light",
            };
            Complaint::at("shading", key, error.to_string())
        })?;
        match model.as_str() {
            "phong" => Ok(Shading::Phong(phong)),
            "none" => Ok(Shading::None),
            other => {
                let what = format!("{other:?} is not a choice here: use one of phong, none");
                Err(Complaint::at("shading", "model", what))
            }
        }
    }
}

impl CameraSection {
    fn into_desc(self) -> Result<CameraDesc, Complaint> {
        let Self { projection, eye, target, up, view_height, fov_y } = self;
        if let Some(height) = view_height.filter(|h| !h.is_normal() || *h < 0.0) {
            let what = format!("view_height must be a positive number, not {height}");
            return Err(Complaint::at("camera", "view_height", what));
        }
        if let Some(angle) = fov_y.filter(|a| !a.is_normal() || !(0.0..180.0).contains(a)) {
            let what = format!("fov_y must lie between 0 and 180 degrees, not {angle}");
            return Err(Complaint::at("camera", "fov_y", what));
        }
        for (key, point) in [("eye", eye), ("target", target), ("up", up)] {
            if point.is_some_and(|p| p.iter().any(|c| !c.is_finite())) {
                let what = format!("{key} must be three finite numbers");
                return Err(Complaint::at("camera", key, what));
            }
        }
        let [eye, target, up] = [eye, target, up].map(|point| point.map(DVec3::from_array));
        Ok(CameraDesc { projection, eye, target, up, view_height, fov_y })
    }
}

impl ImageSection {
    fn into_desc(self) -> Result<ImageDesc, Complaint> {
        let Self { width, height, background } = self;
        ImageDesc { width, height, background }.checked().map_err(|error| {
            let key = match error {
                slabsplat_core::ImageError::BadBackground(_) => "background",
                slabsplat_core::ImageError::BadSize { .. } => "width",
            };
            Complaint::at("image", key, error.to_string())
        })
    }
}

impl RenderSection {
    fn into_settings(self) -> Result<RenderSettings, Complaint> {
        let settings = RenderSettings {
            method: self.method,
            kernel: KernelName(Cow::Owned(self.kernel)),
            slab_width: self.slab_width,
            compositing: self.compositing,
            normalization: self.normalization,
            base_slab_width: self.base_slab_width,
            sections: self.sections,
            radial_samples: self.radial_samples,
            lookup: self.lookup,
            opacity_cutoff: self.opacity_cutoff,
            tolerance: self.tolerance,
        };
        settings.checked().map_err(|error| {
            let key = match error {
                SettingsError::BadWidth { name, .. } | SettingsError::BadCount { name, .. } => name,
                SettingsError::BadHierarchy { .. } => "normalization",
                SettingsError::BadCutoff(_) => "opacity_cutoff",
                SettingsError::BadTolerance(_) => "tolerance",
            };
            Complaint::at("render", key, error.to_string())
        })
    }
}
