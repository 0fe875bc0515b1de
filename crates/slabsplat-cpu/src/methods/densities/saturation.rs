//! From which density on a pixel is saturated that shows the largest of all, or the least (model §12): a
//! better one would look the same.
//!
//! Beyond its last point a transfer function is constant, and before its first; mostly it is further in, as
//! what is transparent looks the same whatever its colour. So nothing behind air can change a minimum in
//! which air is invisible.

use super::one_for_all::shown;
use slabsplat_backend::densities::{ROUNDING, ValueScale};
use slabsplat_core::TransferFunction;

/// What saturates a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Saturation {
    /// Times 1 in a maximum, and −1 in a minimum, its density is at least this.
    pub(super) bound: f32,
    /// And it counts by at least this much.
    pub(super) least_counting: f32,
}

/// What no picture shows of a colour.
const INVISIBLE: f32 = 1e-6;

impl Saturation {
    /// In a maximum, if `up` is 1; in a minimum, if it is −1.
    pub(super) fn new(transfer: &TransferFunction, scale: &ValueScale, up: f64) -> Self {
        let mut points: Vec<f64> = transfer.positions().collect();
        points.sort_by(|a, b| (up * b).total_cmp(&(up * a)));
        points.dedup();
        let at = |value: f64| shown(transfer, value);
        let beyond = at(up * f64::INFINITY);
        let looks_alike =
            |value: f64| at(value).iter().zip(beyond).all(|(a, b)| (a - b).abs() <= INVISIBLE);
        // Just behind a point there may be a step. On a line between two that is alike at two points, all is.
        let behind = |point: f64| if up < 0.0 { point.next_up() } else { point.next_down() };
        let is_flat = |pair: &&[f64]| {
            looks_alike(pair[0])
                && looks_alike(behind(pair[0]))
                && looks_alike(0.5 * pair[0] + 0.5 * pair[1])
        };
        let n_flat = points.windows(2).take_while(is_flat).count();
        let last = points[n_flat];
        // Sums are rounded, and those on a step must be beyond it.
        let goes_on = looks_alike(last) && looks_alike(behind(last));
        let rounding = if goes_on { -ROUNDING } else { ROUNDING };
        let is_visible = INVISIBLE < beyond[3];
        Self {
            bound: (up * scale.unclamped(last) + rounding) as f32,
            least_counting: if is_visible { 1.0 } else { 0.0 },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the steepest slope of these, a tenth for a unit, does within what sums are rounded by, 3·10⁻⁴.
    const SLOPE_IN_ROUNDING: f32 = 4e-5;

    /// Whatever is better than the bound looks the same, and what is worse by more than rounding does not.
    fn check(opacity: &[(f64, f64)], color: &[(f64, f64)], up: f64, expected: (f64, f32)) {
        let color = color.iter().map(|&(x, y)| (x, [y; 3]));
        let transfer = TransferFunction::new(opacity.iter().copied(), color).unwrap();
        let scale = ValueScale::new(Some([-50.0, 250.0]), [0.0, 200.0]);
        let Saturation { bound, least_counting } = Saturation::new(&transfer, &scale, up);
        let value = scale.value(up * f64::from(bound));
        assert!((value - expected.0).abs() < 1e-3, "{value}, not {}", expected.0);
        assert_eq!(least_counting, expected.1);
        let beyond = shown(&transfer, up * f64::INFINITY);
        for step in 0..100 {
            let off = shown(&transfer, value + up * f64::from(step)).into_iter().zip(beyond);
            let off = off.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(off < SLOPE_IN_ROUNDING, "{off}: {value} {step}");
        }
        assert!(shown(&transfer, value - 0.01 * up) != beyond, "{value} is not the first");
    }

    const GRAY: &[(f64, f64)] = &[(0.0, 0.5)];

    #[test]
    fn saturation_is_where_functions_end() {
        let ramp = [(10.0, 0.1), (90.0, 0.7)];
        check(&ramp, GRAY, 1.0, (90.0, 1.0));
        check(&ramp, GRAY, -1.0, (10.0, 1.0));
        check(&ramp, &[(0.0, 0.1), (140.0, 0.9)], 1.0, (140.0, 1.0));
        check(&ramp, &[(0.0, 0.1), (140.0, 0.9)], -1.0, (0.0, 1.0));
    }

    /// Colours of what is transparent do not matter, nor how much of it there is.
    #[test]
    fn saturation_goes_on_where_nothing_shows() {
        let band = [(0.0, 0.0), (40.0, 0.0), (60.0, 0.9), (70.0, 0.9), (80.0, 0.0), (150.0, 0.0)];
        let colors = [(-9.0, 0.2), (20.0, 0.8), (100.0, 0.1), (120.0, 0.4)];
        check(&band, &colors, 1.0, (80.0, 0.0));
        check(&band, &colors, -1.0, (40.0, 0.0));
    }

    #[test]
    fn saturation_begins_at_steps() {
        let steps = [(20.0, 0.0), (20.0, 0.6), (50.0, 0.6), (50.0, 0.2)];
        check(&steps, GRAY, 1.0, (50.0, 1.0));
        check(&steps, GRAY, -1.0, (20.0, 0.0));
        let steps_and_flat = [(20.0, 0.3), (20.0, 0.6), (50.0, 0.6)];
        check(&steps_and_flat, GRAY, 1.0, (20.0, 1.0));
    }
}
