//! Values as sheets sum them: 32-bit numbers from −1 to 1, counted from the middle of the transfer function
//! or of the isosurfaces, where digits matter most.

use rayon::prelude::*;
use slabsplat_core::{Isosurface, Sample, TransferFunction, Volume, with_samples};

/// Takes values to what is summed, and back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ValueScale {
    /// Half of that middle: halved numbers have finite differences.
    half_middle: f64,
    /// Half of the largest distance of a value from that middle.
    half_reach: f64,
    /// What infinite values count as.
    ends: [f64; 2],
}

impl ValueScale {
    /// The scale for values of the range `finite`, if there are any, and those from `first` to `last`, which
    /// decide.
    pub(super) fn new(finite: Option<[f64; 2]>, [first, last]: [f64; 2]) -> Self {
        let half_middle = 0.25 * first + 0.25 * last;
        let [lo, hi] = finite.unwrap_or([first, last]);
        let ends = [lo.min(first), hi.max(last)];
        let half_reach = ends.map(|end| (0.5 * end - half_middle).abs());
        let half_reach = half_reach[0].max(half_reach[1]);
        Self { half_middle, half_reach: if half_reach == 0.0 { 0.5 } else { half_reach }, ends }
    }

    /// What is summed for `value`, which is not NaN.
    #[inline]
    pub(super) fn scaled(&self, value: f64) -> f32 {
        self.unclamped(value.clamp(self.ends[0], self.ends[1])) as f32
    }

    /// The least and the largest of what is summed.
    pub(super) fn ends(&self) -> [f32; 2] {
        self.ends.map(|end| self.scaled(end))
    }

    /// Where `value` lies on the scale, be it far outside.
    #[inline]
    pub(super) fn unclamped(&self, value: f64) -> f64 {
        (0.5 * value - self.half_middle) / self.half_reach
    }

    /// The value that `scaled` stands for.
    #[inline]
    pub(super) fn value(&self, scaled: f64) -> f64 {
        2.0 * (self.half_middle + scaled * self.half_reach)
    }

    /// The extent of a range of values on the scale.
    pub(super) fn extent(&self, [lo, hi]: [f64; 2]) -> f64 {
        (0.5 * hi - 0.5 * lo) / self.half_reach
    }
}

/// The first and the last point of either function.
pub(super) fn ends_of_transfer(transfer: &TransferFunction) -> [f64; 2] {
    ends_of(transfer.positions())
}

/// The first and the last surface.
pub(super) fn ends_of_isosurfaces(isosurfaces: &[Isosurface]) -> [f64; 2] {
    ends_of(isosurfaces.iter().map(Isosurface::value))
}

fn ends_of(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let none = [f64::INFINITY, f64::NEG_INFINITY];
    values.fold(none, |[lo, hi], x| [lo.min(x), hi.max(x)])
}

/// The least and the largest finite value; `None` if there is none.
pub(super) fn finite_range(volume: &Volume) -> Option<[f64; 2]> {
    let range = with_samples!(volume.samples(), |s| finite_range_of(s))?;
    let [a, b] = range.map(|sample| volume.scaling().apply(sample));
    // The scaling may make finite samples infinite.
    let range = [a.min(b).max(f64::MIN), a.max(b).min(f64::MAX)];
    Some(range)
}

fn finite_range_of<T: Sample>(samples: &[T]) -> Option<[f64; 2]> {
    let joined = |[a, b]: [f64; 2], [c, d]: [f64; 2]| [a.min(c), b.max(d)];
    let empty = [f64::INFINITY, f64::NEG_INFINITY];
    let of_chunk = |chunk: &[T]| {
        let finite = chunk.iter().map(|s| s.to_f64()).filter(|v| v.is_finite());
        finite.fold(empty, |range, v| joined(range, [v, v]))
    };
    let range = samples.par_chunks(1 << 16).map(of_chunk).reduce(|| empty, joined);
    (range[0] <= range[1]).then_some(range)
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::{Grid, Scaling};

    fn transfer(points: &[f64]) -> TransferFunction {
        let opacity = points.iter().map(|&x| (x, [0.5])).collect();
        TransferFunction::new(opacity, vec![(points[0], [1.0; 3])]).unwrap()
    }

    #[test]
    fn value_scale_round_trip() {
        for (range, points) in [
            ([0.0, 255.0], vec![80.0, 120.0]),
            ([-1000.0, 3000.0], vec![500.0]),
            ([7.0, 7.0], vec![7.0]),
            ([-1.7e308, 1.7e308], vec![-1e308, 1.7e308]),
        ] {
            let scale = ValueScale::new(Some(range), ends_of_transfer(&transfer(&points)));
            for value in [range[0], range[1], points[0]] {
                let back = scale.value(scale.scaled(value).into());
                let tolerance = 1e-6 * (0.5 * value - scale.half_middle).abs() + 1e-12;
                assert!((0.5 * back - 0.5 * value).abs() <= tolerance, "{value}: {back}");
            }
        }
    }

    #[test]
    fn value_scale_of_infinities() {
        let grid = Grid::with_spacing([4, 1, 1], [1.0; 3]).unwrap();
        let samples = vec![f32::INFINITY, 3.0, f32::NAN, f32::NEG_INFINITY];
        let volume = Volume::new(grid, samples.into(), Scaling { slope: -2.0, intercept: 1.0 });
        let range = finite_range(&volume.unwrap());
        assert_eq!(range, Some([-5.0, -5.0]));
        let scale = ValueScale::new(range, [-2.0, 9.0]);
        let back = |value: f64| scale.value(scale.scaled(value).into());
        assert!((back(f64::INFINITY) - 9.0).abs() < 1e-5, "the transfer function's end");
        assert!((back(f64::NEG_INFINITY) + 5.0).abs() < 1e-5, "the least value");
    }
}
