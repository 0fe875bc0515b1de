//! What is opened: instead of what is open, or as a further layer of it.

use super::{BRIEF_S, Message, Viewer};
#[cfg(target_arch = "wasm32")]
use crate::frames::Wake;
use crate::jobs::{self, Job};
use crate::state::{Document, are_apart};
use crate::ui::{self, Drop, OpenAs, Panel, Ruler, WantedChannel};
use eframe::egui::{Color32, Context, DroppedFileHandle, FontId, Id, LayerId, Order, Rect};
use std::collections::VecDeque;
use std::path::PathBuf;

/// Seconds for which is said what a volume is taken for.
const FOUND_S: f64 = 12.0;

/// What is being opened, and what waits for its turn.
#[derive(Default)]
pub(super) struct Opening {
    under_way: Option<(OpenAs, Job<Document>)>,
    /// Files that become layers once those before them are.
    waiting: VecDeque<DroppedFileHandle>,
    /// Files that were dropped, of which is asked what is to become of them.
    dropped: Vec<DroppedFileHandle>,
}

impl Opening {
    pub(super) fn job(&self) -> Option<&Job<Document>> {
        self.under_way.as_ref().map(|(_, job)| job)
    }

    /// Gives up what is being opened, and what was to follow.
    pub(super) fn give_up(&mut self) {
        *self = Self::default();
    }

    fn begin(&mut self, opens: OpenAs, job: Job<Document>) {
        self.under_way = Some((opens, job));
    }
}

impl Viewer {
    /// Opens what a job opens, of views of a size.
    #[cfg(target_arch = "wasm32")]
    pub(crate) fn begin(&mut self, job: impl FnOnce([u32; 2], &Wake) -> Job<Document>) {
        let job = job(self.view, &self.wake);
        self.opening.begin(OpenAs::Document, job);
    }

