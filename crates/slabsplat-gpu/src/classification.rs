//! What decides which voxels are relevant and in which colour, as the shaders read it.

use crate::number::Numbers;
use crate::params::VolumeParams;
use crate::segments::{color_elements, opacity_elements, segments};
use slabsplat_backend::{FramePlan, LayerPlan};
use slabsplat_core::glam::DMat3;
use slabsplat_core::{Compositing, IsoRange, Volume};

/// One element of the shaders' `transfer`.
pub(crate) type Element = [u32; 4];

/// Everything that the list of relevant voxels depends on but for the samples.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Classification {
    pub(crate) params: VolumeParams,
    /// Iso-ranges, segments of opacity, segments of colour.
    pub(crate) transfer: Vec<Element>,
    /// The iso-ranges as keys, to count voxels by.
    pub(crate) key_ranges: Vec<[u64; 2]>,
}

impl Classification {
    pub(crate) fn new(plan: &FramePlan<'_>, layer: &LayerPlan<'_>, numbers: &Numbers) -> Self {
        let key_ranges = key_ranges(&layer.relevant, numbers);
        let mut transfer: Vec<Element> = key_ranges
            .iter()
            .map(|&[first, last]| {
                let ([a, b], [c, d]) = (numbers.words(first), numbers.words(last));
                [a, b, c, d]
            })
            .collect();
        let opacities = segments(layer.transfer.opacity_points(), numbers);
        transfer.extend(opacities.iter().flat_map(|segment| opacity_elements(segment, numbers)));
        let colors = segments(layer.transfer.color_points(), numbers);
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
            compositing: compositing_code(plan.compositing),
        };
        Self { params, transfer, key_ranges }
    }
}

/// The number by which the shaders know the compositing: its place among all of them.
pub(crate) fn compositing_code(compositing: Compositing) -> u32 {
    compositing as u32
}

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
