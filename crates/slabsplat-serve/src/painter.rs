//! Who draws: one renderer on a thread of its own, for all viewers, and who makes files of its pictures.
//!
//! Scenes are texts until it is their turn, so that those that are never drawn cost nothing.

use crate::hub::{Hub, Turn};
use crate::message::{Ask, Encoded, Urgency};
use slabsplat::io::{
    IoError, SceneFile, jpeg_bytes, parse_scene_alone, png_bytes, quick_png_bytes,
};
use slabsplat::{Image, OpenScene, Picture, Renderer, Scene};
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::mpsc::{self, Receiver, SyncSender};
use std::thread::{Builder, JoinHandle};
use std::time::Instant;

/// Of pictures that are seen for a moment.
const JPEG_QUALITY: u8 = 80;

/// What a viewer may ask for at once: pixels, and samples of all of them.
const MAX_PIXELS: u64 = 16 << 20;
const MAX_SAMPLES: u64 = 64 << 20;

/// Draws what viewers of a hub ask for, until that ends, on one thread, and encodes it on another.
pub(crate) fn spawn(
    hub: Arc<Hub>,
    opened: Arc<OpenScene>,
    file: SceneFile,
) -> io::Result<[JoinHandle<()>; 2]> {
    // Who draws waits for who encodes.
    let (sender, pictures) = mpsc::sync_channel(0);
    let of_encoder = hub.clone();
    let encoder = Builder::new().name("slabsplat-serve-pictures".to_owned());
    let encoder = encoder.spawn(move || encode_all(&of_encoder, &pictures))?;
    let painter = Builder::new().name("slabsplat-serve-frames".to_owned());
    let painter = painter.spawn(move || Painter { hub, opened, file }.paint_all(&sender))?;
    Ok([encoder, painter])
}

struct Painter {
    hub: Arc<Hub>,
    opened: Arc<OpenScene>,
    /// The scene as a scene file says it.
    file: SceneFile,
}

/// A picture that is to be encoded.
struct Drawn {
    turn: Turn,
    picture: Picture,
    ms: f64,
}

/// Why there is no picture.
enum NoPicture {
    /// Nobody wants it any more, or not now.
    Cancelled,
    /// For people.
    Failed(String),
}

impl Painter {
    fn paint_all(&self, sender: &SyncSender<Drawn>) {
        let mut renderer = self.open();
        while let Some(turn) = self.hub.next() {
            let started = Instant::now();
            // What panics once would do so again, and the thread goes on.
            let result = catch_unwind(AssertUnwindSafe(|| self.paint(renderer.as_mut(), &turn)));
            self.hub.drawn();
            match result {
                Ok(Ok(picture)) => {
                    let ms = started.elapsed().as_secs_f64() * 1e3;
                    // It ends after this thread.
                    drop(sender.send(Drawn { turn, picture, ms }));
                }
                Ok(Err(NoPicture::Cancelled)) => self.hub.put_off(turn),
                Ok(Err(NoPicture::Failed(why))) => self.hub.done(&turn, &Err(why)),
                Err(_) => {
                    let why = "the renderer stopped in the middle";
                    self.hub.done(&turn, &Err(why.to_owned()));
                    // Nothing is used again that may be half done.
                    renderer = self.open();
                }
            }
        }
    }

    /// A renderer on the scene's backend, or on the CPU where that cannot be had, which is said.
    fn open(&self) -> Option<Renderer> {
        let teller = || {
            let hub = self.hub.clone();
            move |note: &str| hub.tell_all(note)
        };
        let opened = Renderer::open(&self.opened.backend, teller()).or_else(|error| {
            self.hub.tell_all(&format!("{error}; the CPU draws"));
            Renderer::open("cpu", teller())
        });
        opened.inspect_err(|error| self.hub.tell_all(&error.to_string())).ok()
    }

