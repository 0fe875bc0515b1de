//! What mouse, touch and keys make of a camera. A move that numbers do not suffice for leaves it where it is.

use slabsplat::glam::{DVec2, DVec3};
use slabsplat::{Aim, Camera, Projection};
use std::f64::consts::PI;

/// Points of a view: from its middle to the right and upwards, in parts of its height.
pub type ViewPoint = DVec2;

/// The camera after a drag across parts of the view's height: what is in front goes with the pointer, half a
/// turn for all of the height.
pub fn orbited(camera: &Camera, drag: DVec2) -> Camera {
    let degrees = drag * PI.to_degrees();
    // Things are dragged, so that the camera goes the other way.
    let aim = Aim::default().azimuth_degrees(-degrees.x).elevation_degrees(-degrees.y);
    aim.turned(camera).unwrap_or(*camera)
}

/// The camera after the picture was turned counter-clockwise.
pub fn rolled(camera: &Camera, radians: f64) -> Camera {
    Aim::default().roll_degrees(radians.to_degrees()).turned(camera).unwrap_or(*camera)
}

/// The camera after the picture was dragged by parts of the view's height.
pub fn panned(camera: &Camera, drag: DVec2) -> Camera {
    Aim::default().pan(drag.into()).moved(camera, 1.0).unwrap_or(*camera)
}

/// The camera that shows all so many times as large; what is under the pointer stays there.
pub fn zoomed(camera: &Camera, at: ViewPoint, factor: f64) -> Camera {
    let moved = Aim::default().zoom(factor).pan((at * (1.0 - factor)).into()).moved(camera, 1.0);
    moved.ok().filter(is_sensible).unwrap_or(*camera)
}

/// The camera that has a point of the world in the middle, seen from where it was seen from.
pub fn centered_on(camera: &Camera, point: DVec3) -> Camera {
    let eye = camera.eye() + (point - camera.target());
    Camera::new(eye, point, camera.up(), camera.projection()).unwrap_or(*camera)
}

/// Degrees between the lower and the upper edge where rays leave an eye.
const FOV_Y: f64 = PI / 6.0;

/// The camera with the other projection; what lies as deep as its target is as large as before.
pub fn with_projection_switched(camera: &Camera) -> Camera {
    let to_eye = camera.eye() - camera.target();
    let (eye, projection) = match camera.projection() {
        Projection::Orthographic { view_height } => {
            let distance = 0.5 * view_height / (0.5 * FOV_Y).tan();
            let projection = Projection::Perspective { fov_y_radians: FOV_Y };
            (camera.target() + to_eye.normalize() * distance, projection)
        }
        Projection::Perspective { .. } => {
            (camera.eye(), Projection::Orthographic { view_height: height_at_target(camera) })
        }
    };
    Camera::new(eye, camera.target(), camera.up(), projection).unwrap_or(*camera)
}

/// World units from the lower to the upper edge of the picture, as deep as the target.
pub fn height_at_target(camera: &Camera) -> f64 {
    match camera.projection() {
        Projection::Orthographic { view_height } => view_height,
        Projection::Perspective { fov_y_radians } => {
            2.0 * (0.5 * fov_y_radians).tan() * camera.eye().distance(camera.target())
        }
    }
}

/// The ray that a point of the view sees: where it begins, and its direction, of length 1.
pub fn ray(camera: &Camera, at: ViewPoint) -> [DVec3; 2] {
    let axes = camera.axes();
    let beside = (axes.right * at.x + axes.up * at.y) * height_at_target(camera);
    match camera.projection() {
        Projection::Orthographic { .. } => [camera.eye() + beside, axes.forward],
        Projection::Perspective { .. } => {
            [camera.eye(), (camera.target() + beside - camera.eye()).normalize()]
        }
    }
}

/// Where the view shows a point of the world; `None` if that lies behind an eye.
pub fn seen_at(camera: &Camera, point: DVec3) -> Option<ViewPoint> {
    let (axes, to_point) = (camera.axes(), point - camera.eye());
    let beside = DVec2::new(to_point.dot(axes.right), to_point.dot(axes.up));
    let height = height_at_target(camera);
    match camera.projection() {
        Projection::Orthographic { .. } => Some(beside / height),
        Projection::Perspective { .. } => {
            let depth = to_point.dot(axes.forward);
            let shrunk = camera.eye().distance(camera.target()) / depth;
            (0.0 < depth).then(|| beside * shrunk / height)
        }
    }
}

/// How far a point goes along a direction of the world if it is dragged by parts of the view's height; 0
/// where the direction is seen end on.
pub fn slid(camera: &Camera, point: DVec3, direction: DVec3, drag: DVec2) -> f64 {
    let step = 1e-3 * height_at_target(camera);
    let ends = [point, point + direction * step].map(|point| seen_at(camera, point));
    let [Some(from), Some(to)] = ends else { return 0.0 };
    let along = (to - from) / step;
    let is_end_on = along.length() * height_at_target(camera) < 0.05;
    if is_end_on { 0.0 } else { drag.dot(along) / along.length_squared() }
}

/// Fields of view that a wheel reaches: what is nearly 180° or 0° shows nothing.
const SENSIBLE_FOV: std::ops::Range<f64> = 0.001..2.6;

