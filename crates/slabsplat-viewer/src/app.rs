//! The viewer: what is open, what is shown of it, and what its user does. A window or a page drives it.

use crate::frames::{Drawn, Event, FrameSource, Request, Urgency, Wake};
#[cfg(not(target_arch = "wasm32"))]
use crate::jobs::Opening;
use crate::jobs::{self, Job, Opener};
use crate::state::{self, Asked, Document, FrameBudget, Pacing, Picked};
use crate::ui::{self, Files, Pane, Panel, Pointed, Ruler, Wish};
use eframe::egui::{
    self, CentralPanel, Context, Key, KeyboardShortcut, Modifiers, Panel as Bar, Rect, Ui,
};
use slabsplat::glam::DVec2;
use slabsplat::{Finish, ImageDesc, OpenScene, Viewpoint};

/// A viewer of volumes, an app of eframe's.
pub struct Viewer {
    opener: Opener,
    wake: Wake,
    source: Box<dyn FrameSource>,
    pacing: Pacing,
    budgets: Vec<FrameBudget>,
    document: Option<Document>,
    opening: Option<Job<Document>>,
    jobs: Vec<Job<String>>,
    panel: Panel,
    files: Files,
    ruler: Ruler,
    panes: Vec<Pane>,
    /// The size of a pane, in pixels.
    view: [u32; 2],
    messages: Vec<String>,
    pointed: Option<Picked>,
    is_held: bool,
    shows_help: bool,
    /// What the frames that are shown took, and how large they were.
    shown: Option<(f64, [u32; 2])>,
}

impl std::fmt::Debug for Viewer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Viewer").field("view", &self.view).finish_non_exhaustive()
    }
}

/// Degrees of a step of a turn, and of an arrow key.
const TURN_STEP: f64 = 0.5;
const ARROW_STEP: f64 = 5.0;

/// Larger views are shown by fewer pixels.
const MAX_SIDE: u32 = 8192;

impl Viewer {
    /// A viewer in a window of egui's, on frames of `source`, that opens what `opener` makes of names.
    pub fn new(context: &Context, source: Box<dyn FrameSource>, opener: Opener, wake: Wake) -> Self {
        ui::dress(context);
        Self {
            opener,
            wake,
            source,
            pacing: Pacing::default(),
            budgets: Vec::new(),
            document: None,
            opening: None,
            jobs: Vec::new(),
            panel: Panel::default(),
            files: Files::default(),
            ruler: Ruler::default(),
            panes: Vec::new(),
            view: [960, 720],
            messages: Vec::new(),
            pointed: None,
            is_held: false,
            shows_help: false,
            shown: None,
        }
    }

    /// Opens what a job opens, of views of a size.
    #[cfg(target_arch = "wasm32")]
    pub(crate) fn begin(&mut self, job: impl FnOnce([u32; 2], &Wake) -> Job<Document>) {
        self.opening = Some(job(self.view, &self.wake));
    }

