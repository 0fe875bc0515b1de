//! What is seen of the viewer but for the picture: controls, and what they change.
//!
//! Reading order: `style`, `colors`, `settings`; `transfer`, `layers`, `scene`, `compare`, `files`, `help`;
//! `pane`, `handles`, `ruler`.

mod colors;
mod compare;
mod files;
mod handles;
mod help;
mod layers;
mod pane;
mod ruler;
mod scene;
mod settings;
mod style;
mod transfer;

pub(crate) use compare::Comparison;
pub(crate) use files::{Files, Wish};
pub(crate) use pane::{Frame, Pane, Pointed, pointer, rects, sensed, title, under, zoom_of_keys};
pub(crate) use ruler::Ruler;
pub(crate) use style::dress;
pub(crate) use transfer::Editor;
pub(crate) use {handles::show as show_handles, help::show as show_help};

use crate::state::Document;
use eframe::egui::{CollapsingHeader, ScrollArea, Ui};
use slabsplat::Viewpoint;

/// What of the panel is no part of the scene.
#[derive(Debug, Default)]
pub(crate) struct Panel {
    /// The layer whose controls are shown.
    pub(crate) layer_idx: usize,
    /// Whether its region is being edited, so that handles are in the view.
    pub(crate) edits_region: bool,
    /// Panes and their differences.
    pub(crate) comparison: Comparison,
    editors: Vec<Editor>,
}

impl Panel {
    /// All controls. Returns what has to be said.
    pub(crate) fn show(&mut self, ui: &mut Ui, document: &mut Document) -> Vec<String> {
        let mut said = Vec::new();
        ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
            if !document.state().opened.scene.layers.is_empty() {
                said = self.layer(ui, document);
            }
            section(ui, "Method", true, |ui| scene::rendering(ui, document));
            section(ui, "Lights", false, |ui| scene::lights(ui, document));
            section(ui, "Background", false, |ui| scene::background(ui, document));
            section(ui, "On the picture", false, |ui| scene::annotations(ui, document));
            section(ui, "Compare", false, |ui| self.comparison.show(ui, document));
            section(ui, "Popping meter", false, |ui| self.comparison.meter(ui, document));
        });
        said
    }

    fn layer(&mut self, ui: &mut Ui, document: &mut Document) -> Vec<String> {
        let n_layers = document.state().opened.scene.layers.len();
        self.layer_idx = self.layer_idx.min(n_layers - 1);
        self.editors.resize(n_layers, Editor::default());
        let layer_idx = self.layer_idx;
        if 1 < n_layers {
            ui.horizontal_wrapped(|ui| {
                for idx in 0..n_layers {
                    let name = layer_name(document, idx);
                    ui.selectable_value(&mut self.layer_idx, idx, name);
                }
            });
        }
        let mut said = Vec::new();
        let editor = &mut self.editors[layer_idx];
        section(ui, "Transfer function", true, |ui| {
            editor.show(ui, document, layer_idx);
            said = transfer::strips(ui, document, layer_idx);
        });
        self.edits_region =
            section(ui, "Crop and cut", false, |ui| layers::region(ui, document, layer_idx));
        if !document.labels[layer_idx].is_empty() {
            section(ui, "Labels", false, |ui| layers::labels(ui, document, layer_idx));
        }
        section(ui, "Isosurfaces", false, |ui| layers::isosurfaces(ui, document, layer_idx));
        section(ui, "Shading", false, |ui| layers::shading(ui, document, layer_idx));
        said
    }
}

/// A part of the panel that is opened and closed by its title; whether it is open.
fn section(ui: &mut Ui, title: &str, is_open: bool, show: impl FnOnce(&mut Ui)) -> bool {
    CollapsingHeader::new(title).default_open(is_open).show(ui, show).body_returned.is_some()
}

fn layer_name(document: &Document, layer_idx: usize) -> String {
    let file = document.state().opened.sources.layers.get(layer_idx);
    let name = file.and_then(|file| file.name.clone());
    name.unwrap_or_else(|| format!("layer {}", layer_idx + 1))
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
