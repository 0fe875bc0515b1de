//! What keys do; `ui/help.rs` says it to the user.

use super::Viewer;
use crate::{state, ui};
use eframe::egui::{Context, Key, KeyboardShortcut, Modifiers};
use slabsplat::glam::DVec2;

/// Degrees of an arrow key.
const ARROW_STEP: f64 = 5.0;

impl Viewer {
    pub(super) fn keys(&mut self, context: &Context) {
        let shortcut = |modifiers, key| {
            let shortcut = KeyboardShortcut::new(modifiers, key);
            context.input_mut(|input| input.consume_shortcut(&shortcut))
        };
        if shortcut(Modifiers::COMMAND | Modifiers::SHIFT, Key::O)
            && self.document.is_some()
            && !self.is_served
        {
            self.files.ask_layer();
        }
        if shortcut(Modifiers::COMMAND, Key::O) && !self.is_served {
            self.files.ask_open();
        }
        let redoes = shortcut(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z)
            || shortcut(Modifiers::COMMAND, Key::Y);
        let undoes = shortcut(Modifiers::COMMAND, Key::Z);
        let films = shortcut(Modifiers::COMMAND | Modifiers::SHIFT, Key::E);
        let saves = [Key::S, Key::E].map(|key| shortcut(Modifiers::COMMAND, key));
        let Some(document) = &mut self.document else { return };
        match (redoes, undoes, saves) {
            (true, ..) => document.redo(),
            (_, true, _) => document.undo(),
            (_, _, [true, _]) => self.files.ask_scene(),
            (_, _, [_, true]) => self.files.ask_picture(self.view),
            _ if films => self.files.ask_film(self.view),
            _ => {}
        }
        // Whoever writes a number does not turn the camera, nor who writes a name for which there is no field
        // before the next frame.
        if context.egui_wants_keyboard_input() || self.files.is_asking() {
            return;
        }
        let pressed = |key| context.input(|input| input.key_pressed(key) && !input.modifiers.any());
        let viewpoints = ui::SIDES;
        let keys = [Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5, Key::Num6];
        for (key, viewpoint) in keys.into_iter().zip(viewpoints) {
            if pressed(key) {
                self.aim(Some(viewpoint));
            }
        }
        if pressed(Key::Num0) {
            self.aim(None);
        }
        self.camera_keys(context);
        if pressed(Key::M) {
            self.ruler.toggle();
        }
        if pressed(Key::C) {
            self.hides_controls ^= true;
        }
        if pressed(Key::T) {
            self.panel.comparison.is_turning ^= true;
            self.panel.comparison.clear();
        }
        let asks = context.input(|input| input.key_pressed(Key::Questionmark));
        self.shows_help ^= asks || pressed(Key::F1);
        self.shows_help &= !pressed(Key::Escape);
    }

    pub(super) fn camera_keys(&mut self, context: &Context) {
        let Some(document) = &mut self.document else { return };
        let pressed = |key| context.input(|input| input.key_pressed(key));
        let step = ARROW_STEP / 180.0;
        let arrows = [
            (Key::ArrowLeft, DVec2::new(-step, 0.0)),
            (Key::ArrowRight, DVec2::new(step, 0.0)),
            (Key::ArrowUp, DVec2::new(0.0, step)),
            (Key::ArrowDown, DVec2::new(0.0, -step)),
        ];
        for (_, drag) in arrows.into_iter().filter(|(key, _)| pressed(*key)) {
            document.move_camera(|camera| state::orbited(camera, drag));
        }
        let factor = ui::zoom_of_keys(context);
        if factor != 1.0 {
            document.move_camera(|camera| state::zoomed(camera, DVec2::ZERO, factor));
        }
        if pressed(Key::P) {
            document.settle();
            document.move_camera(state::with_projection_switched);
            document.settle();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::{Event, FrameSource, Request};
    use crate::state::Document;
    use eframe::egui::{self, RawInput};
    use slabsplat::io::{SceneFile, VolumeSource};
    use std::sync::Arc;

    /// Nobody draws.
    struct Nobody;

    impl FrameSource for Nobody {
        fn ask(&mut self, _: Request) {}

        fn events(&mut self) -> Vec<Event> {
            Vec::new()
        }

        fn progress(&self) -> Option<f32> {
            None
        }

        fn drawn_by(&self) -> String {
            "nobody".to_owned()
        }
    }

    fn viewer(context: &Context) -> Viewer {
        let opener = Arc::new(|_: &std::path::Path| Err("nothing is opened".to_owned()));
        let mut viewer = Viewer::new(context, Box::new(Nobody), opener, Arc::new(|| {}));
        let source = VolumeSource::Builtin { name: "sphere".to_owned(), size: Some(8) };
        let file = SceneFile::of_volume(source);
        viewer.document = Some(Document::open(&file, "sphere".to_owned(), [64, 48]).unwrap());
        viewer
    }

    fn press(context: &Context, viewer: &mut Viewer, keys: &[(Modifiers, Key)]) {
        let event = |(modifiers, key): &(Modifiers, Key)| egui::Event::Key {
            key: *key,
            physical_key: None,
            pressed: true,
            repeat: false,
            modifiers: *modifiers,
        };
        let input = RawInput { events: keys.iter().map(event).collect(), ..RawInput::default() };
        context.run_ui(input, |ui| viewer.keys(ui.ctx())).textures_delta.clear();
    }

    /// A name is typed as soon as it is asked for, which a busy window hears of in one frame.
    #[test]
    fn keys_of_a_name_do_nothing_else() {
        let context = Context::default();
        let mut viewer = viewer(&context);
        let projection = |viewer: &Viewer| {
            viewer.document.as_ref().map(|document| document.shown().scene.camera.projection())
        };
        let before = projection(&viewer);
        let [turns, switches] = [Key::T, Key::P].map(|key| (Modifiers::NONE, key));
        press(&context, &mut viewer, &[(Modifiers::COMMAND, Key::E), turns, switches]);
        press(&context, &mut viewer, &[switches]);
        assert!(viewer.files.is_asking() && !viewer.panel.comparison.is_turning);
        assert_eq!(projection(&viewer), before);

        viewer.files = ui::Files::default();
        press(&context, &mut viewer, &[turns, switches]);
        assert!(viewer.panel.comparison.is_turning && projection(&viewer) != before);
    }
}
