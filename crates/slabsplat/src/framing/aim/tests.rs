//! Where eyes and pictures go.

use super::*;

fn camera(projection: Projection) -> Camera {
    Camera::new(DVec3::new(0.0, -10.0, 0.0), DVec3::ZERO, DVec3::Z, projection).unwrap()
}

const ORTHO: Projection = Projection::Orthographic { view_height: 4.0 };
const PERSPECTIVE: Projection = Projection::Perspective { fov_y_radians: 0.5 };

#[test]
fn aim_turns_right_up_and_counter_clockwise() {
    let check = |aim: Aim, eye: [f64; 3], up: [f64; 3]| {
        let turned = aim.turned(&camera(ORTHO)).unwrap();
        assert!(turned.eye().abs_diff_eq(eye.into(), 1e-9), "{aim:?}: {}", turned.eye());
        let axes = turned.axes();
        assert!(axes.up.abs_diff_eq(up.into(), 1e-9), "{aim:?}: {}", axes.up);
    };
    check(Aim::default(), [0.0, -10.0, 0.0], [0.0, 0.0, 1.0]);
    check(Aim::default().azimuth_degrees(90.0), [10.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    // Over the pole, where the up vector of before would be no help.
    check(Aim::default().elevation_degrees(90.0), [0.0, 0.0, 10.0], [0.0, 1.0, 0.0]);
    check(Aim::default().elevation_degrees(-90.0), [0.0, 0.0, -10.0], [0.0, -1.0, 0.0]);
    check(Aim::default().elevation_degrees(180.0), [0.0, 10.0, 0.0], [0.0, 0.0, -1.0]);
    // What was above is then on the left.
    check(Aim::default().roll_degrees(90.0), [0.0, -10.0, 0.0], [1.0, 0.0, 0.0]);
}

#[test]
fn aim_keeps_the_axis_that_a_camera_turns_about() {
    let turned = Aim::default().elevation_degrees(40.0).turned(&camera(ORTHO)).unwrap();
    assert_eq!(turned.up(), DVec3::Z);
}

/// Where a point is in the picture, in halves of its height from the middle.
fn seen(camera: &Camera, point: DVec3) -> [f64; 2] {
    let ViewAxes { right, up, forward } = camera.axes();
    let from_eye = point - camera.eye();
    let half = match camera.projection() {
        Projection::Orthographic { view_height } => 0.5 * view_height,
        Projection::Perspective { fov_y_radians } => {
            (0.5 * fov_y_radians).tan() * from_eye.dot(forward)
        }
    };
    [from_eye.dot(right) / half, from_eye.dot(up) / half]
}

#[test]
fn aim_moves_by_parts_of_the_picture_and_magnifies() {
    for projection in [ORTHO, PERSPECTIVE] {
        let before = camera(projection);
        let check = |aim: Aim, point: DVec3, expected: [f64; 2]| {
            let at = seen(&aim.moved(&before, 2.0).unwrap(), point);
            let is_there = (0..2).all(|axis| (at[axis] - expected[axis]).abs() < 1e-9);
            assert!(is_there, "{projection:?} {aim:?}: {at:?} should be {expected:?}");
        };
        // A picture twice as wide as it is high.
        check(Aim::default().pan([0.25, 0.1]), DVec3::ZERO, [1.0, 0.2]);
        let [x, y] = seen(&before, DVec3::new(0.5, 0.0, 0.2));
        check(Aim::default().zoom(3.0), DVec3::new(0.5, 0.0, 0.2), [3.0 * x, 3.0 * y]);
        let point = DVec3::new(3.0, 1.0, -7.0);
        check(Aim::default().look_at(point), point, [0.0, 0.0]);
        check(Aim::default().look_at(point).zoom(2.0).pan([0.5, 0.0]), point, [2.0, 0.0]);
        assert_eq!(Aim::default().moved(&before, 2.0), Ok(before));
    }
}

#[test]
fn aim_rejects_what_is_no_number() {
    for zoom in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(Aim::default().zoom(zoom).checked(), Err(AimError::BadZoom(_))), "{zoom}");
    }
    let bad = [
        Aim::default().azimuth_degrees(f64::NAN),
        Aim::default().elevation_degrees(f64::INFINITY),
        Aim::default().roll_degrees(f64::NAN),
        Aim::default().pan([0.0, f64::NAN]),
        Aim::default().look_at(DVec3::INFINITY),
    ];
    for aim in bad {
        assert!(matches!(aim.checked(), Err(AimError::NotFinite(_))), "{aim:?}");
    }
}
