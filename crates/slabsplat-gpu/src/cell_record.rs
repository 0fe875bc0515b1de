//! A cell as the shaders read it: `shaders/shared/cell_record.wgsl`.

use crate::params::CellRecord;
use slabsplat_traverse::{CellValues, Moments};

/// 0 … 1, and −1 … 1, in 16 bits.
const UNORM_STEPS: f32 = 65535.0;
const SNORM_STEPS: f32 = 32767.0;

impl CellRecord {
    /// That of a cell with this index, and with second moments of its normals, if they are known.
    pub(crate) fn new(cell_idx: usize, cell: &CellValues, moments: Option<Moments>) -> Self {
        let CellValues { extinction, color: [r, g, b], normal: [x, y, z], undirected } = *cell;
        let bits = moments.map_or(0, Moments::to_bits);
        let is_known = if moments.is_some() { 1.0 } else { 0.0 };
        Self {
            // A grid has fewer cells than 2³².
            cell_idx: cell_idx as u32,
            extinction,
            color: [unorms([r, g]), unorms([b, undirected])],
            normal: [snorms([x, y]), snorms([z, is_known])],
            moments: [bits as u32, (bits >> 32) as u32],
        }
    }
}

fn unorms(pair: [f32; 2]) -> u32 {
    let [low, high] = pair.map(|number| (number.clamp(0.0, 1.0) * UNORM_STEPS).round() as u32);
    high << 16 | low
}

fn snorms(pair: [f32; 2]) -> u32 {
    let steps = |number: f32| (number.clamp(-1.0, 1.0) * SNORM_STEPS).round() as i16;
    let [low, high] = pair.map(|number| u32::from(steps(number) as u16));
    high << 16 | low
}