fn is_sensible(camera: &Camera) -> bool {
    match camera.projection() {
        Projection::Orthographic { view_height } => {
            let reach = 1.0 + camera.target().abs().max_element();
            // Below that, positions of voxels are rounded to more than a pixel.
            1e-9 * reach < view_height && view_height < 1e9 * reach
        }
        Projection::Perspective { fov_y_radians } => SENSIBLE_FOV.contains(&fov_y_radians),
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// One of each projection, aside from all axes.
    pub(in crate::state) fn cameras() -> [Camera; 2] {
        let of = |projection| {
            let (eye, target) = (DVec3::new(9.0, 1.0, 3.0), DVec3::new(1.0, 0.0, 0.5));
            Camera::new(eye, target, DVec3::Z, projection).unwrap()
        };
        let orthographic = Projection::Orthographic { view_height: 4.0 };
        [of(orthographic), of(Projection::Perspective { fov_y_radians: 0.6 })]
    }

    #[test]
    fn what_is_in_front_goes_with_the_pointer() {
        for camera in cameras() {
            let towards_eye = (camera.eye() - camera.target()).normalize();
            let in_front = camera.target() + 0.5 * towards_eye;
            for drag in [DVec2::new(0.02, 0.0), DVec2::new(0.0, 0.02), DVec2::new(-0.03, 0.01)] {
                let moved = seen_at(&orbited(&camera, drag), in_front).unwrap();
                assert!(0.0 < moved.dot(drag), "{drag} has it at {moved}");
                let moved = seen_at(&panned(&camera, drag), camera.target()).unwrap();
                assert!(moved.distance(drag) < 1e-12, "{drag} has it at {moved}");
            }
        }
    }

    #[test]
    fn orbit_goes_all_around() {
        for camera in cameras() {
            let mut there = camera;
            for _ in 0..8 {
                there = orbited(&there, DVec2::new(0.25, 0.0));
            }
            assert!(there.eye().distance(camera.eye()) < 1e-9);
            for _ in 0..300 {
                there = orbited(&there, DVec2::new(0.013, 0.17));
                let distance = there.eye().distance(there.target());
                assert!((distance - camera.eye().distance(camera.target())).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn what_is_under_the_pointer_stays_there_in_a_zoom() {
        for camera in cameras() {
            let at = DVec2::new(0.3, -0.2);
            let axes = camera.axes();
            let height = height_at_target(&camera);
            let point = camera.target() + (axes.right * at.x + axes.up * at.y) * height;
            for factor in [0.5, 1.1, 3.0] {
                let zoomed = zoomed(&camera, at, factor);
                assert!(seen_at(&zoomed, point).unwrap().distance(at) < 1e-9);
                assert!((height_at_target(&zoomed) * factor / height - 1.0).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn zooms_have_ends() {
        for camera in cameras() {
            for factor in [0.5, 2.0] {
                let mut there = camera;
                for _ in 0..200 {
                    there = zoomed(&there, DVec2::ZERO, factor);
                }
                let once_more = zoomed(&there, DVec2::ZERO, factor);
                assert_eq!(there, once_more);
                assert!(height_at_target(&there).is_normal());
            }
        }
    }

    #[test]
    fn projections_show_the_target_as_large() {
        for camera in cameras() {
            let other = with_projection_switched(&camera);
            assert_ne!(other.projection().kind(), camera.projection().kind());
            let heights = [height_at_target(&camera), height_at_target(&other)];
            assert!((heights[0] / heights[1] - 1.0).abs() < 1e-9, "{heights:?}");
            let back = with_projection_switched(&other);
            assert!((height_at_target(&back) / heights[0] - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn what_slides_stays_under_the_pointer() {
        for camera in cameras() {
            let point = camera.target() + DVec3::new(0.1, 0.2, -0.1);
            let from = seen_at(&camera, point).unwrap();
            for direction in [DVec3::Y, DVec3::new(0.3, 0.8, 0.5).normalize()] {
                let far = seen_at(&camera, point + 0.1 * direction).unwrap() - from;
                let by = slid(&camera, point, direction, far);
                assert!((by - 0.1).abs() < 0.01, "{by}");
            }
            let end_on = camera.axes().forward;
            assert_eq!(slid(&camera, camera.target(), end_on, DVec2::ONE), 0.0);
        }
    }

    #[test]
    fn rays_go_through_what_is_seen() {
        for camera in cameras() {
            for at in [DVec2::ZERO, DVec2::new(0.4, 0.1), DVec2::new(-0.2, -0.5)] {
                let [from, along] = ray(&camera, at);
                for distance in [2.0, 7.0] {
                    let seen = seen_at(&camera, from + along * distance).unwrap();
                    assert!(seen.distance(at) < 1e-9, "{at} is seen at {seen}");
                }
            }
            let rolled = rolled(&camera, PI / 2.0);
            let point = camera.target() + camera.axes().right;
            let seen = seen_at(&rolled, point).unwrap();
            assert!(0.0 < seen.y && seen.x.abs() < 1e-9, "to the left it goes up: {seen}");
            let centered = centered_on(&camera, point);
            assert!(seen_at(&centered, point).unwrap().length() < 1e-9);
        }
    }
}
