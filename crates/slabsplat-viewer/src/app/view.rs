//! The view: all panes, and what the pointer does in them.

use super::Viewer;
use crate::state::{self, FrameBudget};
use crate::ui::{self, Pane, Pointed};
use eframe::egui::{self, Context, Rect, Ui};

/// Larger views are shown by fewer pixels.
const MAX_SIDE: u32 = 8192;

impl Viewer {
    /// The view: all panes, and what the pointer does in them.
    pub(super) fn view(&mut self, ui: &mut Ui) {
        let all = ui.available_rect_before_wrap();
        let Some(document) = &mut self.document else {
            return nothing_open(ui, all, self.opening.job().is_some());
        };
        let n_panes = document.n_panes();
        self.panes.resize_with(n_panes, Pane::default);
        if self.budgets.len() != n_panes {
            let budget = FrameBudget::new(FrameBudget::USUAL_MS / n_panes as f64);
            self.budgets = vec![budget; n_panes];
        }
        let rects = ui::rects(all, n_panes);
        self.view = pixels(rects[0], ui.ctx());
        document.resize(self.view);
        (self.pointed, self.is_held) = (None, false);
        for (pane_idx, rect) in rects.into_iter().enumerate() {
            self.show_pane(ui, pane_idx, rect);
        }
    }

    pub(super) fn show_pane(&mut self, ui: &mut Ui, pane_idx: usize, rect: Rect) {
        let Some(document) = &mut self.document else { return };
        let frame = ui::Frame { rect };
        let response = ui::sensed(ui, rect, pane_idx);
        let pane = &mut self.panes[pane_idx];
        pane.paint(ui, rect);
        let now = ui.input(|input| input.time);
        if self.pacing.is_moving(now, self.is_held) {
            let opened = document.pane(pane_idx);
            let revision = document.revision();
            pane.paint_annotations(ui, rect, revision, &opened.scene, opened.acquisition);
        }
        let handle = self.panel.edits_region.then_some(self.panel.layer_idx);
        let handle = handle.and_then(|layer_idx| ui::show_handles(ui, &frame, document, layer_idx));
        let pointed = ui::pointer(ui, &frame, &response, document, handle.is_some());
        self.is_held |= pointed.is_held || handle.is_some_and(|drag| drag.is_held);
        if 1 < document.n_panes() {
            let method = document.pane(pane_idx).scene.settings.method;
            ui::title(&ui.painter_at(rect), rect, method.name());
        }
        self.point(ui, &frame, &response, pointed);
    }

    /// What is under the pointer, and what clicks do with it.
    pub(super) fn point(
        &mut self,
        ui: &Ui,
        frame: &ui::Frame,
        response: &egui::Response,
        pointed: Pointed,
    ) {
        let Some(document) = &mut self.document else { return };
        if let Some(at) = pointed.at {
            self.pointed = ui::under(document, at);
        }
        let clicked = pointed.clicked.and_then(|at| ui::under(document, at));
        if let Some(picked) = clicked.filter(|_| self.ruler.is_on) {
            self.ruler.click(picked.point);
        } else if let (true, Some(picked)) = (response.double_clicked(), clicked) {
            document.settle();
            document.move_camera(|camera| state::centered_on(camera, picked.point));
            document.settle();
        }
        let opened = &document.state().opened;
        let painter = ui.painter_at(frame.rect);
        let (camera, acquisition) = (&opened.scene.camera, opened.acquisition);
        self.ruler.paint(&painter, camera, acquisition, |at| frame.to_screen(at));
    }
}

/// The pixels of a part of the window.
fn pixels(rect: Rect, context: &Context) -> [u32; 2] {
    let size = rect.size() * context.pixels_per_point();
    [size.x, size.y].map(|side| (side.round() as u32).clamp(1, MAX_SIDE))
}

fn nothing_open(ui: &Ui, all: Rect, is_opening: bool) {
    let text = if is_opening { "opening…" } else { "drop a volume or a scene here, or open one" };
    let font = egui::FontId::proportional(18.0);
    let color = ui.visuals().weak_text_color();
    ui.painter().text(all.center(), egui::Align2::CENTER_CENTER, text, font, color);
}
