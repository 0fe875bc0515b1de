//! Points of a transfer function, as they are edited.

use slabsplat::{PiecewiseLinear, TransferFunction};

/// A curve of which one point is changed at a time. Whatever is done to it, it is a valid curve.
pub trait Curve: Sized {
    /// The same with a point elsewhere, which stays between its neighbours.
    #[must_use]
    fn point_moved(&self, idx: usize, position: f64) -> Self;
    /// The same with one more point on it, and which that is.
    #[must_use]
    fn with_point(&self, position: f64) -> (Self, usize);
    /// The same with a point less, unless it is the last one.
    #[must_use]
    fn without(&self, idx: usize) -> Self;
}

impl<const N: usize> Curve for PiecewiseLinear<N> {
    fn point_moved(&self, idx: usize, position: f64) -> Self {
        let points = self.points();
        let before = idx.checked_sub(1).map_or(f64::MIN, |idx| points[idx].0);
        let after = points.get(idx + 1).map_or(f64::MAX, |point| point.0);
        let mut points = points.to_vec();
        points[idx].0 = position.clamp(before, after);
        made(points).unwrap_or_else(|| self.clone())
    }

    fn with_point(&self, position: f64) -> (Self, usize) {
        let idx = self.points().partition_point(|point| point.0 <= position);
        let mut points = self.points().to_vec();
        points.insert(idx, (position, self.at(position)));
        match made(points) {
            Some(curve) => (curve, idx),
            // A third point where two are.
            None => (self.clone(), idx.saturating_sub(1)),
        }
    }

    fn without(&self, idx: usize) -> Self {
        let mut points = self.points().to_vec();
        points.remove(idx);
        made(points).unwrap_or_else(|| self.clone())
    }
}

/// The same with another result at a point, within 0 … 1.
#[must_use]
pub fn with_result<const N: usize>(
    curve: &PiecewiseLinear<N>,
    idx: usize,
    result: [f64; N],
) -> PiecewiseLinear<N> {
    let mut points = curve.points().to_vec();
    points[idx].1 = result.map(|part| part.clamp(0.0, 1.0));
    made(points).unwrap_or_else(|| curve.clone())
}

/// The colours of a map from 0 to 1, over the range of values that a curve goes over.
#[must_use]
pub fn stretched(map: &PiecewiseLinear<3>, [lo, hi]: [f64; 2]) -> PiecewiseLinear<3> {
    let at = |part: f64| lo + (hi - lo) * part;
    let points = map.points().iter().map(|&(position, color)| (at(position), color)).collect();
    made(points).unwrap_or_else(|| map.clone())
}

/// The least and the greatest value at which a transfer function has a point.
pub fn span(transfer: &TransferFunction) -> [f64; 2] {
    let ends = |ends: [f64; 2], at: f64| [ends[0].min(at), ends[1].max(at)];
    transfer.positions().fold([f64::INFINITY, f64::NEG_INFINITY], ends)
}

fn made<const N: usize>(points: Vec<(f64, [f64; N])>) -> Option<PiecewiseLinear<N>> {
    PiecewiseLinear::new("points", points).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(points: &[(f64, f64)]) -> PiecewiseLinear<1> {
        PiecewiseLinear::new("opacity", points.iter().copied()).unwrap()
    }

    #[test]
    fn points_stay_between_their_neighbours() {
        let before = curve(&[(0.0, 0.0), (5.0, 1.0), (9.0, 0.5)]);
        assert_eq!(before.point_moved(1, 7.0), curve(&[(0.0, 0.0), (7.0, 1.0), (9.0, 0.5)]));
        assert_eq!(before.point_moved(1, 70.0), curve(&[(0.0, 0.0), (9.0, 1.0), (9.0, 0.5)]));
        assert_eq!(before.point_moved(0, -3.0), curve(&[(-3.0, 0.0), (5.0, 1.0), (9.0, 0.5)]));
        assert_eq!(before.point_moved(2, f64::NAN), before);
        let step = curve(&[(0.0, 0.0), (5.0, 0.0), (5.0, 1.0)]);
        assert_eq!(step.point_moved(0, 8.0), step, "a third point cannot be where two are");
    }

    #[test]
    fn a_new_point_changes_nothing_yet() {
        let before = curve(&[(0.0, 0.0), (4.0, 1.0)]);
        let (after, idx) = before.with_point(1.0);
        assert_eq!((after.points()[idx], after.points().len()), ((1.0, [0.25]), 3));
        for value in [-1.0, 0.5, 1.0, 3.0, 9.0] {
            assert!((after.at(value)[0] - before.at(value)[0]).abs() < 1e-12);
        }
        assert_eq!(after.without(idx), before);
        let (twice, _) = after.with_point(1.0);
        let (thrice, idx) = twice.with_point(1.0);
        assert_eq!((thrice, idx), (twice, 2));
    }

    #[test]
    fn the_last_point_stays() {
        let alone = curve(&[(1.0, 0.5)]);
        assert_eq!(alone.without(0), alone);
    }

    #[test]
    fn results_stay_opacities() {
        let before = curve(&[(0.0, 0.0), (4.0, 1.0)]);
        assert_eq!(with_result(&before, 0, [1.5]), curve(&[(0.0, 1.0), (4.0, 1.0)]));
        assert_eq!(with_result(&before, 0, [f64::NAN]), before);
    }

    #[test]
    fn maps_are_stretched() {
        let map = slabsplat::io::colormap("gray").unwrap();
        let wide = stretched(&map, [-10.0, 30.0]);
        assert_eq!(wide.span(), [-10.0, 30.0]);
        assert_eq!(wide.at(10.0), map.at(0.5));
    }
}
