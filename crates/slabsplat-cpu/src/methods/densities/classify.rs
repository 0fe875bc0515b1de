//! From the density at a pixel to what it adds to the picture: opacity, colour, light.

use super::values::ValueScale;
use slabsplat_backend::FramePlan;
use slabsplat_core::glam::DVec3;
use slabsplat_core::{BlinnPhong, Compositing, IsoRange, TransferFunction, ViewAxes};

/// Classifies and shades densities.
pub(super) struct Classifier<'a> {
    transfer: &'a TransferFunction,
    scale: ValueScale,
    compositing: Compositing,
    light: Option<BlinnPhong>,
    axes: ViewAxes,
    /// Where anything is drawn, scaled: from the first end up to the second.
    drawn: Vec<[f64; 2]>,
    /// Where the transfer function has a step: value, and scaled.
    steps: Vec<(f64, f64)>,
}

/// Sums of 32-bit floats miss a density by less than this, scaled. A step of the transfer function that lies
/// on the value of a plateau must not be taken here and missed there, so that a density this far before a
/// step counts as on it.
const ROUNDING: f64 = 1.0 / (1 << 19) as f64;

impl<'a> Classifier<'a> {
    pub(super) fn new(plan: &FramePlan<'a>, scale: ValueScale) -> Self {
        let drawn = |range: &IsoRange| {
            let [lo, hi] = [range.lo, range.hi].map(|end| scale.unclamped(end));
            let is_step = starts_with_a_step(plan.transfer, range);
            [if is_step { lo - ROUNDING } else { lo + ROUNDING }, hi - ROUNDING]
        };
        Self {
            transfer: plan.transfer,
            scale,
            compositing: plan.compositing,
            light: plan.light,
            axes: *plan.view.axes(),
            drawn: plan.relevant.iter().map(drawn).collect(),
            steps: steps(plan.transfer).map(|step| (step, scale.unclamped(step))).collect(),
        }
    }

    /// Opacity per `unit` at a scaled density, and the density as it is classified; `None` where it is 0.
    #[inline]
    pub(super) fn opacity(&self, scaled: f64) -> Option<(f64, f64)> {
        if !self.drawn.iter().any(|[lo, hi]| *lo <= scaled && scaled < *hi) {
            return None;
        }
        let is_before = |(_, step): &&(f64, f64)| scaled < *step && *step - ROUNDING <= scaled;
        let value = match self.steps.iter().find(is_before) {
            Some((value, _)) => *value,
            None => self.scale.value(scaled),
        };
        let opacity = self.transfer.opacity(value);
        (0.0 < opacity).then_some((opacity, value))
    }

    /// Premultiplied colour and opacity of `length` `unit`s of one density, whose surface faces along
    /// `normal`, in view space and not longer than 1.
    #[inline]
    pub(super) fn premultiplied(
        &self,
        length: f64,
        (opacity, value): (f64, f64),
        normal: DVec3,
    ) -> [f32; 4] {
        let color = DVec3::from_array(self.transfer.color(value));
        let color = self.light.map_or(color, |light| light.lit(color, self.in_world(normal)));
        let weight = length * self.compositing.weight(opacity);
        let of_color = if self.compositing.weights_colors() { weight } else { length };
        let [r, g, b] = (of_color * color).to_array();
        self.compositing.resolve([r, g, b, weight]).map(|channel| channel as f32)
    }

    fn in_world(&self, v: DVec3) -> DVec3 {
        self.axes.right * v.x + self.axes.up * v.y + self.axes.forward * v.z
    }
}

/// The visible ranges with room for rounding, by which voxels are to be selected.
pub(super) fn ranges_with_room(plan: &FramePlan<'_>, scale: &ValueScale) -> Vec<IsoRange> {
    let room = |range: &IsoRange| {
        let is_step = starts_with_a_step(plan.transfer, range);
        let lo = if is_step {
            scale.value(scale.unclamped(range.lo) - 2.0 * ROUNDING)
        } else {
            range.lo
        };
        IsoRange { lo: lo.min(range.lo), hi: range.hi }
    };
    plan.relevant.iter().map(room).collect()
}

/// Whether the opacity jumps at the start of a visible range, instead of rising from 0.
fn starts_with_a_step(transfer: &TransferFunction, range: &IsoRange) -> bool {
    let is_here = |(x, [opacity]): &(f64, [f64; 1])| *x == range.lo && 0.0 < *opacity;
    transfer.opacity_points().points().iter().any(is_here)
}

fn steps(transfer: &TransferFunction) -> impl Iterator<Item = f64> + '_ {
    fn of<const N: usize>(points: &[(f64, [f64; N])]) -> impl Iterator<Item = f64> + '_ {
        points.windows(2).filter(|pair| pair[0].0 == pair[1].0).map(|pair| pair[0].0)
    }
    of(transfer.opacity_points().points()).chain(of(transfer.color_points().points()))
}
