//! What is to become of files that were dropped while something is open.

use super::OpenAs;
use eframe::egui::{Align2, Context, Key, Window};
use std::path::PathBuf;

/// What was decided on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Drop {
    /// They are opened so.
    Open(OpenAs),
    /// Nothing becomes of them.
    Nothing,
}

/// Asks, until it is decided.
pub(crate) fn ask(context: &Context, names: &[PathBuf]) -> Option<Drop> {
    let mut decided = None;
    let mut is_open = true;
    let shown = match names {
        [name] => short(name),
        [name, ..] => format!("{} and {} more", short(name), names.len() - 1),
        [] => return Some(Drop::Nothing),
    };
    let window = Window::new(shown).open(&mut is_open).collapsible(false).resizable(false);
    window.anchor(Align2::CENTER_CENTER, [0.0, 0.0]).show(context, |ui| {
        ui.horizontal(|ui| {
            let instead = ui.button("Open").on_hover_text("instead of what is open: Enter");
            if instead.clicked() || ui.input(|input| input.key_pressed(Key::Enter)) {
                decided = Some(Drop::Open(OpenAs::Document));
            }
            let layer = if names.len() == 1 { "Add as a layer" } else { "Add as layers" };
            let layer = ui.button(layer).on_hover_text("beside what is open: Shift");
            if layer.clicked() {
                decided = Some(Drop::Open(OpenAs::Layer));
            }
        });
    });
    let is_escaped = context.input(|input| input.key_pressed(Key::Escape));
    decided.or((!is_open || is_escaped).then_some(Drop::Nothing))
}

fn short(path: &std::path::Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}
