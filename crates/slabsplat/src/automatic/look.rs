//! What a volume of each kind looks like: opacity, colours, and what is behind it.
//!
//! All tables are of a position on the volume's own scale and what is there, so that a reader sees what comes
//! out.

#[cfg(feature = "files")]
use slabsplat_core::SampleType;
use slabsplat_core::{Acquisition, Grid, PiecewiseLinear, TransferFunction, Volume};
#[cfg(feature = "files")]
use slabsplat_io::OpacitySource;

use super::histogram::{Histogram, NOISE};
use super::kind::DataKind;
use super::statistics::Statistics;
use super::{hounsfield, label_colors};

/// Points of a piecewise-linear function of values.
pub(super) type Points<const N: usize> = Vec<(f64, [f64; N])>;

/// How a volume is shown.
#[derive(Clone, Debug)]
pub(crate) struct Look {
    pub(crate) kind: DataKind,
    pub(crate) transfer: TransferFunction,
    /// What opacity is multiplied with, by the gradient.
    pub(crate) gradient_opacity: Option<PiecewiseLinear<1>>,
    /// Behind it all, opaque.
    pub(crate) background: [f32; 4],
    /// What is shown, for people: `object above 57 of 0 to 255`.
    pub(crate) what: String,
}

/// Opacity and colours, before they are checked.
pub(super) struct Curves {
    pub(super) opacity: Points<1>,
    pub(super) color: Points<3>,
    pub(super) gradient_opacity: Option<Points<1>>,
    pub(super) what: String,
}

/// Before a dark grey, light things stand out, and their shadows are still to be told from it.
pub(crate) const DARK: [f32; 4] = [0.075, 0.082, 0.098, 1.0];

/// What glows is seen in the dark.
const BLACK: [f32; 4] = [0.0, 0.0, 0.0, 1.0];

/// Opacities per unit at the top of a ramp and at the largest value.
const RAMP_OPACITY: [f64; 2] = [0.7, 0.95];

/// From border to densest: light enough that shading has room below. Bone and other things that are warm.
const IVORY: [[f64; 3]; 3] = [[0.80, 0.60, 0.45], [0.93, 0.82, 0.68], [1.0, 0.97, 0.91]];

/// Grey matter.
const PARCHMENT: [[f64; 3]; 3] = [[0.74, 0.66, 0.62], [0.90, 0.86, 0.82], [1.0, 1.0, 0.98]];

/// What has colours of its own.
const WHITE: [[f64; 3]; 3] = [[1.0; 3]; 3];

/// What is stained with a green dye.
const GREEN: [[f64; 3]; 3] = [[0.05, 0.55, 0.38], [0.32, 0.92, 0.55], [0.92, 1.0, 0.80]];

/// Even steps of what the eye takes for even steps: ten colours of viridis (S. van der Walt, N. Smith,
/// matplotlib 2015, CC0).
const PERCEPTUAL: [[f64; 3]; 10] = [
    [0.267, 0.004, 0.329],
    [0.282, 0.157, 0.471],
    [0.243, 0.290, 0.537],
    [0.192, 0.408, 0.557],
    [0.149, 0.510, 0.557],
    [0.122, 0.620, 0.537],
    [0.208, 0.718, 0.475],
    [0.427, 0.804, 0.349],
    [0.706, 0.871, 0.173],
    [0.992, 0.906, 0.145],
];

impl Look {
    /// Of a volume on that grid, of which `rows` are enough, the [rows that are looked at](LookedAt).
    pub(crate) fn of(rows: &Volume, grid: &Grid, acquisition: Acquisition) -> Self {
        let statistics = Statistics::of(rows);
        let kind = DataKind::of(grid, &statistics, acquisition);
        Self::of_kind(kind, &statistics)
    }

    fn of_kind(kind: DataKind, statistics: &Statistics) -> Self {
        let curves = match (&statistics.histogram, kind) {
            (None, _) | (_, DataKind::Flat) => Curves::flat(),
            (Some(_), DataKind::Labels) => {
                label_colors::curves(statistics.distinct.as_deref().unwrap_or_default())
            }
            (Some(histogram), DataKind::Hounsfield { water }) => {
                hounsfield::curves(histogram, water)
            }
            (Some(histogram), DataKind::Mr) => Curves::ramp(histogram, PARCHMENT),
            (Some(histogram), DataKind::Microscopy) => Curves::glow(histogram, GREEN),
            (Some(histogram), DataKind::Colors) => Curves::ramp(histogram, WHITE),
            (Some(histogram), DataKind::Scan) => Curves::ramp(histogram, IVORY),
            (Some(histogram), DataKind::Field) => Curves::layers(histogram),
        };
        let background = match kind {
            DataKind::Microscopy => BLACK,
            _ => DARK,
        };
        curves.into_look(kind, background)
    }

    /// Of a volume whose voxels have colours of their own, of which it holds what opacity is made of.
    #[cfg(feature = "files")]
    pub(crate) fn of_colors(rows: &Volume, opacity_from: OpacitySource) -> Self {
        match opacity_from {
            OpacitySource::Alpha => {
                Curves::alpha(rows.sample_type()).into_look(DataKind::Colors, DARK)
            }
            // How light it is, and any other scalar that has no meaning of its own.
            _ => Self::of_kind(DataKind::Colors, &Statistics::of(rows)),
        }
    }
}

