//! Gradients and normals by the definition (model §6), a voxel at a time in 64 bits: what `gradient` and
//! `membership` are tested against.

use slabsplat_core::glam::DVec3;
use slabsplat_core::{Sample, Volume, with_samples};

/// `∇v` in world space.
pub(crate) fn naive_gradient(volume: &Volume, voxel_idx: usize) -> DVec3 {
    let coords = volume.grid().voxel_coords(voxel_idx);
    let in_index = DVec3::from([0, 1, 2].map(|axis| difference(volume, coords, axis)));
    volume.grid().index_from_world().matrix3.transpose() * in_index
}

/// `−∇v/|∇v|` in world space, or zero.
pub(crate) fn naive_normal(volume: &Volume, voxel_idx: usize) -> DVec3 {
    let in_world = naive_gradient(volume, voxel_idx);
    // Scaled before the length is taken: squares of tiny differences would underflow.
    let largest = in_world.abs().max_element();
    let normal = -(in_world / largest).normalize_or_zero();
    if normal.is_finite() { normal } else { DVec3::ZERO }
}

fn difference(volume: &Volume, coords: [usize; 3], axis: usize) -> f64 {
    let value_at = |step: isize| {
        let mut coords = coords;
        let moved = coords[axis].checked_add_signed(step);
        coords[axis] = moved.filter(|&c| c < volume.grid().dims()[axis])?;
        let voxel_idx = volume.grid().voxel_idx(coords);
        // Without the intercept, in which a faint difference could drown.
        let value = with_samples!(volume.samples(), |s| s[voxel_idx].to_f64());
        Some(volume.scaling().slope * value).filter(|value| !value.is_nan())
    };
    match (value_at(-1), value_at(0), value_at(1)) {
        (Some(before), _, Some(after)) => 0.5 * (after - before),
        (None, Some(here), Some(after)) => after - here,
        (Some(before), Some(here), None) => here - before,
        _ => 0.0,
    }
}
