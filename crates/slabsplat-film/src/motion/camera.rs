//! Cameras over time: around what they look at, not through it.
//!
//! A camera is what it looks at, how far away it is, how much it shows, and a rotation. Rotations go from key
//! to key by a cubic curve of unit quaternions (Kim, Kim & Shin 1995) whose speeds at keys are limited as
//! those of numbers are; between two keys that is a turn about one axis at one speed. What is upwards comes
//! from the cameras' own up vectors, so that the horizon stays level where it is so in all keys.

use super::MotionError;
use super::track::{Moment, Track};
use slabsplat_core::glam::{DMat3, DQuat, DVec3};
use slabsplat_core::{Camera, Projection, ProjectionKind, ViewAxes};

#[derive(Clone, Debug, PartialEq)]
pub(super) struct CameraPath {
    track: Track,
    cameras: Vec<Camera>,
    poses: Vec<Pose>,
    /// Rotation vectors from each key to the next.
    turns: Vec<DVec3>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Pose {
    /// From the camera's axes: right, up and towards the eye.
    world_from_camera: DQuat,
    /// Of the distance between eye and target, and of the size of what is shown at the target: logarithms,
    /// since what doubles in a second doubles in the next.
    logs: [f64; 2],
}

impl CameraPath {
    /// # Errors
    /// If the cameras are of both projections.
    pub(super) fn new(track: Track, cameras: Vec<Camera>) -> Result<Self, MotionError> {
        let kind = |camera: &Camera| camera.projection().kind();
        if cameras.windows(2).any(|pair| kind(&pair[0]) != kind(&pair[1])) {
            return Err(MotionError::TwoProjections);
        }
        let poses: Vec<Pose> = cameras.iter().map(Pose::of).collect();
        let pairs = poses.windows(2).zip(&cameras);
        let turns = pairs.map(|(pair, camera)| {
            let turn =
                rotation_vector(pair[1].world_from_camera * pair[0].world_from_camera.inverse());
            // Half a turn may go either way; the camera goes to its own right.
            let is_half = std::f64::consts::PI - 1e-6 < turn.length();
            if is_half && turn.dot(camera.up()) < 0.0 { -turn } else { turn }
        });
        let turns = turns.collect();
        Ok(Self { track, cameras, poses, turns })
    }

    /// # Errors
    /// If numbers do not suffice.
    pub(super) fn at(&self, seconds: f64) -> Result<Camera, MotionError> {
        let moment = self.track.at(seconds);
        let key_idx = moment.segment + usize::from(moment.part == 1.0);
        if moment.part == 0.0 || moment.part == 1.0 {
            return Ok(self.cameras[key_idx]);
        }
        let vector = |of: fn(&Camera) -> DVec3| {
            let axis = |axis: usize| self.track.number(moment, |idx| of(&self.cameras[idx])[axis]);
            DVec3::from_array([0, 1, 2].map(axis))
        };
        let log = |which: usize| self.track.number(moment, |idx| self.poses[idx].logs[which]).exp();
        let world_from_camera = self.rotation(moment);
        let (target, distance) = (vector(Camera::target), log(0));
        let eye = target + world_from_camera * DVec3::Z * distance;
        let projection = match self.cameras[0].projection().kind() {
            ProjectionKind::Orthographic => Projection::Orthographic { view_height: log(1) },
            ProjectionKind::Perspective => {
                Projection::Perspective { fov_y_radians: 2.0 * log(1).atan() }
            }
        };
        let up = vector(|camera| camera.up().normalize());
        let level = Camera::new(eye, target, up, projection);
        let camera =
            level.or_else(|_| Camera::new(eye, target, world_from_camera * DVec3::Y, projection));
        Ok(camera?)
    }

    fn rotation(&self, Moment { segment, part: t }: Moment) -> DQuat {
        let [from, to] = [segment, segment + 1].map(|idx| self.poses[idx].world_from_camera);
        let third = self.track.duration(segment) / 3.0;
        let speed = |key_idx: usize| {
            let axis = |axis: usize| self.track.slope(key_idx, |segment| self.turns[segment][axis]);
            DVec3::from_array([0, 1, 2].map(axis))
        };
        let (first, last) = (speed(segment) * third, speed(segment + 1) * third);
        let turn = DQuat::from_scaled_axis;
        let middle = rotation_vector(turn(-last) * to * (turn(first) * from).inverse());
        let u = 1.0 - t;
        // Sums of Bernstein's polynomials, each from 0 to 1.
        let shares = [1.0 - u * u * u, t * t * (3.0 - 2.0 * t), t * t * t];
        (turn(last * shares[2]) * turn(middle * shares[1]) * turn(first * shares[0]) * from)
            .normalize()
    }
}

impl Pose {
    fn of(camera: &Camera) -> Self {
        let ViewAxes { right, up, forward } = camera.axes();
        let distance = camera.eye().distance(camera.target());
        let size = match camera.projection() {
            Projection::Orthographic { view_height } => view_height,
            Projection::Perspective { fov_y_radians } => (0.5 * fov_y_radians).tan(),
        };
        Self {
            world_from_camera: DQuat::from_mat3(&DMat3::from_cols(right, up, -forward)),
            logs: [distance.ln(), size.ln()],
        }
    }
}

/// Axis times angle of the shorter way, at most π long.
fn rotation_vector(rotation: DQuat) -> DVec3 {
    let shorter = if rotation.w < 0.0 { -rotation } else { rotation };
    shorter.to_scaled_axis()
}

#[cfg(test)]
mod tests {
    use super::super::track::tests::largest_kink;
    use super::*;
    use slabsplat_core::Easing;