    /// Opens something instead of what is open; `name` is what it is called.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn open(&mut self, name: String, opening: Opening) {
        self.opening = Some(jobs::begin(name, opening, self.view, &self.wake));
    }

    /// What was opened before, the newest first.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn set_recent(&mut self, recent: Vec<std::path::PathBuf>) {
        self.files.recent = recent;
    }

    /// Says something to the user.
    pub fn say(&mut self, what: impl Into<String>) {
        let what = what.into();
        if self.messages.last() != Some(&what) {
            self.messages.push(what);
        }
    }

    fn hear_jobs(&mut self) {
        if let Some(result) = self.opening.as_ref().and_then(Job::done) {
            self.opening = None;
            match result {
                Ok(document) => self.show_document(document),
                Err(why) => self.say(why),
            }
        }
        let done: Vec<_> = self.jobs.iter().map(Job::done).collect();
        let mut is_done = done.iter().map(Option::is_some);
        self.jobs.retain(|_| !is_done.next().unwrap_or(false));
        for result in done.into_iter().flatten() {
            self.say(result.unwrap_or_else(|why| why));
        }
    }

    fn show_document(&mut self, document: Document) {
        let opened = &document.state().opened;
        let said: Vec<String> = opened.found.iter().chain(&opened.warnings).cloned().collect();
        said.into_iter().for_each(|what| self.say(what));
        self.document = Some(document);
        self.panes.clear();
        self.pacing.forget();
        self.ruler = Ruler::default();
        self.panel = Panel::default();
    }

    fn hear_frames(&mut self, context: &Context) {
        for event in self.source.events() {
            match event {
                Event::Drawn(drawn) => self.show_frame(context, *drawn),
                Event::Failed { pane, number, why } => {
                    if self.pacing.came(pane, number)
                        && let Some(pane) = self.panes.get_mut(pane)
                    {
                        pane.error = Some(why);
                    }
                }
                Event::Note(note) => self.say(note),
            }
        }
    }

    fn show_frame(&mut self, context: &Context, drawn: Drawn) {
        let (pane_idx, urgency) = (drawn.pane, drawn.urgency);
        if !self.pacing.came(pane_idx, drawn.number) || self.panes.len() <= pane_idx {
            return;
        }
        let size = [drawn.image.width(), drawn.image.height()];
        if let Some(ms) = drawn.ms {
            self.shown = Some((ms, size));
            if urgency == Urgency::Moving {
                self.budgets[pane_idx].took(ms);
            }
        }
        drawn.notes.iter().for_each(|note| self.say(note.clone()));
        let comparison = &mut self.panel.comparison;
        if comparison.is_turning
            && let Some(before) = &self.panes[pane_idx].image
            && [before.width(), before.height()] == size
        {
            comparison.add(pane_idx, drawn.image.mean_difference(before));
        }
        self.panes[pane_idx].set(context, pane_idx, drawn);
        if self.panel.comparison.shows_difference {
            self.show_difference(context);
        }
    }

    /// Panes beside the first show by how much they differ from it.
    fn show_difference(&mut self, context: &Context) {
        let Some((first, others)) = self.panes.split_first_mut() else { return };
        let Some(reference) = &first.image else { return };
        for (idx, pane) in others.iter_mut().enumerate() {
            let Some(image) = &pane.image else { continue };
            if (image.width(), image.height()) == (reference.width(), reference.height()) {
                let largest = image.max_color_difference(reference);
                let gain = slabsplat::gain_for(f64::from(largest));
                let picture = slabsplat::difference_picture(image, reference, gain);
                pane.show_instead(context, idx + 1, &picture);
            }
        }
    }

    fn keys(&mut self, context: &Context) {
        let shortcut = |modifiers, key| {
            let shortcut = KeyboardShortcut::new(modifiers, key);
            context.input_mut(|input| input.consume_shortcut(&shortcut))
        };
        if shortcut(Modifiers::COMMAND, Key::O) {
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

    fn camera_keys(&mut self, context: &Context) {
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

    fn aim(&mut self, viewpoint: Option<Viewpoint>) {
        let Some(document) = &mut self.document else { return };
        document.settle();
        if let Err(error) = document.aim(viewpoint) {
            self.say(error.to_string());
        }
    }

    /// What was dropped onto the window.
    fn dropped(&mut self, context: &Context) {
        let dropped = context.input(|input| input.raw.dropped_files.clone());
        if let Some(file) = dropped.first() {
            let opener = self.opener.clone();
            self.opening = Some(jobs::open_dropped(opener, file, self.view, &self.wake));
        }
    }

    fn grant(&mut self, wish: Wish) {
        let pane = |[width, height]: [u32; 2]| {
            let mut opened = self.document.as_ref()?.pane(0);
            let image = ImageDesc::new(width, height);
            opened.scene.image = image.background(opened.scene.image.background);
            Some(opened)
        };
        match wish {
            #[cfg(target_arch = "wasm32")]
            Wish::OpenBytes(name, bytes) => {
                self.opening = Some(jobs::open_bytes(name, bytes, self.view, &self.wake));
            }
            Wish::Open(path) => {
                self.files.opened(&path);
                let job = jobs::open(self.opener.clone(), path, self.view, &self.wake);
                self.opening = Some(job);
            }
            Wish::SaveScene(path) => {
                let opened = pane(self.view);
                self.jobs.extend(opened.map(|it| jobs::save_scene(it, path, &self.wake)));
            }
            Wish::SavePicture(path, size) => {
                let opened = pane(size);
                self.jobs.extend(opened.map(|it| jobs::save_picture(it, path, &self.wake)));
            }
            Wish::Film(path, size, seconds) => {
                let opened = pane(size);
                self.jobs.extend(opened.map(|it| jobs::film(it, path, seconds, &self.wake)));
            }
        }
    }

    fn bar(&mut self, ui: &mut Ui) {
        ui.horizontal_wrapped(|ui| {
            if ui.button("Open…").clicked() {
                self.files.ask_open();
            }
            let Some(document) = &mut self.document else { return };
            if ui.button("Save picture…").clicked() {
                self.files.ask_picture(self.view);
            }
            if ui.button("Save scene…").clicked() {
                self.files.ask_scene();
            }
            if ui.button("Film…").clicked() {
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

    fn status(&mut self, ui: &mut Ui) {
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
    fn notices(&mut self, context: &Context) {
        let (mut dropped, mut dropped_job, mut drops_opening) = (None, None, false);
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
            if let Some(opening) = &self.opening {
                drops_opening = line(ui, &opening.title, Some(opening.share()));
            }
            for (idx, job) in self.jobs.iter().enumerate() {
                if line(ui, &job.title, Some(job.share())) {
                    dropped_job = Some(idx);
                }
            }
            for (idx, message) in self.messages.iter().enumerate() {
                if line(ui, message, None) {
                    dropped = Some(idx);
                }
            }
        });
        if drops_opening {
            self.opening = None;
        }
        dropped_job.map(|idx| self.jobs.remove(idx));
        dropped.map(|idx| self.messages.remove(idx));
    }

    /// The view: all panes, and what the pointer does in them.
    fn view(&mut self, ui: &mut Ui) {
        let all = ui.available_rect_before_wrap();
        let Some(document) = &mut self.document else {
            return nothing_open(ui, all, self.opening.is_some());
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

    fn show_pane(&mut self, ui: &mut Ui, pane_idx: usize, rect: Rect) {
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
        let pointed = ui::pointer(ui, &frame, &response, document);
        self.is_held |= pointed.is_held;
        if self.panel.edits_region {
            self.is_held |= ui::show_handles(ui, &frame, document, self.panel.layer_idx);
        }
        if 1 < document.n_panes() {
            let method = document.pane(pane_idx).scene.settings.method;
            ui::title(&ui.painter_at(rect), rect, method.name());
        }
        self.point(ui, &frame, &response, pointed);
    }

    /// What is under the pointer, and what clicks do with it.
    fn point(&mut self, ui: &Ui, frame: &ui::Frame, response: &egui::Response, pointed: Pointed) {
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

    /// Asks for pictures of what is shown now.
    fn ask(&mut self, context: &Context) {
        let Some(document) = &mut self.document else { return };
        if self.panel.comparison.is_turning && self.pacing.is_done() {
            document.move_camera(|camera| camera.orbited(TURN_STEP.to_radians()));
        }
        let now = context.input(|input| input.time);
        let is_held = self.is_held || self.panel.comparison.is_turning;
        let asked = self.pacing.step(document.revision(), document.n_panes(), now, is_held);
        for Asked { pane, number, urgency } in asked {
            let opened = document.pane(pane);
            let opened = match urgency {
                Urgency::AtRest => opened,
                Urgency::Moving => preview(opened, self.budgets[pane].size(self.view)),
            };
            self.source.ask(Request { pane, number, opened, urgency });
        }
        if let Some(seconds) = self.pacing.wake_in(now).filter(|_| !is_held) {
            context.request_repaint_after(std::time::Duration::from_secs_f64(seconds));
        }
        if !self.pacing.is_done() || self.opening.is_some() || !self.jobs.is_empty() {
            // For progress bars: what is done wakes the window by itself.
            context.request_repaint_after(std::time::Duration::from_millis(100));
        }
    }
}

impl eframe::App for Viewer {
    fn ui(&mut self, ui: &mut Ui, _: &mut eframe::Frame) {
        let context = ui.ctx().clone();
        self.hear_jobs();
        self.hear_frames(&context);
        self.dropped(&context);
        self.keys(&context);
        Bar::top("bar").show(ui, |ui| self.bar(ui));
        Bar::bottom("status").show(ui, |ui| self.status(ui));
        if let Some(document) = &mut self.document {
            let panel = Bar::right("controls").default_size(330.0).size_range(330.0..=520.0);
            let said = panel.show(ui, |ui| self.panel.show(ui, document)).inner;
            said.into_iter().for_each(|what| self.say(what));
        }
        CentralPanel::no_frame().show(ui, |ui| self.view(ui));
        self.notices(&context);
        ui::show_help(&context, &mut self.shows_help);
        if let Some(wish) = self.files.show(&context) {
            self.grant(wish);
        }
        if context.input(|input| input.pointer.any_released())
            && let Some(document) = &mut self.document
        {
            document.settle();
        }
        self.ask(&context);
    }
}

/// A scene as it is shown while it moves: small, and with nothing drawn on it.
fn preview(mut opened: OpenScene, [width, height]: [u32; 2]) -> OpenScene {
    let image = &mut opened.scene.image;
    (image.width, image.height) = (width, height);
    let below = opened.scene.finish.background_below;
    opened.scene.finish = below.map_or_else(Finish::default, |color| {
        Finish::default().background_below(color)
    });
    opened
}

/// The pixels of a part of the window.
fn pixels(rect: Rect, context: &Context) -> [u32; 2] {
    let size = rect.size() * context.pixels_per_point();
    [size.x, size.y].map(|side| (side.round() as u32).clamp(1, MAX_SIDE))
}

/// What is under the pointer, for people.
fn told(picked: &Picked, document: &Document) -> String {
    let [i, j, k] = picked.voxel;
    let unit = if document.state().opened.acquisition.is_metric { " mm" } else { "" };
    let [x, y, z] = picked.point.to_array().map(ui::number);
    format!("{} at voxel {i}, {j}, {k}, ({x}, {y}, {z}){unit}", ui::number(picked.value))
}

fn nothing_open(ui: &Ui, all: Rect, is_opening: bool) {
    let text = if is_opening { "opening…" } else { "drop a volume or a scene here, or open one" };
    let font = egui::FontId::proportional(18.0);
    let color = ui.visuals().weak_text_color();
    ui.painter().text(all.center(), egui::Align2::CENTER_CENTER, text, font, color);
}
