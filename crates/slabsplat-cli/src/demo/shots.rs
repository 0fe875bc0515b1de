//! What the demo shows: for each volume a transfer function, a light and a view, picked by eye.

use anyhow::Result;
use slabsplat::glam::DVec3;
use slabsplat::{
    Camera, ImageDesc, Layer, Light, Method, Mode, Phong, Projection, RenderSettings, Scene,
    Shading, Sweep, TransferFunction, Volume,
};
use std::sync::Arc;

/// Width and height of the demo's pictures.
pub(super) const SIDE_PIXELS: u32 = 384;

/// How the cube turns for the popping table: through the angle at which the grid's slices change their axis.
pub(super) const CUBE_TURN: Sweep = Sweep::turn(40.0, 50.0).step(0.5);

/// Width and height of the pictures that the popping table compares.
const METER_SIDE_PIXELS: u32 = 128;

/// Opaque: a PNG is mostly looked at on white.
const BACKGROUND: [f32; 4] = [0.05, 0.06, 0.08, 1.0];

/// Farther from the centre than any voxel.
const DISTANCE: f64 = 1000.0;

/// A volume and how it looks best.
pub(super) struct Shot {
    /// Its built-in name.
    pub(super) volume: &'static str,
    /// Value, opacity per voxel step.
    opacity: &'static [(f64, f64)],
    /// Value; red, green, blue.
    color: &'static [(f64, [f64; 3])],
    /// From the volume's centre towards the eye, x, y, z.
    to_eye: [f64; 3],
    /// World units in the height of the picture.
    view_height: f64,
    /// Towards the light, in the view's own axes: right, up, towards the eye.
    light: [f64; 3],
    /// Ambient, diffuse, specular light; shininess.
    phong: [f64; 4],
}

pub(super) const SHOTS: &[Shot] = &[
    Shot {
        volume: "cube",
        opacity: &[(0.0, 0.0), (255.0, 0.97)],
        color: &[(0.0, [0.95, 0.6, 0.3])],
        to_eye: [1.0, 1.0, 0.62],
        view_height: 32.0,
        light: [0.3, 0.45, 1.0],
        phong: [0.2, 0.95, 0.1, 20.0],
    },
    Shot {
        volume: "sphere",
        opacity: &[(0.0, 0.0), (60.0, 0.0), (200.0, 0.9)],
        color: &[(0.0, [0.4, 0.65, 0.9])],
        to_eye: [1.0, 0.6, 0.4],
        view_height: 64.0,
        light: [-0.45, 0.55, 1.0],
        phong: [0.18, 0.8, 0.35, 40.0],
    },
    Shot {
        volume: "marschner-lobb",
        opacity: &[(0.45, 0.0), (0.55, 0.95)],
        color: &[(0.0, [0.98, 0.85, 0.5])],
        to_eye: [0.45, -0.75, 0.95],
        view_height: 70.0,
        light: [-0.4, 0.4, 1.0],
        phong: [0.15, 0.9, 0.25, 30.0],
    },
    // Translucent skull and brain (255 and 51), and the lobes inside (76): glow rather than surface,
    // because every edge passes through the lobes' value.
    Shot {
        volume: "shepp-logan",
        opacity: &[
            (0.0, 0.0),
            (40.0, 0.007),
            (60.0, 0.007),
            (72.0, 0.08),
            (82.0, 0.08),
            (95.0, 0.01),
            (255.0, 0.02),
        ],
        color: &[
            (0.0, [0.35, 0.55, 1.0]),
            (60.0, [0.35, 0.55, 1.0]),
            (72.0, [1.0, 0.6, 0.25]),
            (82.0, [1.0, 0.6, 0.25]),
            (95.0, [0.7, 0.8, 0.95]),
            (255.0, [0.8, 0.88, 1.0]),
        ],
        to_eye: [0.0, -0.4, 0.9],
        view_height: 100.0,
        light: [0.0, 0.3, 1.0],
        phong: [0.8, 0.3, 0.0, 20.0],
    },
    Shot {
        volume: "neuron",
        opacity: &[(0.0, 0.0), (15.0, 0.0), (110.0, 0.9)],
        color: &[(0.0, [0.25, 0.8, 0.5]), (255.0, [0.75, 1.0, 0.65])],
        to_eye: [0.4, -1.0, 0.1],
        view_height: 130.0,
        light: [-0.3, 0.4, 1.0],
        phong: [0.25, 0.85, 0.2, 20.0],
    },
];

impl Shot {
    /// The scene of this shot by one method.
    pub(super) fn scene(&self, volume: Arc<Volume>, method: Method) -> Result<Scene> {
        let opacity = self.opacity.iter().copied();
        let eye = DVec3::from_array(self.to_eye).normalize() * DISTANCE;
        let projection = Projection::Orthographic { view_height: self.view_height };
        let camera = Camera::new(eye, DVec3::ZERO, DVec3::Z, projection)?;
        let transfer = TransferFunction::new(opacity, self.color.to_vec())?;
        let layer = Layer::new(volume, transfer).shading(Shading::Phong(self.phong()?));
        Ok(Scene::new(layer, camera)
            .lights(vec![self.light(&camera)?])
            .image(ImageDesc::new(SIDE_PIXELS, SIDE_PIXELS).background(BACKGROUND))
            .settings(RenderSettings::default().method(method)))
    }

    fn light(&self, camera: &Camera) -> Result<Light> {
        let [right, up, towards_eye] = self.light;
        let axes = camera.axes();
        Ok(Light::towards(axes.right * right + axes.up * up - axes.forward * towards_eye)?)
    }

    fn phong(&self) -> Result<Phong> {
        let [ambient, diffuse, specular, shininess] = self.phong;
        Ok(Phong::default()
            .ambient(ambient)
            .diffuse(diffuse)
            .specular(specular)
            .shininess(shininess)
            .two_sided(false)
            .checked()?)
    }
}

/// The paper's figures 2 and 6: the cube seen level, one unit of slab, colour and opacity summed
/// apart, and nothing but diffuse light from the eye.
pub(super) fn popping_scene(cube: Volume) -> Result<Scene> {
    let eye = DVec3::Z * DISTANCE;
    let projection = Projection::Orthographic { view_height: 34.0 };
    let transfer = vec![(0.0, [0.0]), (255.0, [0.5])];
    let transfer = TransferFunction::new(transfer, vec![(0.0, [1.0; 3])])?;
    let camera = Camera::new(eye, DVec3::ZERO, DVec3::Y, projection)?;
    let diffuse = Phong::default()
        .ambient(0.0)
        .diffuse(1.0)
        .zero_gradient(0.0)
        .specular(0.0)
        .shininess(1.0)
        .two_sided(false);
    let (width, height) = (METER_SIDE_PIXELS, METER_SIDE_PIXELS);
    let layer = Layer::new(cube, transfer).shading(Shading::Phong(diffuse));
    Ok(Scene::new(layer, camera)
        .image(ImageDesc::new(width, height))
        .settings(RenderSettings::default().mode(Mode::Separate)))
}
