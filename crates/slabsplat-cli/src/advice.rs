//! What helps where a backend cannot draw a frame: the CPU draws all of them.

use anyhow::{Result, anyhow};
use slabsplat::{
    Acquisition, Caps, Frame, FrameHandle, Method, Picture, PoppingError, PoppingReport,
    RenderError, Renderer, Scene, Sweep, measure_popping,
};

/// Renders a scene's picture, whose frame is watched by its handle.
///
/// # Errors
/// As [`Renderer::picture_as`], with what helps.
pub(crate) fn picture(
    renderer: &mut Renderer,
    scene: &Scene,
    acquisition: Acquisition,
    frame: &FrameHandle,
) -> Result<Picture> {
    let picture = renderer.picture_as(scene, acquisition, frame);
    picture.map_err(|error| of(error, renderer.caps()))
}

/// Renders a frame, which nobody finishes.
///
/// # Errors
/// As [`Renderer::render`], with what helps.
pub(crate) fn render(renderer: &mut Renderer, scene: &Scene) -> Result<Frame> {
    renderer.render(scene).map_err(|error| of(error, renderer.caps()))
}

/// Measures by how much pictures change.
///
/// # Errors
/// As [`measure_popping`], with what helps.
pub(crate) fn popping(
    renderer: &mut Renderer,
    scene: &Scene,
    method: Method,
    sweep: Sweep,
    progress: impl FnMut(),
) -> Result<PoppingReport> {
    measure_popping(renderer, scene, method, sweep, progress).map_err(|error| match error {
        PoppingError::Render(error) => of(error, renderer.caps()),
        error => error.into(),
    })
}

/// An error of a backend, with what helps, if anything does.
pub(crate) fn of(error: RenderError, caps: &Caps) -> anyhow::Error {
    match &error {
        RenderError::Backend(of_backend) if of_backend.is_of_device() && caps.name != "cpu" => {
            anyhow!("{error}: --backend cpu draws it")
        }
        _ => error.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat::{BackendError, PlanError};

    #[test]
    fn advice_where_it_helps() {
        let unable = BackendError::Unable { device: "Fake 3000".into(), reason: "no".into() };
        let [gpu, cpu] = ["wgpu", "cpu"].map(|name| Caps::new(name, "Fake 3000", Method::ALL));
        let check = |error: RenderError, caps: &Caps, expected: &str| {
            assert_eq!(of(error, caps).to_string(), expected);
        };
        let plain = "Fake 3000 cannot make this frame: no";
        check(unable.clone().into(), &gpu, &format!("{plain}: --backend cpu draws it"));
        check(unable.into(), &cpu, plain);
        check(PlanError::NoLayers.into(), &gpu, "the scene has no layers and no meshes");
    }
}
