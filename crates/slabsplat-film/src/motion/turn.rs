//! A camera that goes around: a turntable, on which the thing turns before camera and lights that stand
//! still.

use super::MotionError;
use slabsplat_core::glam::DQuat;
use slabsplat_core::{Camera, Light, LightSource, Scene, TurnAxis};
use std::f64::consts::TAU;

/// A camera that goes around in equal steps, or to and fro.
///
/// ```
/// use slabsplat_core::TurnAxis;
/// use slabsplat_film::Turn;
///
/// let turn = Turn::new(TurnAxis::Up, 360.0, 12);
/// assert_eq!(turn.degrees_at(1), 30.0);
/// assert_eq!(turn.rocking().degrees_at(3), 180.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Turn {
    /// Around what.
    pub axis: TurnAxis,
    /// From the first frame to the last, or if it rocks, from one side to the other; negative the other way
    /// round.
    pub degrees: f64,
    /// Whether it goes to and fro about where it begins, slowest at either side.
    pub is_rocking: bool,
    /// How many frames there are.
    pub n_frames: u32,
}

/// Degrees between two views. What stands 24 times as far out as it is wide is cut off by 1 % between them,
/// and pictures are filled to 95 %.
const VIEW_STEP_DEGREES: f64 = 7.5;

impl Turn {
    /// So far about that axis, in so many frames.
    pub fn new(axis: TurnAxis, degrees: f64, n_frames: u32) -> Self {
        Self { axis, degrees, is_rocking: false, n_frames }
    }

    /// The same to and fro.
    #[must_use]
    pub fn rocking(self) -> Self {
        Self { is_rocking: true, ..self }
    }

    /// How far the camera has gone in a frame, in degrees.
    ///
    /// The last frame of a whole turn is a step before the first one, so that a film that is shown again and
    /// again has no frame twice; a part of a turn ends where it says.
    pub fn degrees_at(&self, frame_idx: u32) -> f64 {
        let (idx, n_frames) = (f64::from(frame_idx), f64::from(self.n_frames.max(1)));
        if self.is_rocking {
            return 0.5 * self.degrees * (TAU * idx / n_frames).sin();
        }
        let is_whole = self.degrees % 360.0 == 0.0;
        let n_steps = if is_whole { n_frames } else { (n_frames - 1.0).max(1.0) };
        self.degrees * idx / n_steps
    }

    /// The camera of a frame.
    ///
    /// # Errors
    /// If numbers do not suffice.
    pub fn camera_at(&self, camera: &Camera, frame_idx: u32) -> Result<Camera, MotionError> {
        turned(camera, self.rotation_at(camera, frame_idx))
    }

    /// Cameras on the way, close enough to tell what is seen from all of it; however long the film is, they
    /// are few.
    pub fn views(&self, camera: &Camera) -> Vec<Camera> {
        let span = self.degrees.abs().min(360.0);
        let n_steps = (span / VIEW_STEP_DEGREES).ceil().max(1.0);
        let from = if self.is_rocking { -0.5 * span } else { 0.0 };
        let view = |idx: u32| {
            let degrees = from + span * f64::from(idx) / n_steps;
            let radians = degrees * self.degrees.signum().to_radians();
            turned(camera, DQuat::from_axis_angle(self.axis.direction(camera), radians))
        };
        // Where numbers do not suffice for a camera, there is no frame either.
        (0..=n_steps as u32).filter_map(|idx| view(idx).ok()).collect()
    }

    /// The scene of a frame: camera and lights are turned.
    ///
    /// # Errors
    /// If numbers do not suffice.
    pub fn scene_at(&self, scene: &Scene, frame_idx: u32) -> Result<Scene, MotionError> {
        let rotation = self.rotation_at(&scene.camera, frame_idx);
        let camera = turned(&scene.camera, rotation)?;
        let lights = scene.lights.iter().map(|light| match light.source {
            LightSource::Headlight => Ok(*light),
            LightSource::Direction(towards) => {
                Ok(Light::towards(rotation * towards.get())?.color(light.color))
            }
        });
        let lights = lights.collect::<Result<_, MotionError>>()?;
        Ok(scene.clone().camera(camera).lights(lights))
    }

    fn rotation_at(&self, camera: &Camera, frame_idx: u32) -> DQuat {
        let radians = self.degrees_at(frame_idx).to_radians();
        DQuat::from_axis_angle(self.axis.direction(camera), radians)
    }
}

