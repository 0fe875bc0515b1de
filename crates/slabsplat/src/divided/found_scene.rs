//! What is found before anything is drawn: a scene whose volumes are files of which boxes are read.

use super::opened_boxes;
use super::overview::{self, Overview};
use super::painter::CPU;
use super::survey::{self, Survey};
use super::values::BoxValues;
use super::{DividedDesc, DividedError, DividedScene, Exchange};
use crate::OpenScene;
use crate::transfer::VolumeValues;
use crate::volume_facts::VolumeFacts;
use slabsplat_backend::check_parts;
use slabsplat_core::{Camera, Grid, Samples, Scene, Volume};
use slabsplat_io::{LabelBoxes, SceneFile, VolumeBoxes};
use std::cell::RefCell;
use std::sync::Arc;

/// A scene as it is found.
pub(super) struct Surveyed {
    pub(super) opened: OpenScene,
    pub(super) sources: Vec<VolumeBoxes>,
    pub(super) labels: Vec<Option<LabelBoxes>>,
    pub(super) grids: Vec<Grid>,
    pub(super) outlines: Vec<Arc<Volume>>,
    /// What draws it, by name.
    pub(super) backend: String,
}

/// The cameras that go around with one.
pub(super) type Views<'a> = &'a dyn Fn(&Camera) -> Vec<Camera>;

impl DividedScene {
    /// The scene, of which each share looks at a part.
    pub(super) fn surveyed(
        file: &SceneFile,
        desc: &DividedDesc,
        others: &mut dyn Exchange,
        views: Option<Views<'_>>,
    ) -> Result<Surveyed, DividedError> {
        let sources = opened_boxes::volumes_of(&file.layers, desc, others)?;
        let (labels, label_warnings) = opened_boxes::labels_of(&file.layers, desc, others)?;
        let others = RefCell::new(others);
        let surveys = surveys(&sources, &labels, &others);
        let values: Vec<BoxValues<'_, '_>> =
            surveys.iter().map(|survey| BoxValues::new(*survey)).collect();
        let of_file = file;
        let (mut file, mut loaded, mut grids) = (file.clone(), Vec::new(), Vec::new());
        for (layer, survey) in file.layers.iter_mut().zip(&surveys) {
            let overview = Overview::of(*survey)?;
            // What it says of the volume's content is not of this, and labels are not read whole.
            (layer.hash, layer.labels) = (None, None);
            grids.push(overview.whole);
            loaded.push(overview.loaded);
        }
        let facts = grids.iter().zip(&values);
        let facts = facts.map(|(grid, values)| VolumeFacts { grid: *grid, values });
        let opened = OpenScene::unframed_by(loaded, &facts.collect::<Vec<_>>(), &file);
        if let Some(failure) = values.iter().find_map(BoxValues::failure) {
            return Err(failure);
        }
        let mut opened = opened?;
        opened.warnings.extend(label_warnings);
        for (idx, labels) in labels.iter().enumerate() {
            let Some(labels) = labels else { continue };
            let layer = &mut opened.scene.layers[idx];
            let (of_overview, is_there) = match overview::labels_of(labels, layer.volume.grid()) {
                Ok(labels) => (Some(labels), Ok(Samples::U8(Vec::new()))),
                Err(error) => (None, Err(error)),
            };
            others.borrow_mut().all(is_there)?;
            layer.labels = of_overview;
            opened.sources.layers[idx].labels = of_file.layers[idx].labels.clone();
        }
        check_parts(&opened.scene)?;
        let outlines = outlines(&opened.scene, &grids, &values);
        opened.frame_by(&file, (&desc.aim, views), |opened| {
            let Scene { layers, settings, .. } = &opened.scene;
            let cells = surveys.iter().zip(layers);
            let cells = cells.map(|(survey, layer)| survey.cells(layer, settings.mode));
            let cells = cells.collect::<Result<Vec<_>, _>>()?;
            let finished = outlined(&opened.scene, &outlines);
            Ok::<_, DividedError>(opened.framing_of(cells, &grids, &finished))
        })?;
        sources.iter().for_each(|source| source.retain_chunks(0));
        let named = if of_file.backend == "auto" { CPU } else { &of_file.backend };
        let backend = named.to_owned();
        Ok(Surveyed { opened, sources, labels, grids, outlines, backend })
    }
}

/// What looks at the volumes of layers.
fn surveys<'a, 'e>(
    sources: &'a [VolumeBoxes],
    labels: &'a [Option<LabelBoxes>],
    others: &'a RefCell<&'e mut dyn Exchange>,
) -> Vec<Survey<'a, 'e>> {
    let layers = sources.iter().zip(labels);
    layers.map(|(source, labels)| Survey { source, labels: labels.as_ref(), others }).collect()
}

/// A volume for each layer that ends where the layer's does, with its values if somebody will see them.
fn outlines(scene: &Scene, grids: &[Grid], values: &[BoxValues<'_, '_>]) -> Vec<Arc<Volume>> {
    let has_values = scene.finish.annotations.color_bar;
    let outlines = grids.iter().zip(values).map(|(grid, values)| {
        let range = has_values.then(|| values.range()).flatten();
        Arc::new(survey::outline(grid, range))
    });
    outlines.collect()
}

/// A scene as annotations see it.
pub(super) fn outlined(scene: &Scene, outlines: &[Arc<Volume>]) -> Scene {
    let mut outlined = scene.clone();
    for (layer, outline) in outlined.layers.iter_mut().zip(outlines) {
        layer.volume = outline.clone();
    }
    outlined
}
