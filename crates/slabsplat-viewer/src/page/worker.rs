//! Frames of a worker: a thread of the browser's with a renderer and volumes of its own, so that the page
//! never waits for a frame.

use super::PageSource;
use crate::frames::{Event, FrameSource, Request, Wake};
use crate::handed::{Handed, PictureHead, Said, VolumeHead};
use eframe::wasm_bindgen::closure::Closure;
use eframe::wasm_bindgen::{JsCast, JsValue};
use js_sys::{Array, Float32Array, Uint8Array};
use std::cell::RefCell;
use std::rc::Rc;
use web_sys::{ErrorEvent, MessageEvent, WorkerOptions, WorkerType};

/// What the worker runs; it lies beside the page.
const SCRIPT: &str = "worker.js";

/// A worker that draws.
pub(super) struct Worker {
    worker: web_sys::Worker,
    shared: Rc<RefCell<Shared>>,
    handed: Handed,
    _on_message: Closure<dyn FnMut(MessageEvent)>,
    _on_error: Closure<dyn FnMut(ErrorEvent)>,
}

#[derive(Default)]
struct Shared {
    events: Vec<Event>,
    is_ready: bool,
    /// What is to be said once the worker listens.
    unsaid: Vec<Message>,
    /// What drew the last picture, as scene files call it and as it calls itself.
    drawn_by: Option<[String; 2]>,
    ended: Option<String>,
}

/// What is said to a worker, and which of it is handed over instead of copied.
struct Message {
    what: JsValue,
    transferred: Array,
}

impl Message {
    fn send(&self, worker: &web_sys::Worker) -> Result<(), String> {
        let sent = worker.post_message_with_transfer(&self.what, &self.transferred);
        sent.map_err(|error| format!("the worker takes nothing: {error:?}"))
    }

    fn of_volume(head: &VolumeHead, samples: &[u8], colors: &[u8]) -> Result<Self, String> {
        let head = serde_json::to_string(head).map_err(|error| error.to_string())?;
        let buffer = |bytes: &[u8]| JsValue::from(Uint8Array::from(bytes).buffer());
        let (samples, colors) = (buffer(samples), buffer(colors));
        let transferred = Array::of2(&samples, &colors);
        Ok(Self { what: Array::of3(&head.into(), &samples, &colors).into(), transferred })
    }
}

impl Worker {
    /// Starts one. `wake` is called whenever there are events.
    pub(super) fn start(wake: Wake) -> Result<Self, String> {
        let options = WorkerOptions::new();
        options.set_type(WorkerType::Module);
        let worker = web_sys::Worker::new_with_options(SCRIPT, &options)
            .map_err(|error| format!("the browser starts no worker: {error:?}"))?;
        let shared = Rc::new(RefCell::new(Shared::default()));
        let on_message = {
            let (shared, worker, wake) = (shared.clone(), worker.clone(), wake.clone());
            Closure::<dyn FnMut(MessageEvent)>::new(move |message: MessageEvent| {
                shared.borrow_mut().hear(&message.data(), &worker);
                wake();
            })
        };
        let on_error = {
            let shared = shared.clone();
            Closure::<dyn FnMut(ErrorEvent)>::new(move |event: ErrorEvent| {
                shared.borrow_mut().end(&event);
                wake();
            })
        };
        worker.set_onmessage(Some(on_message.as_ref().unchecked_ref()));
        worker.set_onerror(Some(on_error.as_ref().unchecked_ref()));
        let handed = Handed::default();
        Ok(Self { worker, shared, handed, _on_message: on_message, _on_error: on_error })
    }
}

impl Drop for Worker {
    /// Whatever it draws is given up.
    fn drop(&mut self) {
        self.worker.set_onmessage(None);
        self.worker.set_onerror(None);
        self.worker.terminate();
    }
}

impl FrameSource for Worker {
    fn ask(&mut self, request: Request) {
        let (pane, number) = (request.pane, request.number);
        let mut shared = self.shared.borrow_mut();
        let hand = |head: &VolumeHead, samples: &[u8], colors: &[u8]| {
            let message = Message::of_volume(head, samples, colors)?;
            shared.say(message, &self.worker)
        };
        let asked = self.handed.asked(&request, hand).and_then(|text| {
            let message = Message { what: text.into(), transferred: Array::new() };
            shared.say(message, &self.worker)
        });
        if let Err(why) = asked {
            shared.events.push(Event::Failed { pane, number, why });
        }
    }

    fn events(&mut self) -> Vec<Event> {
        std::mem::take(&mut self.shared.borrow_mut().events)
    }

    fn progress(&self) -> Option<f32> {
        None
    }

    fn drawn_by(&self) -> String {
        match &self.shared.borrow().drawn_by {
            None => String::new(),
            Some([backend, _]) if backend == "cpu" => "CPU".to_owned(),
            Some([_, device]) => format!("WebGPU: {device}"),
        }
    }
}

impl PageSource for Worker {
    fn ended(&self) -> Option<String> {
        self.shared.borrow().ended.clone()
    }

    fn backend(&self) -> Option<String> {
        self.shared.borrow().drawn_by.as_ref().map(|[backend, _]| backend.clone())
    }
}

impl Shared {
    fn say(&mut self, message: Message, worker: &web_sys::Worker) -> Result<(), String> {
        if self.is_ready {
            return message.send(worker);
        }
        self.unsaid.push(message);
        Ok(())
    }

    fn hear(&mut self, data: &JsValue, worker: &web_sys::Worker) {
        let event = match data.as_string() {
            Some(text) => match serde_json::from_str(&text) {
                Ok(Said::Ready) => {
                    self.is_ready = true;
                    let unsaid = std::mem::take(&mut self.unsaid);
                    unsaid.iter().find_map(|message| message.send(worker).err()).map(Event::Note)
                }
                Ok(said) => said.into_event(),
                Err(error) => Some(Event::Note(error.to_string())),
            },
            None => Some(self.picture(data).unwrap_or_else(Event::Note)),
        };
        self.events.extend(event);
    }

    fn picture(&mut self, data: &JsValue) -> Result<Event, String> {
        let parts: &Array = data.dyn_ref().ok_or("the worker sent nothing")?;
        let head = parts.get(0).as_string().unwrap_or_default();
        let head: PictureHead = serde_json::from_str(&head).map_err(|error| error.to_string())?;
        self.drawn_by = Some(head.drawn_by.clone());
        let values = Float32Array::new(&parts.get(1));
        let mut pixels = vec![[0.0_f32; 4]; head.n_pixels()];
        if values.length() as usize != 4 * pixels.len() {
            return Err("the worker sent half a picture".to_owned());
        }
        values.copy_to(bytemuck::cast_slice_mut(&mut pixels));
        Ok(Event::Drawn(Box::new(head.drawn(pixels))))
    }

    fn end(&mut self, event: &ErrorEvent) {
        let why = match event.message() {
            // Browsers do not say what there is instead of a script.
            message if message.is_empty() => format!("is {SCRIPT} beside the page?"),
            message => message,
        };
        let why = format!("what draws stopped: {why}; reload the page");
        self.events.push(Event::Note(why.clone()));
        self.ended = Some(why);
    }
}
