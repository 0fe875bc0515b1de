//! Transfer functions over time. Where all keys have as many points, points move from key to key; else the
//! functions fade into each other, over the positions of all of them.

use super::MotionError;
use super::track::{Moment, Track};
use slabsplat_core::{PiecewiseLinear, TransferFunction};

#[derive(Clone, Debug, PartialEq)]
pub(super) struct TransferPath {
    track: Track,
    opacity: Curves<1>,
    color: Curves<3>,
}

impl TransferPath {
    pub(super) fn new(track: Track, keys: &[TransferFunction]) -> Self {
        let opacity = Curves::of(keys.iter().map(TransferFunction::opacity_points));
        let color = Curves::of(keys.iter().map(TransferFunction::color_points));
        Self { track, opacity, color }
    }

    /// # Errors
    /// If numbers do not suffice.
    pub(super) fn at(&self, seconds: f64) -> Result<TransferFunction, MotionError> {
        let moment = self.track.at(seconds);
        let opacity = self.opacity.at("opacity", &self.track, moment)?;
        let color = self.color.at("color", &self.track, moment)?;
        Ok(TransferFunction::of_curves(opacity, color))
    }
}

/// Functions that have as many points each.
#[derive(Clone, Debug, PartialEq)]
struct Curves<const N: usize> {
    keys: Vec<Vec<(f64, [f64; N])>>,
}

impl<const N: usize> Curves<N> {
    fn of<'a>(curves: impl Iterator<Item = &'a PiecewiseLinear<N>>) -> Self {
        let curves: Vec<&PiecewiseLinear<N>> = curves.collect();
        let n_points = |curve: &PiecewiseLinear<N>| curve.points().len();
        if curves.windows(2).all(|pair| n_points(pair[0]) == n_points(pair[1])) {
            return Self { keys: curves.iter().map(|curve| curve.points().to_vec()).collect() };
        }
        let mut positions: Vec<f64> =
            curves.iter().flat_map(|curve| curve.points()).map(|point| point.0).collect();
        positions.sort_by(f64::total_cmp);
        positions.dedup();
        // Where any of them has a step, all have two points.
        let is_step = |position: f64| {
            let steps = |curve: &&PiecewiseLinear<N>| 1 < points_at(curve, position).count();
            curves.iter().any(steps)
        };
        let positions: Vec<(f64, bool)> = positions.iter().map(|&it| (it, is_step(it))).collect();
        let resampled = |curve: &&PiecewiseLinear<N>| {
            let points = |&(position, is_step): &(f64, bool)| {
                let right = (position, curve.at(position));
                let left = points_at(curve, position).next().copied().unwrap_or(right);
                [is_step.then_some(left), Some(right)].into_iter().flatten()
            };
            positions.iter().flat_map(points).collect()
        };
        Self { keys: curves.iter().map(resampled).collect() }
    }

    fn at(
        &self,
        what: &'static str,
        track: &Track,
        moment: Moment,
    ) -> Result<PiecewiseLinear<N>, MotionError> {
        let points = 0..self.keys[0].len();
        let smooth = points.clone().map(|idx| {
            let position = track.number(moment, |key| self.keys[key][idx].0);
            let result = |channel| track.number(moment, |key| self.keys[key][idx].1[channel]);
            (position, std::array::from_fn(result))
        });
        // Points that move along curves of their own may overtake each other; on straight ways they cannot.
        if let Ok(curve) = PiecewiseLinear::new(what, smooth) {
            return Ok(curve);
        }
        let Moment { segment, part } = moment;
        let between = |a: f64, b: f64| a * (1.0 - part) + b * part;
        let straight = points.map(|idx| {
            let ([x0, x1], [y0, y1]) = {
                let [a, b] = [segment, segment + 1].map(|key| self.keys[key][idx]);
                ([a.0, b.0], [a.1, b.1])
            };
            let result = |channel: usize| between(y0[channel], y1[channel]).clamp(0.0, 1.0);
            (between(x0, x1), std::array::from_fn(result))
        });
        Ok(PiecewiseLinear::new(what, straight)?)
    }
}

fn points_at<const N: usize>(
    curve: &PiecewiseLinear<N>,
    position: f64,
) -> impl Iterator<Item = &(f64, [f64; N])> {
    curve.points().iter().filter(move |point| point.0 == position)
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::Easing;

    const GRAY: [(f64, [f64; 3]); 1] = [(0.0, [0.5; 3])];

    fn path(keys: &[TransferFunction]) -> TransferPath {
        let times = (0..keys.len()).map(|idx| (idx as f64, Easing::Linear));
        TransferPath::new(Track::new(times, false), keys)
    }

    #[test]
    fn transfer_points_move() {
        let peak = |at: f64| {
            TransferFunction::new([(at - 10.0, 0.0), (at, 0.8), (at + 10.0, 0.0)], GRAY).unwrap()
        };
        let there = path(&[peak(100.0), peak(200.0)]);
        let half = there.at(0.5).unwrap();
        assert!((half.opacity(150.0) - 0.8).abs() < 1e-12);
        assert_eq!([half.opacity(100.0), half.opacity(200.0)], [0.0; 2]);
        assert_eq!([0.0, 1.0].map(|t| there.at(t).unwrap()), [peak(100.0), peak(200.0)]);
    }

    #[test]
    fn transfer_of_other_points_fades() {
        let ramp = TransferFunction::new([(0.0, 0.0), (100.0, 1.0)], GRAY).unwrap();
        let step = [(50.0, 0.0), (50.0, 0.6), (70.0, 0.2)];
        let step = TransferFunction::new(step, GRAY).unwrap();
        let there = path(&[ramp.clone(), step.clone()]);
        for (t, share) in [(0.0, 0.0), (0.25, 0.25), (0.5, 0.5), (1.0, 1.0)] {
            let now = there.at(t).unwrap();
            for value in [0.0, 20.0, 49.0, 50.0, 51.0, 60.0, 99.0] {
                let expected = ramp.opacity(value) * (1.0 - share) + step.opacity(value) * share;
                let found = now.opacity(value);
                assert!((found - expected).abs() < 1e-9, "{t} {value}: {found} {expected}");
            }
        }
    }

    #[test]
    fn transfer_points_that_would_overtake_do_not() {
        let of = |points: [f64; 4]| {
            let points = points.iter().zip([0.0, 0.5, 0.5, 0.0]).map(|(&x, y)| (x, y));
            TransferFunction::new(points.collect::<Vec<_>>(), GRAY).unwrap()
        };
        let there = path(&[
            of([0.0, 0.0, 1.0, 100.0]),
            of([0.0, 90.0, 91.0, 100.0]),
            of([0.0, 91.0, 91.0, 92.0]),
            of([90.0, 91.0, 98.0, 98.0]),
        ]);
        (0..=300).for_each(|step| drop(there.at(f64::from(step) / 100.0).unwrap()));
    }
}
