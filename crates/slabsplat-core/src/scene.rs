//! Everything that decides a pixel, but for the volume itself (`docs/model.md`).

use crate::{Camera, ImageDesc, Phong, RenderSettings, Shading, TransferFunction};

/// A picture to be made of some volume.
///
/// What is visible and from where has no default that fits every volume; the facade's `Automatic` finds
/// both for one. Everything else has, and a method of the same name to set it:
///
/// ```
/// use slabsplat_core::glam::DVec3;
/// use slabsplat_core::{Camera, ImageDesc, Projection, RenderSettings, Scene, TransferFunction};
///
/// let transfer = TransferFunction::new(vec![(0.0, [0.0]), (255.0, [0.9])], vec![(0.0, [1.0; 3])])?;
/// let projection = Projection::Orthographic { view_height: 40.0 };
/// let camera = Camera::new(DVec3::X * 90.0, DVec3::ZERO, DVec3::Z, projection)?;
/// let scene = Scene::new(transfer, camera)
///     .image(ImageDesc { width: 64, height: 64, background: [0.0; 4] })
///     .settings(RenderSettings::default().slab_width(0.5));
/// assert_eq!(scene.settings.tolerance, RenderSettings::default().tolerance);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Scene {
    /// Which values are visible, and in which colour.
    pub transfer: TransferFunction,
    /// What light does to them.
    pub shading: Shading,
    /// Where they are seen from.
    pub camera: Camera,
    /// Size and background of the picture.
    pub image: ImageDesc,
    /// How it is made.
    pub settings: RenderSettings,
}

impl Scene {
    /// What `transfer` shows, seen by `camera`, lit by a headlight; the picture and how it is made as by
    /// default.
    pub fn new(transfer: TransferFunction, camera: Camera) -> Self {
        Self {
            transfer,
            shading: Shading::Phong(Phong::default()),
            camera,
            image: ImageDesc::default(),
            settings: RenderSettings::default(),
        }
    }

    /// The same with other values visible.
    #[must_use]
    pub fn transfer(self, transfer: TransferFunction) -> Self {
        Self { transfer, ..self }
    }

    /// The same in another light.
    #[must_use]
    pub fn shading(self, shading: Shading) -> Self {
        Self { shading, ..self }
    }

    /// The same from elsewhere.
    #[must_use]
    pub fn camera(self, camera: Camera) -> Self {
        Self { camera, ..self }
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
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Projection;
    use glam::DVec3;

    #[test]
    fn scene_setters_set_their_field() {
        let transfer = |opacity: f64| {
            TransferFunction::new(vec![(0.0, [opacity])], vec![(0.0, [1.0; 3])]).unwrap()
        };
        let camera = |eye: DVec3| {
            let projection = Projection::Orthographic { view_height: 1.0 };
            Camera::new(eye, DVec3::ZERO, DVec3::Y, projection).unwrap()
        };
        let expected = Scene {
            transfer: transfer(0.5),
            shading: Shading::None,
            camera: camera(DVec3::X),
            image: ImageDesc { width: 7, height: 5, background: [1.0; 4] },
            settings: RenderSettings::default().sections(9),
        };
        let scene = Scene::new(transfer(0.25), camera(DVec3::Z))
            .transfer(expected.transfer.clone())
            .shading(expected.shading)
            .camera(expected.camera)
            .image(expected.image)
            .settings(expected.settings.clone());
        assert_eq!(scene, expected);
    }
}
