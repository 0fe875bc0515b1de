//! What keys and mouse do: one table, which the overlay shows.

use eframe::egui::{Align2, Context, Grid, Window};

/// What there is to be done, and by what.
pub(crate) const KEYS: &[[&str; 2]] = &[
    ["drag", "turn"],
    ["right drag, Shift + drag", "move"],
    ["wheel, pinch", "zoom to what is under the pointer"],
    ["Ctrl + drag", "roll"],
    ["two fingers", "move, zoom and roll what they touch"],
    ["double click", "look at what is under the pointer"],
    ["arrows", "turn by 5°"],
    ["+, −", "zoom"],
    ["1 … 6", "front, back, left, right, top, bottom"],
    ["0", "fill the view"],
    ["P", "perspective on and off"],
    ["M", "measure: click two points"],
    ["T", "turn around"],
    ["C", "controls shown and hidden"],
    ["Ctrl + Z, Ctrl + Shift + Z", "undo, redo"],
    ["Ctrl + O, Ctrl + Shift + O", "open a volume or a scene, add one as a layer"],
    ["Ctrl + S, Ctrl + E, Ctrl + Shift + E", "save the scene, save a picture, film a turn"],
    ["Tab, Space, Enter", "reach and use any control"],
    ["?", "this help"],
];

/// The overlay.
pub(crate) fn show(context: &Context, is_open: &mut bool) {
    let window = Window::new("Keys and mouse").open(is_open).collapsible(false).resizable(false);
    window.anchor(Align2::CENTER_CENTER, [0.0, 0.0]).show(context, |ui| {
        Grid::new("keys").num_columns(2).striped(true).show(ui, |ui| {
            for [what, does] in KEYS {
                ui.strong(*what);
                ui.label(*does);
                ui.end_row();
            }
        });
    });
}