    /// Opens something instead of what is open; `name` is what it is called.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn open(&mut self, name: String, opening: jobs::Opening) {
        let job = jobs::begin(name, opening, self.view, &self.wake);
        self.opening.begin(OpenAs::Document, job);
    }

    /// Opens a file of that name, or in a page what is under that address.
    pub(super) fn open_named(&mut self, opens: OpenAs, path: PathBuf) {
        if self.refuses_files() {
            return;
        }
        self.files.opened(&path);
        let job = jobs::open(self.opener.clone(), path, self.view, &self.wake);
        self.opening.begin(opens, job);
    }

    /// Opens another channel of a layer's file, as a layer.
    pub(super) fn open_channel(&mut self, WantedChannel { layer_idx, channel }: WantedChannel) {
        let Some(document) = &self.document else { return };
        let file = document.file_of_channel(layer_idx, channel);
        let name = document.channel_name(layer_idx, channel);
        #[cfg(not(target_arch = "wasm32"))]
        let job = jobs::open_channel(file, name, self.view, &self.wake);
        #[cfg(target_arch = "wasm32")]
        let job = {
            let bytes = document.bytes_of(layer_idx);
            jobs::open_channel(file, bytes, name, self.view, &self.wake)
        };
        self.opening.begin(OpenAs::Layer, job);
    }

    /// Opens bytes that were chosen in a page.
    #[cfg(target_arch = "wasm32")]
    pub(super) fn open_bytes(&mut self, opens: OpenAs, name: String, bytes: Vec<u8>) {
        if self.refuses_files() {
            return;
        }
        let job = jobs::open_bytes(name, bytes, self.view, &self.wake);
        self.opening.begin(opens, job);
    }

    /// Of other files than the server's it has no voxels to draw.
    fn refuses_files(&mut self) -> bool {
        if self.is_served {
            self.say("this page shows what its server draws: nothing else can be opened in it");
        }
        self.is_served
    }

    pub(super) fn hear_opening(&mut self, now: f64) {
        let Some((opens, job)) = &self.opening.under_way else { return };
        let Some(result) = job.done() else { return };
        let opens = *opens;
        self.opening.under_way = None;
        match (result, opens) {
            (Err(why), _) => self.say(why),
            (Ok(document), OpenAs::Layer) if self.document.is_some() => {
                self.add_layers(&document, now);
            }
            (Ok(document), _) => self.show_document(document, now),
        }
    }

    fn show_document(&mut self, document: Document, now: f64) {
        self.say_what_was_found(&document, now);
        self.document = Some(document);
        self.panes.clear();
        self.pacing.forget();
        self.ruler = Ruler::default();
        self.panel = Panel::new(self.is_served);
    }

    fn add_layers(&mut self, added: &Document, now: f64) {
        self.say_what_was_found(added, now);
        let Some(document) = &mut self.document else { return };
        let is_apart = are_apart(&document.shown().scene, &added.state().opened.scene);
        document.add(added);
        self.panel.layer_idx = document.state().opened.scene.layers.len().saturating_sub(1);
        let name = &added.name;
        let text = if is_apart {
            format!("{name} lies beside what was open: 0 fills the view with all of it")
        } else {
            format!("{name} is a layer now")
        };
        let until = (!is_apart).then_some(now + BRIEF_S);
        self.messages.push(Message { text, until });
    }

    /// What it is taken for is said for a while, and what is doubtful until it is closed.
    fn say_what_was_found(&mut self, document: &Document, now: f64) {
        let opened = &document.state().opened;
        for text in opened.found.iter().cloned() {
            self.messages.push(Message { text, until: Some(now + FOUND_S) });
        }
        opened.warnings.iter().for_each(|what| self.say(what.clone()));
    }

    /// What was dropped onto the window. Where something is open already, Shift makes layers of it, and
    /// without it is asked; systems do not tell of keys while something is dragged from another window.
    pub(super) fn dropped(&mut self, context: &Context) {
        let (dropped, shift) =
            context.input(|input| (input.raw.dropped_files.clone(), input.modifiers.shift));
        if !dropped.is_empty() && !self.refuses_files() {
            self.opening.dropped = dropped;
        }
        let names: Vec<PathBuf> =
            self.opening.dropped.iter().map(|file| file.path().to_owned()).collect();
        if names.is_empty() {
            return;
        }
        let decided = match (&self.document, shift) {
            (None, _) => Some(Drop::Open(OpenAs::Document)),
            (Some(_), true) => Some(Drop::Open(OpenAs::Layer)),
            _ => ui::ask_of_dropped(context, &names),
        };
        let Some(decided) = decided else { return };
        let mut files = std::mem::take(&mut self.opening.dropped);
        match decided {
            Drop::Nothing => {}
            Drop::Open(OpenAs::Layer) => self.opening.waiting.extend(files),
            Drop::Open(OpenAs::Document) => {
                self.open_dropped(OpenAs::Document, &files.swap_remove(0));
            }
        }
    }

    /// Says what becomes of what is held over the window, if it is dropped.
    pub(super) fn hovered(&self, context: &Context) {
        let is_hovered = context.input(|input| !input.raw.hovered_files.is_empty());
        if !is_hovered || self.is_served {
            return;
        }
        let text = match self.document {
            Some(_) => "drop it to open it, or to add it as a layer",
            None => "drop it to open it",
        };
        let layer = LayerId::new(Order::Foreground, Id::unique("hovered"));
        let painter = context.layer_painter(layer);
        let at = context.content_rect().center();
        let font = FontId::proportional(20.0);
        let galley = painter.layout_no_wrap(text.to_owned(), font, Color32::WHITE);
        let rect = Rect::from_center_size(at, galley.size());
        painter.rect_filled(rect.expand(14.0), 6.0, Color32::from_black_alpha(200));
        painter.galley(rect.min, galley, Color32::WHITE);
    }

    /// Opens the next of several files.
    pub(super) fn open_waiting(&mut self) {
        if self.opening.under_way.is_none()
            && let Some(file) = self.opening.waiting.pop_front()
        {
            self.open_dropped(OpenAs::Layer, &file);
        }
    }

    fn open_dropped(&mut self, opens: OpenAs, file: &DroppedFileHandle) {
        let job = jobs::open_dropped(self.opener.clone(), file, self.view, &self.wake);
        self.opening.begin(opens, job);
    }
}
