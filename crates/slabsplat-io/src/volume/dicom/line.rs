//! The line along which slices lie, and which slices a volume has of it.
//!
//! Slices that are evenly apart are a grid, also if they are shifted along their planes from one to the next,
//! as a tilted gantry does: then the grid is sheared. Where they are not evenly apart, slices are made
//! between them.

use slabsplat_core::glam::DVec3;

use super::frame::Frame;

/// Slices within this share of a step are where even ones would be.
const EVEN: f64 = 0.05;

/// From this share of a step on it is said that they are not quite.
const WORTH_A_WORD: f64 = 0.01;

/// Distances of slices that are up to so many times others are of the same part of a scan.
const SAME_PART: f64 = 1.25;

/// Made slices are at most so many times those that are there.
const MAX_GROWTH: usize = 4;

/// A slice of the volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Slice {
    /// This frame.
    Frame(usize),
    /// Between this frame and the next, so far along.
    Between(usize, f64),
}

impl Slice {
    /// The frame that it is, unless it is made of two.
    pub(super) fn stored(&self) -> Option<usize> {
        match *self {
            Self::Frame(idx) => Some(idx),
            Self::Between(..) => None,
        }
    }
}

/// The line along which slices lie.
#[derive(Debug)]
pub(super) struct Line {
    pub(super) origin: DVec3,
    /// From the first slice to the last; of one slice, to where the next would be.
    span: DVec3,
    normal: DVec3,
    /// Whether positions say where slices are.
    is_measured: bool,
    /// Of each slice over the first, along the normal.
    heights: Vec<f64>,
}

impl Line {
    pub(super) fn of(frames: &[Frame], normal: DVec3, warnings: &mut Vec<String>) -> Self {
        let origin = frames[0].position.unwrap_or(DVec3::ZERO);
        let last = frames.last().and_then(|frame| frame.position).unwrap_or(origin);
        let n = frames.len();
        if 1 < n && 0.0 < (last - origin).dot(normal) {
            let height = |frame: &Frame| frame.position.map_or(0.0, |p| (p - origin).dot(normal));
            let heights = frames.iter().map(height).collect();
            return Self { origin, span: last - origin, normal, is_measured: true, heights };
        }
        let said = frames[0].slice_spacing;
        let step = said.unwrap_or(1.0);
        if n == 1 {
            warnings.push(format!("there is only one slice: it is {step} mm thick"));
        } else {
            let why = if said.is_some() { "as they say to be spaced or thick" } else { "a guess" };
            warnings.push(format!(
                "the files do not say where slices are: {step} mm apart was assumed, {why}"
            ));
        }
        let heights: Vec<f64> = (0..n).map(|idx| idx as f64 * step).collect();
        let n_steps = n.saturating_sub(1).max(1) as f64;
        Self { origin, span: normal * step * n_steps, normal, is_measured: false, heights }
    }

    fn height(&self) -> f64 {
        self.span.dot(self.normal)
    }

    /// From one slice of the volume to the next.
    pub(super) fn step(&self, n_slices: usize) -> DVec3 {
        self.span / n_slices.saturating_sub(1).max(1) as f64
    }

    /// The slices that are there, if they are evenly apart; or else others, that are.
    pub(super) fn slices(&self, warnings: &mut Vec<String>) -> Vec<Slice> {
        let n = self.heights.len();
        if n < 3 {
            return (0..n).map(Slice::Frame).collect();
        }
        let step = self.height() / (n - 1) as f64;
        let off = |(idx, height): (usize, &f64)| (height - idx as f64 * step).abs();
        let farthest = self.heights.iter().enumerate().map(off).fold(0.0, f64::max);
        if farthest <= EVEN * step {
            if WORTH_A_WORD * step < farthest {
                warnings.push(format!(
                    "slices are up to {farthest:.3} mm from where {step:.3} mm steps would have them"
                ));
            }
            return (0..n).map(Slice::Frame).collect();
        }
        self.resampled(warnings)
    }

