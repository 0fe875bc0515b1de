//! A camera of which parts may be missing.

use slabsplat_core::glam::DVec3;
use slabsplat_core::{Camera, CameraError, Projection};

/// Which projection is meant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ProjectionKind {
    /// Depth does not change size.
    #[default]
    Orthographic,
    /// Rays leave the eye.
    Perspective,
}

/// The parts of a camera that were given.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CameraDesc {
    /// Which projection; orthographic if not given.
    pub projection: Option<ProjectionKind>,
    /// The eye in world space.
    pub eye: Option<[f64; 3]>,
    /// The point looked at.
    pub target: Option<[f64; 3]>,
    /// What points upwards.
    pub up: Option<[f64; 3]>,
    /// World units that fill the image's height, orthographic only.
    pub view_height: Option<f64>,
    /// Vertical angle of view in degrees, perspective only; 30 if not given.
    pub fov_y: Option<f64>,
}

/// The angle of view if none is given, in degrees.
const DEFAULT_FOV_Y: f64 = 30.0;

impl ProjectionKind {
    /// The name that scene files and flags use.
    pub fn name(self) -> &'static str {
        match self {
            Self::Orthographic => "orthographic",
            Self::Perspective => "perspective",
        }
    }

    /// The projection of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        [Self::Orthographic, Self::Perspective].into_iter().find(|kind| kind.name() == name)
    }
}

impl CameraDesc {
    /// Whether rays leave the eye.
    pub fn is_perspective(&self) -> bool {
        self.projection == Some(ProjectionKind::Perspective)
    }

    /// The camera, with what is missing taken from `fallback`. A target that is given without an eye
    /// moves the fallback's eye along, so that the direction stays.
    ///
    /// # Errors
    /// If the parts do not make a camera.
    pub fn complete(&self, fallback: &Camera) -> Result<Camera, CameraError> {
        let given = |part: Option<[f64; 3]>| part.map(DVec3::from_array);
        let target = given(self.target).unwrap_or(fallback.target());
        let eye = given(self.eye).unwrap_or(target + (fallback.eye() - fallback.target()));
        let up = given(self.up).unwrap_or(fallback.up());
        Camera::new(eye, target, up, self.projection_or(fallback.projection()))
    }

    fn projection_or(&self, fallback: Projection) -> Projection {
        if self.is_perspective() {
            let degrees = self.fov_y.unwrap_or(DEFAULT_FOV_Y);
            return Projection::Perspective { fov_y_radians: degrees.to_radians() };
        }
        match (self.view_height, fallback) {
            (Some(view_height), _) | (None, Projection::Orthographic { view_height }) => {
                Projection::Orthographic { view_height }
            }
            // An orthographic picture as high as the perspective one is a world unit from the eye; no
            // caller asks for this, as fallbacks are of the kind that is wanted.
            (None, Projection::Perspective { fov_y_radians }) => {
                Projection::Orthographic { view_height: 2.0 * (0.5 * fov_y_radians).tan() }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn camera_desc_takes_the_rest_from_the_fallback() {
        let projection = Projection::Orthographic { view_height: 9.0 };
        let fallback = Camera::new(DVec3::Z * 4.0, DVec3::ZERO, DVec3::Y, projection).unwrap();
        assert_eq!(CameraDesc::default().complete(&fallback), Ok(fallback));

        let moved = CameraDesc { target: Some([1.0, 2.0, 3.0]), ..CameraDesc::default() };
        let moved = moved.complete(&fallback).unwrap();
        assert_eq!(moved.eye(), DVec3::new(1.0, 2.0, 7.0));

        let wide = CameraDesc {
            projection: Some(ProjectionKind::Perspective),
            fov_y: Some(90.0),
            up: Some([1.0, 0.0, 0.0]),
            ..CameraDesc::default()
        };
        let wide = wide.complete(&fallback).unwrap();
        assert_eq!(wide.up(), DVec3::X);
        let fov_y_radians = std::f64::consts::FRAC_PI_2;
        assert_eq!(wide.projection(), Projection::Perspective { fov_y_radians });

        let blind = CameraDesc { eye: Some([0.0; 3]), ..CameraDesc::default() };
        assert_eq!(blind.complete(&fallback), Err(CameraError::NoDirection));
    }
}
