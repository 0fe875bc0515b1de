//! What `every-sample` sorts by, in fixed point: `shaders/depth_key.wgsl`.

use crate::params::DepthParams;
use slabsplat_backend::LayerPlan;

/// Steps to which depths are rounded, per `unit`; the CPU's are the same.
const STEPS_PER_UNIT: f64 = (1 << 20) as f64;

/// Bits of a position in fixed point that are not the sign.
const MAX_BITS: i32 = 62;

/// How the list is sorted by depth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DepthSort {
    pub(crate) params: DepthParams,
    /// Bits of a rounded position, on each axis of the view.
    pub(crate) n_bits: u32,
}

impl DepthSort {
    pub(crate) fn new(layer: &LayerPlan<'_>) -> Self {
        let grid = layer.volume.grid();
        let from_index = layer.view.from_index(grid);
        let steps_per_world = STEPS_PER_UNIT / grid.unit();
        // Along each axis of the view, what half a voxel step adds.
        let half_steps =
            [0, 1, 2].map(|axis| from_index.matrix.row(axis) * (0.5 * steps_per_world));
        let half_dims = grid.center_in_index() * 2.0;
        let reach = half_steps.map(|m| m.abs().dot(half_dims)).into_iter().fold(1.0, f64::max);
        let n_bits = (reach + 1.0).log2().ceil() as i32 + 1;
        let fraction_bits = (MAX_BITS - n_bits).clamp(1, 24);
        let fixed = |number: f64| (number * 2_f64.powi(fraction_bits)).round() as i64 as u64;
        let mut params = DepthParams {
            dims: grid.dims().map(|n| n as u32),
            fraction_bits: fraction_bits as u32,
            ..DepthParams::default()
        };
        for (axis, row) in half_steps.iter().enumerate() {
            for (i, number) in row.to_array().into_iter().enumerate() {
                let [low, high] = words(fixed(number));
                (params.low[axis][i], params.high[axis][i]) = (low, high);
            }
        }
        params.bias = words(fixed(2_f64.powi(n_bits - 1) + 0.5));
        Self { params, n_bits: n_bits as u32 }
    }
}

fn words(number: u64) -> [u32; 2] {
    [number as u32, (number >> 32) as u32]
}
