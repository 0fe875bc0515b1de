//! What stands in for the paper's volumes: the MRI of a head, and the nerve cell, neither of which is ours to
//! give. Both are built in, so that nobody needs a file.

use anyhow::Result;
use slabsplat::glam::DVec3;
use slabsplat::{
    Camera, ImageDesc, Layer, Phong, Projection, RenderSettings, Scene, Shading, TransferFunction,
    Volume, io,
};

/// A built-in volume and how it is shown.
#[derive(Clone, Copy)]
pub(super) struct StandIn {
    /// Its name among the built-in volumes.
    pub(super) builtin: &'static str,
    /// What is invisible up to which value, and opaque from which on.
    opacity: [f64; 2],
    /// World units in the height of the picture, over the volume's side.
    view_height: f64,
}

/// The phantom of Shepp and Logan, for the brain.
pub(super) const HEAD: StandIn =
    StandIn { builtin: "shepp-logan", opacity: [38.0, 60.0], view_height: 0.98 };

/// A nerve cell that grew by rules, for the paper's.
pub(super) const NERVE_CELL: StandIn =
    StandIn { builtin: "neuron", opacity: [15.0, 110.0], view_height: 1.0 };

impl StandIn {
    pub(super) fn volume(&self, side_voxels: usize) -> Result<Volume> {
        Ok(io::builtin_volume(self.builtin, Some(side_voxels))?)
    }

    /// The volume from the level, with a headlight; at 45° the grid's slices change their axis.
    pub(super) fn scene(
        &self,
        volume: Volume,
        side_pixels: u32,
        settings: RenderSettings,
    ) -> Result<Scene> {
        let side = volume.grid().dims()[0] as f64;
        let [invisible, opaque] = self.opacity;
        let opacity = vec![(invisible, [0.0]), (opaque, [1.0])];
        let transfer = TransferFunction::new(opacity, vec![(0.0, [1.0; 3])])?;
        let projection = Projection::Orthographic { view_height: self.view_height * side };
        let camera = Camera::new(-4.0 * side * DVec3::Y, DVec3::ZERO, DVec3::Z, projection)?;
        let phong = Phong::default()
            .ambient(0.1)
            .diffuse(0.8)
            .specular(0.1)
            .shininess(20.0)
            .zero_gradient(0.0)
            .two_sided(false)
            .checked()?;
        let image = ImageDesc::new(side_pixels, side_pixels).background([0.0, 0.0, 0.0, 1.0]);
        let layer = Layer::new(volume, transfer).shading(Shading::Phong(phong));
        Ok(Scene::new(layer, camera).image(image).settings(settings))
    }
}

/// The scene with its camera turned about the volume.
pub(super) fn turned(scene: &Scene, degrees: f64) -> Scene {
    scene.clone().camera(scene.camera.orbited(degrees.to_radians()))
}
