//! Values as sheets sum them: 32-bit numbers from −1 to 1, counted from the middle of the transfer function
//! or of the isosurfaces, where digits matter most.

use crate::{LayerPlan, ShownDensities};
use slabsplat_core::{IsoRange, Isosurface, Sample, Scaling, Statistic, TransferFunction};

/// Takes values to what is summed, and back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ValueScale {
    /// Half of that middle: halved numbers have finite differences.
    half_middle: f64,
    /// Half of the largest distance of a value from that middle.
    half_reach: f64,
    /// What infinite values count as.
    ends: [f64; 2],
}

impl ValueScale {
    /// The scale for the values of a layer, of which the finite ones have that range, if there are any.
    pub fn of(layer: &LayerPlan<'_>, shown: ShownDensities, finite: Option<[f64; 2]>) -> Self {
        let ends = match shown {
            ShownDensities::Composited | ShownDensities::Statistic(_) => {
                ends_of_transfer(layer.transfer)
            }
            ShownDensities::Isosurfaces => ends_of_isosurfaces(layer.isosurfaces),
        };
        Self::new(finite, ends)
    }

    /// The scale for values of the range `finite`, if there are any, and those from `first` to `last`, which
    /// decide.
    pub fn new(finite: Option<[f64; 2]>, [first, last]: [f64; 2]) -> Self {
        let half_middle = 0.25 * first + 0.25 * last;
        let [lo, hi] = finite.unwrap_or([first, last]);
        let ends = [lo.min(first), hi.max(last)];
        let half_reach = ends.map(|end| (0.5 * end - half_middle).abs());
        let half_reach = half_reach[0].max(half_reach[1]);
        Self { half_middle, half_reach: if half_reach == 0.0 { 0.5 } else { half_reach }, ends }
    }

    /// What the value of a surface counts as, scaled.
    pub fn of_isosurface(&self, surface: &Isosurface) -> f64 {
        let [least, largest] = self.ends().map(f64::from);
        self.unclamped(surface.value()) - PLATEAU * (largest - least)
    }

    /// What is summed for `value`, which is not NaN.
    #[inline]
    pub fn scaled(&self, value: f64) -> f32 {
        self.unclamped(value.clamp(self.ends[0], self.ends[1])) as f32
    }

    /// What infinite values count as: the least, and the largest, of all values.
    pub fn values(&self) -> [f64; 2] {
        self.ends
    }

    /// The least and the largest of what is summed.
    pub fn ends(&self) -> [f32; 2] {
        self.ends.map(|end| self.scaled(end))
    }

    /// Up to where densities count for nothing in a maximum or a minimum, where those of `relevant` decide
    /// (model §12). What holds next to nothing counts as such a one.
    pub fn worst(&self, statistic: Statistic, relevant: &[IsoRange]) -> f32 {
        let [least, largest] = self.ends;
        let worst = match statistic {
            Statistic::Minimum => {
                let last = relevant.last().map_or(largest, |range| range.hi.min(largest));
                self.unclamped(last) + self.rise()
            }
            Statistic::Maximum | Statistic::Average => {
                let first = relevant.first().map_or(least, |range| range.lo.max(least));
                self.unclamped(first) - self.rise()
            }
        };
        worst as f32
    }

    /// How much better they must be to count in full, scaled.
    pub fn rise(&self) -> f64 {
        let extent = self.extent(self.ends);
        if extent == 0.0 { 1.0 } else { RISE * extent }
    }

    /// Where `value` lies on the scale, be it far outside.
    #[inline]
    pub fn unclamped(&self, value: f64) -> f64 {
        (0.5 * value - self.half_middle) / self.half_reach
    }

    /// The value that `scaled` stands for.
    #[inline]
    pub fn value(&self, scaled: f64) -> f64 {
        2.0 * (self.half_middle + scaled * self.half_reach)
    }

    /// The extent of a range of values on the scale.
    pub fn extent(&self, [lo, hi]: [f64; 2]) -> f64 {
        (0.5 * hi - 0.5 * lo) / self.half_reach
    }
}

/// A density that is less than this part of all values below a surface's counts as on it: plateaus that are
/// rounded to either side must not be speckled.
const PLATEAU: f64 = 1.0 / (1 << 19) as f64;

/// Of all values.
const RISE: f64 = 1.0 / 128.0;

/// The first and the last point of either function.
fn ends_of_transfer(transfer: &TransferFunction) -> [f64; 2] {
    ends_of(transfer.positions())
}

/// The first and the last surface.
fn ends_of_isosurfaces(isosurfaces: &[Isosurface]) -> [f64; 2] {
    ends_of(isosurfaces.iter().map(Isosurface::value))
}

fn ends_of(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let none = [f64::INFINITY, f64::NEG_INFINITY];
    values.fold(none, |[lo, hi], x| [lo.min(x), hi.max(x)])
}

/// The least and the largest finite sample; `[∞, −∞]` if there is none.
pub fn finite_samples<T: Sample>(samples: &[T]) -> [f64; 2] {
    let finite = samples.iter().map(|sample| sample.to_f64()).filter(|value| value.is_finite());
    ends_of(finite)
}

/// The least and the largest finite value of a volume whose finite samples have that range; `None` if there
/// is none.
pub fn finite_values([least, largest]: [f64; 2], scaling: Scaling) -> Option<[f64; 2]> {
    if largest < least {
        return None;
    }
    let [a, b] = [least, largest].map(|sample| scaling.apply(sample));
    // The scaling may make finite samples infinite.
    Some([a.min(b).max(f64::MIN), a.max(b).min(f64::MAX)])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn transfer(points: &[f64]) -> TransferFunction {
        let opacity = points.iter().map(|&x| (x, 0.5));
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
        let samples = finite_samples(&[f32::INFINITY, 3.0, f32::NAN, f32::NEG_INFINITY]);
        let range = finite_values(samples, Scaling { slope: -2.0, intercept: 1.0 });
        assert_eq!(range, Some([-5.0, -5.0]));
        let scale = ValueScale::new(range, [-2.0, 9.0]);
        let back = |value: f64| scale.value(scale.scaled(value).into());
        assert!((back(f64::INFINITY) - 9.0).abs() < 1e-5, "the transfer function's end");
        assert!((back(f64::NEG_INFINITY) + 5.0).abs() < 1e-5, "the least value");
    }
}
