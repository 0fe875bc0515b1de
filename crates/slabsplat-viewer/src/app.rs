//! The viewer: what is open, what is shown of it, and what its user does. A window or a page drives it.
//!
//! Reading order: here, `opening`, `saving`, `view`, `keys`, `bars`, `thumbnails`, `textures`.

mod bars;
mod keys;
mod opening;
mod saving;
mod textures;
mod thumbnails;
mod view;

use crate::frames::{Drawn, DrawnInTexture, Event, FrameSource, Request, Urgency, Wake};
use crate::jobs::{Job, Opener};
use crate::state::{Asked, Document, FrameBudget, Pacing, Picked};
use crate::ui::{self, Files, Pane, Panel, PanelWish, Ruler};
use eframe::egui::{CentralPanel, Context, Panel as Bar, Ui, ViewportCommand};
use opening::Opening;
use slabsplat::Viewpoint;
use textures::Textures;

/// A viewer of volumes, an app of eframe's.
pub struct Viewer {
    opener: Opener,
    wake: Wake,
    source: Box<dyn FrameSource>,
    pacing: Pacing,
    budgets: Vec<FrameBudget>,
    document: Option<Document>,
    opening: Opening,
    /// A preset that is fitted to a volume, for a small picture.
    thumbnail: Option<thumbnails::Fitting>,
    /// Whether a server draws: what is open is its scene, and stays that.
    is_served: bool,
    jobs: Vec<Job<String>>,
    panel: Panel,
    files: Files,
    ruler: Ruler,
    panes: Vec<Pane>,
    textures: Textures,
    /// The size of a pane, in pixels.
    view: [u32; 2],
    messages: Vec<Message>,
    pointed: Option<Picked>,
    is_held: bool,
    shows_help: bool,
    hides_controls: bool,
    /// What the window is called.
    title: String,
    /// What the frames that are shown took, and how large they were.
    shown: Option<(f64, [u32; 2])>,
}

impl std::fmt::Debug for Viewer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Viewer").field("view", &self.view).finish_non_exhaustive()
    }
}

/// Something that is said.
struct Message {
    text: String,
    /// When it goes away by itself, in seconds of egui's clock, if it does.
    until: Option<f64>,
}

/// Seconds for which is said what went well.
const BRIEF_S: f64 = 4.0;

/// Degrees of a step of a turn.
const TURN_STEP: f64 = 0.5;

impl Viewer {
    /// A viewer in a window of egui's, on frames of `source`, that opens what `opener` makes of names.
    pub fn new(
        context: &Context,
        source: Box<dyn FrameSource>,
        opener: Opener,
        wake: Wake,
    ) -> Self {
        ui::dress(context);
        Self {
            opener,
            wake,
            source,
            pacing: Pacing::default(),
            budgets: Vec::new(),
            document: None,
            opening: Opening::default(),
            thumbnail: None,
            is_served: false,
            jobs: Vec::new(),
            panel: Panel::default(),
            files: Files::default(),
            ruler: Ruler::default(),
            panes: Vec::new(),
            textures: Textures::default(),
            view: [960, 720],
            messages: Vec::new(),
            pointed: None,
            is_held: false,
            shows_help: false,
            hides_controls: false,
            title: String::new(),
            shown: None,
        }
    }

