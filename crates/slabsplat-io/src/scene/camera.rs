//! A camera with parts left out, to be filled in once the volume is known.

use slabsplat_core::glam::DVec3;
use slabsplat_core::{Camera, CameraError, Projection, ProjectionKind};

/// The parts of a camera that someone has given.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct CameraDesc {
    /// Orthographic or perspective.
    pub projection: Option<ProjectionKind>,
    /// Where the camera is.
    pub eye: Option<DVec3>,
    /// What it looks at.
    pub target: Option<DVec3>,
    /// What is upwards in the picture.
    pub up: Option<DVec3>,
    /// World units from the lower to the upper edge of the picture, if orthographic.
    pub view_height: Option<f64>,
    /// Degrees between the lower and the upper edge of the picture, if perspective.
    pub fov_y: Option<f64>,
    /// The same angle in radians, where no number of degrees is just that; `fov_y` overrules it.
    pub fov_y_radians: Option<f64>,
}

/// The field of view where neither the scene nor the fallback has one.
const DEFAULT_FOV_Y_DEGREES: f64 = 30.0;

impl CameraDesc {
    /// Whether a perspective camera is asked for: by name, or by giving only the angle of one.
    pub fn is_perspective(&self) -> bool {
        match self.projection {
            Some(kind) => kind == ProjectionKind::Perspective,
            None => self.angle_radians().is_some() && self.view_height.is_none(),
        }
    }

    /// The camera with what is left out taken from `fallback`: a target alone moves the fallback's
    /// eye along, and a fallback of the other projection lends the size that it shows at the target.
    /// The fallback's kind counts where nothing given names the projection.
    ///
    /// # Errors
    /// If the parts do not make a camera.
    pub fn complete(&self, fallback: &Camera) -> Result<Camera, CameraError> {
        let target = self.target.unwrap_or(fallback.target());
        let eye = self.eye.unwrap_or(target + (fallback.eye() - fallback.target()));
        let projection = self.projection(eye.distance(target), fallback);
        if let Some(up) = self.up {
            return Camera::new(eye, target, up, projection);
        }
        // A given eye may lie just where the fallback's up points to.
        let ups = [fallback.up(), fallback.axes().up, DVec3::Z, DVec3::Y];
        let mut cameras = ups.into_iter().map(|up| Camera::new(eye, target, up, projection));
        let is_settled = |camera: &Result<_, _>| *camera != Err(CameraError::UpIsForward);
        cameras.find(is_settled).unwrap_or(Err(CameraError::UpIsForward))
    }

    /// The angle that is given, by either.
    fn angle_radians(&self) -> Option<f64> {
        self.fov_y.map(f64::to_radians).or(self.fov_y_radians)
    }

    fn projection(&self, distance: f64, fallback: &Camera) -> Projection {
        let says_nothing = self.projection.is_none()
            && self.view_height.is_none()
            && self.angle_radians().is_none();
        let is_perspective = match fallback.projection() {
            Projection::Perspective { .. } => says_nothing || self.is_perspective(),
            Projection::Orthographic { .. } => self.is_perspective(),
        };
        if is_perspective {
            let fov_y_radians =
                self.angle_radians().unwrap_or_else(|| match fallback.projection() {
                    Projection::Perspective { fov_y_radians } => fov_y_radians,
                    Projection::Orthographic { .. } => DEFAULT_FOV_Y_DEGREES.to_radians(),
                });
            return Projection::Perspective { fov_y_radians };
        }
        let view_height = self.view_height.unwrap_or_else(|| match fallback.projection() {
            Projection::Orthographic { view_height } => view_height,
            Projection::Perspective { fov_y_radians } => {
                2.0 * distance * (fov_y_radians / 2.0).tan()
            }
        });
        Projection::Orthographic { view_height }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fallback(projection: Projection) -> Camera {
        Camera::new(DVec3::new(0.0, 0.0, 10.0), DVec3::ZERO, DVec3::Y, projection).unwrap()
    }

    fn orthographic() -> Camera {
        fallback(Projection::Orthographic { view_height: 4.0 })
    }

    fn perspective() -> Camera {
        fallback(Projection::Perspective { fov_y_radians: 0.5 })
    }

    #[test]
    fn camera_without_parts_is_the_fallback() {
        for camera in [orthographic(), perspective()] {
            assert_eq!(CameraDesc::default().complete(&camera), Ok(camera));
        }
    }

    #[test]
    fn camera_target_moves_the_eye() {
        let desc = CameraDesc { target: Some(DVec3::X), ..CameraDesc::default() };
        assert_eq!(desc.complete(&orthographic()).unwrap().eye(), DVec3::new(1.0, 0.0, 10.0));
    }

    #[test]
    fn camera_projection_by_what_is_given() {
        let with = |projection, view_height, fov_y| CameraDesc {
            projection,
            view_height,
            fov_y,
            ..CameraDesc::default()
        };
        let check = |desc: CameraDesc, fallback: &Camera, expected: Projection| {
            assert_eq!(desc.complete(fallback).unwrap().projection(), expected, "{desc:?}");
        };
        let angle = 60_f64.to_radians();
        let by_angle = Projection::Perspective { fov_y_radians: angle };
        check(with(None, None, Some(60.0)), &orthographic(), by_angle);
        let by_height = Projection::Orthographic { view_height: 7.0 };
        check(with(None, Some(7.0), None), &perspective(), by_height);
        let kind = Some(ProjectionKind::Perspective);
        check(with(kind, Some(7.0), Some(60.0)), &orthographic(), by_angle);
        let usual = Projection::Perspective { fov_y_radians: DEFAULT_FOV_Y_DEGREES.to_radians() };
        check(with(kind, None, None), &orthographic(), usual);
        let kind = Some(ProjectionKind::Orthographic);
        let as_seen = Projection::Orthographic { view_height: 20.0 * 0.25_f64.tan() };
        check(with(kind, None, None), &perspective(), as_seen);
    }

    #[test]
    fn camera_finds_another_up() {
        let above = CameraDesc { eye: Some(DVec3::Y * 9.0), ..CameraDesc::default() };
        assert_eq!(above.complete(&orthographic()).unwrap().up(), DVec3::Z);
        let given = CameraDesc { up: Some(DVec3::Y), ..above };
        assert_eq!(given.complete(&orthographic()), Err(CameraError::UpIsForward));
        let nowhere = CameraDesc { eye: Some(DVec3::ZERO), ..CameraDesc::default() };
        assert_eq!(nowhere.complete(&orthographic()), Err(CameraError::NoDirection));
    }
}
