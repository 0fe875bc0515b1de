//! Panes with one camera and different settings, their differences, and by how much each changes as it turns.

use super::settings;
use crate::state::Document;
use eframe::egui::{Color32, Sense, Stroke, Ui, pos2, vec2};
use slabsplat::{Method, Mode, RenderSettings};
use std::collections::VecDeque;

/// What of the comparison is no part of the scene.
#[derive(Clone, Debug, Default)]
pub(crate) struct Comparison {
    /// Whether panes beside the first show by how much they differ from it.
    pub(crate) shows_difference: bool,
    /// Whether the camera goes around by itself.
    pub(crate) is_turning: bool,
    /// What changed from frame to frame, of each pane.
    changes: Vec<VecDeque<f64>>,
}

/// Frames that the graph shows.
const N_SHOWN: usize = 160;

/// Colours of panes in the graph.
const COLORS: [Color32; Document::MAX_PANES] = [
    Color32::from_rgb(90, 170, 255),
    Color32::from_rgb(255, 160, 60),
    Color32::from_rgb(110, 210, 120),
    Color32::from_rgb(235, 110, 170),
];

impl Comparison {
    /// A pane's picture has changed by so much since the one before, as it was turned by one step.
    pub(crate) fn add(&mut self, pane: usize, change: f64) {
        if self.changes.len() <= pane {
            self.changes.resize(pane + 1, VecDeque::new());
        }
        let changes = &mut self.changes[pane];
        changes.push_back(change);
        if N_SHOWN < changes.len() {
            changes.pop_front();
        }
    }

    /// Begins anew.
    pub(crate) fn clear(&mut self) {
        self.changes.clear();
    }

    /// Which panes there are, and how they are made.
    pub(crate) fn show(&mut self, ui: &mut Ui, document: &mut Document) {
        ui.horizontal(|ui| {
            if document.n_panes() < Document::MAX_PANES && ui.button("add a pane").clicked() {
                let settings = document.state().opened.scene.settings.clone();
                document.change("panes", |state| state.compared.push(settings));
            }
            if ui.button("three methods").on_hover_text("as the paper compares them").clicked() {
                let own = &document.state().opened.scene.settings;
                let of = |method| own.clone().method(method).mode(sheets(own));
                let others = [Method::AxisAligned, Method::EverySample].map(of);
                let own = of(Method::ImageAligned);
                document.change("panes", |state| {
                    state.opened.scene.settings = own;
                    state.compared = others.to_vec();
                });
                self.clear();
            }
            if 1 < document.n_panes() && ui.button("one pane").clicked() {
                document.change("panes", |state| state.compared.clear());
                self.clear();
            }
        });
        if 1 < document.n_panes() {
            ui.checkbox(&mut self.shows_difference, "show differences from the first");
        }
        self.others(ui, document);
    }

    /// The settings of the panes beside the first one.
    fn others(&mut self, ui: &mut Ui, document: &mut Document) {
        let others = document.state().compared.clone();
        for (idx, other) in others.iter().enumerate() {
            let title = format!("pane {}: {}", idx + 2, other.method.name());
            ui.push_id(("pane", idx), |ui| {
                ui.collapsing(title, |ui| {
                    if let Some((kind, edited)) = settings::rows(ui, other) {
                        document.change(kind, |state| state.compared[idx] = edited);
                        self.clear();
                    }
                    if ui.button("remove").clicked() {
                        document.change("panes", |state| drop(state.compared.remove(idx)));
                        self.clear();
                    }
                });
            });
        }
    }

    /// The popping meter: by how much pictures change from step to step of a turn. What pops is a spike.
    pub(crate) fn meter(&mut self, ui: &mut Ui, document: &Document) {
        let help = "turns the camera by equal steps; a method that does not pop changes evenly";
        if ui.toggle_value(&mut self.is_turning, "turn").on_hover_text(help).changed() {
            self.clear();
        }
        let (response, painter) =
            ui.allocate_painter(vec2(ui.available_width(), 90.0), Sense::hover());
        let rect = response.rect;
        painter.rect_filled(rect, 2.0, ui.visuals().extreme_bg_color);
        let most = self.changes.iter().flatten().copied().fold(0.0, f64::max);
        for (changes, color) in self.changes.iter().zip(COLORS) {
            let at = |(idx, change): (usize, &f64)| {
                let x = rect.left() + rect.width() * idx as f32 / (N_SHOWN - 1) as f32;
                pos2(
                    x,
                    rect.bottom() - 4.0 - (rect.height() - 8.0) * (change / most.max(1e-12)) as f32,
                )
            };
            let line: Vec<_> = changes.iter().enumerate().map(at).collect();
            painter.line(line, Stroke::new(1.5, color));
        }
        for (pane, changes) in self.changes.iter().enumerate().take(document.n_panes()) {
            let method = document.pane(pane).scene.settings.method.name();
            let ratio = pop_ratio(changes).map_or("–".to_owned(), |ratio| format!("{ratio:.2}"));
            ui.colored_label(COLORS[pane], format!("{method}: largest over median {ratio}"));
        }
    }
}

/// The largest change over the median one; `None` while there are too few.
fn pop_ratio(changes: &VecDeque<f64>) -> Option<f64> {
    let mut sorted: Vec<f64> = changes.iter().copied().collect();
    sorted.sort_by(f64::total_cmp);
    let median = *sorted.get(sorted.len() / 2)?;
    (8 < sorted.len() && 0.0 < median).then(|| sorted[sorted.len() - 1] / median)
}

/// A mode that all methods have.
fn sheets(settings: &RenderSettings) -> Mode {
    if settings.mode.compositing().is_some() { settings.mode } else { Mode::Extinction }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pops_are_told_from_even_changes() {
        let even: VecDeque<f64> = (0..20).map(|_| 0.25).collect();
        assert_eq!(pop_ratio(&even), Some(1.0));
        let mut popping = even;
        popping[7] = 1.0;
        assert_eq!(pop_ratio(&popping), Some(4.0));
        assert_eq!(pop_ratio(&VecDeque::from([1.0, 2.0])), None);
        let mut comparison = Comparison::default();
        (0..1000).for_each(|_| comparison.add(2, 1.0));
        assert_eq!(comparison.changes[2].len(), N_SHOWN);
        assert!(comparison.changes[0].is_empty());
    }
}
