//! The list of layers: which are shown, which one's controls are below, and which come and go.

use crate::state::Document;
use eframe::egui::{Button, Ui};
use slabsplat::io::VolumeSource;

/// Shows the list. `selected` is the layer whose controls are shown.
pub(crate) fn show(ui: &mut Ui, document: &mut Document, selected: &mut usize) {
    let n_layers = document.state().opened.scene.layers.len();
    let mut removed = None;
    for layer_idx in 0..n_layers {
        ui.horizontal(|ui| {
            if 1 < n_layers {
                visibility(ui, document, layer_idx);
            }
            if document.can_do_without(layer_idx) {
                let button = ui.small_button("×").on_hover_text("take the layer away");
                removed = button.clicked().then_some(layer_idx).or(removed);
            }
            let name = name_of(document, layer_idx);
            let is_selected = *selected == layer_idx && 1 < n_layers;
            let label = Button::selectable(is_selected, name).truncate();
            if ui.add(label).clicked() {
                *selected = layer_idx;
            }
        });
    }
    if let Some(layer_idx) = removed {
        document.remove_layer(layer_idx);
        if layer_idx < *selected {
            *selected -= 1;
        }
    }
}

/// Whether another layer is to be added.
pub(crate) fn asks_for_another(ui: &mut Ui) -> bool {
    let help = "another volume or scene in the same picture, where its file says that it is";
    ui.button("Add layer…").on_hover_text(help).clicked()
}

/// Whether a layer is in the picture, and whether it is so alone.
fn visibility(ui: &mut Ui, document: &mut Document, layer_idx: usize) {
    let mut is_shown = document.is_shown(layer_idx);
    if ui.checkbox(&mut is_shown, "").on_hover_text("in the picture").changed() {
        document.set_shown(layer_idx, is_shown);
    }
    let is_alone = document.is_alone(layer_idx);
    let help = if is_alone { "show all layers" } else { "show this layer alone" };
    if ui.add(Button::selectable(is_alone, "alone").small()).on_hover_text(help).clicked() {
        document.show_alone(layer_idx);
    }
}

/// What a layer is called: as its scene says, or as its file is.
pub(crate) fn name_of(document: &Document, layer_idx: usize) -> String {
    let source = &document.state().opened.sources.layers[layer_idx];
    let of_volume = || match &source.volume {
        VolumeSource::File(path) => Some(path.file_name()?.to_string_lossy().into_owned()),
        other => Some(other.to_string()),
    };
    let of_channel = |name: String| match document.shown_channel(layer_idx) {
        Some(channel) => format!("{name}, {channel}"),
        None => name,
    };
    let name = source.name.clone().or_else(|| of_volume().map(of_channel));
    name.unwrap_or_else(|| format!("layer {}", layer_idx + 1))
}