    const VIEW: Projection = Projection::Perspective { fov_y_radians: 0.5 };

    fn from(eye: [f64; 3]) -> Camera {
        Camera::new(eye, [0.0; 3], [0.0, 0.0, 1.0], VIEW).unwrap()
    }

    fn path(keys: &[(f64, Camera)], is_loop: bool) -> CameraPath {
        let track = Track::new(keys.iter().map(|key| (key.0, Easing::Linear)), is_loop);
        CameraPath::new(track, keys.iter().map(|key| key.1).collect()).unwrap()
    }

    #[test]
    fn camera_goes_around_its_target_at_one_speed() {
        let there = path(&[(0.0, from([0.0, -8.0, 0.0])), (2.0, from([0.0, 8.0, 0.0]))], false);
        for step in 0..=20 {
            let seconds = f64::from(step) / 10.0;
            let eye = there.at(seconds).unwrap().eye();
            let angle = std::f64::consts::PI * seconds / 2.0;
            let expected = DVec3::new(8.0 * angle.sin(), -8.0 * angle.cos(), 0.0);
            assert!(eye.abs_diff_eq(expected, 1e-6), "{seconds}: {eye} and not {expected}");
        }
    }

    #[test]
    fn camera_passes_through_keys_smoothly() {
        let keys = [
            (0.0, from([0.0, -8.0, 1.0])),
            (1.0, from([6.0, -6.0, 2.0])),
            (2.5, from([7.0, 3.0, 5.0])),
            (3.0, from([5.0, 6.0, 4.0])),
        ];
        let there = path(&keys, false);
        for (seconds, camera) in keys {
            assert_eq!(there.at(seconds).unwrap(), camera);
            let near = there.at(seconds + 1e-9).unwrap().eye();
            assert!(near.abs_diff_eq(camera.eye(), 1e-6), "{seconds}");
        }
        for axis in 0..3 {
            let kink = largest_kink(|seconds| there.at(seconds).unwrap().eye()[axis], 3.0);
            // The eye goes some 10 units a second.
            assert!(kink < 0.2, "axis {axis}: {kink}");
        }
        // The horizon is level: what is right in the picture is so in the world.
        for step in 0..30 {
            let right = there.at(f64::from(step) / 10.0).unwrap().axes().right;
            assert!(right.z.abs() < 1e-12, "{right}");
        }
    }

    #[test]
    fn camera_rests_between_equal_keys() {
        let (a, b) = (from([0.0, -8.0, 1.0]), from([6.0, -6.0, 2.0]));
        let there = path(&[(0.0, a), (1.0, b), (2.0, b), (3.0, a)], false);
        for seconds in [1.0, 1.3, 1.7, 2.0] {
            assert!(there.at(seconds).unwrap().eye().abs_diff_eq(b.eye(), 1e-12), "{seconds}");
        }
    }

    #[test]
    fn camera_zooms_by_equal_factors() {
        let parallel = |view_height| {
            let projection = Projection::Orthographic { view_height };
            Camera::new([0.0, -8.0, 0.0], [0.0; 3], [0.0, 0.0, 1.0], projection).unwrap()
        };
        let there = path(&[(0.0, parallel(1.0)), (2.0, parallel(16.0))], false);
        let Projection::Orthographic { view_height } = there.at(1.0).unwrap().projection() else {
            panic!("it is orthographic")
        };
        assert!((view_height - 4.0).abs() < 1e-12, "{view_height}");
        let track = Track::new([(0.0, Easing::Linear), (1.0, Easing::Linear)], false);
        let both = CameraPath::new(track, vec![parallel(1.0), from([1.0; 3])]);
        assert_eq!(both, Err(MotionError::TwoProjections));
    }

    #[test]
    fn camera_over_the_pole_has_an_up() {
        let above = Camera::new([0.0, -1e-3, 8.0], [0.0; 3], [0.0, 0.0, 1.0], VIEW).unwrap();
        let there = path(
            &[(0.0, from([0.0, -8.0, 0.0])), (1.0, above), (2.0, from([0.0, 8.0, 0.0]))],
            false,
        );
        for step in 0..=40 {
            there.at(f64::from(step) / 20.0).unwrap();
        }
    }
}
