//! What decides which voxels are relevant and in which colour, as the shaders read it.

use crate::known_volume::KnownVolume;
use crate::number::Numbers;
use crate::params::VolumeParams;
use crate::segments::{Segment, color_elements, opacity_elements, segments, segments_between};
use slabsplat_backend::densities::ValueScale;
use slabsplat_backend::{FramePlan, LayerPlan, ShownDensities, Splats};
use slabsplat_core::glam::DMat3;
use slabsplat_core::{Compositing, IsoRange, Volume};

/// One element of the shaders' `transfer`.
pub(crate) type Element = [u32; 4];

/// Everything that the list of relevant voxels depends on but for the samples.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Classification {
    pub(crate) params: VolumeParams,
    /// Iso-ranges, segments of opacity, segments of colour; for densities, segments of what sheets sum.
    pub(crate) transfer: Vec<Element>,
    /// The iso-ranges as keys, to count voxels by.
    pub(crate) key_ranges: Vec<[u64; 2]>,
}

/// Which voxels are listed, and what is recorded of them.
struct Rules {
    key_ranges: Vec<[u64; 2]>,
    opacities: Vec<Segment<1>>,
    colors: Vec<Segment<3>>,
    /// What a sheet sums, as a number.
    sums: u32,
}

impl Classification {
    pub(crate) fn new(plan: &FramePlan<'_>, layer: &LayerPlan<'_>, known: &KnownVolume) -> Self {
        let numbers = &known.numbers;
        let rules = match &layer.splats {
            Splats::Colors(_) => Rules::of_colors(plan, layer, numbers),
            Splats::Densities(splats) => Rules::of_densities(layer, splats.shown, known),
        };
        let Rules { key_ranges, opacities, colors, sums } = rules;
        let mut transfer: Vec<Element> = key_ranges
            .iter()
            .map(|&[first, last]| {
                let ([a, b], [c, d]) = (numbers.words(first), numbers.words(last));
                [a, b, c, d]
            })
            .collect();
        transfer.extend(opacities.iter().flat_map(|segment| opacity_elements(segment, numbers)));
        transfer.extend(colors.iter().flat_map(|segment| color_elements(segment, numbers)));
        let [gradient_x, gradient_y, gradient_z] = gradient_rows(layer.volume);
        let params = VolumeParams {
            gradient_x,
            gradient_y,
            gradient_z,
            dims: layer.volume.grid().dims().map(|n| n as u32),
            sample_type: numbers.type_code(),
            n_ranges: key_ranges.len() as u32,
            n_opacities: opacities.len() as u32,
            n_colors: colors.len() as u32,
            compositing: sums,
        };
        Self { params, transfer, key_ranges }
    }
}

impl Rules {
    fn of_colors(plan: &FramePlan<'_>, layer: &LayerPlan<'_>, numbers: &Numbers) -> Self {
        Self {
            key_ranges: key_ranges(&layer.relevant, numbers),
            opacities: segments(layer.transfer.opacity_points(), numbers),
            colors: segments(layer.transfer.color_points(), numbers),
            sums: compositing_code(plan.compositing),
        }
    }

    /// All voxels count that have a value, if any density is shown; what sheets sum stands for opacity.
    fn of_densities(layer: &LayerPlan<'_>, shown: ShownDensities, known: &KnownVolume) -> Self {
        let scale = ValueScale::of(layer, shown, known.finite_range());
        let numbers = &known.numbers;
        Self {
            key_ranges: if layer.relevant.is_empty() { Vec::new() } else { vec![numbers.keys()] },
            opacities: value_segments(&scale, numbers),
            colors: Vec::new(),
            sums: SUMS_DENSITIES,
        }
    }
}

/// The number by which the shaders know the compositing: its index among all of them.
pub(crate) fn compositing_code(compositing: Compositing) -> u32 {
    compositing as u32
}

/// What shaders know instead where sheets sum densities.
pub(crate) const SUMS_DENSITIES: u32 = Compositing::ALL.len() as u32;

/// What sheets sum, by segments: these are halved towards the middle of the scale, where digits matter most,
/// so that each value is as exact as a float of its size.
fn value_segments(scale: &ValueScale, numbers: &Numbers) -> Vec<Segment<1>> {
    let [least, largest] = scale.values();
    let halves = (0..N_HALVED).map(|n| scale.value(-(0.5_f64.powi(n))));
    let within = halves.chain([scale.value(0.0)]).filter(|&value| least < value && value < largest);
    let summed = |value: f64| [scale.unclamped(value.clamp(least, largest))];
    segments_between(within.chain([least, largest]), summed, numbers)
}

/// Digits that a value keeps below the middle of the scale.
const N_HALVED: i32 = 24;

/// The iso-ranges as ranges of keys, rising.
fn key_ranges(ranges: &[IsoRange], numbers: &Numbers) -> Vec<[u64; 2]> {
    let mut ranges: Vec<_> = ranges.iter().filter_map(|&range| numbers.key_range(range)).collect();
    if numbers.is_falling() {
        ranges.reverse();
    }
    ranges
}

/// The rows of `A⁻ᵀ`, which takes gradients to world space; scaled, as only directions count, and turned
/// around where values fall with samples.
fn gradient_rows(volume: &Volume) -> [[f32; 4]; 3] {
    let grid = volume.grid();
    let sign = volume.scaling().slope.signum();
    let columns: DMat3 = grid.index_from_world().matrix3 * (sign * grid.unit());
    // The rows of a transposed matrix are its columns.
    [columns.x_axis, columns.y_axis, columns.z_axis].map(|row| row.extend(0.0).as_vec4().to_array())
}
