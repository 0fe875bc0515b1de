//! What two fingers make of a camera: what they touch stays under them.

use super::{ViewPoint, panned, rolled, zoomed};
use slabsplat::Camera;
use slabsplat::glam::DVec2;

/// What fingers did since the frame before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// The middle between them, where it is now.
    pub center: ViewPoint,
    /// How far that went, in parts of the view's height.
    pub moved: DVec2,
    /// By how much they went apart: above 1 if they did.
    pub spread: f64,
    /// The angle about each other, counter-clockwise, in radians.
    pub turned: f64,
}

/// The camera after fingers moved: what lies as deep as its target goes with them, as a sheet of paper does
/// on a table.
pub fn touched(camera: &Camera, touch: Touch) -> Camera {
    let camera = panned(camera, touch.moved);
    let camera = zoomed(&camera, touch.center, touch.spread);
    if touch.turned == 0.0 {
        return camera;
    }
    // A camera rolls about the middle of the view, and fingers about their own.
    let turn = DVec2::from_angle(touch.turned);
    panned(&rolled(&camera, touch.turned), touch.center - turn.rotate(touch.center))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state::camera_moves::tests::cameras;
    use crate::state::{height_at_target, seen_at};

    /// What two fingers do that go from `before` to `after`.
    fn of_fingers(before: [DVec2; 2], after: [DVec2; 2]) -> Touch {
        let center = |fingers: [DVec2; 2]| 0.5 * (fingers[0] + fingers[1]);
        let between = |fingers: [DVec2; 2]| fingers[1] - fingers[0];
        Touch {
            center: center(after),
            moved: center(after) - center(before),
            spread: between(after).length() / between(before).length(),
            turned: between(before).angle_to(between(after)),
        }
    }

    #[test]
    fn what_fingers_touch_stays_under_them() {
        let v = DVec2::new;
        let fingers = [
            // Apart and together, aside, about each other, and all of it.
            ([v(0.1, 0.0), v(0.3, 0.1)], [v(0.0, -0.05), v(0.4, 0.15)]),
            ([v(-0.4, 0.3), v(0.3, -0.2)], [v(-0.2, 0.2), v(0.1, -0.1)]),
            ([v(0.1, 0.0), v(0.3, 0.1)], [v(0.2, -0.1), v(0.4, 0.0)]),
            ([v(0.1, 0.0), v(0.3, 0.0)], [v(0.2, -0.1), v(0.2, 0.1)]),
            ([v(0.2, 0.3), v(-0.1, -0.2)], [v(0.35, 0.1), v(-0.2, -0.15)]),
        ];
        for camera in cameras() {
            let axes = camera.axes();
            let in_world = |at: DVec2| {
                camera.target() + (axes.right * at.x + axes.up * at.y) * height_at_target(&camera)
            };
            for (before, after) in fingers {
                let moved = touched(&camera, of_fingers(before, after));
                for (before, after) in before.into_iter().zip(after) {
                    let seen = seen_at(&moved, in_world(before)).unwrap();
                    assert!(seen.distance(after) < 1e-9, "{after} has it at {seen}");
                }
            }
        }
    }

    #[test]
    fn fingers_that_rest_move_nothing() {
        for camera in cameras() {
            let fingers = [DVec2::new(0.1, 0.2), DVec2::new(-0.3, 0.0)];
            assert_eq!(touched(&camera, of_fingers(fingers, fingers)), camera);
        }
    }
}
