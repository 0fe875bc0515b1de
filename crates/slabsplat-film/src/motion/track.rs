//! Numbers over time, through values at given moments.
//!
//! Between two keys a number is a cubic polynomial whose slopes at both ends are limited (Fritsch & Butland
//! 1984): the curve is smooth, passes through every key, and never leaves the range between two neighbours.
//! So opacities stay opacities, and what rests between two equal keys rests.

use slabsplat_core::Easing;

/// Moments of keys, and how time passes between them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Track {
    /// Seconds, each later than the one before.
    times: Vec<f64>,
    /// From each key to the next.
    easings: Vec<Easing>,
    /// Whether the last key is the first one again.
    is_loop: bool,
}

/// Where a moment is: between the keys `segment` and `segment + 1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Moment {
    pub(super) segment: usize,
    /// How much of the way to the next key is behind, 0 … 1.
    pub(super) part: f64,
}

impl Track {
    pub(super) fn new(keys: impl IntoIterator<Item = (f64, Easing)>, is_loop: bool) -> Self {
        let (times, easings) = keys.into_iter().unzip();
        Self { times, easings, is_loop }
    }

    /// Where a moment is; before the first key and behind the last nothing changes.
    pub(super) fn at(&self, seconds: f64) -> Moment {
        let n_segments = self.times.len().saturating_sub(1);
        let n_before = self.times.partition_point(|time| *time <= seconds);
        if n_before == 0 || n_segments == 0 {
            return Moment { segment: 0, part: 0.0 };
        }
        if n_segments < n_before {
            return Moment { segment: n_segments - 1, part: 1.0 };
        }
        let segment = n_before - 1;
        let part = (seconds - self.times[segment]) / self.duration(segment);
        Moment { segment, part: self.easings[segment].ease(part) }
    }

    /// The seconds from a key to the next.
    pub(super) fn duration(&self, segment: usize) -> f64 {
        self.times[segment + 1] - self.times[segment]
    }

    /// The segments before and behind a key, where there are any.
    fn around(&self, key_idx: usize) -> [Option<usize>; 2] {
        let n_segments = self.times.len() - 1;
        let (before, behind) = (key_idx.checked_sub(1), (key_idx < n_segments).then_some(key_idx));
        match self.is_loop {
            true => [before.or(Some(n_segments - 1)), behind.or(Some(0))],
            false => [before, behind],
        }
    }

    /// How fast a number changes at a key, a second, if it changes by `change` over each segment.
    pub(super) fn slope(&self, key_idx: usize, change: impl Fn(usize) -> f64) -> f64 {
        let of =
            |segment: usize| (change(segment) / self.duration(segment), self.duration(segment));
        match self.around(key_idx).map(|segment| segment.map(of)) {
            [Some((before, h_before)), Some((behind, h_behind))] => {
                if before * behind <= 0.0 {
                    return 0.0;
                }
                // The harmonic mean, in which the slope of the shorter segment counts for more.
                let [w_before, w_behind] = [2.0 * h_behind + h_before, h_behind + 2.0 * h_before];
                (w_before + w_behind) / (w_before / before + w_behind / behind)
            }
            [Some((slope, _)), None] | [None, Some((slope, _))] => slope,
            [None, None] => 0.0,
        }
    }

    /// A number that has `values` at the keys.
    pub(super) fn number(&self, moment: Moment, values: impl Fn(usize) -> f64) -> f64 {
        if self.times.len() < 2 {
            return values(0);
        }
        let Moment { segment, part: t } = moment;
        let change = |segment: usize| values(segment + 1) - values(segment);
        let slope = |key_idx| self.slope(key_idx, change) * self.duration(segment);
        let [from, to] = [values(segment), values(segment + 1)];
        if from == to {
            return from;
        }
        let (a, b) = (slope(segment), slope(segment + 1));
        // Hermite's polynomial, from the nearer end so that keys are met to the last bit.
        let u = 1.0 - t;
        let value = if t < 0.5 {
            from + (to - from) * t * t * (3.0 - 2.0 * t) + a * t * u * u - b * t * t * u
        } else {
            to - (to - from) * u * u * (3.0 - 2.0 * u) + a * t * u * u - b * t * t * u
        };
        // Of rounding alone.
        value.clamp(from.min(to), from.max(to))
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    fn linear(times: &[f64], is_loop: bool) -> Track {
        Track::new(times.iter().map(|&time| (time, Easing::Linear)), is_loop)
    }

    /// Largest jump of the slope of `f` over `0 … end`.
    pub(crate) fn largest_kink(f: impl Fn(f64) -> f64, end: f64) -> f64 {
        let n = 4000;
        let at = |idx: i32| f(end * f64::from(idx) / f64::from(n));
        let step = end / f64::from(n);
        let slopes: Vec<f64> = (0..n).map(|idx| (at(idx + 1) - at(idx)) / step).collect();
        slopes.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max)
    }

