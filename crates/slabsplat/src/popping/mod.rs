//! The popping meter: figures 2 and 6 of the paper as one number, and two that see what it cannot.
//!
//! The camera turns about its target in equal steps, or magnifies by equal factors. Between two frames the
//! picture changes; if the method is sound, by about as much in every step. The *pop ratio* is the largest
//! change over the median one: near 1 where nothing pops, large where one step changes far more than the
//! others. Changes grow with what is magnified; the *spike* is the largest of a change over the mean of the
//! one before and the one after.
//!
//! What flickers in every frame has a pop ratio of 1. *Jitter* is the mean second difference of frames over
//! the mean first one: 0 if every pixel changes evenly, 2 if all go to and fro, and with the speed of the
//! camera it falls for whatever moves smoothly. The *largest step* is that of a single pixel.

mod sweep;

pub use sweep::{Motion, Sweep, SweepError};

use crate::{RenderError, Renderer};
use slabsplat_core::{CameraError, Image, Method, Scene};
use thiserror::Error;

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
    /// The largest of a change over the mean of the one before it and the one after; `None` if there are
    /// fewer than three, or nothing changes.
    pub spike: Option<f64>,
    /// Mean second difference of frames over mean first difference; `None` if nothing changes.
    pub jitter: Option<f64>,
    /// The largest change of a pixel's red, green or blue between two frames, 0 to 1, as on black: where an
    /// edge passes, its opacity may change from all to nothing, which nobody sees.
    pub largest_step: f64,
    /// Between which two angles, or magnifications, the largest change happened.
    pub at: [f64; 2],
}

/// Why the meter reads nothing.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PoppingError {
    /// A frame fails.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The camera magnifies more than numbers suffice for.
    #[error(transparent)]
    Camera(#[from] CameraError),
}

/// Moves the camera of `scene` and measures by how much the picture of `method` changes in each step.
/// `progress` is called after every frame.
///
/// # Errors
/// If a frame fails, or there is no camera for it.
pub fn measure_popping(
    renderer: &mut Renderer,
    scene: &Scene,
    method: Method,
    sweep: Sweep,
    mut progress: impl FnMut(),
) -> Result<PoppingReport, PoppingError> {
    let mut scene_at = scene.clone();
    scene_at.settings.method = method;
    let mut differences = Differences::default();
    let (mut before, mut before_that) = (None, None);
    for frame_idx in 0..sweep.n_frames() {
        scene_at.camera = sweep.camera(&scene.camera, frame_idx)?;
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
        spike: spike(&changes),
        largest_step: largest_step.into(),
        at: [sweep.at(step_idx), sweep.at(step_idx + 1)],
        changes,
    }
}

fn spike(changes: &[f64]) -> Option<f64> {
    let over_neighbors = |around: &[f64]| {
        let neighbors = 0.5 * (around[0] + around[2]);
        (0.0 < neighbors).then(|| around[1] / neighbors)
    };
    changes.windows(3).filter_map(over_neighbors).reduce(f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn popping_report_finds_the_step() {
        let sweep = Sweep::turn(10.0, 14.0);
        let of = |first: &[f64]| Differences { first: first.to_vec(), ..Differences::default() };
        let read = report(Method::AxisAligned, sweep, of(&[0.2, 0.1, 0.8, 0.3]));
        assert_eq!((read.largest, read.median), (0.8, 0.25));
        assert_eq!(read.pop_ratio, Some(0.8 / 0.25));
        assert_eq!(read.spike, Some(0.8 / 0.2));
        assert_eq!(read.at, [12.0, 13.0]);
        let still = report(Method::AxisAligned, sweep, of(&[0.0; 3]));
        assert_eq!([still.pop_ratio, still.spike, still.jitter], [None; 3]);
        let grows = report(Method::AxisAligned, sweep, of(&[0.1, 0.2, 0.4, 0.8]));
        assert_eq!(grows.spike, Some(0.2 / 0.25), "it grows, and does not pop");
    }

    /// One pixel of two goes to and fro, or rises evenly: the change is the same, and so is the pop ratio.
    #[test]
    fn popping_report_sees_what_flickers() {
        let sweep = Sweep::turn(0.0, 4.0);
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
