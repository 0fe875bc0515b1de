//! A picture by a backend of the project, for tests that judge it.

use slabsplat::{Image, Renderer, Scene, Volume, backend_named};

/// The names of the backends that every test runs on.
pub const BACKENDS: &[&str] = &["cpu"];

/// Renders a frame.
///
/// # Panics
/// If there is no such backend, or the scene is not valid.
pub fn render(backend: &str, volume: &Volume, scene: &Scene) -> Image {
    let backend = backend_named(backend).expect("tests only name backends that there are");
    let mut renderer = Renderer::new(volume.clone(), backend);
    renderer.render(scene).expect("scenes of tests are valid").image
}
