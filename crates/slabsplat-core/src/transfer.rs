//! Piecewise-linear transfer functions, and the iso-ranges that they make visible (paper §4).

use thiserror::Error;

/// A function of the voxel's value, linear between its points and constant beyond them.
///
/// There is at least one point, every number is finite, and the positions never fall. Two points at
/// one position make a step, which takes the later point's value at the position itself.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize, serde::Serialize))]
#[cfg_attr(feature = "serde", serde(try_from = "Vec<Vec<f64>>", into = "Vec<Vec<f64>>"))]
pub struct PiecewiseLinear<const N: usize> {
    points: Vec<(f64, [f64; N])>,
}

/// A point of a [`PiecewiseLinear`] function: a position and the results there. A function of one result
/// takes it as a number or as an array of one.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(clippy::exhaustive_structs, reason = "a point is a position and results")]
pub struct CurvePoint<const N: usize>(pub f64, pub [f64; N]);

/// What makes voxels visible: opacity and colour as functions of the value.
///
/// ```
/// use slabsplat_core::TransferFunction;
///
/// let transfer = TransferFunction::new(
///     [(80.0, 0.0), (255.0, 0.9)],
///     [(0.0, [0.0, 0.0, 0.0]), (255.0, [1.0, 0.9, 0.8])],
/// )?;
/// assert_eq!(transfer.opacity(80.0), 0.0);
/// assert_eq!(transfer.opacity(300.0), 0.9);
/// assert_eq!(transfer.iso_ranges().len(), 1);
/// # Ok::<(), slabsplat_core::TransferError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize, serde::Serialize))]
#[cfg_attr(
    feature = "serde",
    serde(try_from = "crate::serialized::TransferKeys", into = "crate::serialized::TransferKeys")
)]
pub struct TransferFunction {
    opacity: PiecewiseLinear<1>,
    color: PiecewiseLinear<3>,
}

/// A closed interval of values, `lo ≤ value ≤ hi`; the ends may be infinite.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(clippy::exhaustive_structs, reason = "a range has two ends")]
pub struct IsoRange {
    /// Smallest value inside.
    pub lo: f64,
    /// Largest value inside.
    pub hi: f64,
}

/// Why a transfer function cannot be made. `what` is `opacity` or `color`.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum TransferError {
    /// There is nothing to interpolate.
    #[error("{what} needs at least one point")]
    Empty {
        /// Which function.
        what: &'static str,
    },
    /// A value, opacity or colour is NaN or infinite.
    #[error("point {point_idx} of {what} is not finite")]
    NotFinite {
        /// Which function.
        what: &'static str,
        /// Which of its points, counted from 0.
        point_idx: usize,
    },
    /// A point stands left of the one before it, or is the third at its value.
    #[error("point {point_idx} of {what} is out of order: values must rise (two may be equal)")]
    Unsorted {
        /// Which function.
        what: &'static str,
        /// Which of its points, counted from 0.
        point_idx: usize,
    },
    /// An opacity or colour is outside 0 … 1.
    #[error("point {point_idx} of {what} lies outside 0 to 1")]
    OutOfRange {
        /// Which function.
        what: &'static str,
        /// Which of its points, counted from 0.
        point_idx: usize,
    },
}

impl TransferError {
    /// Which function a person should look at.
    pub fn what(&self) -> &'static str {
        let (Self::Empty { what }
        | Self::NotFinite { what, .. }
        | Self::Unsorted { what, .. }
        | Self::OutOfRange { what, .. }) = self;
        what
    }
}

impl<const N: usize> From<(f64, [f64; N])> for CurvePoint<N> {
    fn from((position, results): (f64, [f64; N])) -> Self {
        Self(position, results)
    }
}

impl From<(f64, f64)> for CurvePoint<1> {
    fn from((position, result): (f64, f64)) -> Self {
        Self(position, [result])
    }
}

