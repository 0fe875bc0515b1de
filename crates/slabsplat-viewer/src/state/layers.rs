//! Layers that come, go and are left out of pictures, with all that is known of them.
//!
//! A layer that is hidden is in no picture, and in no scene file: what is saved is what is shown. It is one
//! again when it is shown again.

use super::Document;
use slabsplat::glam::DVec3;
use slabsplat::{Labels, Layer, OpenScene, SampleType, Scaling, Scene, ValueCounts, Volume};
use std::sync::Arc;

/// What of a layer is no part of a scene.
#[derive(Clone, Debug)]
pub(super) struct LayerState {
    /// Whether it is left out of pictures.
    pub(super) is_hidden: bool,
    /// What has to be known of how it is shown.
    pub(super) notes: Vec<String>,
    facts: Arc<Facts>,
    /// The file that it is of, where it may not be read again.
    #[cfg(target_arch = "wasm32")]
    bytes: Option<Bytes>,
}

/// A file in memory, which layers of it share.
#[cfg(target_arch = "wasm32")]
pub(crate) type Bytes = Arc<[u8]>;

/// What is known of a layer's volume, whatever it looks like.
#[derive(Clone, Debug, Default)]
struct Facts {
    /// The labels that voxels have, rising.
    labels: Vec<i64>,
    /// How many voxels have which values, where any is finite.
    counts: Option<ValueCounts>,
}

/// Bins of a histogram, at most.
const N_BINS: usize = 256;

/// Volumes of more voxels are counted once, in whatever bins.
const N_COUNTED_TWICE: usize = 1 << 27;

/// How many voxels have which values, in bins of as many values each if those are whole numbers: of 239
/// values in 256 bins some would be empty, and look like gaps in the values.
fn counts_of(volume: &Volume) -> Option<ValueCounts> {
    let counts = ValueCounts::of(volume, N_BINS)?;
    let n_bins = n_bins_of(volume, counts.range);
    let is_even = n_bins == N_BINS || N_COUNTED_TWICE < volume.grid().n_voxels();
    if is_even { Some(counts) } else { ValueCounts::of(volume, n_bins) }
}

fn n_bins_of(volume: &Volume, [lo, hi]: [f64; 2]) -> usize {
    let is_float = matches!(volume.sample_type(), SampleType::F32 | SampleType::F64);
    let Scaling { slope, intercept } = volume.scaling();
    if is_float || slope.abs() != 1.0 || intercept != intercept.round() {
        return N_BINS;
    }
    let n_values = hi - lo + 1.0;
    let per_bin = (n_values / N_BINS as f64).ceil();
    (n_values / per_bin).ceil() as usize
}

impl LayerState {
    /// Looks at all voxels of a layer.
    pub(super) fn of(layer: &Layer) -> Self {
        let labels = layer.labels.as_ref().map(Labels::of_voxels).unwrap_or_default();
        let facts = Facts { labels, counts: counts_of(&layer.volume) };
        Self {
            is_hidden: false,
            notes: Vec::new(),
            facts: Arc::new(facts),
            #[cfg(target_arch = "wasm32")]
            bytes: None,
        }
    }
}

impl Document {
    /// The labels that voxels of a layer have, rising.
    pub fn labels_of(&self, layer_idx: usize) -> &[i64] {
        &self.state().layers[layer_idx].facts.labels
    }

    /// How many voxels of a layer have which values, where any is finite.
    pub fn counts_of(&self, layer_idx: usize) -> Option<&ValueCounts> {
        self.state().layers[layer_idx].facts.counts.as_ref()
    }

    /// What is known of layers by others, whose volumes are not here.
    #[cfg(any(target_arch = "wasm32", test))]
    pub(crate) fn set_facts(&mut self, facts: Vec<(Option<ValueCounts>, Vec<i64>)>) {
        self.amend(|state| {
            for (layer, (counts, labels)) in state.layers.iter_mut().zip(facts) {
                layer.facts = Arc::new(Facts { labels, counts });
            }
        });
    }

