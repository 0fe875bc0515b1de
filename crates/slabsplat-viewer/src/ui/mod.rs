//! What is seen of the viewer but for the picture: controls, and what they change.
//!
//! Reading order: `style`, `colors`, `settings`; `transfer`, `strips`, `channels`, `layer_list`, `layers`,
//! `meshes`, `scene`, `compare`, `files`, `dropped`, `help`; `drag`, `pane`, `handles`, `ruler`.

mod channels;
mod colors;
mod compare;
mod drag;
mod dropped;
mod files;
mod handles;
mod help;
mod layer_list;
mod layers;
mod meshes;
mod pane;
mod ruler;
mod scene;
mod settings;
mod strips;
mod style;
mod transfer;

pub(crate) use channels::WantedChannel;
pub(crate) use compare::Comparison;
pub(crate) use dropped::{Drop, ask as ask_of_dropped};
pub(crate) use files::{Files, OpenAs, Wish};
pub(crate) use layer_list::name_of as name_of_layer;
pub(crate) use pane::{Frame, Pane, Pointed, pointer, rects, sensed, title, under, zoom_of_keys};
pub(crate) use ruler::Ruler;
pub(crate) use style::dress;
pub(crate) use transfer::Editor;
pub(crate) use {handles::show as show_handles, help::show as show_help};

use crate::state::{Document, Thumbnails};
use eframe::egui::{CollapsingHeader, ScrollArea, TextureHandle, Ui};
use slabsplat::Viewpoint;

/// What comes of controls outside of the panel.
#[derive(Debug, Default)]
pub(crate) struct PanelWish {
    /// Why something cannot be.
    pub(crate) refused: Option<String>,
    /// Whether a layer is to be added.
    pub(crate) adds_layer: bool,
    /// A channel that is to be added.
    pub(crate) channel: Option<WantedChannel>,
}

/// What of the panel is no part of the scene.
#[derive(Debug, Default)]
pub(crate) struct Panel {
    /// The layer whose controls are shown.
    pub(crate) layer_idx: usize,
    /// Whether its region is being edited, so that handles are in the view.
    pub(crate) edits_region: bool,
    /// Panes and their differences.
    pub(crate) comparison: Comparison,
    /// Small pictures by presets.
    pub(crate) thumbnails: Thumbnails<TextureHandle>,
    /// Whether a server draws, which has the layers that it has.
    is_served: bool,
    editors: Vec<Editor>,
}

impl Panel {
    pub(crate) fn new(is_served: bool) -> Self {
        Self { is_served, ..Self::default() }
    }

    /// All controls. Returns what comes of them outside of the panel.
    pub(crate) fn show(&mut self, ui: &mut Ui, document: &mut Document) -> PanelWish {
        let mut wish = PanelWish::default();
        ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
            // Above layers, which become more by a click there.
            self.channels(ui, document, &mut wish);
            self.layers(ui, document, &mut wish);
            self.edits_region = false;
            if !document.state().opened.scene.layers.is_empty() {
                wish.refused = self.layer(ui, document);
            }
            if !document.state().opened.scene.meshes.is_empty() {
                section(ui, "Meshes", false, |ui| meshes::show(ui, document));
            }
            section(ui, "Method", true, |ui| scene::rendering(ui, document));
            section(ui, "Lights", false, |ui| scene::lights(ui, document));
            section(ui, "Background", false, |ui| scene::background(ui, document));
            section(ui, "On the picture", false, |ui| scene::annotations(ui, document));
            section(ui, "Compare", false, |ui| self.comparison.show(ui, document));
            section(ui, "Popping meter", false, |ui| self.comparison.meter(ui, document));
        });
        wish
    }

    /// Which layers there are. A server has no more than it has.
    fn layers(&mut self, ui: &mut Ui, document: &mut Document, wish: &mut PanelWish) {
        section(ui, "Layers", true, |ui| {
            layer_list::show(ui, document, &mut self.layer_idx);
            wish.adds_layer = !self.is_served && layer_list::asks_for_another(ui);
        });
    }

    /// The channels of the selected layer's file. A server reads no more of its files than it has.
    fn channels(&mut self, ui: &mut Ui, document: &mut Document, wish: &mut PanelWish) {
        let n_layers = document.state().opened.scene.layers.len();
        let layer_idx = self.layer_idx.min(n_layers.saturating_sub(1));
        if !self.is_served && layer_idx < n_layers && !document.channels(layer_idx).is_empty() {
            section(ui, "Channels", true, |ui| {
                wish.channel = channels::show(ui, document, layer_idx);
            });
        }
    }

    /// The controls of the layer that is selected. Returns why something of it cannot be.
    fn layer(&mut self, ui: &mut Ui, document: &mut Document) -> Option<String> {
        let n_layers = document.state().opened.scene.layers.len();
        self.layer_idx = self.layer_idx.min(n_layers - 1);
        if self.editors.len() != n_layers {
            // What is selected of one layer's points is nothing of another's.
            self.editors = vec![Editor::default(); n_layers];
        }
        let layer_idx = self.layer_idx;
        let mut refused = None;
        let editor = &mut self.editors[layer_idx];
        section(ui, "Transfer function", true, |ui| {
            editor.show(ui, document, layer_idx);
            refused = strips::show(ui, document, layer_idx, &self.thumbnails, self.is_served);
        });
        self.edits_region =
            section(ui, "Crop and cut", false, |ui| layers::region(ui, document, layer_idx));
        if !document.labels_of(layer_idx).is_empty() {
            section(ui, "Labels", false, |ui| layers::labels(ui, document, layer_idx));
        }
        section(ui, "Isosurfaces", false, |ui| layers::isosurfaces(ui, document, layer_idx));
        section(ui, "Shading", false, |ui| layers::shading(ui, document, layer_idx));
        refused
    }
}

/// A part of the panel that is opened and closed by its title; whether it is open.
fn section(ui: &mut Ui, title: &str, is_open: bool, show: impl FnOnce(&mut Ui)) -> bool {
    CollapsingHeader::new(title).default_open(is_open).show(ui, show).body_returned.is_some()
}

/// The six sides, as keys and buttons have them.
pub(crate) const SIDES: [Viewpoint; 6] = {
    use Viewpoint::{Back, Bottom, Front, Left, Right, Top};
    [Front, Back, Left, Right, Top, Bottom]
};

/// A number with as many digits as people read.
pub(crate) fn number(value: f64) -> String {
    let size = value.abs();
    if value == value.round() && size < 1e7 {
        return format!("{value:.0}");
    }
    match size {
        _ if !(1e-3..1e6).contains(&size) => format!("{value:.3e}"),
        _ if 100.0 <= size => format!("{value:.1}"),
        _ if 1.0 <= size => format!("{value:.2}"),
        _ => format!("{value:.4}"),
    }
}