impl<const N: usize> PiecewiseLinear<N> {
    /// A function through `points`, whose results lie within 0 … 1. `what` names it in errors.
    ///
    /// # Errors
    /// If there is no point, a number is not finite, the positions fall, or a result is outside
    /// 0 … 1.
    pub fn new<P: Into<CurvePoint<N>>>(
        what: &'static str,
        points: impl IntoIterator<Item = P>,
    ) -> Result<Self, TransferError> {
        let points = points.into_iter().map(Into::into);
        let points = points.map(|CurvePoint(position, results)| (position, results));
        let points = points.collect::<Vec<_>>();
        if points.is_empty() {
            return Err(TransferError::Empty { what });
        }
        for (point_idx, (position, results)) in points.iter().enumerate() {
            if !position.is_finite() || results.iter().any(|r| !r.is_finite()) {
                return Err(TransferError::NotFinite { what, point_idx });
            }
            if results.iter().any(|r| !(0.0..=1.0).contains(r)) {
                return Err(TransferError::OutOfRange { what, point_idx });
            }
        }
        let falls = |idx: usize| points[idx].0 < points[idx - 1].0;
        let is_third = |idx: usize| 1 < idx && points[idx].0 <= points[idx - 2].0;
        match (1..points.len()).find(|&idx| falls(idx) || is_third(idx)) {
            Some(point_idx) => Err(TransferError::Unsorted { what, point_idx }),
            None => Ok(Self { points }),
        }
    }

    /// The points, from left to right.
    pub fn points(&self) -> &[(f64, [f64; N])] {
        &self.points
    }

    /// The function at `value`. Infinite values give the ends; NaN gives the first point.
    pub fn at(&self, value: f64) -> [f64; N] {
        let n_left = self.points.partition_point(|(position, _)| *position <= value);
        if n_left == 0 {
            return self.points[0].1;
        }
        let (x0, y0) = self.points[n_left - 1];
        let Some(&(x1, y1)) = self.points.get(n_left) else {
            return y0;
        };
        // Halved, or the distance of two points at opposite ends of the numbers would be infinite.
        let t = (0.5 * value - 0.5 * x0) / (0.5 * x1 - 0.5 * x0);
        std::array::from_fn(|channel| y0[channel] + (y1[channel] - y0[channel]) * t)
    }
}

impl IsoRange {
    /// What is in any of some ranges: disjoint ranges that do not touch, from low values to high.
    pub fn union(ranges: impl IntoIterator<Item = Self>) -> Vec<Self> {
        let mut ranges: Vec<Self> = ranges.into_iter().collect();
        ranges.sort_by(|a, b| a.lo.total_cmp(&b.lo));
        let mut union: Vec<Self> = Vec::with_capacity(ranges.len());
        for range in ranges {
            match union.last_mut() {
                Some(last) if range.lo <= last.hi.next_up() => last.hi = last.hi.max(range.hi),
                _ => union.push(range),
            }
        }
        union
    }
}

impl TransferFunction {
    /// Opacity per unit length and RGB, as functions of the value.
    ///
    /// # Errors
    /// As [`PiecewiseLinear::new`].
    pub fn new<P: Into<CurvePoint<1>>>(
        opacity: impl IntoIterator<Item = P>,
        color: impl IntoIterator<Item = (f64, [f64; 3])>,
    ) -> Result<Self, TransferError> {
        Ok(Self {
            opacity: PiecewiseLinear::new("opacity", opacity)?,
            color: PiecewiseLinear::new("color", color)?,
        })
    }

    /// Of two functions that are there.
    pub fn of_curves(opacity: PiecewiseLinear<1>, color: PiecewiseLinear<3>) -> Self {
        Self { opacity, color }
    }

    /// The opacity function.
    pub fn opacity_points(&self) -> &PiecewiseLinear<1> {
        &self.opacity
    }

