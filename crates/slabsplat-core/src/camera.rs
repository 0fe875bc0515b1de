//! Orthographic and perspective cameras, and the three axes of the view.

use crate::ProjectionKind;
use glam::DVec3;
use thiserror::Error;

/// Where the picture is taken from.
///
/// The three vectors always span a view: the eye is not at the target, and up is not along the
/// viewing direction.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize, serde::Serialize))]
#[cfg_attr(
    feature = "serde",
    serde(try_from = "crate::serialized::CameraKeys", into = "crate::serialized::CameraKeys")
)]
pub struct Camera {
    eye: DVec3,
    target: DVec3,
    up: DVec3,
    projection: Projection,
}

/// How depth changes size.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(clippy::exhaustive_enums, reason = "who projects has to know each")]
pub enum Projection {
    /// It does not: `view_height` world units fill the height of the image.
    Orthographic {
        /// World units from the lower to the upper edge of the image.
        view_height: f64,
    },
    /// Rays leave the eye.
    Perspective {
        /// Angle between the lower and the upper edge of the image, above 0 and below π.
        fov_y_radians: f64,
    },
}

/// The right-handed axes of a view in world space, each of length 1.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(clippy::exhaustive_structs, reason = "space has three axes")]
pub struct ViewAxes {
    /// `r = f × up`.
    pub right: DVec3,
    /// `u = r × f`.
    pub up: DVec3,
    /// From the eye to the target.
    pub forward: DVec3,
}

/// Why a camera cannot be made.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum CameraError {
    /// A coordinate is NaN or infinite.
    #[error("the camera's {0} is not finite")]
    NotFinite(&'static str),
    /// The eye is at the target.
    #[error("the camera's eye and target are the same point")]
    NoDirection,
    /// The up vector is zero or along the viewing direction.
    #[error("the camera's up vector is parallel to the viewing direction (or zero)")]
    UpIsForward,
    /// The view has no height.
    #[error("view_height must be a positive number, not {0}")]
    BadViewHeight(f64),
    /// The angle is not between 0 and 180 degrees.
    #[error("fov_y must lie between 0 and 180 degrees, not {0}")]
    BadFieldOfView(f64),
}

/// Sine of the smallest angle allowed between up and the viewing direction.
const MIN_UP_SINE: f64 = 1e-6;

impl Camera {
    /// A camera at `eye` that looks at `target`, with `up` pointing upwards in the image.
    ///
    /// # Errors
    /// If a number is not finite, or the three vectors do not span a view.
    pub fn new(
        eye: impl Into<DVec3>,
        target: impl Into<DVec3>,
        up: impl Into<DVec3>,
        projection: Projection,
    ) -> Result<Self, CameraError> {
        let (eye, target, up) = (eye.into(), target.into(), up.into());
        for (name, vector) in [("eye", eye), ("target", target), ("up vector", up)] {
            if !vector.is_finite() {
                return Err(CameraError::NotFinite(name));
            }
        }
        projection.check()?;
        let forward = (target - eye).try_normalize().ok_or(CameraError::NoDirection)?;
        let up_sine = up.try_normalize().map_or(0.0, |up| forward.cross(up).length());
        if up_sine < MIN_UP_SINE {
            return Err(CameraError::UpIsForward);
        }
        Ok(Self { eye, target, up, projection })
    }

    /// The eye in world space.
    pub fn eye(&self) -> DVec3 {
        self.eye
    }

    /// The point looked at, in world space.
    pub fn target(&self) -> DVec3 {
        self.target
    }

    /// The up vector as given; any length.
    pub fn up(&self) -> DVec3 {
        self.up
    }

    /// How depth changes size.
    pub fn projection(&self) -> Projection {
        self.projection
    }

    /// Right, up and forward: unit vectors in the world, at right angles to each other.
    pub fn axes(&self) -> ViewAxes {
        let forward = (self.target - self.eye).normalize();
        let right = forward.cross(self.up.normalize()).normalize();
        ViewAxes { right, up: right.cross(forward), forward }
    }

    /// The same camera, turned about its target around its up vector; the eye moves to its own
    /// right for a positive angle.
    #[must_use]
    pub fn orbited(&self, angle_radians: f64) -> Self {
        let turn = glam::DQuat::from_axis_angle(self.up.normalize(), angle_radians);
        Self { eye: self.target + turn * (self.eye - self.target), ..*self }
    }

