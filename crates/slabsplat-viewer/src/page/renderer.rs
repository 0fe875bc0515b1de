//! A renderer in the page: by WebGPU where the browser has it, and else by the CPU, on the page's only
//! thread.

use crate::frames::{Drawn, Event, FrameSource, Request, Urgency, Wake};
use eframe::wasm_bindgen::JsValue;
use slabsplat::{FrameHandle, RenderError, Renderer, finished, frame_scene};
use std::cell::RefCell;
use std::rc::Rc;
use wasm_bindgen_futures::{JsFuture, spawn_local};
use web_sys::MessageChannel;
use web_time::Instant;

/// Draws in the page.
pub(super) struct PageRenderer {
    shared: Rc<RefCell<Shared>>,
    backend: String,
    wake: Wake,
}

#[derive(Default)]
struct Shared {
    waiting: Vec<Request>,
    events: Vec<Event>,
    under_way: Option<(FrameHandle, usize, Urgency)>,
    drawn_by: String,
    /// Whether somebody takes what waits.
    is_drawing: bool,
    /// A renderer for each pane; none while it draws.
    renderers: Vec<Option<Renderer>>,
}

impl PageRenderer {
    pub(super) fn open(backend: Option<String>, wake: Wake) -> Self {
        let backend = backend.unwrap_or_else(|| "auto".to_owned());
        Self { shared: Rc::default(), backend, wake }
    }
}

impl FrameSource for PageRenderer {
    fn ask(&mut self, request: Request) {
        let mut shared = self.shared.borrow_mut();
        if let Some((frame, pane, Urgency::AtRest)) = &shared.under_way
            && (*pane == request.pane || request.urgency == Urgency::Moving)
        {
            frame.cancel();
        }
        shared.waiting.retain(|waiting| waiting.pane != request.pane);
        shared.waiting.push(request);
        if !std::mem::replace(&mut shared.is_drawing, true) {
            let (shared, wake) = (self.shared.clone(), self.wake.clone());
            spawn_local(draw_all(shared, self.backend.clone(), wake));
        }
    }

    fn events(&mut self) -> Vec<Event> {
        std::mem::take(&mut self.shared.borrow_mut().events)
    }

    fn progress(&self) -> Option<f32> {
        self.shared.borrow().under_way.as_ref().map(|(frame, ..)| frame.progress())
    }

    fn drawn_by(&self) -> String {
        self.shared.borrow().drawn_by.clone()
    }
}

/// Draws what waits until nothing does. The page has its turn between frames.
async fn draw_all(shared: Rc<RefCell<Shared>>, backend: String, wake: Wake) {
    loop {
        turn_of_page().await;
        let request = {
            let mut shared = shared.borrow_mut();
            if shared.waiting.is_empty() {
                shared.is_drawing = false;
                return;
            }
            shared.waiting.remove(0)
        };
        let (pane, number) = (request.pane, request.number);
        let event = match draw(&shared, &backend, request).await {
            Ok(drawn) => Some(Event::Drawn(Box::new(drawn))),
            Err(why) => why.map(|why| Event::Failed { pane, number, why }),
        };
        let mut shared = shared.borrow_mut();
        shared.under_way = None;
        shared.events.extend(event);
        wake();
    }
}

/// Draws a frame. An error is what is wrong; nothing is, if it was cancelled.
async fn draw(
    shared: &RefCell<Shared>,
    backend: &str,
    request: Request,
) -> Result<Drawn, Option<String>> {
    let mut renderer = taken(shared, backend, request.pane).await.map_err(Some)?;
    let frame = FrameHandle::new();
    shared.borrow_mut().under_way = Some((frame.clone(), request.pane, request.urgency));
    let result = drawn(&mut renderer, &request, &frame).await;
    let mut shared = shared.borrow_mut();
    shared.drawn_by = match renderer.caps().name {
        "cpu" => "CPU".to_owned(),
        _ => format!("WebGPU: {}", renderer.caps().device),
    };
    shared.renderers[request.pane] = Some(renderer);
    result.map_err(|error| (!error.is_cancelled()).then(|| error.to_string()))
}

async fn drawn(
    renderer: &mut Renderer,
    request: &Request,
    frame: &FrameHandle,
) -> Result<Drawn, RenderError> {
    let started = Instant::now();
    let opened = &request.opened;
    renderer.submit_as(&*frame_scene(&opened.scene)?, frame)?;
    let frame = renderer.wait_async(frame).await?;
    let picture = finished(frame, &opened.scene, opened.acquisition);
    Ok(Drawn {
        pane: request.pane,
        number: request.number,
        urgency: request.urgency,
        n_voxels: picture.frame.stats.n_voxels,
        image: picture.frame.image,
        notes: picture.notes,
        ms: Some(started.elapsed().as_secs_f64() * 1e3),
    })
}

/// The renderer of a pane, which is opened if there is none.
async fn taken(shared: &RefCell<Shared>, backend: &str, pane: usize) -> Result<Renderer, String> {
    let known = {
        let renderers = &mut shared.borrow_mut().renderers;
        if renderers.len() <= pane {
            renderers.resize_with(pane + 1, || None);
        }
        renderers[pane].take()
    };
    match known {
        Some(renderer) => Ok(renderer),
        None => Renderer::open_async(backend, |_| {}).await.map_err(|error| error.to_string()),
    }
}

/// Lets the page show what it has. It hears a message to itself before it draws again; a timer may come
/// later, so that the page would be drawn twice for each frame of ours.
pub(crate) async fn turn_of_page() {
    let promise = js_sys::Promise::new(&mut |resolve, _| {
        let Ok(channel) = MessageChannel::new() else { return };
        channel.port1().set_onmessage(Some(&resolve));
        // Nothing is sent but that it is time.
        drop(channel.port2().post_message(&JsValue::NULL));
    });
    drop(JsFuture::from(promise).await);
}
