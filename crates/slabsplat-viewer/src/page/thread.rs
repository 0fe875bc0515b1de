//! A worker: a thread of the browser's with a memory of its own, in which this program runs once more. What
//! is said to it before it listens waits.

use crate::handed::{Outside, Said};
use eframe::wasm_bindgen::closure::Closure;
use eframe::wasm_bindgen::{JsCast, JsValue};
use js_sys::{Array, Uint8Array};
use serde::Serialize;
use std::cell::RefCell;
use std::rc::Rc;
use web_sys::{ErrorEvent, MessageEvent, WorkerOptions, WorkerType};

/// What workers run; it lies beside the page.
const SCRIPT: &str = "worker.js";

/// What a worker says.
pub(super) enum Heard {
    /// In words.
    Said(Said),
    /// A head, and bytes or numbers.
    Parts(String, Array),
    /// There is nothing to be expected of it any more.
    Ended(String),
}

/// A worker. It ends with this.
pub(super) struct Thread {
    worker: web_sys::Worker,
    shared: Rc<RefCell<Shared>>,
    _on_message: Closure<dyn FnMut(MessageEvent)>,
    _on_error: Closure<dyn FnMut(ErrorEvent)>,
}

#[derive(Default)]
struct Shared {
    is_ready: bool,
    unsaid: Vec<Message>,
}

/// What is said to it, and which of that is handed over instead of copied.
struct Message {
    what: JsValue,
    transferred: Array,
}

impl Thread {
    /// Starts one; `hear` hears what it says.
    pub(super) fn start(hear: impl Fn(Heard) + 'static) -> Result<Self, String> {
        let options = WorkerOptions::new();
        options.set_type(WorkerType::Module);
        let worker = web_sys::Worker::new_with_options(SCRIPT, &options)
            .map_err(|error| format!("the browser starts no worker: {error:?}"))?;
        let shared = Rc::new(RefCell::new(Shared::default()));
        let hear = Rc::new(hear);
        let on_message = {
            let (shared, worker, hear) = (shared.clone(), worker.clone(), hear.clone());
            Closure::<dyn FnMut(MessageEvent)>::new(move |message: MessageEvent| {
                match heard(&message.data()) {
                    Ok(Heard::Said(Said::Ready)) => {
                        if let Err(why) = shared.borrow_mut().begin(&worker) {
                            hear(Heard::Ended(why));
                        }
                    }
                    Ok(heard) => hear(heard),
                    Err(why) => hear(Heard::Said(Said::Note(why))),
                }
            })
        };
        let on_error = Closure::<dyn FnMut(ErrorEvent)>::new(move |event: ErrorEvent| {
            hear(Heard::Ended(why_it_ended(&event)));
        });
        worker.set_onmessage(Some(on_message.as_ref().unchecked_ref()));
        worker.set_onerror(Some(on_error.as_ref().unchecked_ref()));
        Ok(Self { worker, shared, _on_message: on_message, _on_error: on_error })
    }

    /// Says a text.
    pub(super) fn say(&self, text: String) -> Result<(), String> {
        self.send(Message { what: text.into(), transferred: Array::new() })
    }

    /// Says a head with parts of bytes.
    pub(super) fn say_with(&self, head: &impl Serialize, parts: &[&[u8]]) -> Result<(), String> {
        let head = serde_json::to_string(head).map_err(|error| error.to_string())?;
        let what = Array::of1(&head.into());
        let transferred = Array::new();
        for part in parts {
            let buffer = Uint8Array::from(*part).buffer();
            transferred.push(&buffer);
            what.push(&buffer);
        }
        self.send(Message { what: what.into(), transferred })
    }

    fn send(&self, message: Message) -> Result<(), String> {
        let mut shared = self.shared.borrow_mut();
        if shared.is_ready {
            return message.send(&self.worker);
        }
        shared.unsaid.push(message);
        Ok(())
    }
}

impl Drop for Thread {
    /// Whatever it does is given up.
    fn drop(&mut self) {
        self.worker.set_onmessage(None);
        self.worker.set_onerror(None);
        self.worker.terminate();
    }
}

impl Message {
    fn send(&self, worker: &web_sys::Worker) -> Result<(), String> {
        let sent = worker.post_message_with_transfer(&self.what, &self.transferred);
        sent.map_err(|error| format!("the worker takes nothing: {error:?}"))
    }
}

impl Shared {
    fn begin(&mut self, worker: &web_sys::Worker) -> Result<(), String> {
        self.is_ready = true;
        std::mem::take(&mut self.unsaid).iter().try_for_each(|message| message.send(worker))
    }
}

/// What is made of a volume's samples and colours, which are two parts of a message, `first` and the next.
pub(super) fn of_volume<T>(
    parts: &Array,
    first: u32,
    make: impl FnOnce(Outside<'_>, Outside<'_>) -> T,
) -> T {
    let [samples, colors] = [first, first + 1].map(|part| Uint8Array::new(&parts.get(part)));
    let outside = |len: u32, copy_to| Outside { len: len as usize, copy_to };
    make(
        outside(samples.length(), &|into| samples.copy_to(into)),
        outside(colors.length(), &|into| colors.copy_to(into)),
    )
}

fn heard(data: &JsValue) -> Result<Heard, String> {
    if let Some(text) = data.as_string() {
        return serde_json::from_str(&text).map(Heard::Said).map_err(|error| error.to_string());
    }
    let parts: &Array = data.dyn_ref().ok_or("the worker sent nothing")?;
    let head = parts.shift().as_string().ok_or("the worker sent parts of nothing")?;
    Ok(Heard::Parts(head, parts.clone()))
}

fn why_it_ended(event: &ErrorEvent) -> String {
    match event.message() {
        // Browsers do not say what there is instead of a script.
        message if message.is_empty() => format!("is {SCRIPT} beside the page?"),
        message => message,
    }
}
