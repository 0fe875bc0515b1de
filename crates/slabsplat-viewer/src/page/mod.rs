//! The viewer in a page of a browser: on files that are dropped there, nothing of which is sent anywhere, or
//! on frames of a server.
//!
//! The page's address may say `?url=` of a volume, `?scene=` of a scene file, `?builtin=` a built-in volume,
//! `?backend=` what draws, and `?token=` that a server draws.
//!
//! Reading order: `address` and `fetch` (what the page asks for), `thread` (a worker), `reading` (files that
//! one reads), `worker` (frames that one draws), `drawing` (what workers do), `remote` (frames of a server),
//! `pictures` (what is saved), `aloud` (messages as text).

mod address;
mod aloud;
mod drawing;
mod fetch;
mod pictures;
mod reading;
mod remote;
mod thread;
mod worker;

pub(crate) use address::{backend, token};
pub(crate) use drawing::turn_of_others;
pub use drawing::work_for_page;
pub(crate) use fetch::{bytes_of, download};
pub(crate) use pictures::Pictures;
pub(crate) use reading::read;

use crate::app::Viewer;
use crate::frames::{FrameSource, Wake};
use crate::jobs;
use eframe::wasm_bindgen::JsValue;
use std::sync::Arc;
use web_sys::HtmlCanvasElement;

/// Shows the viewer in a canvas, for as long as the page is there. What it says to its user is also the text
/// of the element `said`, if the page has one, for those who cannot read it in the canvas.
///
/// Files are read and frames are drawn by workers, unless a server draws them: `worker.js` beside the page, a
/// module, loads this program, too, and calls [`work_for_page`].
///
/// # Errors
/// If the browser draws nothing in it, in a sentence for people.
pub async fn show_in_page(canvas: HtmlCanvasElement) -> Result<(), String> {
    get_context(&canvas).map_err(|error| format!("the browser draws nothing: {error:?}"))?;
    let options = eframe::WebOptions { dithering: false, ..eframe::WebOptions::default() };
    let create = |context: &eframe::CreationContext<'_>| {
        let app: Box<dyn eframe::App> = Box::new(aloud::Aloud::new(viewer(&context.egui_ctx)?));
        Ok(app)
    };
    let started = eframe::WebRunner::new().start(canvas, options, Box::new(create)).await;
    started.map_err(|error| format!("the browser draws nothing: {error:?}"))
}

/// Asks for the context that egui then finds, as the first who asks decides what it is like: egui smooths
/// edges itself, and nothing is to be seen through the canvas.
fn get_context(canvas: &HtmlCanvasElement) -> Result<(), JsValue> {
    let options = js_sys::Object::new();
    for name in ["antialias", "alpha"] {
        js_sys::Reflect::set(&options, &name.into(), &false.into())?;
    }
    canvas.get_context_with_context_options("webgl2", &options).map(drop)
}

fn viewer(egui: &eframe::egui::Context) -> Result<Viewer, String> {
    let of_wake = egui.clone();
    let wake: Wake = Arc::new(move || of_wake.request_repaint());
    let source = source(wake.clone())?;
    let mut viewer = Viewer::new(egui, source, jobs::opener(), wake);
    if let Some(token) = token() {
        viewer.set_served();
        viewer.begin(|size, wake| jobs::open_session(token, size, wake));
    } else if let Some(url) = address::parameter("scene").or_else(|| address::parameter("url")) {
        viewer.begin(|size, wake| jobs::open(jobs::opener(), url.into(), size, wake));
    } else {
        let name = address::parameter("builtin").unwrap_or_else(|| "neuron".to_owned());
        viewer.begin(|size, wake| jobs::open_builtin(name, size, wake));
    }
    Ok(viewer)
}

/// Where a page's frames come from.
pub(crate) trait PageSource: FrameSource {
    /// Why there will be no more frames, if so.
    fn ended(&self) -> Option<String>;

    /// What drew the last one, as scene files call it, if that is known.
    fn backend(&self) -> Option<String>;
}

/// The server that the address names, or a worker.
fn source(wake: Wake) -> Result<Box<dyn PageSource>, String> {
    Ok(match token() {
        Some(token) => Box::new(remote::Remote::connect(&token, wake)?),
        None => Box::new(worker::Worker::start(wake)?),
    })
}
