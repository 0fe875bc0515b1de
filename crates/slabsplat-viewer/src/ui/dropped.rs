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

#[cfg(test)]
mod tests {
    use super::*;
    use eframe::egui::{Event, Modifiers, RawInput};

    /// What is decided on by a key.
    fn decided(key: Option<Key>, names: &[&str]) -> Option<Drop> {
        let names: Vec<PathBuf> = names.iter().map(PathBuf::from).collect();
        let modifiers = Modifiers::NONE;
        let event =
            |key| Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers };
        let input =
            RawInput { events: key.map(event).into_iter().collect(), ..RawInput::default() };
        let (context, mut decided) = (Context::default(), None);
        let mut output = context.run_ui(input, |ui| decided = ask(ui.ctx(), &names).or(decided));
        // Nobody shows what is painted.
        output.textures_delta.clear();
        decided
    }

    #[test]
    fn what_was_dropped_waits_for_an_answer() {
        assert_eq!(decided(None, &["/data/a.nii"]), None);
        assert_eq!(decided(Some(Key::A), &["/data/a.nii", "/data/b.nii"]), None);
        let opened = Drop::Open(OpenAs::Document);
        assert_eq!(decided(Some(Key::Enter), &["/data/a.nii"]), Some(opened));
        assert_eq!(decided(Some(Key::Escape), &["/data/a.nii"]), Some(Drop::Nothing));
        assert_eq!(decided(None, &[]), Some(Drop::Nothing));
    }
}
