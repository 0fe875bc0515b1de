//! The light in which a volume is shown: a lamp over the viewer's left shoulder, and a weaker one where the
//! viewer is, so that nothing is black.

use slabsplat_core::{Camera, Light, Phong, ViewAxes};

/// Towards the lamp: to the right, upwards, towards the viewer.
const LAMP: [f64; 3] = [-0.55, 0.65, 0.75];

/// How bright the lamp is, and the headlight.
const BRIGHTNESS: [f64; 2] = [0.72, 0.42];

/// What surfaces make of it.
pub(crate) fn phong() -> Phong {
    Phong::default().ambient(0.16).diffuse(0.78).specular(0.16).shininess(28.0)
}

/// The lights for a viewer; the lamp stays where it is when the camera turns.
pub(crate) fn lights(camera: &Camera) -> Vec<Light> {
    let ViewAxes { right, up, forward } = camera.axes();
    let [x, y, z] = LAMP;
    let lamp =
        Light::towards(right * x + up * y - forward * z).expect("the axes are at right angles");
    let [of_lamp, of_headlight] = BRIGHTNESS;
    vec![lamp.color([of_lamp; 3]), Light::default().color([of_headlight; 3])]
}
