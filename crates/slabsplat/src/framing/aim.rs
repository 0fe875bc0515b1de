//! Cameras as people say them: a side, turns, zoom.

use slabsplat_core::glam::{DQuat, DVec3};
use slabsplat_core::{Camera, CameraError, Fit, Projection, ViewAxes, Viewpoint};

/// What a camera is to be, beginning with one that there is.
///
/// ```
/// use slabsplat::{Aim, Viewpoint};
///
/// let aim = Aim::default().viewpoint(Viewpoint::Left).elevation_degrees(20.0).zoom(1.5);
/// assert_eq!(aim, aim.checked()?);
/// assert!(aim.zoom(0.0).checked().is_err());
/// # Ok::<(), slabsplat::AimError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Aim {
    /// The side from which the picture is taken.
    pub viewpoint: Option<Viewpoint>,
    /// By how much the camera goes to its own right, around what it looks at.
    pub azimuth_degrees: f64,
    /// By how much it then rises.
    pub elevation_degrees: f64,
    /// By how much the picture then turns counter-clockwise.
    pub roll_degrees: f64,
    /// By how much all is magnified, above 0.
    pub zoom: f64,
    /// Parts of its width and height by which the picture moves, to the right and upwards.
    pub pan: [f64; 2],
    /// The point of the world in the middle of the picture, but for `pan`.
    pub look_at: Option<DVec3>,
    /// What fills the picture before it is magnified; by default that of a camera that is all found.
    pub fit: Option<Fit>,
}

/// Why there is no such camera.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AimError {
    /// A number is NaN or infinite.
    #[error("{0} must be finite")]
    NotFinite(&'static str),
    /// The zoom is not positive.
    #[error("zoom must be a positive number, not {0}: 2 shows all twice as large")]
    BadZoom(f64),
}

impl Default for Aim {
    fn default() -> Self {
        Self {
            viewpoint: None,
            azimuth_degrees: 0.0,
            elevation_degrees: 0.0,
            roll_degrees: 0.0,
            zoom: 1.0,
            pan: [0.0; 2],
            look_at: None,
            fit: None,
        }
    }
}

/// Cosine of the angle to the up vector from which on that is no help to tell what is upwards.
const NEAR_UP: f64 = 0.999;

impl Aim {
    /// The same from that side.
    #[must_use]
    pub fn viewpoint(self, viewpoint: impl Into<Option<Viewpoint>>) -> Self {
        Self { viewpoint: viewpoint.into(), ..self }
    }

    /// The same from as much further to the right.
    #[must_use]
    pub fn azimuth_degrees(self, azimuth_degrees: f64) -> Self {
        Self { azimuth_degrees, ..self }
    }

    /// The same from as much further above.
    #[must_use]
    pub fn elevation_degrees(self, elevation_degrees: f64) -> Self {
        Self { elevation_degrees, ..self }
    }

    /// The same with a picture that is turned counter-clockwise.
    #[must_use]
    pub fn roll_degrees(self, roll_degrees: f64) -> Self {
        Self { roll_degrees, ..self }
    }

    /// The same magnified.
    #[must_use]
    pub fn zoom(self, zoom: f64) -> Self {
        Self { zoom, ..self }
    }

    /// The same with a picture that is moved by parts of its width and height.
    #[must_use]
    pub fn pan(self, pan: [f64; 2]) -> Self {
        Self { pan, ..self }
    }

    /// The same with that point in the middle.
    #[must_use]
    pub fn look_at(self, point: impl Into<Option<DVec3>>) -> Self {
        Self { look_at: point.into(), ..self }
    }

    /// The same with a picture that is filled.
    #[must_use]
    pub fn fit(self, fit: impl Into<Option<Fit>>) -> Self {
        Self { fit: fit.into(), ..self }
    }

    /// The same, if it can be done.
    ///
    /// # Errors
    /// If a number is not finite, or the zoom is not positive.
    pub fn checked(self) -> Result<Self, AimError> {
        let numbers = [
            ("azimuth", self.azimuth_degrees),
            ("elevation", self.elevation_degrees),
            ("roll", self.roll_degrees),
            ("pan", self.pan[0] + self.pan[1]),
            ("look-at", self.look_at.map_or(0.0, DVec3::element_sum)),
        ];
        if let Some((name, _)) = numbers.iter().find(|(_, number)| !number.is_finite()) {
            return Err(AimError::NotFinite(name));
        }
        let is_zoom = self.zoom.is_normal() && 0.0 < self.zoom;
        if is_zoom { Ok(self) } else { Err(AimError::BadZoom(self.zoom)) }
    }

    /// Whether it turns a camera.
    pub(crate) fn turns(&self) -> bool {
        [self.azimuth_degrees, self.elevation_degrees, self.roll_degrees].iter().any(|d| *d != 0.0)
    }

    /// The camera turned around its target: to its right, upwards, and about its own axis.
    ///
    /// # Errors
    /// If numbers do not suffice.
    pub fn turned(&self, camera: &Camera) -> Result<Camera, CameraError> {
        if !self.turns() {
            return Ok(*camera);
        }
        let beside = camera.orbited(self.azimuth_degrees.to_radians());
        let ViewAxes { right, up, forward } = beside.axes();
        let turn = DQuat::from_axis_angle(right, -self.elevation_degrees.to_radians());
        let (up_there, forward_there) = (turn * up, turn * forward);
        // The camera's own up stays, so that it still turns about the same axis, unless it looks along it
        // or stands on its head.
        let own = camera.up().normalize();
        let is_upright = 0.0 < up_there.dot(own) && forward_there.dot(own).abs() < NEAR_UP;
        let up = if is_upright { own } else { up_there };
        let roll = DQuat::from_axis_angle(forward_there, self.roll_degrees.to_radians());
        let up = if self.roll_degrees == 0.0 { up } else { roll * up };
        let target = camera.target();
        let eye = target - forward_there * camera.eye().distance(target);
        Camera::new(eye, target, up, camera.projection())
    }

    /// The camera moved sideways and magnified.
    ///
    /// # Errors
    /// If numbers do not suffice.
    pub fn moved(&self, camera: &Camera, aspect: f64) -> Result<Camera, CameraError> {
        let projection = camera.magnified(self.zoom)?.projection();
        let ViewAxes { right, up, .. } = camera.axes();
        let height = match projection {
            Projection::Orthographic { view_height } => view_height,
            Projection::Perspective { fov_y_radians } => {
                2.0 * (0.5 * fov_y_radians).tan() * camera.eye().distance(camera.target())
            }
        };
        let [x, y] = self.pan;
        let to_point = self.look_at.map_or(DVec3::ZERO, |point| point - camera.target());
        let shift = to_point - right * (x * height * aspect) - up * (y * height);
        if shift == DVec3::ZERO && projection == camera.projection() {
            return Ok(*camera);
        }
        Camera::new(camera.eye() + shift, camera.target() + shift, camera.up(), projection)
    }
}

#[cfg(test)]
mod tests;
