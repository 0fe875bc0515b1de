//! A page that draws a volume, by WebGPU where the browser has it and by the CPU where it has not.
//!
//! Drag to turn it, drop the file of another one. `cargo xtask web` builds it into `target/web`. Its address
//! may say more: `?backend=cpu`, `?volume=shepp-logan`, `?voxels=32`, `?pixels=96`, `?turn=30` in degrees.
//!
//! [`run`] is what a page needs of slabsplat; `screen` is the canvas and the words below it, `view` what is
//! to be seen, and `events` what the user does.

mod events;
mod screen;
mod view;

use std::cell::RefCell;
use std::error::Error;
use std::rc::Rc;

use screen::{Screen, asked, say};
use slabsplat::Renderer;
use view::View;
use wasm_bindgen::prelude::wasm_bindgen;

/// Called when the page has loaded. It goes on for as long as the page is there.
#[wasm_bindgen(start)]
pub async fn start() {
    if let Err(error) = run().await {
        say(&error.to_string());
    }
}

async fn run() -> Result<(), Box<dyn Error>> {
    let screen = Screen::of_page()?;
    let view = Rc::new(RefCell::new(View::asked_for(&screen)?));
    events::listen(&screen, &view)?;
    let backend = asked("backend").unwrap_or_else(|| "auto".to_owned());
    let mut renderer = Renderer::open_async(&backend, say).await?;
    loop {
        screen.repainted().await?;
        // What the user did meanwhile is in the next frame, and no frame is drawn for nothing.
        let Some(scene) = view.borrow_mut().changed() else { continue };
        let began = screen.now_ms();
        match renderer.render_async(&scene).await {
            Ok(frame) => screen.show(&frame.image, renderer.caps(), screen.now_ms() - began)?,
            Err(error) => say(&error.to_string()),
        }
    }
}
