//! Small pictures by presets, made when nothing else is: their scenes on a thread of their own, the pictures
//! by whoever draws frames, and all of it is given up for a frame that is asked for.

use super::Viewer;
use crate::frames::{Drawn, Request, Urgency};
use crate::jobs::{self, Job};
use crate::state::Thumbnails;
use eframe::egui::{ColorImage, Context, TextureHandle, TextureOptions};
use slabsplat::{Image, OpenScene};

/// Whether the number of a request is of a small picture.
pub(super) fn is_thumbnail(number: u64) -> bool {
    Thumbnails::<TextureHandle>::is_number(number)
}

impl Viewer {
    /// Has the next small picture made, if there is time for that.
    pub(super) fn ask_thumbnail(&mut self) {
        let Some(document) = self.document.as_ref().filter(|_| !self.is_served) else { return };
        let thumbnails = &mut self.panel.thumbnails;
        let is_idle =
            self.pacing.is_whole() && self.opening.job().is_none() && self.jobs.is_empty();
        if !is_idle {
            self.thumbnail = None;
            return thumbnails.give_way();
        }
        if let Some(result) = self.thumbnail.as_ref().and_then(Job::done) {
            self.thumbnail = None;
            match result {
                Ok(opened) => {
                    // A pane of its own has a renderer of its own: what one retains for the next frame is of
                    // no use to other transfer functions.
                    let (pane, urgency) = (document.n_panes(), Urgency::AtRest);
                    let number = thumbnails.asked();
                    let is_read_back = true;
                    let request = number.map(|number| Request {
                        pane,
                        number,
                        opened,
                        urgency,
                        is_read_back,
                    });
                    request.into_iter().for_each(|request| self.source.ask(request));
                }
                Err(_) => thumbnails.came(None, None),
            }
        }
        let layer_idx = self.panel.layer_idx;
        let Some(layer) = document.state().opened.scene.layers.get(layer_idx) else { return };
        thumbnails.are_of(&layer.volume);
        if let Some(preset_idx) = thumbnails.begin_next() {
            let opened = document.layer_alone(layer_idx);
            self.thumbnail = Some(jobs::thumbnail(opened, preset_idx, &self.wake));
        }
    }

    pub(super) fn show_thumbnail(&mut self, context: &Context, drawn: &Drawn) {
        let texture = texture(context, drawn.number, &drawn.image);
        self.panel.thumbnails.came(Some(drawn.number), Some(texture));
    }
}

fn texture(context: &Context, number: u64, image: &Image) -> TextureHandle {
    let size = [image.width() as usize, image.height() as usize];
    let image = ColorImage::from_rgba_unmultiplied(size, &image.to_rgba8());
    context.load_texture(format!("preset {number}"), image, TextureOptions::LINEAR)
}

/// What fits a preset to a layer.
pub(super) type Fitting = Job<OpenScene>;
