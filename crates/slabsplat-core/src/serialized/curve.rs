//! A piecewise-linear function is a list of its points, each a position and the results there.

use crate::{PiecewiseLinear, TransferError};

/// What such a function is called in errors.
const NAME: &str = "the function";

impl<const N: usize> TryFrom<Vec<Vec<f64>>> for PiecewiseLinear<N> {
    type Error = String;

    fn try_from(points: Vec<Vec<f64>>) -> Result<Self, String> {
        let point = |(idx, point): (usize, Vec<f64>)| {
            let found = point.len();
            let wrong_length =
                || format!("point {idx} of {NAME} has {found} numbers, and not {}", N + 1);
            let (position, results) = point.split_first().ok_or_else(wrong_length)?;
            let results = results.try_into().map_err(|_| wrong_length())?;
            Ok((*position, results))
        };
        let points: Vec<_> =
            points.into_iter().enumerate().map(point).collect::<Result<_, String>>()?;
        Self::new(NAME, points).map_err(|error: TransferError| error.to_string())
    }
}

impl<const N: usize> From<PiecewiseLinear<N>> for Vec<Vec<f64>> {
    fn from(function: PiecewiseLinear<N>) -> Self {
        let point =
            |(position, results): &(f64, [f64; N])| [&[*position], results.as_slice()].concat();
        function.points().iter().map(point).collect()
    }
}
