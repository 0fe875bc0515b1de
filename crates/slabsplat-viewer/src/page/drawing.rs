//! What a worker does: it reads files for its page, or draws what that asks for, by WebGPU where the browser
//! has it, and else by the CPU.

use super::thread::of_volume;
use crate::frames::Urgency;
use crate::handed::{Asked, PictureHead, Said, Volumes, WithBytes};
use crate::read_elsewhere::{LoadedHead, ToRead, parts_of};
use crate::received::Header;
use eframe::wasm_bindgen::closure::Closure;
use eframe::wasm_bindgen::{JsCast, JsValue};
use js_sys::{Array, Float32Array, Uint8Array};
use serde::Serialize;
use slabsplat::{FrameHandle, OpenScene, Picture, RenderError, Renderer, finished, frame_scene};
use std::cell::RefCell;
use std::rc::Rc;
use wasm_bindgen_futures::{JsFuture, spawn_local};
use web_sys::{DedicatedWorkerGlobalScope, MessageChannel, MessageEvent};
use web_time::Instant;

/// Reads and draws for the page that started the worker in which this is called, for as long as both are
/// there.
///
/// # Errors
/// If this is no worker.
pub fn work_for_page() -> Result<(), String> {
    let scope: Result<DedicatedWorkerGlobalScope, _> = js_sys::global().dyn_into();
    let scope = scope.map_err(|_| "this is no worker")?;
    let drawing = Drawing { scope: scope.clone(), shared: Rc::default() };
    let of_messages = drawing.clone();
    let on_message = Closure::<dyn FnMut(MessageEvent)>::new(move |message: MessageEvent| {
        if let Err(why) = of_messages.hear(&message.data()) {
            say(&Said::Note(why));
        }
    });
    scope.set_onmessage(Some(on_message.as_ref().unchecked_ref()));
    // It is there until the worker ends.
    on_message.forget();
    say(&Said::Ready);
    Ok(())
}

/// What all of the worker's tasks have.
#[derive(Clone)]
struct Drawing {
    scope: DedicatedWorkerGlobalScope,
    shared: Rc<RefCell<Shared>>,
}

#[derive(Default)]
struct Shared {
    volumes: Volumes,
    /// The newest request of each pane, the oldest first.
    waiting: Vec<Asked>,
    under_way: Option<(FrameHandle, usize, Urgency)>,
    /// Whether somebody takes what waits.
    is_drawing: bool,
    /// A renderer for each pane, and what it was asked for as; none while it draws.
    renderers: Vec<Option<(String, Renderer)>>,
}

impl Drawing {
    fn hear(&self, data: &JsValue) -> Result<(), String> {
        let Some(text) = data.as_string() else {
            let parts: &Array = data.dyn_ref().ok_or("the page sent nothing")?;
            let head = parts.get(0).as_string().unwrap_or_default();
            return match serde_json::from_str(&head).map_err(|error| error.to_string())? {
                WithBytes::Volume(head) => of_volume(parts, 1, |samples, colors| {
                    self.shared.borrow_mut().volumes.add(&head, samples, colors)
                }),
                WithBytes::ToRead(to_read) => self.read(to_read, parts),
            };
        };
        let asked: Asked = serde_json::from_str(&text).map_err(|error| error.to_string())?;
        let mut shared = self.shared.borrow_mut();
        shared.ask(asked);
        if !std::mem::replace(&mut shared.is_drawing, true) {
            spawn_local(self.clone().draw_all());
        }
        Ok(())
    }

    /// Reads a file, and sends what was read, or why nothing is.
    fn read(&self, to_read: ToRead, parts: &Array) -> Result<(), String> {
        let bytes = Uint8Array::new(&parts.get(1)).to_vec();
        let hear = |share| say(&Said::Read(share));
        match to_read.read(&bytes, hear) {
            Ok(loaded) => {
                let head = LoadedHead::of(&loaded);
                let [samples, colors] =
                    parts_of(&loaded).map(|part| JsValue::from(Uint8Array::from(part).buffer()));
                self.send(&head, &[samples, colors])
            }
            Err(why) => {
                say(&Said::NotRead(why));
                Ok(())
            }
        }
    }

    /// Draws what waits until nothing does. Messages are heard between frames.
    async fn draw_all(self) {
        loop {
            turn_of_others().await;
            let asked = {
                let mut shared = self.shared.borrow_mut();
                if shared.waiting.is_empty() {
                    shared.is_drawing = false;
                    return;
                }
                shared.waiting.remove(0)
            };
            let (pane, number) = (asked.pane, asked.number);
            if let Err(Some(why)) = self.draw(asked).await {
                say(&Said::Failed { pane, number, why });
            }
            self.shared.borrow_mut().under_way = None;
        }
    }