    /// The same camera with all in the picture so many times as large. The eye stays where it is.
    ///
    /// # Errors
    /// If numbers do not suffice, or the factor is not positive.
    pub fn magnified(&self, factor: f64) -> Result<Self, CameraError> {
        let projection = match self.projection {
            Projection::Orthographic { view_height } => {
                Projection::Orthographic { view_height: view_height / factor }
            }
            Projection::Perspective { fov_y_radians } => {
                let half = ((0.5 * fov_y_radians).tan() / factor).atan();
                Projection::Perspective { fov_y_radians: 2.0 * half }
            }
        };
        projection.check()?;
        Ok(Self { projection, ..*self })
    }
}

impl Projection {
    /// Which of the two it is.
    pub fn kind(self) -> ProjectionKind {
        match self {
            Self::Orthographic { .. } => ProjectionKind::Orthographic,
            Self::Perspective { .. } => ProjectionKind::Perspective,
        }
    }

    fn check(self) -> Result<(), CameraError> {
        match self {
            Self::Orthographic { view_height } => {
                let ok = view_height.is_normal() && 0.0 < view_height;
                ok.then_some(()).ok_or(CameraError::BadViewHeight(view_height))
            }
            Self::Perspective { fov_y_radians: angle } => {
                let ok = angle.is_normal() && 0.0 < angle && angle < std::f64::consts::PI;
                ok.then_some(()).ok_or(CameraError::BadFieldOfView(angle.to_degrees()))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ORTHO: Projection = Projection::Orthographic { view_height: 2.0 };

    #[test]
    fn camera_axes_are_right_handed() {
        let camera = Camera::new(DVec3::Z * 5.0, DVec3::ZERO, DVec3::Y * 3.0, ORTHO).unwrap();
        let ViewAxes { right, up, forward } = camera.axes();
        assert_eq!((right, up, forward), (DVec3::X, DVec3::Y, -DVec3::Z));
    }

    #[test]
    fn camera_orbit_moves_eye_to_its_right() {
        let camera = Camera::new(DVec3::Z * 5.0, DVec3::ZERO, DVec3::Y, ORTHO).unwrap();
        let turned = camera.orbited(std::f64::consts::FRAC_PI_2);
        assert!(turned.eye().abs_diff_eq(DVec3::X * 5.0, 1e-12));
        assert!(
            turned.orbited(-std::f64::consts::FRAC_PI_2).eye().abs_diff_eq(camera.eye(), 1e-12)
        );
        let target = DVec3::new(7.0, 2.0, 1.0);
        let elsewhere = Camera::new(target + DVec3::Z, target, DVec3::Y * 4.0, ORTHO).unwrap();
        assert_eq!((elsewhere.target(), elsewhere.up()), (target, DVec3::Y * 4.0));
        let turned = elsewhere.orbited(std::f64::consts::FRAC_PI_2);
        assert!(turned.eye().abs_diff_eq(target + DVec3::X, 1e-12));
    }

    #[test]
    fn camera_magnifies() {
        let of =
            |projection| Camera::new(DVec3::Z * 5.0, DVec3::ZERO, DVec3::Y, projection).unwrap();
        let larger = of(ORTHO).magnified(4.0).unwrap();
        assert_eq!(larger.projection(), Projection::Orthographic { view_height: 0.5 });
        let wide = Projection::Perspective { fov_y_radians: std::f64::consts::FRAC_PI_2 };
        let Projection::Perspective { fov_y_radians } =
            of(wide).magnified(2.0).unwrap().projection()
        else {
            panic!("it stays in perspective")
        };
        assert!(((0.5 * fov_y_radians).tan() - 0.5).abs() < 1e-12);
        for factor in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(of(ORTHO).magnified(factor).is_err() && of(wide).magnified(factor).is_err());
        }
    }

    #[test]
    fn camera_rejects_what_spans_no_view() {
        let check = |eye, up, projection, expected: CameraError| {
            assert_eq!(Camera::new(eye, DVec3::ZERO, up, projection), Err(expected));
        };
        check(DVec3::ZERO, DVec3::Y, ORTHO, CameraError::NoDirection);
        check(DVec3::Z, DVec3::Z, ORTHO, CameraError::UpIsForward);
        check(DVec3::Z, DVec3::ZERO, ORTHO, CameraError::UpIsForward);
        check(DVec3::NAN, DVec3::Y, ORTHO, CameraError::NotFinite("eye"));
        for view_height in [0.0, -1.0, 1e-310, f64::INFINITY] {
            let flat = Projection::Orthographic { view_height };
            check(DVec3::Z, DVec3::Y, flat, CameraError::BadViewHeight(view_height));
        }
        for fov_y_radians in [0.0, -1.0, std::f64::consts::PI, 4.0, f64::INFINITY] {
            let wide = Projection::Perspective { fov_y_radians };
            let degrees = fov_y_radians.to_degrees();
            check(DVec3::Z, DVec3::Y, wide, CameraError::BadFieldOfView(degrees));
        }
    }
}
