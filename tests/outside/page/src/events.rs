//! What the user does: drags turn the volume, and a file that is dropped shows another one.

use std::cell::RefCell;
use std::error::Error;
use std::rc::Rc;
use std::sync::Arc;

use crate::screen::{Screen, error, say};
use crate::view::View;
use js_sys::{ArrayBuffer, Uint8Array};
use slabsplat::{Volume, io};
use wasm_bindgen::convert::FromWasmAbi;
use wasm_bindgen::prelude::Closure;
use wasm_bindgen::{JsCast, JsValue};
use wasm_bindgen_futures::{JsFuture, spawn_local};
use web_sys::{DragEvent, EventTarget, File, PointerEvent};

/// Radians that a drag over a pixel turns.
const RADIANS_PER_PIXEL: f64 = 0.01;

/// From now on the view is what the user makes of it.
pub(crate) fn listen(screen: &Screen, view: &Rc<RefCell<View>>) -> Result<(), Box<dyn Error>> {
    let canvas = &screen.canvas;
    let turned = view.clone();
    on(canvas, "pointermove", move |event: PointerEvent| {
        if event.buttons() & 1 != 0 {
            let by = [-event.movement_x(), event.movement_y()];
            turned.borrow_mut().turn(by.map(|pixels| f64::from(pixels) * RADIANS_PER_PIXEL));
        }
    })?;
    on(canvas, "dragover", |event: DragEvent| event.prevent_default())?;
    let replaced = view.clone();
    on(canvas, "drop", move |event: DragEvent| {
        event.prevent_default();
        let list = event.data_transfer().and_then(|transfer| transfer.files());
        let files: Vec<File> = list
            .map_or_else(Vec::new, |list| (0..list.length()).filter_map(|i| list.get(i)).collect());
        let view = replaced.clone();
        spawn_local(async move {
            match read(&files).await {
                Ok(volume) => view.borrow_mut().show(volume),
                Err(error) => say(&error.to_string()),
            }
        });
    })
}

/// The volume of files that were dropped together: of a header and the data that it names, or of one.
async fn read(files: &[File]) -> Result<Arc<Volume>, Box<dyn Error>> {
    let mut read = Vec::new();
    for file in files {
        let buffer: ArrayBuffer = JsFuture::from(file.array_buffer()).await.map_err(error)?.into();
        read.push((file.name(), Uint8Array::new(&buffer).to_vec()));
    }
    let in_memory: io::FilesInMemory =
        read.iter().map(|(name, bytes)| (name, &bytes[..])).collect();
    let mut reason = "nothing was dropped".into();
    for (name, _) in &read {
        match in_memory.read_volume(name) {
            Ok(loaded) => return Ok(loaded.volume),
            Err(error) => reason = error.to_string(),
        }
    }
    Err(reason.into())
}

fn on<E: FromWasmAbi + 'static>(
    target: &EventTarget,
    kind: &str,
    act: impl FnMut(E) + 'static,
) -> Result<(), Box<dyn Error>> {
    let act = Closure::<dyn FnMut(E)>::new(act);
    let added = target.add_event_listener_with_callback(kind, act.as_ref().unchecked_ref());
    // It is called for as long as the page is there.
    act.forget();
    added.map_err(|thrown: JsValue| error(thrown))
}
