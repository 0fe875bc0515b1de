//! Transfer functions made from others: moved to other values, more or less opaque, over another distance.

use crate::{PiecewiseLinear, TransferError, TransferFunction};

/// Into so many parts a ramp is cut that is bent over another distance: each is then straight to 10⁻³.
const N_PARTS: u32 = 32;

impl<const N: usize> PiecewiseLinear<N> {
    /// The first and the last position.
    pub fn span(&self) -> [f64; 2] {
        let points = self.points();
        [points[0].0, points[points.len() - 1].0]
    }

    /// The function with the positions `from` moved to `to`, and all others with them. `from` that are one
    /// position are moved to the first of `to`.
    ///
    /// # Errors
    /// If positions are not finite there, or no numbers lie between them. `what` names the function.
    pub fn moved(
        &self,
        what: &'static str,
        from: [f64; 2],
        to: [f64; 2],
    ) -> Result<Self, TransferError> {
        // Halved, or the distance of opposite ends of the numbers would be infinite.
        let half = |[lo, hi]: [f64; 2]| 0.5 * hi - 0.5 * lo;
        let moved = |position: f64| {
            if half(from) <= 0.0 {
                return position - from[0] + to[0];
            }
            let t = half([from[0], position]) / half(from);
            to[0] * (1.0 - t) + to[1] * t
        };
        Self::new(what, self.points().iter().map(|&(position, results)| (moved(position), results)))
    }
}

impl PiecewiseLinear<1> {
    /// The results times `factor`, 1 at most.
    ///
    /// # Panics
    /// If the factor is negative or not finite.
    pub fn multiplied(&self, factor: f64) -> Self {
        assert!(0.0 <= factor && factor.is_finite(), "usage: a factor of opacity is at least 0");
        let mut points: Vec<(f64, [f64; 1])> = Vec::with_capacity(self.points().len());
        let mut before: Option<(f64, f64)> = None;
        for &(position, [result]) in self.points() {
            let product = factor * result;
            if let Some((last, of_last)) = before {
                // Where a ramp reaches 1 it has a corner.
                let at = last + (position - last) * ((1.0 - of_last) / (product - of_last));
                if (of_last < 1.0) != (product < 1.0) && last < at && at < position {
                    points.push((at, [1.0]));
                }
            }
            points.push((position, [product.min(1.0)]));
            before = Some((position, product));
        }
        Self::new("opacity", points).expect("points are where they were, or between two")
    }

    /// Opacities over `ratio` times the distance: `1 − (1 − α)^ratio`.
    ///
    /// # Panics
    /// If the ratio is negative or not finite.
    pub fn over_distance(&self, ratio: f64) -> Self {
        assert!(0.0 <= ratio && ratio.is_finite(), "usage: a ratio of distances is at least 0");
        if ratio == 1.0 {
            return self.clone();
        }
        // Exact where little is absorbed; at 1 the logarithm is infinite, and all is absorbed.
        let over = |opacity: f64| {
            if 1.0 <= opacity {
                1.0
            } else {
                (-(ratio * (-opacity).ln_1p()).exp_m1()).clamp(0.0, 1.0)
            }
        };
        let mut points: Vec<(f64, [f64; 1])> = Vec::with_capacity(self.points().len());
        let mut before: Option<(f64, f64)> = None;
        for &(position, [result]) in self.points() {
            if let Some((last, of_last)) = before.filter(|&(_, of_last)| of_last != result) {
                for part in 1..N_PARTS {
                    let t = f64::from(part) / f64::from(N_PARTS);
                    let at = last + (position - last) * t;
                    if points.last().is_some_and(|point| point.0 < at) && at < position {
                        points.push((at, [over(of_last + (result - of_last) * t)]));
                    }
                }
            }
            points.push((position, [over(result)]));
            before = Some((position, result));
        }
        Self::new("opacity", points).expect("points are where they were, or between two")
    }
}