fn turned(camera: &Camera, rotation: DQuat) -> Result<Camera, MotionError> {
    if rotation == DQuat::IDENTITY {
        return Ok(*camera);
    }
    let target = camera.target();
    let eye = target + rotation * (camera.eye() - target);
    Ok(Camera::new(eye, target, rotation * camera.up(), camera.projection())?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::glam::DVec3;
    use slabsplat_core::{Projection, ViewAxes};

    fn turn(degrees: f64, is_rocking: bool, n_frames: u32) -> Turn {
        Turn { axis: TurnAxis::Up, degrees, is_rocking, n_frames }
    }

    fn camera() -> Camera {
        let projection = Projection::Orthographic { view_height: 4.0 };
        Camera::new([3.0, -9.0, 5.0], [1.0, 2.0, 3.0], [0.0, 0.0, 2.0], projection).unwrap()
    }

    #[test]
    fn turn_is_seamless() {
        let degrees =
            |turn: Turn| (0..turn.n_frames).map(|idx| turn.degrees_at(idx)).collect::<Vec<_>>();
        assert_eq!(degrees(turn(360.0, false, 4)), [0.0, 90.0, 180.0, 270.0]);
        assert_eq!(degrees(turn(-720.0, false, 4)), [0.0, -180.0, -360.0, -540.0]);
        assert_eq!(degrees(turn(90.0, false, 4)), [0.0, 30.0, 60.0, 90.0]);
        assert_eq!(degrees(turn(360.0, false, 1)), [0.0]);
        assert_eq!(degrees(turn(90.0, false, 1)), [0.0]);
        let rock = degrees(turn(60.0, true, 8));
        assert!(rock.iter().all(|degrees| degrees.abs() <= 30.0));
        assert_eq!((rock[0], rock[2]), (0.0, 30.0));
        assert!((rock[6] + 30.0).abs() < 1e-12 && (rock[4]).abs() < 1e-12);
    }

    #[test]
    fn turn_about_up_is_an_orbit() {
        let turn = turn(360.0, false, 8);
        for idx in 0..8 {
            let [by_turn, orbited] = [
                turn.camera_at(&camera(), idx).unwrap(),
                camera().orbited(turn.degrees_at(idx).to_radians()),
            ];
            assert!(by_turn.eye().abs_diff_eq(orbited.eye(), 1e-12), "{idx}");
        }
        let over = Turn { axis: TurnAxis::Right, ..turn };
        let eye = over.camera_at(&camera(), 4).unwrap();
        assert!(eye.eye().abs_diff_eq(DVec3::new(-1.0, 13.0, 1.0), 1e-12), "{}", eye.eye());
        assert!(eye.up().z < 0.0, "it stands on its head there");
    }

    #[test]
    fn turn_has_views_of_all_of_it() {
        let angles = |turn: Turn| {
            let [right, forward] = [camera().axes().right, camera().axes().forward];
            let axis = DVec3::Z;
            let flat = (forward - axis * forward.dot(axis)).normalize();
            let angle = |view: Camera| {
                let there = view.axes().forward;
                (-there.dot(right)).atan2(there.dot(flat)).to_degrees()
            };
            let angles: Vec<f64> = turn.views(&camera()).into_iter().map(angle).collect();
            angles
                .iter()
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], c| [a.min(*c), b.max(*c)])
        };
        let near = |found: [f64; 2], expected: [f64; 2]| {
            assert!(
                found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9),
                "{found:?} {expected:?}"
            );
        };
        near(angles(turn(60.0, true, 5)), [-30.0, 30.0]);
        near(angles(turn(60.0, false, 5)), [0.0, 60.0]);
        near(angles(turn(-60.0, false, 5)), [-60.0, 0.0]);
        assert_eq!(turn(36_000.0, false, 9).views(&camera()).len(), 49);
    }

    #[test]
    fn turn_has_lights_stand_still() {
        use slabsplat_core::{Layer, Samples, Scaling, TransferFunction, Volume};
        let grid = slabsplat_core::Grid::with_spacing([1, 1, 1], [1.0; 3]).unwrap();
        let volume = Volume::new(grid, Samples::U8(vec![1]), Scaling::IDENTITY).unwrap();
        let transfer = TransferFunction::new([(0.0, 1.0)], [(0.0, [1.0; 3])]).unwrap();
        let lights = vec![Light::towards([1.0, 2.0, 3.0]).unwrap(), Light::default()];
        let scene = Scene::new(Layer::new(volume, transfer), camera()).lights(lights);
        let seen = |scene: &Scene| {
            let LightSource::Direction(towards) = scene.lights[0].source else {
                panic!("it has one")
            };
            let ViewAxes { right, up, forward } = scene.camera.axes();
            [right, up, forward].map(|axis| axis.dot(towards.get()))
        };
        let there = turn(360.0, false, 5).scene_at(&scene, 2).unwrap();
        for (before, after) in seen(&scene).into_iter().zip(seen(&there)) {
            assert!((before - after).abs() < 1e-12, "{before} {after}");
        }
        assert_eq!(there.lights[1], Light::default());
    }
}