    /// Draws a frame, and sends it. An error is what is wrong; nothing is, if it was cancelled.
    async fn draw(&self, asked: Asked) -> Result<(), Option<String>> {
        let opened = self.shared.borrow_mut().volumes.scene(&asked).map_err(Some)?;
        let mut renderer = self.renderer(asked.pane, &asked.backend).await.map_err(Some)?;
        let frame = FrameHandle::new();
        self.shared.borrow_mut().under_way = Some((frame.clone(), asked.pane, asked.urgency()));
        let started = Instant::now();
        let result = drawn(&mut renderer, &opened, &frame).await;
        let ms = started.elapsed().as_secs_f64() * 1e3;
        let sent = match &result {
            Ok(picture) => self.send_picture(&asked, picture, &renderer, ms).map_err(Some),
            Err(error) => Err((!error.is_cancelled()).then(|| error.to_string())),
        };
        self.shared.borrow_mut().renderers[asked.pane] = Some((asked.backend, renderer));
        sent
    }

    /// The renderer of a pane, which is opened if there is none. Where a scene names what browsers do not
    /// have, what they have draws it.
    async fn renderer(&self, pane: usize, backend: &str) -> Result<Renderer, String> {
        let known = {
            let renderers = &mut self.shared.borrow_mut().renderers;
            if renderers.len() <= pane {
                renderers.resize_with(pane + 1, || None);
            }
            renderers[pane].take()
        };
        if let Some((_, renderer)) = known.filter(|(of, _)| of == backend) {
            return Ok(renderer);
        }
        match Renderer::open_async(backend, |_| {}).await {
            Ok(renderer) => Ok(renderer),
            Err(error) => {
                say(&Said::Note(format!("{error}; the browser draws as it can")));
                Renderer::open_async("auto", |_| {}).await.map_err(|error| error.to_string())
            }
        }
    }

    fn send_picture(
        &self,
        asked: &Asked,
        Picture { frame, notes, .. }: &Picture,
        renderer: &Renderer,
        ms: f64,
    ) -> Result<(), String> {
        let as_asked = (asked.pane, asked.number, asked.urgency());
        let caps = renderer.caps();
        let head = PictureHead {
            header: Header::of(as_asked, ms, frame.stats.n_voxels, notes.clone()),
            size: [frame.image.width(), frame.image.height()],
            drawn_by: [caps.name.to_owned(), caps.device.clone()],
        };
        let pixels: &[f32] = bytemuck::cast_slice(frame.image.pixels());
        self.send(&head, &[Float32Array::from(pixels).buffer().into()])
    }

    /// A head, and parts that are handed over.
    fn send(&self, head: &impl Serialize, parts: &[JsValue]) -> Result<(), String> {
        let head = serde_json::to_string(head).map_err(|error| error.to_string())?;
        let transferred = parts.iter().collect::<Array>();
        let message = Array::of1(&head.into()).concat(&transferred);
        let sent = self.scope.post_message_with_transfer(&message, &transferred);
        sent.map_err(|error| format!("the page takes nothing: {error:?}"))
    }
}

/// Tells the page, from wherever it is that something is to be said.
fn say(said: &Said) {
    let scope: Result<DedicatedWorkerGlobalScope, _> = js_sys::global().dyn_into();
    let text = serde_json::to_string(said).unwrap_or_default();
    // There is nobody else to tell.
    drop(scope.map(|scope| scope.post_message(&text.into())));
}

impl Shared {
    /// What is asked for replaces what its pane was asked for and has not begun; a picture that is only made
    /// better is given up for whatever is newer.
    fn ask(&mut self, asked: Asked) {
        if let Some((frame, pane, Urgency::AtRest)) = &self.under_way
            && (*pane == asked.pane || asked.urgency() == Urgency::Moving)
        {
            frame.cancel();
        }
        self.waiting.retain(|waiting| waiting.pane != asked.pane);
        self.waiting.push(asked);
    }
}

async fn drawn(
    renderer: &mut Renderer,
    opened: &OpenScene,
    frame: &FrameHandle,
) -> Result<Picture, RenderError> {
    renderer.submit_as(&*frame_scene(&opened.scene)?, frame)?;
    let frame = renderer.wait_async(frame).await?;
    Ok(finished(frame, &opened.scene, opened.acquisition))
}

/// Lets others have a turn: what is heard, and in a page what is shown. A message to oneself comes at once,
/// a timer may come later.
pub(crate) async fn turn_of_others() {
    let promise = js_sys::Promise::new(&mut |resolve, _| {
        let Ok(channel) = MessageChannel::new() else { return };
        channel.port1().set_onmessage(Some(&resolve));
        // Nothing is sent but that it is time.
        drop(channel.port2().post_message(&JsValue::NULL));
    });
    drop(JsFuture::from(promise).await);
}
