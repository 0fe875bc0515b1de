//! What decides which voxels are relevant and in which colour, as the shaders read it.

use crate::number::{Numbers, split};
use crate::params::{VolumeParams, flag};
use slabsplat_backend::FramePlan;
use slabsplat_core::glam::DMat3;
use slabsplat_core::{Compositing, IsoRange, PiecewiseLinear, Volume};

/// One element of the shaders' `transfer`.
pub(crate) type Element = [u32; 4];

/// Everything that the list of relevant voxels depends on but for the samples.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Classification {
    pub(crate) params: VolumeParams,
    /// Iso-ranges, points of opacity, points of colour.
    pub(crate) transfer: Vec<Element>,
    /// The iso-ranges as keys, to count voxels by.
    pub(crate) key_ranges: Vec<[u64; 2]>,
}

impl Classification {
    pub(crate) fn new(plan: &FramePlan<'_>, numbers: Numbers) -> Self {
        let opacities = plan.transfer.opacity_points().points().iter().map(|point| point.0);
        let colors = plan.transfer.color_points().points().iter().map(|point| point.0);
        let numbers = &numbers.scaled_for(opacities.chain(colors));
        let key_ranges = key_ranges(&plan.relevant, numbers);
        let mut transfer: Vec<Element> = key_ranges
            .iter()
            .map(|&[first, last]| {
                let ([a, b], [c, d]) = (numbers.words(first), numbers.words(last));
                [a, b, c, d]
            })
            .collect();
        let opacities = points(plan.transfer.opacity_points(), numbers);
        transfer.extend(opacities.iter().map(|&(position, [opacity])| {
            let [high, low] = split(position);
            [high, low, opacity as f32, (1.0 - opacity) as f32].map(f32::to_bits)
        }));
        let colors = points(plan.transfer.color_points(), numbers);
        transfer.extend(colors.iter().flat_map(|&(position, [r, g, b])| {
            let [high, low] = split(position);
            [[high, low, 0.0, 0.0], [r as f32, g as f32, b as f32, 0.0]]
                .map(|e| e.map(f32::to_bits))
        }));
        let [gradient_x, gradient_y, gradient_z] = gradient_rows(plan.volume);
        let params = VolumeParams {
            gradient_x,
            gradient_y,
            gradient_z,
            dims: plan.volume.grid().dims().map(|n| n as u32),
            sample_type: numbers.type_code(),
            number_scale: 2_f64.powi(-numbers.exponent()) as f32,
            n_ranges: key_ranges.len() as u32,
            n_opacities: opacities.len() as u32,
            n_colors: colors.len() as u32,
            is_falling: flag(numbers.is_falling()),
            compositing: compositing_code(plan.compositing),
            exponent: numbers.exponent(),
            padding: 0,
        };
        Self { params, transfer, key_ranges }
    }
}

/// The number by which the shaders know the compositing.
pub(crate) fn compositing_code(compositing: Compositing) -> u32 {
    match compositing {
        Compositing::Separate => 0,
        Compositing::Associated => 1,
        Compositing::Extinction => 2,
    }
}

/// The iso-ranges as ranges of keys, rising.
fn key_ranges(ranges: &[IsoRange], numbers: &Numbers) -> Vec<[u64; 2]> {
    let mut ranges: Vec<_> = ranges.iter().filter_map(|&range| numbers.key_range(range)).collect();
    if numbers.is_falling() {
        ranges.reverse();
    }
    ranges
}

/// The points of a function by their positions among the samples, rising.
fn points<const N: usize>(
    function: &PiecewiseLinear<N>,
    numbers: &Numbers,
) -> Vec<(f64, [f64; N])> {
    let mut points: Vec<_> =
        function.points().iter().map(|&(value, y)| (numbers.position(value), y)).collect();
    if numbers.is_falling() {
        points.reverse();
    }
    points
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
