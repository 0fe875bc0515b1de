//! Everything that decides a pixel ([`model`](crate::model)).

use crate::{Camera, Finish, ImageDesc, Layer, Light, MeshLayer, RenderSettings};

/// A picture to be made of one thing or several.
///
/// What is visible and from where has no default that fits every volume; the facade's `Automatic` finds
/// both for one. Everything else has, and a method of the same name to set it:
///
/// ```
/// use slabsplat_core::{
///     Camera, Grid, ImageDesc, Layer, Projection, RenderSettings, Scaling, Scene, TransferFunction, Volume,
/// };
///
/// let grid = Grid::with_spacing([2, 2, 1], [1.0, 1.0, 2.5])?;
/// let volume = Volume::new(grid, vec![0_u8, 10, 20, 30].into(), Scaling::IDENTITY)?;
/// let transfer = TransferFunction::new([(0.0, 0.0), (255.0, 0.9)], [(0.0, [1.0; 3])])?;
/// let projection = Projection::Orthographic { view_height: 40.0 };
/// let camera = Camera::new([90.0, 0.0, 0.0], [0.0; 3], [0.0, 0.0, 1.0], projection)?;
/// let scene = Scene::new(Layer::new(volume, transfer), camera)
///     .image(ImageDesc::new(64, 64))
///     .settings(RenderSettings::default().slab_width(0.5));
/// assert_eq!(scene.settings.tolerance, RenderSettings::default().tolerance);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Scene {
    /// What is seen. All that lies in a slab is summed before anything is composited, so that the order of
    /// layers has no meaning ([model §10](crate::model)).
    pub layers: Vec<Layer>,
    /// Opaque surfaces among them ([model §14](crate::model)), in any order. There may be no layers
    /// beside them.
    pub meshes: Vec<MeshLayer>,
    /// Where they are seen from.
    pub camera: Camera,
    /// What shines on all of them; without a light there is what is ambient.
    pub lights: Vec<Light>,
    /// Size and background of the picture.
    pub image: ImageDesc,
    /// How it is made.
    pub settings: RenderSettings,
    /// What becomes of the frame before it is a picture. What a backend draws has nothing of it.
    pub finish: Finish,
}

impl Scene {
    /// A layer, seen by `camera` under a headlight; the picture and how it is made as by default.
    pub fn new(layer: Layer, camera: Camera) -> Self {
        Self {
            layers: vec![layer],
            meshes: Vec::new(),
            camera,
            lights: vec![Light::default()],
            image: ImageDesc::default(),
            settings: RenderSettings::default(),
            finish: Finish::default(),
        }
    }

    /// Meshes alone, seen by `camera`; all else as by default.
    pub fn of_meshes(meshes: Vec<MeshLayer>, camera: Camera) -> Self {
        Self {
            layers: Vec::new(),
            meshes,
            camera,
            lights: vec![Light::default()],
            image: ImageDesc::default(),
            settings: RenderSettings::default(),
            finish: Finish::default(),
        }
    }

    /// The premultiplied background at a part of the picture's height, from 0 at its upper edge to 1.
    pub fn background_at(&self, part: f32) -> [f32; 4] {
        let above = self.image.premultiplied_background();
        let Some(below) = self.finish.background_below else { return above };
        let below = self.image.background(below).premultiplied_background();
        std::array::from_fn(|channel| above[channel] * (1.0 - part) + below[channel] * part)
    }

    /// The same of other layers.
    #[must_use]
    pub fn layers(self, layers: Vec<Layer>) -> Self {
        Self { layers, ..self }
    }

    /// The same with other meshes.
    #[must_use]
    pub fn meshes(self, meshes: Vec<MeshLayer>) -> Self {
        Self { meshes, ..self }
    }

    /// The same from elsewhere.
    #[must_use]
    pub fn camera(self, camera: Camera) -> Self {
        Self { camera, ..self }
    }

    /// The same in another light.
    #[must_use]
    pub fn lights(self, lights: Vec<Light>) -> Self {
        Self { lights, ..self }
    }

    /// The same in another size, or before another background.
    #[must_use]
    pub fn image(self, image: ImageDesc) -> Self {
        Self { image, ..self }
    }

    /// The same made otherwise.
    #[must_use]
    pub fn settings(self, settings: RenderSettings) -> Self {
        Self { settings, ..self }
    }

    /// The same finished otherwise.
    #[must_use]
    pub fn finish(self, finish: Finish) -> Self {
        Self { finish, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        Grid, Isosurface, Mesh, Projection, Region, Scaling, Shading, TransferFunction, Volume,
    };
    use glam::DVec3;

    #[test]
    fn scene_setters_set_their_field() {
        let transfer = |opacity: f64| {
            TransferFunction::new(vec![(0.0, [opacity])], vec![(0.0, [1.0; 3])]).unwrap()
        };
        let volume = || {
            let grid = Grid::with_spacing([1; 3], [1.0; 3]).unwrap();
            Volume::new(grid, vec![7_u8].into(), Scaling::IDENTITY).unwrap()
        };
        let camera = |eye: DVec3| {
            let projection = Projection::Orthographic { view_height: 1.0 };
            Camera::new(eye, DVec3::ZERO, DVec3::Y, projection).unwrap()
        };
        let region = Region::default().inverted();
        let isosurfaces = vec![Isosurface::new(3.0, 0.5, None).unwrap()];
        let layer = Layer::new(volume(), transfer(0.5))
            .isosurfaces(isosurfaces)
            .shading(Shading::None)
            .region(region);
        let mesh = MeshLayer::new(Mesh::default());
        let expected = Scene {
            layers: vec![layer.clone()],
            meshes: vec![mesh.clone()],
            camera: camera(DVec3::X),
            lights: vec![],
            image: ImageDesc::new(7, 5).background([1.0; 4]),
            settings: RenderSettings::default().sections(9),
            finish: Finish { samples: 4, ..Finish::default() },
        };
        let other = Layer::new(volume(), transfer(0.25));
        assert_ne!(other.clone().transfer(transfer(0.5)).shading(Shading::None), layer);
        let layer = other
            .clone()
            .volume(layer.volume)
            .transfer(layer.transfer.clone())
            .isosurfaces(layer.isosurfaces.clone())
            .shading(layer.shading)
            .region(layer.region.clone());
        let scene = Scene::new(other, camera(DVec3::Z))
            .layers(vec![layer])
            .meshes(vec![mesh.clone()])
            .camera(expected.camera)
            .lights(vec![])
            .image(expected.image)
            .settings(expected.settings.clone())
            .finish(expected.finish.clone());
        assert_eq!(scene, expected);
        let alone = Scene::of_meshes(vec![mesh], camera(DVec3::X)).lights(vec![]);
        let alone = alone.image(expected.image).settings(expected.settings.clone());
        let alone = alone.finish(expected.finish.clone());
        assert_eq!(alone, expected.layers(Vec::new()));
    }
}
