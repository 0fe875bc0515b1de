//! Frames of a worker, which has a renderer and volumes of its own, so that the page never waits for a frame.

use super::PageSource;
use super::thread::{Heard, Thread};
use crate::frames::{Event, FrameSource, Request, Wake};
use crate::handed::{Handed, PictureHead, VolumeHead, WithBytes};
use js_sys::{Array, Float32Array};
use std::cell::RefCell;
use std::rc::Rc;

/// A worker that draws.
pub(super) struct Worker {
    thread: Thread,
    shared: Rc<RefCell<Shared>>,
    handed: Handed,
}

#[derive(Default)]
struct Shared {
    events: Vec<Event>,
    /// What drew the last picture, as scene files call it and as it calls itself.
    drawn_by: Option<[String; 2]>,
    ended: Option<String>,
}

impl Worker {
    /// Starts one. `wake` is called whenever there are events.
    pub(super) fn start(wake: Wake) -> Result<Self, String> {
        let shared = Rc::new(RefCell::new(Shared::default()));
        let of_thread = shared.clone();
        let thread = Thread::start(move |heard| {
            of_thread.borrow_mut().hear(heard);
            wake();
        })?;
        Ok(Self { thread, shared, handed: Handed::default() })
    }
}

impl FrameSource for Worker {
    fn ask(&mut self, request: Request) {
        let (pane, number) = (request.pane, request.number);
        let thread = &self.thread;
        let hand = |head: VolumeHead, samples: &[u8], colors: &[u8]| {
            thread.say_with(&WithBytes::Volume(head), &[samples, colors])
        };
        let asked = self.handed.asked(&request, hand).and_then(|text| thread.say(text));
        if let Err(why) = asked {
            self.shared.borrow_mut().events.push(Event::Failed { pane, number, why });
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
    fn hear(&mut self, heard: Heard) {
        let event = match heard {
            Heard::Said(said) => said.into_event(),
            Heard::Parts(head, parts) => {
                Some(self.picture(&head, &parts).unwrap_or_else(Event::Note))
            }
            Heard::Ended(why) => {
                let why = format!("what draws stopped: {why}; reload the page");
                self.ended = Some(why.clone());
                Some(Event::Note(why))
            }
        };
        self.events.extend(event);
    }

    fn picture(&mut self, head: &str, parts: &Array) -> Result<Event, String> {
        let head: PictureHead = serde_json::from_str(head).map_err(|error| error.to_string())?;
        self.drawn_by = Some(head.drawn_by.clone());
        let values = Float32Array::new(&parts.get(0));
        let mut pixels = vec![[0.0_f32; 4]; head.n_pixels()];
        if values.length() as usize != 4 * pixels.len() {
            return Err("the worker sent half a picture".to_owned());
        }
        values.copy_to(bytemuck::cast_slice_mut(&mut pixels));
        Ok(Event::Drawn(Box::new(head.drawn(pixels))))
    }
}
