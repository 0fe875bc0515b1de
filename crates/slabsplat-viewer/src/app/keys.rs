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
        let saves = [Key::S, Key::E].map(|key| shortcut(Modifiers::COMMAND, key));
        let Some(document) = &mut self.document else { return };
        match (redoes, undoes, saves) {
            (true, ..) => document.redo(),
            (_, true, _) => document.undo(),
            (_, _, [true, _]) => self.files.ask_scene(),
            (_, _, [_, true]) => self.files.ask_picture(self.view),
            _ => {}
        }
        // Whoever writes a number does not turn the camera.
        if context.egui_wants_keyboard_input() {
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
