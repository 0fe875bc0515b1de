//! Sensible defaults for a volume that nobody has described: what is visible, in which colours and light, and
//! from where.
//!
//! Reading order: `statistics`, `scale` and `histogram` (what a look at the values finds), `kind` (what the
//! volume is of), `look`, `hounsfield` and `label_colors` (what that looks like), `studio` (in which light).
//! Where it is seen from is the business of `framing`.

mod histogram;
mod scale;
mod statistics;

mod kind;

mod hounsfield;
mod label_colors;
mod look;

mod studio;

use slabsplat_core::{
    Acquisition, Camera, Fit, Grid, ImageDesc, Layer, Mode, RenderSettings, Scene, Shading,
    TransferFunction, Volume,
};
use std::sync::Arc;

use crate::framing::{Aim, Facing, Framing, usual_projection};

pub use kind::DataKind;
#[cfg(feature = "files")]
pub(crate) use look::DARK;
pub(crate) use look::Look;
#[cfg(feature = "files")]
pub(crate) use statistics::LookedAt;
pub(crate) use studio::{lights, phong};

/// Defaults that fit one volume.
#[derive(Clone, Debug)]
pub struct Automatic {
    layer: Layer,
    look: Look,
    framing: Framing,
}

impl Automatic {
    /// Looks at the volume's values, of which nothing else is known.
    pub fn new(volume: impl Into<Arc<Volume>>) -> Self {
        Self::with_acquisition(volume, Acquisition::default())
    }

    /// Looks at the volume's values, and takes for granted what is known of it beside them, as readers of
    /// files report it.
    pub fn with_acquisition(volume: impl Into<Arc<Volume>>, acquisition: Acquisition) -> Self {
        let volume = volume.into();
        let look = Look::of(&volume, volume.grid(), acquisition);
        let facing = look.facing(volume.grid(), acquisition);
        let layer = look.layer(volume);
        let framing = Framing::new(std::slice::from_ref(&layer), &[], Mode::Extinction, facing);
        Self { layer, look, framing }
    }

    /// What the volume seems to be of.
    pub fn kind(&self) -> DataKind {
        self.look.kind
    }

    /// What was found, in a line for people.
    pub fn description(&self) -> String {
        self.look.description()
    }

    /// What is visible, and in which colours.
    pub fn transfer(&self) -> &TransferFunction {
        &self.layer.transfer
    }

    /// The volume as it is shown, which may hide what is even all around by
    /// [`gradient_opacity`](Layer::gradient_opacity).
    pub fn layer(&self) -> &Layer {
        &self.layer
    }

    /// A background that suits, opaque.
    pub fn background(&self) -> [f32; 4] {
        self.look.background
    }

    /// What its pictures are to hold, for cameras from other sides.
    pub fn framing(&self) -> &Framing {
        &self.framing
    }

    /// A camera before the volume, a little to the side and above, whose picture is filled by what is
    /// visible.
    pub fn camera(&self, image: &ImageDesc, is_perspective: bool) -> Camera {
        let projection = usual_projection(is_perspective);
        let camera = self.framing.camera(None, Fit::Visible, projection, image);
        camera.expect("a grid is not too far from the origin to tell where its voxels are")
    }

    /// The defaults as a whole scene: orthographic, under a lamp and a headlight, before the background that
    /// `image` has.
    pub fn scene(&self, image: ImageDesc, settings: RenderSettings) -> Scene {
        let camera = self.camera(&image, false);
        let mut layer = self.layer.clone();
        if !takes_gradients(&settings) {
            layer.gradient_opacity = None;
        }
        Scene::new(layer, camera).lights(lights(&camera)).image(image).settings(settings)
    }

    /// The same seen as `aim` says.
    ///
    /// # Errors
    /// If numbers do not suffice to tell where the camera is.
    pub fn scene_from(
        &self,
        aim: &Aim,
        image: ImageDesc,
        settings: RenderSettings,
    ) -> Result<Scene, slabsplat_core::CameraError> {
        let scene = self.scene(image, settings);
        let camera = self.framing.aimed(&scene.camera, aim, true, &image)?;
        let lights = lights(&camera);
        Ok(scene.camera(camera).lights(lights))
    }
}

impl Look {
    /// The volume, looking like that.
    pub(crate) fn layer(&self, volume: impl Into<Arc<Volume>>) -> Layer {
        Layer::new(volume, self.transfer.clone())
            .gradient_opacity(self.gradient_opacity.clone())
            .shading(Shading::Phong(phong()))
    }

    /// Which way the volume stands.
    pub(crate) fn facing(&self, grid: &Grid, acquisition: Acquisition) -> Facing {
        let facing = Facing::of(acquisition.orientation, grid);
        if self.kind.is_head(grid) { facing.on_neck() } else { facing }
    }

    /// What was found, in a line for people.
    pub(crate) fn description(&self) -> String {
        format!("{}: {}", self.kind.name(), self.what)
    }
}

/// Whether opacity by gradients can be drawn.
pub(crate) fn takes_gradients(settings: &RenderSettings) -> bool {
    settings.method != slabsplat_core::Method::PostClassified
        && settings.mode.compositing().is_some()
}

#[cfg(test)]
mod tests;