impl Curves {
    /// Without two values that can be told apart, all is visible.
    fn flat() -> Self {
        Self {
            opacity: vec![(0.0, [RAMP_OPACITY[0]])],
            color: vec![(0.0, IVORY[2])],
            gradient_opacity: None,
            what: "all of it".to_owned(),
        }
    }

    /// Alpha is the opacity of a voxel step.
    #[cfg(feature = "files")]
    fn alpha(sample_type: SampleType) -> Self {
        let most = match sample_type {
            SampleType::U16 => f64::from(u16::MAX),
            _ => f64::from(u8::MAX),
        };
        Self {
            opacity: vec![(0.0, [0.0]), (most, [1.0])],
            color: vec![(0.0, [1.0; 3])],
            gradient_opacity: None,
            what: "as opaque as their alpha".to_owned(),
        }
    }

    /// Opaque from the border between background and object on. The ramp begins where Otsu's threshold parts
    /// them, beyond the background's noise, and reaches its height at the object's mean.
    fn ramp(histogram: &Histogram, colors: [[f64; 3]; 3]) -> Self {
        let background = histogram.background();
        let first = background.last + 1;
        let scale = &histogram.scale;
        let foot = scale.start(first);
        let top = scale.start(scale.n());
        // A flat object has its mean at the threshold: keep the three points apart.
        let mean = histogram.mean_from(first);
        let shoulder = mean.clamp(foot + 0.02 * (top - foot), foot + 0.9 * (top - foot));
        let start =
            (foot - 0.2 * (shoulder - foot)).max(background.value + NOISE * background.noise);
        let start = start.min(foot + 0.5 * (shoulder - foot));
        let least = scale.middle(0);
        let what =
            format!("visible from {} on, of {} to {}", short(start), short(least), short(top));
        Self {
            opacity: vec![(start, [0.0]), (shoulder, [RAMP_OPACITY[0]]), (top, [RAMP_OPACITY[1]])],
            color: vec![(start, colors[0]), (shoulder, colors[1]), (top, colors[2])],
            gradient_opacity: None,
            what,
        }
    }

    /// Whatever is above the background and its noise is visible: what is stained may be thin and faint.
    fn glow(histogram: &Histogram, colors: [[f64; 3]; 3]) -> Self {
        let background = histogram.background();
        let scale = &histogram.scale;
        let above_noise = background.value + 4.0 * background.noise;
        let first = scale.level_of(above_noise).unwrap_or(0) + 1;
        let at = |share: f64| histogram.quantile_from(first, share);
        let half = 0.5 * scale.width();
        let middle = at(0.5);
        // Of a few values they may be the same.
        let (start, top) = (at(0.04).min(middle - half), at(0.98).max(middle + half));
        let what = format!("visible from {} on, brightest at {}", short(start), short(top));
        Self {
            opacity: vec![(start, [0.0]), (middle, [RAMP_OPACITY[0]]), (top, [RAMP_OPACITY[1]])],
            color: vec![(start, colors[0]), (middle, colors[1]), (top, colors[2])],
            gradient_opacity: None,
            what,
        }
    }

    /// A field is seen through: the larger, the more opaque.
    fn layers(histogram: &Histogram) -> Self {
        let scale = &histogram.scale;
        let first = histogram.most_frequent(0..scale.n() / 2) + 1;
        let lo = scale.start(first);
        let hi = histogram.quantile_from(first, 0.995).max(lo + scale.width());
        let at = |part: f64| lo + part * (hi - lo);
        let n = PERCEPTUAL.len() as f64 - 1.0;
        let color =
            PERCEPTUAL.iter().enumerate().map(|(idx, c)| (at(idx as f64 / n), *c)).collect();
        let opacity = [(0.0, 0.0), (0.12, 0.01), (0.4, 0.06), (0.7, 0.25), (1.0, 0.8)];
        let opacity = opacity.map(|(part, opacity)| (at(part), [opacity])).to_vec();
        let what = format!("colours from {} to {}", short(lo), short(hi));
        Self { opacity, color, gradient_opacity: None, what }
    }

    fn into_look(self, kind: DataKind, background: [f32; 4]) -> Look {
        let Self { opacity, color, gradient_opacity, what } = self;
        let transfer = TransferFunction::new(opacity, color);
        // Values may be so close that no number lies between them.
        let flat = || Self::flat();
        let transfer = transfer.unwrap_or_else(|_| {
            let Self { opacity, color, .. } = flat();
            TransferFunction::new(opacity, color).expect("one point is enough")
        });
        let gradient_opacity = gradient_opacity
            .and_then(|points| PiecewiseLinear::new("gradient opacity", points).ok());
        Look { kind, transfer, gradient_opacity, background, what }
    }
}

/// A value for people, with three digits or so.
pub(super) fn short(value: f64) -> String {
    match value.abs() {
        magnitude if magnitude == 0.0 || (0.01..1e6).contains(&magnitude) => {
            let decimals = (2.0 - magnitude.max(0.01).log10().floor()).clamp(0.0, 4.0);
            let text = format!("{value:.*}", decimals as usize);
            let is_fraction = text.contains('.');
            let text =
                if is_fraction { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
            text.to_owned()
        }
        _ => format!("{value:.2e}"),
    }
}