    /// What was opened before, the newest first.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn set_recent(&mut self, recent: Vec<std::path::PathBuf>) {
        self.files.recent = recent;
    }

    /// Says something to the user, until that is closed.
    pub fn say(&mut self, text: impl Into<String>) {
        let text = text.into();
        if self.messages.iter().all(|message| message.text != text) {
            self.messages.push(Message { text, until: None });
        }
    }

    /// All that is said now, a line each.
    #[cfg(target_arch = "wasm32")]
    pub(crate) fn says(&self) -> String {
        let messages = self.messages.iter().map(|message| &*message.text);
        let notes = self.document.iter().flat_map(Document::notes).map(|(_, note)| note);
        messages.chain(notes).collect::<Vec<_>>().join("\n")
    }

    fn hear_jobs(&mut self, now: f64) {
        self.hear_opening(now);
        self.open_waiting();
        let done: Vec<_> = self.jobs.iter().map(Job::done).collect();
        let mut is_done = done.iter().map(Option::is_some);
        self.jobs.retain(|_| !is_done.next().unwrap_or(false));
        self.messages.retain(|message| message.until.is_none_or(|until| now < until));
        for result in done.into_iter().flatten() {
            match result {
                Ok(text) => self.messages.push(Message { text, until: Some(now + BRIEF_S) }),
                Err(why) => self.say(why),
            }
        }
    }

    fn hear_frames(&mut self, context: &Context, window: &eframe::Frame) {
        for event in self.source.events() {
            match event {
                Event::Drawn(drawn) if thumbnails::is_thumbnail(drawn.number) => {
                    self.show_thumbnail(context, &drawn);
                }
                Event::Drawn(drawn) => self.show_frame(context, *drawn),
                Event::InTexture(drawn) => self.show_texture(window, drawn),
                Event::Failed { number, .. } if thumbnails::is_thumbnail(number) => {
                    self.panel.thumbnails.came(Some(number), None);
                }
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

    /// Shows a frame that moves where it was drawn.
    fn show_texture(&mut self, window: &eframe::Frame, drawn: DrawnInTexture) {
        let DrawnInTexture { pane: pane_idx, texture, ms, .. } = drawn;
        if !self.pacing.came(pane_idx, drawn.number) || self.panes.len() <= pane_idx {
            return;
        }
        let Some(id) = self.textures.id_of(window, pane_idx, &texture) else { return };
        self.shown = Some((ms, texture.size()));
        self.budgets[pane_idx].took(ms);
        self.panes[pane_idx].set_texture(id, texture);
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

    /// The source draws volumes that are not here: its scene is shown and edited, of which it has the layers,
    /// and nothing else can be opened.
    pub fn set_served(&mut self) {
        self.is_served = true;
        self.panel = Panel::new(true);
    }

    /// The window is called as what is open.
    fn name_window(&mut self, context: &Context) {
        let title = match &self.document {
            Some(document) => format!("{} – slabsplat", document.name),
            None => "slabsplat".to_owned(),
        };
        if self.title != title {
            context.send_viewport_cmd(ViewportCommand::Title(title.clone()));
            self.title = title;
        }
    }

    fn aim(&mut self, viewpoint: Option<Viewpoint>) {
        let Some(document) = &mut self.document else { return };
        document.settle();
        if let Err(error) = document.aim(viewpoint) {
            self.say(error.to_string());
        }
    }

    fn grant_panel(&mut self, wish: PanelWish) {
        wish.refused.into_iter().for_each(|what| self.say(what));
        if wish.adds_layer {
            self.files.ask_layer();
        }
        if let Some(wanted) = wish.channel {
            self.open_channel(wanted);
        }
    }

    /// Asks for pictures of what is shown now.
    fn ask(&mut self, context: &Context) {
        let Some(document) = &mut self.document else { return };
        if self.panel.comparison.is_turning && self.pacing.is_done() {
            document.move_camera(|camera| camera.orbited(TURN_STEP.to_radians()));
        }
        let now = context.input(|input| input.time);
        let is_held = self.is_held || self.panel.comparison.is_turning;
        let comparison = &self.panel.comparison;
        let is_read_back = comparison.is_turning || comparison.shows_difference;
        let asked = self.pacing.step(document.revision(), document.n_panes(), now, is_held);
        for Asked { pane, number, urgency } in asked {
            let opened = document.pane(pane);
            let opened = match urgency {
                Urgency::AtRest => opened,
                Urgency::Moving => self.budgets[pane].preview(opened, self.view),
            };
            self.source.ask(Request { pane, number, opened, urgency, is_read_back });
        }
        if let Some(seconds) = self.pacing.wake_in(now).filter(|_| !is_held) {
            context.request_repaint_after(std::time::Duration::from_secs_f64(seconds));
        }
        let is_brief = |message: &Message| message.until.is_some();
        let has_brief = self.messages.iter().any(is_brief);
        self.ask_thumbnail();
        if !self.pacing.is_done()
            || self.opening.job().is_some()
            || !self.jobs.is_empty()
            || has_brief
        {
            // For progress bars: what is done wakes the window by itself.
            context.request_repaint_after(std::time::Duration::from_millis(100));
        }
    }
}

impl eframe::App for Viewer {
    fn ui(&mut self, ui: &mut Ui, window: &mut eframe::Frame) {
        let context = ui.ctx().clone();
        self.hear_jobs(context.input(|input| input.time));
        self.hear_frames(&context, window);
        self.dropped(&context);
        self.hovered(&context);
        self.keys(&context);
        Bar::top("bar").show(ui, |ui| self.bar(ui));
        Bar::bottom("status").show(ui, |ui| self.status(ui));
        self.name_window(&context);
        if let Some(document) = self.document.as_mut().filter(|_| !self.hides_controls) {
            let panel = Bar::right("controls").default_size(330.0).size_range(330.0..=520.0);
            let wish = panel.show(ui, |ui| self.panel.show(ui, document)).inner;
            self.grant_panel(wish);
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
