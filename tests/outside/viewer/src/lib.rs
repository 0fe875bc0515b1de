//! The viewer as a page: all of it is [`slabsplat_viewer::show_in_page`].
//!
//! `cargo xtask web` builds it into `target/web/viewer`, a folder that any server of files shows:
//! `python3 -m http.server -d target/web/viewer`. `slabsplat serve` shows it too, and draws its frames.

#![cfg(target_arch = "wasm32")]

use wasm_bindgen::prelude::{JsCast, JsValue, wasm_bindgen};
use web_sys::HtmlCanvasElement;

/// Called in the page's worker.
///
/// # Errors
/// If it is called elsewhere.
#[wasm_bindgen]
pub fn work() -> Result<(), JsValue> {
    Ok(slabsplat_viewer::work_for_page()?)
}

/// Called when the page has loaded.
///
/// # Errors
/// If the page has no canvas, or the browser draws nothing in it.
#[wasm_bindgen]
pub async fn view(canvas_id: &str) -> Result<(), JsValue> {
    let document = web_sys::window().and_then(|window| window.document());
    let canvas = document.and_then(|document| document.get_element_by_id(canvas_id));
    let canvas: HtmlCanvasElement = canvas.ok_or("there is no canvas")?.dyn_into()?;
    Ok(slabsplat_viewer::show_in_page(canvas).await?)
}