    fn paint(&self, renderer: Option<&mut Renderer>, turn: &Turn) -> Result<Picture, NoPicture> {
        let failed = NoPicture::Failed;
        let renderer = renderer.ok_or_else(|| failed("nothing here can draw".to_owned()))?;
        let shown = self.shown(&turn.ask).map_err(failed)?;
        check_size(&shown.scene).map_err(failed)?;
        let picture = renderer.picture_as(&shown.scene, shown.acquisition, &turn.frame);
        picture.map_err(|error| match error.is_cancelled() {
            true => NoPicture::Cancelled,
            false => failed(error.to_string()),
        })
    }

    /// The scene as a viewer wants it, of the layers that it wants. Viewers have neither meshes nor labels of
    /// voxels, so that meshes are where they are here, and what is not said of their colours and sizes is as
    /// it is here; and so are labels of which nothing is said.
    fn shown(&self, ask: &Ask) -> Result<OpenScene, String> {
        let mut file =
            parse_scene_alone(&ask.scene, "scene.toml").map_err(|error| error.to_string())?;
        let keeps = self.keeps(ask)?;
        for (mesh, here) in file.meshes.iter_mut().zip(&self.file.meshes) {
            let said = std::mem::replace(mesh, here.clone());
            mesh.color = said.color.or(here.color);
            mesh.line_width = said.line_width.or(here.line_width);
            mesh.point_size = said.point_size.or(here.point_size);
        }
        let here = self.file.layers.iter().zip(&keeps).filter(|(_, keeps)| **keeps);
        for (layer, (here, _)) in file.layers.iter_mut().zip(here) {
            layer.labels = layer.labels.take().or_else(|| here.labels.clone());
        }
        self.opened.with_layers(&keeps).shown_as(&file).map_err(|error| error.to_string())
    }

    /// Which layers a viewer wants.
    fn keeps(&self, ask: &Ask) -> Result<Vec<bool>, String> {
        let n_layers = self.file.layers.len();
        let Some(layers) = &ask.layers else { return Ok(vec![true; n_layers]) };
        let mut keeps = vec![false; n_layers];
        for &number in layers {
            let keep = keeps.get_mut(number);
            *keep.ok_or_else(|| format!("there is no layer {number}, counted from 0"))? = true;
        }
        Ok(keeps)
    }
}

fn check_size(scene: &Scene) -> Result<(), String> {
    let [width, height] = [scene.image.width, scene.image.height].map(u64::from);
    let n_pixels = width * height;
    if MAX_PIXELS < n_pixels || MAX_SAMPLES < n_pixels * u64::from(scene.finish.samples) {
        return Err(format!(
            "a picture of {width} x {height} pixels with {} samples each is too large for this server",
            scene.finish.samples
        ));
    }
    Ok(())
}

/// Encodes pictures until no more come.
fn encode_all(hub: &Hub, pictures: &Receiver<Drawn>) {
    for Drawn { turn, picture, ms } in pictures {
        let Picture { frame, notes, .. } = picture;
        let n_voxels = frame.stats.n_voxels;
        let encoding = AssertUnwindSafe(|| encode(&frame.image, turn.ask.urgency));
        let result = match catch_unwind(encoding) {
            Ok(Ok((format, bytes))) => Ok(Encoded { format, bytes, ms, n_voxels, notes }),
            Ok(Err(error)) => Err(error.to_string()),
            Err(_) => Err("the encoder stopped in the middle".to_owned()),
        };
        hub.done(&turn, &result);
    }
}

/// What moves is a JPEG, unless it is one of those that cannot be, as something shines through.
fn encode(image: &Image, urgency: Urgency) -> Result<(&'static str, Vec<u8>), IoError> {
    match urgency {
        Urgency::AtRest => png_bytes(image).map(|bytes| ("png", bytes)),
        Urgency::Moving => jpeg_bytes(image, JPEG_QUALITY)
            .map(|bytes| ("jpeg", bytes))
            .or_else(|_| quick_png_bytes(image).map(|bytes| ("png", bytes))),
    }
}
