//! Where a camera has to be so that a picture is filled.

use slabsplat_core::glam::DVec3;
use slabsplat_core::{Camera, CameraError, ImageDesc, Projection};

use super::silhouette::{Axes, Seen};

/// The share of a picture's side that what is seen fills.
const FILLED: f64 = 0.95;

/// How far an orthographic camera is from the middle, in sizes of what is seen: nothing is before it, also
/// when it turns.
const DISTANCE: f64 = 3.0;

/// A camera looking along `to_eye` backwards, that has all of `seen` in its picture.
///
/// An orthographic one fits the box around it. In a perspective view each of the four sides of the picture is
/// a plane through the eye; the eye is as near as all four allow.
///
/// # Errors
/// If numbers do not suffice.
pub(super) fn fitting(
    seen: &[Seen],
    [right, up, forward]: [DVec3; 3],
    world_up: DVec3,
    projection: Projection,
    image: &ImageDesc,
) -> Result<Camera, CameraError> {
    let nothing = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    let [min, max] = seen.iter().fold(nothing, |[min, max], seen| {
        [min.min(seen.middle - seen.reach), max.max(seen.middle + seen.reach)]
    });
    let middle = min.midpoint(max);
    let size = max - min;
    let aspect = f64::from(image.width) / f64::from(image.height);
    let in_world = |v: DVec3| right * v.x + up * v.y + forward * v.z;
    let (eye, target, projection) = match projection {
        Projection::Orthographic { .. } => {
            let view_height = size.y.max(size.x / aspect) / FILLED;
            let eye = middle - DVec3::Z * (DISTANCE * size.length());
            (eye, middle, Projection::Orthographic { view_height })
        }
        Projection::Perspective { fov_y_radians } => {
            let slope = FILLED * (0.5 * fov_y_radians).tan();
            let (x, z_by_x) = between_planes(seen, 0, slope * aspect);
            let (y, z_by_y) = between_planes(seen, 1, slope);
            let eye = DVec3::new(x, y, z_by_x.min(z_by_y));
            (eye, DVec3::new(x, y, middle.z.max(eye.z + 0.5 * size.z)), projection)
        }
    };
    Camera::new(in_world(eye), in_world(target), world_up, projection)
}

/// The camera moved so that the pictures of all `views`, which turn with it about its target, hold what each
/// of them sees. It looks in the same direction, at the middle of it all.
///
/// # Errors
/// If numbers do not suffice.
pub(super) fn around(
    camera: &Camera,
    views: &[(Axes, Vec<Seen>)],
    image: &ImageDesc,
) -> Result<Camera, CameraError> {
    let target = middle_of(camera, views);
    let aspect = f64::from(image.width) / f64::from(image.height);
    let forward = camera.axes().forward;
    let of_all = |needed: &dyn Fn(DVec3, DVec3) -> f64| {
        let of_view = |(axes, seen): &(Axes, Vec<Seen>)| {
            let middle = DVec3::from_array(axes.map(|axis| axis.dot(target)));
            let needed = seen.iter().map(|seen| needed(seen.middle - middle, seen.reach));
            needed.fold(f64::NEG_INFINITY, f64::max)
        };
        views.iter().map(of_view).fold(f64::NEG_INFINITY, f64::max)
    };
    let (distance, projection) = match camera.projection() {
        Projection::Orthographic { .. } => {
            let height = |at: DVec3, reach: DVec3| {
                let half = at.abs() + reach;
                2.0 * half.y.max(half.x / aspect) / FILLED
            };
            let view_height = of_all(&height);
            let size = of_all(&|at, reach| 2.0 * (at.abs() + reach).length());
            (DISTANCE * size, Projection::Orthographic { view_height })
        }
        projection @ Projection::Perspective { fov_y_radians } => {
            let slope = FILLED * (0.5 * fov_y_radians).tan();
            let distance = |at: DVec3, reach: DVec3| {
                let half = at.abs() + reach;
                half.y.max(half.x / aspect) / slope - (at.z - reach.z)
            };
            (of_all(&distance), projection)
        }
    };
    Camera::new(target - forward * distance, target, camera.up(), projection)
}

/// The middle of the box, along the camera's axes, around what any of the views sees.
fn middle_of(camera: &Camera, views: &[(Axes, Vec<Seen>)]) -> DVec3 {
    let own = camera.axes();
    let own = [own.right, own.up, own.forward];
    let along = |[right, up, forward]: Axes, v: DVec3| right * v.x + up * v.y + forward * v.z;
    let nothing = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    let [min, max] = views.iter().fold(nothing, |ends, (axes, seen)| {
        seen.iter().fold(ends, |[min, max], seen| {
            let point = along(*axes, seen.middle);
            let at = DVec3::from_array(own.map(|axis| axis.dot(point)));
            [min.min(at), max.max(at)]
        })
    });
    along(own, min.midpoint(max))
}

/// Where an eye is along an axis of the picture, and at which depth, whose two planes of that slope touch all
/// that is seen.
fn between_planes(seen: &[Seen], axis: usize, slope: f64) -> (f64, f64) {
    let offset = |sign: f64| {
        let of = |seen: &Seen| {
            sign * seen.middle[axis] + seen.reach[axis] - slope * (seen.middle.z - seen.reach.z)
        };
        seen.iter().map(of).fold(f64::NEG_INFINITY, f64::max)
    };
    let [above, below] = [offset(1.0), offset(-1.0)];
    (0.5 * (above - below), -0.5 * (above + below) / slope)
}
