//! A camera has its angle in degrees, and in radians where no number of degrees is that angle.

use serde::{Deserialize, Serialize};

use super::exact_degrees;
use crate::{Camera, Projection, ProjectionKind};

/// The keys of a camera.
#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct CameraKeys {
    projection: ProjectionKind,
    eye: [f64; 3],
    target: [f64; 3],
    up: [f64; 3],
    #[serde(skip_serializing_if = "Option::is_none")]
    view_height: Option<f64>,
    /// Degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    fov_y: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    fov_y_radians: Option<f64>,
}

impl TryFrom<CameraKeys> for Camera {
    type Error = String;

    fn try_from(keys: CameraKeys) -> Result<Self, String> {
        let CameraKeys { projection, eye, target, up, view_height, fov_y, fov_y_radians } = keys;
        let projection = match (projection, view_height, fov_y, fov_y_radians) {
            (ProjectionKind::Orthographic, Some(view_height), None, None) => {
                Projection::Orthographic { view_height }
            }
            (ProjectionKind::Perspective, None, Some(degrees), None) => {
                Projection::Perspective { fov_y_radians: degrees.to_radians() }
            }
            (ProjectionKind::Perspective, None, None, Some(fov_y_radians)) => {
                Projection::Perspective { fov_y_radians }
            }
            (ProjectionKind::Orthographic, ..) => {
                return Err("an orthographic camera has view_height, and no fov_y".to_owned());
            }
            (ProjectionKind::Perspective, ..) => {
                return Err("a perspective camera has fov_y, once, and no view_height".to_owned());
            }
        };
        Self::new(eye, target, up, projection).map_err(|error| error.to_string())
    }
}

impl From<Camera> for CameraKeys {
    fn from(camera: Camera) -> Self {
        let (view_height, radians) = match camera.projection() {
            Projection::Orthographic { view_height } => (Some(view_height), None),
            Projection::Perspective { fov_y_radians } => (None, Some(fov_y_radians)),
        };
        let fov_y = radians.and_then(exact_degrees);
        Self {
            projection: camera.projection().kind(),
            eye: camera.eye().to_array(),
            target: camera.target().to_array(),
            up: camera.up().to_array(),
            view_height,
            fov_y,
            fov_y_radians: radians.filter(|_| fov_y.is_none()),
        }
    }
}