    /// The file of its one layer, which may have to be read again.
    #[cfg(target_arch = "wasm32")]
    pub(crate) fn set_bytes(&mut self, bytes: Option<Bytes>) {
        self.amend(|state| {
            state.layers.iter_mut().for_each(|layer| layer.bytes.clone_from(&bytes))
        });
    }

    /// The file of a layer, if it is retained.
    #[cfg(target_arch = "wasm32")]
    pub(crate) fn bytes_of(&self, layer_idx: usize) -> Option<Bytes> {
        self.state().layers[layer_idx].bytes.clone()
    }

    /// Adds the layers and meshes of another document, as they look there: one step of undo.
    pub fn add(&mut self, other: &Self) {
        let other = other.state().clone();
        self.step("added layers", |state| {
            state.opened.add_layers_of(other.opened);
            state.layers.extend(other.layers);
        });
    }

    /// Takes a layer away, unless nothing would be left.
    pub fn remove_layer(&mut self, layer_idx: usize) {
        if !self.can_do_without(layer_idx) {
            return;
        }
        self.step("removed layer", |state| {
            let keeps: Vec<bool> = (0..state.layers.len()).map(|idx| idx != layer_idx).collect();
            state.opened = state.opened.with_layers(&keeps);
            state.layers.remove(layer_idx);
            if state.shows_nothing() {
                state.layers.iter_mut().for_each(|layer| layer.is_hidden = false);
            }
        });
    }

    /// Whether there is anything else than a layer.
    pub fn can_do_without(&self, layer_idx: usize) -> bool {
        let state = self.state();
        layer_idx < state.layers.len()
            && (1 < state.layers.len() || !state.opened.scene.meshes.is_empty())
    }

    /// Whether a layer is in pictures.
    pub fn is_shown(&self, layer_idx: usize) -> bool {
        !self.state().layers[layer_idx].is_hidden
    }

    /// How many layers are in no picture.
    pub fn n_hidden(&self) -> usize {
        self.state().layers.iter().filter(|layer| layer.is_hidden).count()
    }

    /// Shows a layer or hides it, unless nothing would be left.
    pub fn set_shown(&mut self, layer_idx: usize, is_shown: bool) {
        let mut layers = self.state().layers.clone();
        layers[layer_idx].is_hidden = !is_shown;
        self.show_layers(layers);
    }

    /// Whether a layer is shown and no other is.
    pub fn is_alone(&self, layer_idx: usize) -> bool {
        let layers = self.state().layers.iter().enumerate();
        layers.into_iter().all(|(idx, layer)| layer.is_hidden == (idx != layer_idx))
    }

    /// Shows a layer and no other; if it is alone already, all of them.
    pub fn show_alone(&mut self, layer_idx: usize) {
        let shows_all = self.is_alone(layer_idx);
        let mut layers = self.state().layers.clone();
        for (idx, layer) in layers.iter_mut().enumerate() {
            layer.is_hidden = !shows_all && idx != layer_idx;
        }
        self.show_layers(layers);
    }

    fn show_layers(&mut self, layers: Vec<LayerState>) {
        let mut shown = self.state().clone();
        shown.layers = layers;
        if !shown.shows_nothing() {
            self.step("shown layers", |state| *state = shown);
        }
    }

    /// What pictures show, and what scene files say: all but layers that are hidden.
    pub fn shown(&self) -> OpenScene {
        let state = self.state();
        let keeps: Vec<bool> = state.layers.iter().map(|layer| !layer.is_hidden).collect();
        if keeps.iter().all(|keeps| *keeps) {
            return state.opened.clone();
        }
        state.opened.with_layers(&keeps)
    }

    /// Which layer is the one of that index among those that are shown.
    pub fn layer_of_shown(&self, shown_idx: usize) -> usize {
        let layers = self.state().layers.iter().enumerate();
        let mut shown = layers.filter(|(_, layer)| !layer.is_hidden).map(|(idx, _)| idx);
        shown.nth(shown_idx).unwrap_or_default()
    }
}

