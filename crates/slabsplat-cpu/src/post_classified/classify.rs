//! From the density at a pixel to what it adds to the picture: opacity, colour, light.

use super::values::ValueScale;
use slabsplat_backend::FramePlan;
use slabsplat_core::glam::DVec3;
use slabsplat_core::{Compositing, IsoRange, Phong, Shading, TransferFunction, extinction};

/// Classifies and shades densities.
pub(super) struct Classifier<'a> {
    transfer: &'a TransferFunction,
    scale: ValueScale,
    compositing: Compositing,
    lamp: Option<Lamp>,
    /// Where anything is drawn, scaled: from the first end up to the second.
    drawn: Vec<[f64; 2]>,
    /// Where the transfer function has a step: value, and scaled.
    steps: Vec<(f64, f64)>,
}

/// Sums of 32-bit floats miss a density by less than this, scaled. A step of the transfer function that lies on the value
/// of a plateau must not be taken here and missed there, so that a density this far before a step counts as on it.
const ROUNDING: f64 = 1.0 / (1 << 19) as f64;

impl<'a> Classifier<'a> {
    pub(super) fn new(plan: &FramePlan<'a>, scale: ValueScale) -> Self {
        let drawn = |range: &IsoRange| {
            let [lo, hi] = [range.lo, range.hi].map(|end| scale.unclamped(end));
            let is_step = starts_with_a_step(plan.transfer, range);
            [if is_step { lo - ROUNDING } else { lo + ROUNDING }, hi - ROUNDING]
        };
        let lamp = match plan.shading {
            Shading::None => None,
            Shading::Phong(phong) => Some(Lamp::new(phong, plan)),
        };
        Self {
            transfer: plan.transfer,
            scale,
            compositing: plan.compositing,
            lamp,
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

    /// Whether light matters, and with it the gradient.
    pub(super) fn is_lit(&self) -> bool {
        self.lamp.is_some()
    }

    /// Premultiplied colour and opacity of `length` `unit`s of one density, whose surface faces along `normal`, in view
    /// space and not longer than 1.
    #[inline]
    pub(super) fn premultiplied(
        &self,
        length: f64,
        (opacity, value): (f64, f64),
        normal: DVec3,
    ) -> [f32; 4] {
        let base = DVec3::from_array(self.transfer.color(value));
        let color = self.lamp.as_ref().map_or(base, |lamp| lamp.light_up(base, normal));
        let opacity = match self.compositing {
            Compositing::Separate => {
                let opacity = (length * opacity).min(1.0);
                let color = (length * color).min(DVec3::ONE);
                return (opacity * color).extend(opacity).as_vec4().to_array();
            }
            Compositing::Associated => (length * opacity).min(1.0),
            Compositing::Extinction => -(-length * extinction(opacity)).exp_m1(),
        };
        (opacity * color).extend(opacity).as_vec4().to_array()
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

/// A light and a viewer, both infinitely far away, in view space.
#[derive(Clone, Copy, Debug)]
struct Lamp {
    phong: Phong,
    to_light: DVec3,
    /// `h = (l + v)/|l + v|`; zero if the light shines straight at the viewer.
    halfway: DVec3,
}

impl Lamp {
    fn new(phong: Phong, plan: &FramePlan<'_>) -> Self {
        let axes = plan.view.axes();
        let in_view = |v: DVec3| DVec3::new(v.dot(axes.right), v.dot(axes.up), v.dot(axes.forward));
        Self {
            phong,
            to_light: in_view(phong.light.to_light(axes.forward)),
            halfway: in_view(phong.light.halfway(axes.forward)),
        }
    }

    /// `c·(k_a + k_d·n·l) + k_s·(n·h)^s`, clamped.
    #[inline]
    fn light_up(&self, color: DVec3, normal: DVec3) -> DVec3 {
        let Phong { ambient, diffuse, specular, shininess, two_sided, .. } = self.phong;
        let facing = |direction: DVec3| {
            let product = normal.dot(direction);
            if two_sided { product.abs() } else { product.max(0.0) }
        };
        let n_l = facing(self.to_light);
        let highlight =
            if 0.0 < n_l { specular * facing(self.halfway).powf(shininess) } else { 0.0 };
        (color * (ambient + diffuse * n_l) + highlight).clamp(DVec3::ZERO, DVec3::ONE)
    }
}