    /// The colour function.
    pub fn color_points(&self) -> &PiecewiseLinear<3> {
        &self.color
    }

    /// The values at which either function has a point; those of opacity first.
    pub fn positions(&self) -> impl Iterator<Item = f64> + '_ {
        let opacities = self.opacity.points.iter().map(|point| point.0);
        opacities.chain(self.color.points.iter().map(|point| point.0))
    }

    /// Opacity per `unit` at `value`, 0 … 1.
    pub fn opacity(&self, value: f64) -> f64 {
        self.opacity.at(value)[0]
    }

    /// Red, green and blue at `value`, 0 … 1 each, display-referred.
    pub fn color(&self, value: f64) -> [f64; 3] {
        self.color.at(value)
    }

    /// Where the opacity is above 0: disjoint ranges, from low values to high.
    pub fn iso_ranges(&self) -> Vec<IsoRange> {
        // Neighbouring pieces meet at a point, or right beside it where the point itself has opacity 0 on one
        // side of a step.
        IsoRange::union(self.visible_pieces())
    }

    /// The visible part of every piece between two points, and beyond the ends.
    fn visible_pieces(&self) -> Vec<IsoRange> {
        let points = &self.opacity.points;
        let (first, last) = (points[0], points[points.len() - 1]);
        let mut pieces = Vec::with_capacity(points.len() + 1);
        if 0.0 < first.1[0] {
            pieces.push(IsoRange { lo: f64::NEG_INFINITY, hi: first.0.next_down() });
        }
        for pair in points.windows(2) {
            let ((x0, [a0]), (x1, [a1])) = (pair[0], pair[1]);
            if x0 < x1 && (0.0 < a0 || 0.0 < a1) {
                // At x1 itself the next piece decides, which may be the far side of a step.
                let lo = if 0.0 < a0 { x0 } else { x0.next_up() };
                pieces.push(IsoRange { lo, hi: x1.next_down() });
            }
        }
        if 0.0 < last.1[0] {
            pieces.push(IsoRange { lo: last.0, hi: f64::INFINITY });
        }
        pieces.retain(|piece| piece.lo <= piece.hi);
        pieces
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn transfer(opacity: &[(f64, f64)]) -> TransferFunction {
        let opacity = opacity.iter().copied();
        TransferFunction::new(opacity, vec![(0.0, [1.0; 3])]).unwrap()
    }

    #[test]
    fn transfer_is_constant_beyond_its_ends() {
        let t = transfer(&[(1.0, 0.2), (3.0, 0.8)]);
        for (value, expected) in [
            (f64::NEG_INFINITY, 0.2),
            (0.0, 0.2),
            (2.0, 0.5),
            (3.0, 0.8),
            (1e300, 0.8),
            (f64::INFINITY, 0.8),
        ] {
            assert!((t.opacity(value) - expected).abs() < 1e-15, "{value}");
        }
    }

    #[test]
    fn transfer_spans_all_numbers() {
        let t = transfer(&[(-1.7e308, 0.0), (1.7e308, 1.0)]);
        assert_eq!((t.opacity(0.0), t.opacity(1.7e308)), (0.5, 1.0));
    }

    #[test]
    fn transfer_step_takes_the_later_point() {
        let t = transfer(&[(0.0, 0.0), (5.0, 0.0), (5.0, 1.0), (9.0, 1.0)]);
        assert_eq!(t.opacity(5.0_f64.next_down()), 0.0);
        assert_eq!(t.opacity(5.0), 1.0);
        let points = [(0.0, [0.0]), (5.0, [0.0]), (5.0, [1.0]), (9.0, [1.0])];
        assert_eq!(t.opacity_points().points(), points);
        let color = vec![(1.0, [0.0, 0.2, 0.4]), (3.0, [1.0, 0.4, 0.4])];
        let t = TransferFunction::new(vec![(0.0, [1.0])], color).unwrap();
        let expected = [0.5, 0.3, 0.4];
        assert!(t.color(2.0).iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12));
    }

    /// The ranges must hold exactly the values whose opacity is above 0. Within a rounding error of a
    /// point they may hold a value whose opacity rounds to 0, but must never miss a visible one.
    #[test]
    fn iso_ranges_are_the_support() {
        for points in [
            vec![(0.0, 0.0)],
            vec![(0.0, 0.3)],
            vec![(0.0, 0.0), (80.0, 0.0), (255.0, 0.9)],
            vec![(-7.0, 0.5), (1.0, 0.0), (2.0, 0.0), (3.0, 0.5), (4.0, 0.0)],
            vec![(0.5, 0.0), (1.0, 0.5), (2.0, 0.0), (3.0, 0.5), (4.0, 0.0)],
            vec![(0.0, 0.0), (5.0, 0.0), (5.0, 1.0), (9.0, 1.0), (9.0, 0.0)],
            vec![(0.0, 1.0), (0.0, 0.0)],
            vec![(-1.0, 1.0), (0.0, 0.0), (0.0, 1.0), (1.0, 0.0)],
        ] {
            let t = transfer(&points);
            let ranges = t.iso_ranges();
            let is_inside = |v: f64| ranges.iter().any(|r| r.lo <= v && v <= r.hi);
            let exact = points.iter().flat_map(|&(x, _)| [x - 0.5, x, x + 0.5]);
            for value in exact.chain([f64::NEG_INFINITY, -1e9, 1e9, f64::INFINITY]) {
                let visible = 0.0 < t.opacity(value);
                assert_eq!(is_inside(value), visible, "{value} in {ranges:?} of {points:?}");
            }
            for value in points.iter().flat_map(|&(x, _)| [x.next_down(), x.next_up()]) {
                let visible = 0.0 < t.opacity(value);
                assert!(is_inside(value) || !visible, "{value} in {ranges:?} of {points:?}");
            }
            assert!(ranges.iter().all(|range| range.lo <= range.hi), "{ranges:?}");
            // What touches is one.
            assert!(ranges.windows(2).all(|w| w[0].hi.next_up() < w[1].lo), "{ranges:?}");
        }
    }

    #[test]
    fn iso_ranges_unite() {
        let check = |ranges: &[(f64, f64)], expected: &[(f64, f64)]| {
            let ranges = ranges.iter().map(|&(lo, hi)| IsoRange { lo, hi });
            let expected: Vec<_> = expected.iter().map(|&(lo, hi)| IsoRange { lo, hi }).collect();
            assert_eq!(IsoRange::union(ranges), expected);
        };
        check(&[], &[]);
        check(&[(4.0, 5.0), (1.0, 2.0)], &[(1.0, 2.0), (4.0, 5.0)]);
        check(&[(1.0, 9.0), (2.0, 3.0), (9.0, 10.0)], &[(1.0, 10.0)]);
        check(&[(2.0_f64.next_up(), 3.0), (f64::NEG_INFINITY, 2.0)], &[(f64::NEG_INFINITY, 3.0)]);
    }

    #[test]
    fn transfer_rejects_bad_points() {
        let check = |points: Vec<(f64, [f64; 1])>, expected| {
            assert_eq!(PiecewiseLinear::new("opacity", points), Err(expected));
        };
        let what = "opacity";
        check(vec![], TransferError::Empty { what });
        check(vec![(f64::NAN, [0.0])], TransferError::NotFinite { what, point_idx: 0 });
        check(vec![(0.0, [1.5])], TransferError::OutOfRange { what, point_idx: 0 });
        check(vec![(1.0, [0.0]), (0.0, [1.0])], TransferError::Unsorted { what, point_idx: 1 });
        let third = vec![(1.0, [0.0]), (1.0, [1.0]), (1.0, [0.0])];
        check(third, TransferError::Unsorted { what, point_idx: 2 });
    }
}