    const TIMES: [f64; 6] = [0.0, 1.0, 1.5, 3.0, 4.0, 6.0];
    const VALUES: [f64; 6] = [0.0, 0.2, 1.0, 1.0, 0.3, 0.0];

    #[test]
    fn track_passes_through_keys() {
        let track = linear(&TIMES, false);
        for (time, value) in TIMES.into_iter().zip(VALUES) {
            assert_eq!(track.number(track.at(time), |idx| VALUES[idx]), value, "{time}");
        }
        let beyond = [-3.0, 99.0].map(|time| track.number(track.at(time), |idx| VALUES[idx]));
        assert_eq!(beyond, [0.0, 0.0]);
    }

    #[test]
    fn track_is_smooth_and_stays_between_neighbours() {
        let track = linear(&TIMES, false);
        let value = |time: f64| track.number(track.at(time), |idx| VALUES[idx]);
        for step in 0..=600 {
            let time = f64::from(step) / 100.0;
            let Moment { segment, .. } = track.at(time);
            let [a, b] = [VALUES[segment], VALUES[segment + 1]];
            assert!((a.min(b)..=a.max(b)).contains(&value(time)), "{time}");
        }
        // Slopes are up to 3 a second: a kink would be of that order.
        assert!(largest_kink(value, 6.0) < 0.05, "{}", largest_kink(value, 6.0));
        let broken = |time: f64| (time - 2.0).abs();
        assert!(1.0 < largest_kink(broken, 6.0), "the measure sees a kink");
    }

    #[test]
    fn track_of_two_keys_is_even() {
        let track = linear(&[1.0, 3.0], false);
        for (time, expected) in [(1.0, 10.0), (1.5, 12.5), (2.0, 15.0), (2.5, 17.5), (3.0, 20.0)] {
            let value = track.number(track.at(time), |idx| [10.0, 20.0][idx]);
            assert!((value - expected).abs() < 1e-12, "{time}: {value}");
        }
    }

    #[test]
    fn track_of_one_key_stays() {
        let track = linear(&[2.0], false);
        assert_eq!([0.0, 2.0, 9.0].map(|t| track.number(track.at(t), |_| 7.0)), [7.0; 3]);
    }

    #[test]
    fn track_that_loops_is_smooth_where_it_begins() {
        let (times, values) = ([0.0, 1.0, 2.0, 3.0, 4.0], [0.4, 1.0, 0.6, 0.2, 0.4]);
        let track = linear(&times, true);
        let twice = |time: f64| track.number(track.at(time % 4.0), |idx| values[idx]);
        assert!(largest_kink(twice, 7.9) < 0.02, "{}", largest_kink(twice, 7.9));
        let open = linear(&times, false);
        let twice = |time: f64| open.number(open.at(time % 4.0), |idx| values[idx]);
        assert!(0.02 < largest_kink(twice, 7.9), "without a loop there is a kink");
    }

    #[test]
    fn track_eases() {
        let track = Track::new([(0.0, Easing::EaseInOut), (2.0, Easing::Linear)], false);
        let part = |time| track.at(time).part;
        assert_eq!([0.0, 1.0, 2.0].map(part), [0.0, 0.5, 1.0]);
        assert!(part(0.2) < 0.05 && 0.95 < part(1.8));
    }
}
