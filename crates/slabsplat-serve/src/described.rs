//! What a viewer is told of a scene before it asks for pictures.

use crate::{ServeError, overview};
use axum::body::Bytes;
use serde_json::{Value, json};
use slabsplat::io::{SceneFile, scene_text};
use slabsplat::{Acquisition, Labels, Layer, Modality, OpenScene, Scene, ValueCounts};
use std::sync::{Arc, OnceLock};

/// A scene, and what is told of it. What goes through all voxels is made when it is first asked for.
pub(crate) struct Described {
    pub(crate) opened: Arc<OpenScene>,
    name: String,
    /// The scene as a text.
    text: String,
    session: OnceLock<Bytes>,
    overviews: Vec<OnceLock<Bytes>>,
}

/// Bins that values are counted in.
const N_BINS: usize = 256;

impl Described {
    /// A scene, as `file` says it.
    pub(crate) fn new(
        opened: Arc<OpenScene>,
        file: &SceneFile,
        name: String,
    ) -> Result<Self, ServeError> {
        let text = scene_text(&shown_to_viewers(&opened.scene, file), "scene.toml")?;
        let overviews = opened.scene.layers.iter().map(|_| OnceLock::new()).collect();
        Ok(Self { opened, name, text, session: OnceLock::new(), overviews })
    }

    /// The JSON of `/session`.
    pub(crate) fn session(&self) -> Bytes {
        let make = || {
            let OpenScene { scene, warnings, found, .. } = &*self.opened;
            let acquisitions = self.opened.acquisitions();
            let layers = scene.layers.iter().zip(acquisitions);
            let layers: Vec<Value> = layers.map(|(it, of)| described(it, of)).collect();
            let session = json!({
                "name": self.name,
                "scene": self.text,
                "warnings": warnings,
                "found": found,
                "layers": layers,
            });
            session.to_string().into()
        };
        self.session.get_or_init(make).clone()
    }

    /// The small volume of a layer; `None` if there is no such layer.
    pub(crate) fn overview(&self, layer_idx: usize) -> Option<Bytes> {
        let layer = self.opened.scene.layers.get(layer_idx)?;
        let make = || overview::overview_of(&layer.volume);
        Some(self.overviews[layer_idx].get_or_init(make).clone())
    }
}

/// The scene as it can be read without its files, and over volumes that are smaller.
fn shown_to_viewers(scene: &Scene, file: &SceneFile) -> SceneFile {
    let mut file = file.clone();
    for (of_file, layer) in file.layers.iter_mut().zip(&scene.layers) {
        of_file.hash = None;
        of_file.labels.iter_mut().for_each(|labels| labels.hash = None);
        // Its pixels are in the text instead.
        of_file.transfer_image = None;
        if of_file.region.is_index {
            // A smaller volume has other voxels there.
            of_file.region.is_index = false;
            of_file.region.ends = None;
            of_file.region.planes = layer.region.planes().to_vec();
        }
    }
    file.meshes.iter_mut().for_each(|mesh| mesh.hash = None);
    file
}

fn described(layer: &Layer, acquisition: Acquisition) -> Value {
    let counted = ValueCounts::of(&layer.volume, N_BINS);
    let labels = layer.labels.as_ref().map(Labels::of_voxels);
    json!({
        "range": counted.as_ref().map(|counted| counted.range),
        "counts": counted.map_or(vec![0; N_BINS], |counted| counted.counts),
        "labels": labels.unwrap_or_default(),
        "modality": acquisition.modality.map(Modality::name),
        "orientation": acquisition.orientation.name(),
        "is_metric": acquisition.is_metric,
    })
}
