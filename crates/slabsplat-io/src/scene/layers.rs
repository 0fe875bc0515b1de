//! What a scene file as a whole means: its layers, of volumes or meshes, be it one at the top or several
//! below `[[layers]]`.

use std::path::{Path, PathBuf};

use super::diagnostic::Diagnostic;
use super::document::{Document, LayerSection, TransferImageSection};
use super::film::{Listed, ListedKind};
use super::sections::into_lights;
use super::settings_section::SettingsSection;
use super::{LayerFile, SceneFile, TransferImageFile, Unsaid};

/// What other files say of how a layer looks.
#[derive(Default)]
pub(super) struct LookFiles {
    /// A transfer function, whose light counts unless the layer has some of its own.
    pub(super) transfer: Option<PathBuf>,
    pub(super) has_shading: bool,
    pub(super) transfer_image: Option<TransferImageFile>,
}

impl Document {
    /// All but what other files say of how layers look, which are told for each.
    pub(super) fn into_scene(
        mut self,
        folder: &Path,
    ) -> Result<(SceneFile, Vec<LookFiles>), Diagnostic> {
        let sections = self.take_layers()?;
        let is_list = self.layers.is_some();
        let (mut layers, mut look_files, mut meshes) = (Vec::new(), Vec::new(), Vec::new());
        let mut listed = Vec::with_capacity(sections.len());
        for (idx, mut section) in sections.into_iter().enumerate() {
            let in_layer = |error: Diagnostic| if is_list { error.in_layer(idx) } else { error };
            let is_visible = section.visible.unwrap_or(true);
            let what = match (&section.mesh, is_visible) {
                (_, false) => ListedKind::Hidden,
                (Some(_), true) => ListedKind::Mesh,
                (None, true) => ListedKind::Layer(layers.len()),
            };
            listed.push(Listed { name: section.name.clone(), what });
            if let Some(mesh) = section.mesh.take() {
                let mesh = section.into_mesh(&mesh, folder).map_err(in_layer)?;
                meshes.extend(is_visible.then_some(mesh));
            } else {
                let of_layer = section.look_files(folder);
                let layer = section.into_layer(folder).map_err(in_layer)?;
                if is_visible {
                    look_files.push(of_layer);
                    layers.push(layer);
                }
            }
        }
        if layers.is_empty() && meshes.is_empty() {
            return Err(Diagnostic::general("no layer of the scene is visible"));
        }
        let (settings, backend) = self.render.into_settings()?;
        let camera = self.camera.into_desc()?;
        let (image, finish) = self.image.into_desc(self.annotations)?;
        let lights = into_lights(self.lights)?;
        let film = self.film.map(|film| film.into_file(&listed)).transpose()?;
        let unsaid = Unsaid::default();
        let scene = SceneFile {
            layers,
            meshes,
            camera,
            lights,
            image,
            settings,
            finish,
            film,
            backend,
            unsaid,
        };
        Ok((scene, look_files))
    }

    /// The layers, of which there is at least one.
    fn take_layers(&mut self) -> Result<Vec<LayerSection>, Diagnostic> {
        let top = LayerSection {
            name: None,
            visible: None,
            volume: self.volume.take(),
            mesh: self.mesh.take(),
            classify: self.classify.take(),
            labels: self.labels.take(),
            shading: self.shading.take(),
            region: self.region.take(),
        };
        let Some(layers) = &mut self.layers else { return Ok(vec![top]) };
        if let Some(section) = top.first_section() {
            let what = format!("[{section}] belongs below [[layers]], as [layers.{section}]");
            return Err(Diagnostic::at(section, "", what));
        }
        if layers.is_empty() {
            return Err(Diagnostic::general("the scene has no layers: layers is empty"));
        }
        Ok(std::mem::take(layers))
    }
}

impl LayerSection {
    /// The first section that is there.
    fn first_section(&self) -> Option<&'static str> {
        let sections = [
            ("volume", self.volume.is_some()),
            ("mesh", self.mesh.is_some()),
            ("classify", self.classify.is_some()),
            ("labels", self.labels.is_some()),
            ("shading", self.shading.is_some()),
            ("region", self.region.is_some()),
        ];
        sections.into_iter().find_map(|(name, is_there)| is_there.then_some(name))
    }

    fn look_files(&self, folder: &Path) -> LookFiles {
        let Some(classify) = &self.classify else { return LookFiles::default() };
        let image = |section: &TransferImageSection| {
            Some(TransferImageFile {
                path: folder.join(section.file.as_ref()?),
                values: section.values,
                gradients: section.gradients,
            })
        };
        LookFiles {
            transfer: classify.file.as_ref().map(|file| folder.join(file)),
            has_shading: self.shading.is_some(),
            transfer_image: classify.image.as_ref().and_then(image),
        }
    }

    fn into_layer(self, folder: &Path) -> Result<LayerFile, Diagnostic> {
        let Self { name, visible: _, volume, mesh: _, classify, labels, shading, region } = self;
        let volume = volume.ok_or_else(|| {
            let what =
                "the scene has no [volume] and no [mesh]: add one with path, or generate a volume";
            Diagnostic::at("volume", "", what)
        })?;
        let has_shading = shading.is_some();
        let mut layer = LayerFile {
            name,
            spacing: volume.checked_spacing()?,
            options: volume.options()?,
            raw: volume.raw()?,
            hash: volume.hash,
            labels: labels.map(|labels| labels.into_file(folder)).transpose()?,
            shading: shading.unwrap_or_else(SettingsSection::default).into_shading()?,
            region: region.unwrap_or_default().into_desc()?,
            ..LayerFile::of_volume(volume.into_source(folder)?)
        };
        if let Some(classify) = classify {
            classify.lay_on(&mut layer, has_shading)?;
        }
        Ok(layer)
    }
}
