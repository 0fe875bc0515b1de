//! The popping meter: figures 2 and 6 of the paper as one number, and two that see what it cannot.
//!
//! The camera turns about its target in equal steps. Between two frames the picture changes; if the
//! method is sound, by about as much in every step. The *pop ratio* is the largest change over the
//! median one: near 1 where nothing pops, large where one step changes far more than the others.
//!
//! What flickers in every frame has a pop ratio of 1. *Jitter* is the mean second difference of frames over
//! the mean first one: 0 if every pixel changes evenly, 2 if all go to and fro, and with the speed of the
//! camera it falls for whatever moves smoothly. The *largest step* is that of a single pixel.

use crate::{RenderError, Renderer};
use slabsplat_core::{Image, Method, Scene};
use thiserror::Error;

/// A turn of the camera about its target, around its up vector.
///
/// ```
/// use slabsplat::Sweep;
///
/// let quarter = Sweep::new(0.0, 90.0);
/// assert_eq!((quarter.step_degrees, quarter.n_frames()), (1.0, 91));
/// assert_eq!(quarter.step_degrees(0.5).n_frames(), 181);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Sweep {
    /// Angle of the first frame from the scene's camera.
    pub from_degrees: f64,
    /// Angle that the last frame does not pass.
    pub to_degrees: f64,
    /// Angle between two frames.
    pub step_degrees: f64,
}

/// Why there are no frames to be measured, or too many.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum SweepError {
    /// A number is not finite, or the step is not positive.
    #[error("a sweep needs finite angles and a positive step, not {0} to {1} in steps of {2}")]
    BadNumbers(f64, f64, f64),
    /// Fewer than three frames: no change to compare another with.
    #[error("a sweep from {0} to {1} degrees in steps of {2} has fewer than 3 frames")]
    TooShort(f64, f64, f64),
    /// More frames than anyone waits for.
    #[error("a sweep from {0} to {1} degrees in steps of {2} has more than 100000 frames")]
    TooLong(f64, f64, f64),
}

/// What the meter reads for one method.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct PoppingReport {
    /// The method.
    pub method: Method,
    /// The change between each two frames: mean absolute difference of premultiplied colour and
    /// opacity over all pixels.
    pub changes: Vec<f64>,
    /// The largest of them.
    pub largest: f64,
    /// The median.
    pub median: f64,
    /// Largest over median; `None` if the median is 0, as for an empty picture.
    pub pop_ratio: Option<f64>,
    /// Mean second difference of frames over mean first difference; `None` if nothing changes.
    pub jitter: Option<f64>,
    /// The largest change of a pixel's red, green or blue between two frames, 0 to 1, as on black: where an
    /// edge passes, its opacity may change from all to nothing, which nobody sees.
    pub largest_step: f64,
    /// The two angles between which the largest change happened, from the scene's camera.
    pub at_degrees: [f64; 2],
}

const MAX_FRAMES: f64 = 1e5;

impl Sweep {
    /// From one angle to another, in degrees from the scene's camera, a degree between two frames.
    pub const fn new(from_degrees: f64, to_degrees: f64) -> Self {
        Self { from_degrees, to_degrees, step_degrees: 1.0 }
    }

    /// The same with another angle between two frames.
    #[must_use]
    pub const fn step_degrees(self, step_degrees: f64) -> Self {
        Self { step_degrees, ..self }
    }

