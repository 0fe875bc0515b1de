//! Frames of a server, by a WebSocket: scenes go there as text, pictures come back as files.

use super::{PageSource, address};
use crate::frames::{Event, FrameSource, Request, Wake};
use crate::received::{Answer, drawn_of, request_text};
use eframe::wasm_bindgen::JsCast;
use eframe::wasm_bindgen::closure::Closure;
use js_sys::{ArrayBuffer, Uint8Array};
use std::cell::RefCell;
use std::rc::Rc;
use web_sys::{BinaryType, CloseEvent, MessageEvent, WebSocket};

/// A server that draws.
pub(super) struct Remote {
    socket: WebSocket,
    shared: Rc<RefCell<Shared>>,
    _on_message: Closure<dyn FnMut(MessageEvent)>,
    _on_open: Closure<dyn FnMut()>,
    _on_close: Closure<dyn FnMut(CloseEvent)>,
}

#[derive(Default)]
struct Shared {
    events: Vec<Event>,
    /// What is to be said once the server listens.
    unsaid: Vec<String>,
}

impl Remote {
    pub(super) fn connect(token: &str, wake: Wake) -> Result<Self, String> {
        let address = address::beside("ws", &format!("frames?token={token}"));
        let address = address.ok_or("the page has no address")?;
        let socket = WebSocket::new(&address).map_err(|error| format!("{error:?}"))?;
        socket.set_binary_type(BinaryType::Arraybuffer);
        let shared = Rc::new(RefCell::new(Shared::default()));
        let on_message = {
            let (shared, wake) = (shared.clone(), wake.clone());
            Closure::<dyn FnMut(MessageEvent)>::new(move |message: MessageEvent| {
                shared.borrow_mut().events.extend(event_of(&message));
                wake();
            })
        };
        let on_open = {
            let (shared, socket) = (shared.clone(), socket.clone());
            Closure::<dyn FnMut()>::new(move || {
                let unsaid = std::mem::take(&mut shared.borrow_mut().unsaid);
                unsaid.iter().for_each(|text| drop(socket.send_with_str(text)));
            })
        };
        let on_close = {
            let shared = shared.clone();
            Closure::<dyn FnMut(CloseEvent)>::new(move |event: CloseEvent| {
                let why = match event.reason() {
                    reason if reason.is_empty() => "reload the page once it is there".to_owned(),
                    reason => reason,
                };
                let note = format!("the server draws no more: {why}");
                shared.borrow_mut().events.push(Event::Note(note));
                wake();
            })
        };
        socket.set_onmessage(Some(on_message.as_ref().unchecked_ref()));
        socket.set_onopen(Some(on_open.as_ref().unchecked_ref()));
        socket.set_onclose(Some(on_close.as_ref().unchecked_ref()));
        Ok(Self { socket, shared, _on_message: on_message, _on_open: on_open, _on_close: on_close })
    }
}

impl PageSource for Remote {
    fn ended(&self) -> Option<String> {
        match self.socket.ready_state() {
            WebSocket::CONNECTING | WebSocket::OPEN => None,
            _ => Some("the server has no room for one more picture".to_owned()),
        }
    }

    /// It does not say.
    fn backend(&self) -> Option<String> {
        None
    }
}

impl Drop for Remote {
    /// Nothing is heard any more, and the server has room for another.
    fn drop(&mut self) {
        self.socket.set_onmessage(None);
        self.socket.set_onopen(None);
        self.socket.set_onclose(None);
        // It may be closed already.
        drop(self.socket.close());
    }
}

fn event_of(message: &MessageEvent) -> Option<Event> {
    let data = message.data();
    if let Some(text) = data.as_string() {
        return Answer::of_text(&text).map(Answer::into_event);
    }
    let bytes = Uint8Array::new(data.dyn_ref::<ArrayBuffer>()?).to_vec();
    Some(match drawn_of(&bytes) {
        Ok(drawn) => Event::Drawn(Box::new(drawn)),
        Err(why) => Event::Note(why),
    })
}

impl FrameSource for Remote {
    fn ask(&mut self, request: Request) {
        let (pane, number) = (request.pane, request.number);
        let mut shared = self.shared.borrow_mut();
        match request_text(&request) {
            Ok(text) if self.socket.ready_state() == WebSocket::CONNECTING => {
                shared.unsaid.push(text);
            }
            Ok(text) => drop(self.socket.send_with_str(&text)),
            Err(why) => shared.events.push(Event::Failed { pane, number, why }),
        }
    }

    fn events(&mut self) -> Vec<Event> {
        std::mem::take(&mut self.shared.borrow_mut().events)
    }

    fn progress(&self) -> Option<f32> {
        None
    }

    fn drawn_by(&self) -> String {
        "drawn by the server".to_owned()
    }
}