impl TransferFunction {
    /// The least and the greatest position of either function.
    pub fn span(&self) -> [f64; 2] {
        let ([a, b], [c, d]) = (self.opacity_points().span(), self.color_points().span());
        [a.min(c), b.max(d)]
    }

    /// The function with the values `from` moved to `to`, and all others with them.
    ///
    /// # Errors
    /// As [`PiecewiseLinear::moved`].
    pub fn moved(&self, from: [f64; 2], to: [f64; 2]) -> Result<Self, TransferError> {
        let opacity = self.opacity_points().moved("opacity", from, to)?;
        Ok(Self::of_curves(opacity, self.color_points().moved("color", from, to)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(points: &[(f64, f64)]) -> PiecewiseLinear<1> {
        PiecewiseLinear::new("opacity", points.iter().copied()).unwrap()
    }

    #[test]
    fn curve_is_moved() {
        let curve = ramp(&[(0.0, 0.0), (0.5, 0.25), (0.5, 0.5), (1.0, 1.0)]);
        let moved = curve.moved("opacity", [0.0, 1.0], [-1000.0, 3000.0]).unwrap();
        assert_eq!(moved, ramp(&[(-1000.0, 0.0), (1000.0, 0.25), (1000.0, 0.5), (3000.0, 1.0)]));
        assert_eq!(moved.span(), [-1000.0, 3000.0]);
        let wide = curve.moved("opacity", [0.0, 1.0], [-1.7e308, 1.7e308]).unwrap();
        assert_eq!(wide.span(), [-1.7e308, 1.7e308]);
        let single = ramp(&[(7.0, 0.5)]).moved("opacity", [7.0, 7.0], [1.0, 2.0]).unwrap();
        assert_eq!(single, ramp(&[(1.0, 0.5)]));
        let narrow = curve.moved("opacity", [0.0, 1.0], [1.0, 1.0]);
        assert!(narrow.is_err(), "four points at one position");
    }

    #[test]
    fn curve_is_multiplied_up_to_1() {
        let curve = ramp(&[(0.0, 0.0), (10.0, 1.0), (20.0, 0.5)]);
        assert_eq!(curve.multiplied(0.5), ramp(&[(0.0, 0.0), (10.0, 0.5), (20.0, 0.25)]));
        let twice = curve.multiplied(2.0);
        for (value, expected) in [(2.5, 0.5), (5.0, 1.0), (7.0, 1.0), (15.0, 1.0), (20.0, 1.0)] {
            assert!((twice.at(value)[0] - expected).abs() < 1e-12, "{value}: {twice:?}");
        }
        assert_eq!(curve.multiplied(0.0).at(10.0), [0.0]);
        let step = ramp(&[(0.0, 0.2), (1.0, 0.2), (1.0, 0.8), (2.0, 0.8)]).multiplied(3.0);
        assert_eq!([0.5, 1.0].map(|value| (10.0 * step.at(value)[0]).round()), [6.0, 10.0]);
    }

    #[test]
    fn curve_over_another_distance() {
        let curve = ramp(&[(0.0, 0.0), (10.0, 0.9), (10.0, 1.0), (20.0, 1.0)]);
        for ratio in [0.25, 1.0, 3.0] {
            let over = curve.over_distance(ratio);
            for step in 0..=100 {
                let value = f64::from(step) / 10.0 - 1e-9;
                let expected = 1.0 - (1.0 - curve.at(value)[0]).powf(ratio);
                let error = (over.at(value)[0] - expected).abs();
                assert!(error < 1e-3, "ratio {ratio} at {value}: off by {error}");
            }
            assert_eq!([over.at(10.0), over.at(20.0)], [[1.0]; 2]);
        }
        // Twice half a step is a step.
        let half = curve.over_distance(0.5).at(10.0_f64.next_down())[0];
        assert!((1.0 - (1.0 - half).powi(2) - 0.9).abs() < 1e-9, "{half}");
        assert_eq!(curve.over_distance(0.0).at(5.0), [0.0]);
    }
}
