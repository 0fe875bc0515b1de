//! How the camera moves while the meter reads.

use slabsplat_core::{Camera, CameraError};
use thiserror::Error;

/// A motion of the camera in equal steps.
///
/// ```
/// use slabsplat::Sweep;
///
/// let quarter = Sweep::turn(0.0, 90.0);
/// assert_eq!((quarter.step, quarter.n_frames()), (1.0, 91));
/// assert_eq!(quarter.step(0.5).n_frames(), 181);
///
/// let eightfold = Sweep::zoom(1.0, 8.0).step(2.0);
/// assert_eq!([0, 1, 2, 3].map(|frame_idx| eightfold.at(frame_idx)), [1.0, 2.0, 4.0, 8.0]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Sweep {
    /// What the camera does.
    pub motion: Motion,
    /// The angle, or the magnification, of the first frame.
    pub from: f64,
    /// That which the last frame does not pass.
    pub to: f64,
    /// The angle between two frames, or the factor from one to the next.
    pub step: f64,
}

/// What the camera does in a [`Sweep`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Motion {
    /// It turns about its target, around its up vector, by degrees from where it is in the scene.
    Turn,
    /// It magnifies, so many times as much as in the scene.
    Zoom,
}

/// Why there are no frames to be measured, or too many.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum SweepError {
    /// A number is not finite, or the step is not positive.
    #[error("a sweep needs finite angles and a positive step, not {0} to {1} in steps of {2}")]
    BadNumbers(f64, f64, f64),
    /// A number is not finite or not positive, or every step the same.
    #[error(
        "a zoom needs positive factors and a step other than 1, not {0} to {1} in steps of {2}"
    )]
    BadFactors(f64, f64, f64),
    /// Fewer than three frames: no change to compare another with.
    #[error("a sweep from {0} to {1} in steps of {2} has fewer than 3 frames")]
    TooShort(f64, f64, f64),
    /// More frames than anyone waits for.
    #[error("a sweep from {0} to {1} in steps of {2} has more than 100000 frames")]
    TooLong(f64, f64, f64),
}

const MAX_FRAMES: f64 = 1e5;

impl Sweep {
    /// A turn from one angle to another, in degrees from the scene's camera, a degree between two frames.
    pub const fn turn(from: f64, to: f64) -> Self {
        Self { motion: Motion::Turn, from, to, step: 1.0 }
    }

    /// From one magnification to another, each frame 1.01 times as large as the one before.
    pub const fn zoom(from: f64, to: f64) -> Self {
        Self { motion: Motion::Zoom, from, to, step: 1.01 }
    }

    /// The same with other steps.
    #[must_use]
    pub const fn step(self, step: f64) -> Self {
        Self { step, ..self }
    }

    /// The same, if it has at least three frames.
    ///
    /// # Errors
    /// If a number is not finite, or not positive where it must be, or there are too few or too many frames.
    pub fn checked(self) -> Result<Self, SweepError> {
        let Self { motion, from, to, step } = self;
        let are_finite = [from, to, step].iter().all(|v| v.is_finite());
        match motion {
            Motion::Turn if !are_finite || step <= 0.0 => {
                return Err(SweepError::BadNumbers(from, to, step));
            }
            Motion::Zoom if !are_finite || from.min(to).min(step) <= 0.0 || step == 1.0 => {
                return Err(SweepError::BadFactors(from, to, step));
            }
            Motion::Turn | Motion::Zoom => (),
        }
        if MAX_FRAMES < self.n_steps() + 1.0 {
            return Err(SweepError::TooLong(from, to, step));
        }
        if self.n_frames() < 3 {
            return Err(SweepError::TooShort(from, to, step));
        }
        Ok(self)
    }

    /// How many frames there are.
    pub fn n_frames(&self) -> usize {
        // The last step may miss the end by a rounding error.
        (self.n_steps() + 1e-9).floor().max(0.0) as usize + 1
    }

    /// The angle of a frame, or its magnification.
    pub fn at(&self, frame_idx: usize) -> f64 {
        match self.motion {
            Motion::Turn => self.from + frame_idx as f64 * self.step,
            Motion::Zoom => self.from * self.step.powf(frame_idx as f64),
        }
    }

    /// The camera of a frame, of that of the scene.
    ///
    /// # Errors
    /// If it magnifies more than numbers suffice for.
    pub fn camera(&self, of_scene: &Camera, frame_idx: usize) -> Result<Camera, CameraError> {
        let at = self.at(frame_idx);
        match self.motion {
            Motion::Turn => Ok(of_scene.orbited(at.to_radians())),
            Motion::Zoom => of_scene.magnified(at),
        }
    }

    fn n_steps(&self) -> f64 {
        let Self { from, to, step, .. } = *self;
        match self.motion {
            Motion::Turn => (to - from) / step,
            Motion::Zoom => (to.ln() - from.ln()) / step.ln(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TURN: Sweep = Sweep::turn(0.0, 90.0).step(0.1);

    #[test]
    fn sweep_reaches_its_end() {
        assert_eq!(TURN.checked().unwrap().n_frames(), 901);
        let short = Sweep::turn(0.0, 0.15).step(0.1);
        assert!(matches!(short.checked(), Err(SweepError::TooShort(..))));
        let back = Sweep::turn(0.0, -9.0).step(0.1);
        assert!(matches!(back.checked(), Err(SweepError::TooShort(..))));
        let still = TURN.step(0.0);
        assert!(matches!(still.checked(), Err(SweepError::BadNumbers(..))));
        let fine = TURN.step(1e-9);
        assert!(matches!(fine.checked(), Err(SweepError::TooLong(..))));
    }

    #[test]
    fn sweep_zooms_either_way() {
        for (from, to, step, n_frames) in
            [(0.5, 8.0, 2.0, 5), (8.0, 0.5, 0.5, 5), (1.0, 2.0, 1.01, 70)]
        {
            let sweep = Sweep::zoom(from, to).step(step).checked().unwrap();
            assert_eq!(sweep.n_frames(), n_frames);
            let last = sweep.at(n_frames - 1);
            assert!((last - to).abs() < 0.01 * to && (last <= to + 1e-9 || step < 1.0), "{last}");
        }
        for (from, to, step) in
            [(0.0, 2.0, 1.1), (1.0, -2.0, 1.1), (1.0, 2.0, 1.0), (1.0, f64::NAN, 1.1)]
        {
            let error = Sweep::zoom(from, to).step(step).checked().unwrap_err();
            assert!(matches!(error, SweepError::BadFactors(..)), "{error}");
        }
        for (from, to, step) in [(1.0, 2.0, 0.9), (2.0, 1.0, 1.1), (1.0, 1.1, 1.09)] {
            let error = Sweep::zoom(from, to).step(step).checked().unwrap_err();
            assert!(matches!(error, SweepError::TooShort(..)), "{error}");
        }
        assert!(matches!(
            Sweep::zoom(1.0, 2.0).step(1.000001).checked(),
            Err(SweepError::TooLong(..))
        ));
    }
}
