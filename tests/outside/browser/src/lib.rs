//! Draws the scenes of `scenes.rs` in a browser: `site/test.js` asks for them, and sends what came out to the
//! test that opened the page, `tests/tests/browser.rs`. `cargo xtask web` builds and runs all that.

mod scenes;

use js_sys::Float32Array;
use slabsplat::{Renderer, Scene};
use wasm_bindgen::prelude::wasm_bindgen;

/// The names of the scenes.
#[wasm_bindgen]
pub fn scene_names() -> Vec<String> {
    scenes::all().into_iter().map(|(name, _)| name.to_owned()).collect()
}

/// The names of all shaders.
#[wasm_bindgen]
pub fn shader_names() -> Vec<String> {
    slabsplat_shaders::ALL.iter().map(|shader| shader.name.to_owned()).collect()
}

/// Their sources, in the same order.
#[wasm_bindgen]
pub fn shader_sources() -> Vec<String> {
    slabsplat_shaders::ALL.iter().map(|shader| shader.wgsl.to_owned()).collect()
}

/// Draws scenes by one backend.
#[wasm_bindgen]
pub struct Painter {
    renderer: Renderer,
    scenes: Vec<Scene>,
}

#[wasm_bindgen]
impl Painter {
    /// Opens a backend.
    pub async fn open(backend: String) -> Result<Painter, String> {
        let renderer = Renderer::open_async(&backend, |_| ()).await;
        let scenes = scenes::all().into_iter().map(|(_, scene)| scene).collect();
        Ok(Self { renderer: renderer.map_err(|error| error.to_string())?, scenes })
    }

    /// What it draws on.
    pub fn device(&self) -> String {
        self.renderer.caps().device.clone()
    }

    /// The pixels of a scene: red, green, blue and opacity, premultiplied.
    pub async fn draw(&mut self, scene: usize) -> Result<Float32Array, String> {
        let frame = self.renderer.render_async(&self.scenes[scene]).await;
        let image = frame.map_err(|error| error.to_string())?.image;
        Ok(Float32Array::from(image.pixels().as_flattened()))
    }

    /// Why a scene cannot be waited for; nothing if it can.
    pub fn refusal(&mut self, scene: usize) -> String {
        let result = self.renderer.render(&self.scenes[scene]);
        result.map_or_else(|error| error.to_string(), |_| String::new())
    }
}
