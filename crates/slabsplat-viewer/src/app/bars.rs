//! The bars above and below the view, and what is said over it.

use super::Viewer;
use crate::state::{self, Document, Picked, State};
use crate::ui;
use eframe::egui::{self, Context, Ui};

impl Viewer {
    pub(super) fn bar(&mut self, ui: &mut Ui) {
        ui.horizontal_wrapped(|ui| {
            if !self.is_served && ui.button("Open…").clicked() {
                self.files.ask_open();
            }
            let Some(document) = &mut self.document else { return };
            if ui.button("Save picture…").clicked() {
                self.files.ask_picture(self.view);
            }
            if ui.button("Save scene…").clicked() {
                self.files.ask_scene();
            }
            if !self.is_served && ui.button("Film…").clicked() {
                self.files.ask_film(self.view);
            }
            ui.separator();
            let [has_undo, has_redo] = document.has_steps();
            if ui.add_enabled(has_undo, egui::Button::new("← Undo")).clicked() {
                document.undo();
            }
            if ui.add_enabled(has_redo, egui::Button::new("Redo →")).clicked() {
                document.redo();
            }
            ui.separator();
            if ui.button("Perspective").on_hover_text("P").clicked() {
                document.settle();
                document.move_camera(state::with_projection_switched);
                document.settle();
            }
            let mut aims = None;
            for viewpoint in ui::SIDES {
                if ui.button(viewpoint.name()).clicked() {
                    aims = Some(Some(viewpoint));
                }
            }
            if ui.button("fill").on_hover_text("0").clicked() {
                aims = Some(None);
            }
            if let Some(viewpoint) = aims {
                self.aim(viewpoint);
            }
            ui.separator();
            if ui.selectable_label(self.ruler.is_on, "Measure").on_hover_text("M").clicked() {
                self.ruler.toggle();
            }
            let controls = ui.selectable_label(!self.hides_controls, "Controls");
            if controls.on_hover_text("shown beside the view: C").clicked() {
                self.hides_controls ^= true;
            }
            let (other, name) = match ui.ctx().theme() {
                egui::Theme::Dark => (egui::Theme::Light, "Light"),
                egui::Theme::Light => (egui::Theme::Dark, "Dark"),
            };
            if ui.button(name).clicked() {
                ui.ctx().set_theme(other);
            }
            if ui.button("?").clicked() {
                self.shows_help ^= true;
            }
        });
    }

    pub(super) fn status(&mut self, ui: &mut Ui) {
        ui.horizontal(|ui| {
            if let (Some(picked), Some(document)) = (&self.pointed, &self.document) {
                ui.label(told(picked, document));
            } else if let Some(document) = &self.document {
                ui.weak(&document.name);
            }
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                ui.weak(self.source.drawn_by());
                if let Some((ms, [width, height])) = self.shown {
                    ui.weak(format!("{width} x {height}, {ms:.0} ms"));
                }
                match self.source.progress() {
                    Some(share) if !self.pacing.is_done() => {
                        ui.add(egui::ProgressBar::new(share).desired_width(80.0));
                    }
                    _ => {}
                }
            });
        });
    }

    /// Work that goes on, and what was said, over the picture.
    pub(super) fn notices(&mut self, context: &Context) {
        let (mut dropped, mut dropped_note) = (None, None);
        let (mut dropped_job, mut drops_opening) = (None, false);
        let area = egui::Area::new(egui::Id::unique("notices"));
        area.anchor(egui::Align2::LEFT_BOTTOM, [8.0, -34.0]).show(context, |ui| {
            ui.set_max_width(520.0);
            let line = |ui: &mut Ui, text: &str, share: Option<f32>| {
                let frame = egui::Frame::popup(ui.style());
                let inner = frame.show(ui, |ui| {
                    ui.horizontal(|ui| {
                        let is_closed = ui.small_button("×").clicked();
                        if let Some(share) = share {
                            ui.add(egui::ProgressBar::new(share).desired_width(90.0));
                        }
                        ui.add(egui::Label::new(text).wrap());
                        is_closed
                    })
                });
                inner.inner.inner
            };
            if let Some(opening) = self.opening.job() {
                drops_opening = line(ui, &opening.title, Some(opening.share()));
            }
            for (idx, job) in self.jobs.iter().enumerate() {
                if line(ui, &job.title, Some(job.share())) {
                    dropped_job = Some(idx);
                }
            }
            for (idx, message) in self.messages.iter().enumerate() {
                if line(ui, &message.text, None) {
                    dropped = Some(idx);
                }
            }
            for (idx, note) in self.document.iter().flat_map(Document::notes) {
                if line(ui, note, None) {
                    dropped_note = Some(idx);
                }
            }
        });
        if drops_opening {
            self.opening.give_up();
        }
        dropped_job.map(|idx| self.jobs.remove(idx));
        dropped.map(|idx| self.messages.remove(idx));
        if let (Some(idx), Some(document)) = (dropped_note, &mut self.document) {
            document.close_note(idx);
        }
    }
}

/// What is under the pointer, for people.
fn told(picked: &Picked, document: &Document) -> String {
    let [i, j, k] = picked.voxel;
    let State { opened, .. } = document.state();
    let unit = if opened.acquisition.is_metric { " mm" } else { "" };
    let [x, y, z] = picked.point.to_array().map(ui::number);
    let of_layer = match opened.scene.layers.len() {
        1 => String::new(),
        _ => format!("{}: ", ui::name_of_layer(document, picked.layer_idx)),
    };
    format!("{of_layer}{} at voxel {i}, {j}, {k}, ({x}, {y}, {z}){unit}", ui::number(picked.value))
}