    fn resampled(&self, warnings: &mut Vec<String>) -> Vec<Slice> {
        let n = self.heights.len();
        let mut gaps: Vec<f64> = self.heights.windows(2).map(|pair| pair[1] - pair[0]).collect();
        gaps.sort_by(f64::total_cmp);
        let most = (MAX_GROWTH * n) as f64;
        let n_steps = (self.height() / finest_usual(&gaps)).round().clamp(1.0, most);
        let step = self.height() / n_steps;
        let usual = gaps[gaps.len() / 2];
        let missing = |gap: &f64| (gap / usual).round().max(1.0) - 1.0;
        let n_missing: f64 = gaps.iter().map(missing).sum();
        let missing = match n_missing {
            0.0 => String::new(),
            n => format!(", and {n} seem to be missing"),
        };
        let [nearest, farthest] = [gaps[0], gaps[gaps.len() - 1]];
        let n_slices = n_steps + 1.0;
        warnings.push(format!(
            "slices are {nearest:.3} to {farthest:.3} mm apart{missing}: the volume was resampled to \
             {n_slices} slices {step:.3} mm apart"
        ));
        (0..=n_steps as usize).map(|idx| self.slice_at(idx as f64 * step, step)).collect()
    }

    fn slice_at(&self, height: f64, step: f64) -> Slice {
        let n = self.heights.len();
        let above = self.heights.partition_point(|&other| other <= height).clamp(1, n - 1);
        let [low, high] = [self.heights[above - 1], self.heights[above]];
        let share = ((height - low) / (high - low)).clamp(0.0, 1.0);
        let is_at = |other: f64| (height - other).abs() <= WORTH_A_WORD * step;
        if is_at(low) {
            return Slice::Frame(above - 1);
        }
        if is_at(high) { Slice::Frame(above) } else { Slice::Between(above - 1, share) }
    }

    /// Whether slices are shifted along their planes in another way than evenly.
    pub(super) fn check_planes(&self, frames: &[Frame], pixel: f64, warnings: &mut Vec<String>) {
        if frames.len() < 3 || !self.is_measured {
            return;
        }
        let off = |(frame, height): (&Frame, &f64)| {
            let expected = self.origin + self.span * (height / self.height());
            frame.position.map_or(0.0, |position| (position - expected).length())
        };
        let farthest = frames.iter().zip(&self.heights).map(off).fold(0.0, f64::max);
        if 0.1 * pixel < farthest {
            warnings.push(format!(
                "slices are shifted along their planes by up to {farthest:.3} mm, unevenly: that is not \
                 followed"
            ));
        }
    }
}

/// The usual distance, given all of them in order; where a scan is finer in one part than in others, that of
/// the finest part, so that no slice is lost there.
fn finest_usual(gaps: &[f64]) -> f64 {
    // A tenth, since two slices at nearly one place are no part.
    let fine = gaps[gaps.len() / 10];
    let n_fine = gaps.partition_point(|gap| *gap <= SAME_PART * fine);
    gaps[n_fine / 2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stack_is_as_fine_as_its_finest_part() {
        let check = |gaps: &[f64], expected: f64| {
            let mut gaps = gaps.to_vec();
            gaps.sort_by(f64::total_cmp);
            assert_eq!(finest_usual(&gaps), expected, "{gaps:?}");
        };
        check(&[2.0, 2.0, 4.0], 2.0);
        check(&[1.0, 1.0, 1.0, 5.0, 5.0, 5.0, 5.0], 1.0);
        check(&[5.0, 5.0, 5.0, 5.0, 1.0, 1.0, 1.0], 1.0);
        // One slice that is missing of many whose places were rounded, and one that was scanned twice.
        let rounded = [1.98, 1.99, 2.0, 2.0, 2.01, 2.02, 2.0, 2.0, 2.0, 1.99, 2.01];
        check(&[&rounded[..], &[4.0]].concat(), 2.0);
        check(&[&rounded[..], &[0.1]].concat(), 2.0);
    }
}
