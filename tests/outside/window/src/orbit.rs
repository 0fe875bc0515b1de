//! What the mouse does, as a camera.

use slabsplat::glam::DVec3;
use slabsplat::{Camera, CameraError};
use std::f64::consts::{FRAC_PI_2, PI};

/// An eye that circles around a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orbit {
    /// What it began as.
    home: Camera,
    yaw_radians: f64,
    pitch_radians: f64,
    /// How many times nearer the eye is.
    zoom: f64,
}

/// Straight above there is no upwards.
const MOST_PITCH_RADIANS: f64 = FRAC_PI_2 - 0.01;

impl Orbit {
    /// Around the camera's target, beginning where it is.
    pub fn new(home: Camera) -> Self {
        let [yaw_radians, pitch_radians] = angles(&home);
        Self { home, yaw_radians, pitch_radians, zoom: 1.0 }
    }

    /// The mouse was dragged by parts of the window's height: across all of it is half a turn. What is
    /// dragged goes with the mouse.
    pub fn drag(&mut self, right: f64, down: f64) {
        self.yaw_radians = (self.yaw_radians - PI * right).rem_euclid(2.0 * PI);
        let pitch = self.pitch_radians + PI * down;
        self.pitch_radians = pitch.clamp(-MOST_PITCH_RADIANS, MOST_PITCH_RADIANS);
    }

    /// The wheel was turned: things get `factor` times larger.
    pub fn magnify(&mut self, factor: f64) {
        self.zoom = (self.zoom * factor).clamp(0.2, 20.0);
    }

    /// Where the eye is now.
    ///
    /// # Errors
    /// Never, if there was a camera to begin with.
    pub fn camera(&self) -> Result<Camera, CameraError> {
        let [right, ahead, up] = axes(&self.home);
        let (sin, cos) = self.yaw_radians.sin_cos();
        let level = cos * ahead + sin * right;
        let to_eye = self.pitch_radians.cos() * level + self.pitch_radians.sin() * up;
        let distance = self.home.eye().distance(self.home.target()) / self.zoom;
        let eye = self.home.target() + distance * to_eye;
        Camera::new(eye, self.home.target(), up, self.home.projection())
    }
}

/// Upwards, and two directions at right angles to it: the eye begins between the second and upwards.
fn axes(home: &Camera) -> [DVec3; 3] {
    let up = home.up().normalize();
    let to_eye = (home.eye() - home.target()).normalize();
    let ahead = (to_eye - up * to_eye.dot(up)).normalize();
    [up.cross(ahead), ahead, up]
}

fn angles(home: &Camera) -> [f64; 2] {
    let [right, ahead, up] = axes(home);
    let to_eye = (home.eye() - home.target()).normalize();
    [to_eye.dot(right).atan2(to_eye.dot(ahead)), to_eye.dot(up).asin()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat::Projection;

    fn orbit() -> Orbit {
        let projection = Projection::Perspective { fov_y_radians: 0.5 };
        Orbit::new(
            Camera::new([9.0, 0.0, 3.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], projection).unwrap(),
        )
    }

    /// What the picture shows of a point, from the middle to the right and up.
    fn seen(orbit: &Orbit, point: DVec3) -> [f64; 2] {
        let camera = orbit.camera().unwrap();
        let (axes, to_point) = (camera.axes(), point - camera.eye());
        let depth = to_point.dot(axes.forward);
        [to_point.dot(axes.right) / depth, to_point.dot(axes.up) / depth]
    }

    #[test]
    fn orbit_begins_at_home() {
        let camera = orbit().camera().unwrap();
        assert!(camera.eye().distance(orbit().home.eye()) < 1e-12, "{camera:?}");
    }

    #[test]
    fn drag_takes_what_is_in_front_along() {
        let in_front = DVec3::new(2.0, 0.0, 0.0);
        let before = seen(&orbit(), in_front);
        let mut right = orbit();
        right.drag(0.1, 0.0);
        assert!(before[0] + 0.01 < seen(&right, in_front)[0]);
        let mut down = orbit();
        down.drag(0.0, 0.1);
        assert!(seen(&down, in_front)[1] < before[1] - 0.01);
    }

    #[test]
    fn drag_ends_at_the_poles_and_goes_round() {
        let mut orbit = orbit();
        for _ in 0..100 {
            orbit.drag(0.3, 0.7);
            assert!(orbit.camera().is_ok());
        }
        let axes = orbit.camera().unwrap().axes();
        assert!(axes.forward.z < -0.99, "from above: {axes:?}");
    }

    #[test]
    fn wheel_brings_the_eye_nearer() {
        let mut orbit = orbit();
        let distance = |orbit: &Orbit| orbit.camera().unwrap().eye().distance(DVec3::X);
        let before = distance(&orbit);
        orbit.magnify(2.0);
        assert!((distance(&orbit) - 0.5 * before).abs() < 1e-12);
        orbit.magnify(1e9);
        assert!(orbit.camera().is_ok());
    }
}