impl super::State {
    fn shows_nothing(&self) -> bool {
        self.opened.scene.meshes.is_empty() && self.layers.iter().all(|layer| layer.is_hidden)
    }
}

/// Whether nothing of one scene is where something of the other is, so that who adds it may not see it.
pub fn are_apart(a: &Scene, b: &Scene) -> bool {
    let boxes = |scene: &Scene| -> Vec<[DVec3; 2]> {
        let of_layers = scene.layers.iter().map(|layer| {
            let corners = layer.volume.grid().corners_in_world();
            corners.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[lo, hi], corner| {
                [lo.min(corner), hi.max(corner)]
            })
        });
        of_layers.chain(scene.meshes.iter().filter_map(slabsplat::MeshLayer::bounds)).collect()
    };
    let meet = |a: &[DVec3; 2], b: &[DVec3; 2]| a[0].cmple(b[1]).all() && b[0].cmple(a[1]).all();
    let (of_a, of_b) = (boxes(a), boxes(b));
    !of_a.iter().any(|a| of_b.iter().any(|b| meet(a, b)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat::Renderer;
    use slabsplat::io::{SceneFile, VolumeSource, parse_scene};
    use std::path::Path;

    fn document(name: &str) -> Document {
        let source = VolumeSource::Builtin { name: name.to_owned(), size: Some(12) };
        Document::open(&SceneFile::of_volume(source), name.to_owned(), [40, 30]).unwrap()
    }

    /// A sphere, a cube and a neuron.
    fn three() -> Document {
        let mut document = document("sphere");
        document.add(&self::document("cube"));
        document.add(&self::document("neuron"));
        document
    }

    /// That the scene file of what is shown gives its picture, to the last bit.
    fn check_reloads(document: &Document) {
        let text = document.scene_text(Path::new("scene.toml")).unwrap();
        let mut again = OpenScene::open(&parse_scene(&text, "scene.toml").unwrap()).unwrap();
        let shown = document.pane(0);
        // Layers are the same only if they share their volume.
        for (again, shown) in again.scene.layers.iter_mut().zip(&shown.scene.layers) {
            assert_eq!(again.volume.samples(), shown.volume.samples());
            again.volume = shown.volume.clone();
        }
        assert_eq!(again.scene, shown.scene);
        assert_eq!(again.acquisition, shown.acquisition);
        let mut renderer = Renderer::open("cpu", |_| {}).unwrap();
        let mut picture = |opened: &OpenScene| {
            renderer.picture(&opened.scene, opened.acquisition).unwrap().frame.image
        };
        assert_eq!(picture(&again), picture(&shown));
    }

    #[test]
    fn every_state_of_layers_is_a_scene_file() {
        let mut document = three();
        check_reloads(&document);
        document.show_alone(1);
        check_reloads(&document);
        document.set_shown(2, true);
        check_reloads(&document);
        document.remove_layer(0);
        check_reloads(&document);
        document.set_shown(1, false);
        check_reloads(&document);
        while document.has_steps()[0] {
            document.undo();
            check_reloads(&document);
        }
        while document.has_steps()[1] {
            document.redo();
            check_reloads(&document);
        }
    }

    #[test]
    fn layers_are_added_and_removed_and_both_is_undone() {
        let mut document = three();
        let n_layers = |document: &Document| {
            let state = document.state();
            assert_eq!(state.layers.len(), state.opened.scene.layers.len());
            assert_eq!(state.layers.len(), state.opened.sources.layers.len());
            state.layers.len()
        };
        let cube = document.counts_of(1).cloned();
        assert_ne!(cube.as_ref(), document.counts_of(0));
        document.remove_layer(0);
        assert_eq!((n_layers(&document), document.counts_of(0)), (2, cube.as_ref()));
        for expected in [3, 2, 1] {
            document.undo();
            assert_eq!(n_layers(&document), expected);
        }
        for expected in [2, 3, 2] {
            document.redo();
            assert_eq!(n_layers(&document), expected);
        }
        assert_eq!(document.counts_of(0), cube.as_ref());
    }

    #[test]
    fn what_is_alone_is_seen_and_nothing_else() {
        let mut document = three();
        let volume = document.state().opened.scene.layers[2].volume.clone();
        document.show_alone(2);
        let shown = document.shown();
        assert_eq!(shown.scene.layers.len(), 1);
        assert!(Arc::ptr_eq(&shown.scene.layers[0].volume, &volume));
        assert_eq!((document.layer_of_shown(0), document.n_hidden()), (2, 2));
        document.show_alone(0);
        assert!(document.is_alone(0) && !document.is_alone(2));
        document.show_alone(0);
        assert_eq!(document.n_hidden(), 0, "once more shows all");
        document.undo();
        document.undo();
        assert!(document.is_alone(2), "each is a step");
    }

    #[test]
    fn something_is_always_left() {
        let mut document = three();
        document.show_alone(1);
        document.set_shown(1, false);
        assert!(document.is_alone(1));
        document.remove_layer(1);
        assert_eq!(document.n_hidden(), 0, "what was hidden beside it is shown");
        document.remove_layer(0);
        assert!(!document.can_do_without(0));
        document.remove_layer(0);
        assert_eq!(document.shown().scene.layers.len(), 1);
    }

    #[test]
    fn a_view_is_filled_by_what_is_shown() {
        let mut document = three();
        document.aim(None).unwrap();
        let all = document.state().opened.scene.camera;
        document.show_alone(2);
        document.aim(None).unwrap();
        let alone = document.state().opened.scene.camera;
        assert_ne!(all, alone);
        let mut neuron = self::document("neuron");
        neuron.move_camera(|_| all);
        neuron.aim(None).unwrap();
        assert_eq!(alone, neuron.state().opened.scene.camera);
    }

    #[test]
    fn bins_have_as_many_values_each() {
        let n_bins = |range: [i16; 2]| {
            let grid = slabsplat::Grid::with_spacing([2, 1, 1], [1.0; 3]).unwrap();
            counts_of(&Volume::from_fn(grid, |[i, ..]| range[i])).unwrap().counts.len()
        };
        assert_eq!((n_bins([0, 238]), n_bins([0, 255]), n_bins([7, 7])), (239, 256, 1));
        // Two each, or four.
        assert_eq!((n_bins([0, 299]), n_bins([-1024, -1])), (150, 256));
        let grid = slabsplat::Grid::with_spacing([2, 1, 1], [1.0; 3]).unwrap();
        let counts = counts_of(&Volume::from_fn(grid, |[i, ..]| i as f32)).unwrap();
        assert_eq!(counts.counts.len(), N_BINS);
    }

    #[test]
    fn what_others_know_of_volumes_counts() {
        let mut document = three();
        let counts = document.counts_of(1).cloned();
        document.set_facts(vec![(counts.clone(), vec![3, 7])]);
        assert_eq!(document.labels_of(0), [3, 7]);
        assert_eq!(document.counts_of(0), counts.as_ref());
        assert!(document.has_steps()[0], "and what can be undone stays so");
    }

    #[test]
    fn what_lies_elsewhere_is_noticed() {
        let scene = document("sphere").state().opened.scene.clone();
        assert!(!are_apart(&scene, &document("cube").state().opened.scene));
        let mut away = scene.clone();
        let volume = &away.layers[0].volume;
        let mut place = volume.grid().world_from_index();
        place.translation += DVec3::splat(100.0);
        let grid = slabsplat::Grid::new(volume.grid().dims(), place).unwrap();
        let moved = Volume::from_fn(grid, |_| 1_u8);
        away.layers[0] = away.layers[0].clone().volume(moved);
        assert!(are_apart(&scene, &away));
    }
}