    /// The same, if it has at least three frames.
    ///
    /// # Errors
    /// If a number is not finite, the step not positive, or there are too few or too many frames.
    pub fn checked(self) -> Result<Self, SweepError> {
        let Self { from_degrees: from, to_degrees: to, step_degrees: step } = self;
        if [from, to, step].iter().any(|v| !v.is_finite()) || step <= 0.0 {
            return Err(SweepError::BadNumbers(from, to, step));
        }
        let n_frames = (to - from) / step + 1.0;
        if MAX_FRAMES < n_frames {
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
        let n_steps = (self.to_degrees - self.from_degrees) / self.step_degrees;
        (n_steps + 1e-9).floor().max(0.0) as usize + 1
    }

    /// The angle of a frame from the scene's camera.
    pub fn degrees(&self, frame_idx: usize) -> f64 {
        self.from_degrees + frame_idx as f64 * self.step_degrees
    }
}

/// Turns the camera of `scene` and measures by how much the picture of `method` changes in each step.
/// `progress` is called after every frame.
///
/// # Errors
/// If the sweep has no steps, or a frame fails.
pub fn measure_popping(
    renderer: &mut Renderer,
    scene: &Scene,
    method: Method,
    sweep: Sweep,
    mut progress: impl FnMut(),
) -> Result<PoppingReport, RenderError> {
    let mut scene_at = scene.clone();
    scene_at.settings.method = method;
    let mut differences = Differences::default();
    let (mut before, mut before_that) = (None, None);
    for frame_idx in 0..sweep.n_frames() {
        scene_at.camera = scene.camera.orbited(sweep.degrees(frame_idx).to_radians());
        let image = renderer.render(&scene_at)?.image;
        differences.add(&image, before.as_ref(), before_that.as_ref());
        (before_that, before) = (before, Some(image));
        progress();
    }
    Ok(report(method, sweep, differences))
}

/// What frames differ by, from one to the next.
#[derive(Debug, Default)]
struct Differences {
    /// Mean first and second differences.
    first: Vec<f64>,
    second: Vec<f64>,
    largest_step: f32,
}

impl Differences {
    fn add(&mut self, image: &Image, before: Option<&Image>, before_that: Option<&Image>) {
        if let Some(before) = before {
            self.first.push(image.mean_difference(before));
            self.largest_step = self.largest_step.max(image.max_color_difference(before));
            let second = before_that.map(|that| image.mean_second_difference(before, that));
            self.second.extend(second);
        }
    }
}

fn report(method: Method, sweep: Sweep, differences: Differences) -> PoppingReport {
    let Differences { first: changes, second, largest_step } = differences;
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
    let mean_change = mean(&changes);
    let (step_idx, largest) = changes
        .iter()
        .copied()
        .enumerate()
        .fold((0, 0.0), |best, step| if best.1 < step.1 { step } else { best });
    let mut sorted = changes.clone();
    sorted.sort_by(f64::total_cmp);
    let middle = |idx: usize| sorted.get(idx).copied().unwrap_or(0.0);
    let median = 0.5 * (middle(sorted.len() / 2) + middle(sorted.len().saturating_sub(1) / 2));
    PoppingReport {
        method,
        largest,
        median,
        pop_ratio: (0.0 < median).then(|| largest / median),
        jitter: (0.0 < mean_change).then(|| mean(&second) / mean_change),
        largest_step: largest_step.into(),
        at_degrees: [sweep.degrees(step_idx), sweep.degrees(step_idx + 1)],
        changes,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TURN: Sweep = Sweep::new(0.0, 90.0).step_degrees(0.1);

    #[test]
    fn popping_sweep_reaches_its_end() {
        assert_eq!(TURN.checked().unwrap().n_frames(), 901);
        let short = Sweep::new(0.0, 0.15).step_degrees(0.1);
        assert!(matches!(short.checked(), Err(SweepError::TooShort(..))));
        let back = Sweep::new(0.0, -9.0).step_degrees(0.1);
        assert!(matches!(back.checked(), Err(SweepError::TooShort(..))));
        let still = TURN.step_degrees(0.0);
        assert!(matches!(still.checked(), Err(SweepError::BadNumbers(..))));
        let fine = TURN.step_degrees(1e-9);
        assert!(matches!(fine.checked(), Err(SweepError::TooLong(..))));
    }

    #[test]
    fn popping_report_finds_the_step() {
        let sweep = Sweep::new(10.0, 14.0);
        let of = |first: &[f64]| Differences { first: first.to_vec(), ..Differences::default() };
        let read = report(Method::AxisAligned, sweep, of(&[0.2, 0.1, 0.8, 0.3]));
        assert_eq!((read.largest, read.median), (0.8, 0.25));
        assert_eq!(read.pop_ratio, Some(0.8 / 0.25));
        assert_eq!(read.at_degrees, [12.0, 13.0]);
        let still = report(Method::AxisAligned, sweep, of(&[0.0; 3]));
        assert_eq!((still.pop_ratio, still.jitter), (None, None));
    }

    /// One pixel of two goes to and fro, or rises evenly: the change is the same, and so is the pop ratio.
    #[test]
    fn popping_report_sees_what_flickers() {
        let sweep = Sweep::new(0.0, 4.0);
        let of = |values: [f32; 5]| {
            let frames = values.map(|value| Image::filled(1, 1, [value; 4]));
            let mut differences = Differences::default();
            for (idx, frame) in frames.iter().enumerate() {
                let earlier = |n: usize| idx.checked_sub(n).map(|idx| &frames[idx]);
                differences.add(frame, earlier(1), earlier(2));
            }
            report(Method::ImageAligned, sweep, differences)
        };
        let (flickers, rises) = (of([0.0, 0.25, 0.0, 0.25, 0.0]), of([0.0, 0.25, 0.5, 0.75, 1.0]));
        assert_eq!([flickers.pop_ratio, rises.pop_ratio], [Some(1.0); 2]);
        assert_eq!([flickers.jitter, rises.jitter], [Some(2.0), Some(0.0)]);
        assert_eq!([flickers.largest_step, rises.largest_step], [0.25; 2]);
    }
}
