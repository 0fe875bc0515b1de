//! How much values change in a `unit`, which opacities may depend on (model §6).

use crate::order::Ordered;
use slabsplat_core::Volume;
use slabsplat_core::glam::{DMat3, DVec3};

/// The lengths of gradients, voxel by voxel, per `unit`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GradientLengths<'a, T> {
    samples: &'a [T],
    dims: [usize; 3],
    /// From differences of samples to the gradient of values, per `unit`.
    gradient_from_differences: DMat3,
}

impl<'a, T: Ordered> GradientLengths<'a, T> {
    /// `samples` are those of `volume`.
    pub(crate) fn new(volume: &Volume, samples: &'a [T]) -> Self {
        let grid = volume.grid();
        let per_unit = volume.scaling().slope * grid.unit();
        let gradient_from_differences = grid.index_from_world().matrix3.transpose() * per_unit;
        Self { samples, dims: grid.dims(), gradient_from_differences }
    }

    /// At least 0, and never NaN.
    #[inline]
    pub(crate) fn at(&self, coords: [usize; 3]) -> f64 {
        let [n_x, n_y, _] = self.dims;
        let voxel_idx = (coords[2] * n_y + coords[1]) * n_x + coords[0];
        let strides = [1, n_x, n_x * n_y];
        let along = |axis: usize| {
            let has = [0 < coords[axis], coords[axis] + 1 < self.dims[axis]];
            self.difference(voxel_idx, strides[axis], has)
        };
        let gradient = self.gradient_from_differences * DVec3::new(along(0), along(1), along(2));
        let length = gradient.length();
        if length.is_nan() { f64::INFINITY } else { length }
    }

    /// Of the samples beside a voxel; NaN beside infinities, too.
    #[inline]
    fn difference(
        &self,
        voxel_idx: usize,
        stride: usize,
        [has_before, has_after]: [bool; 2],
    ) -> f64 {
        let sample = |idx: usize, is_there: bool| {
            if is_there { self.samples[idx].to_f64() } else { f64::NAN }
        };
        let here = sample(voxel_idx, true);
        let before = sample(voxel_idx.wrapping_sub(stride), has_before);
        let after = sample(voxel_idx + stride, has_after);
        match (before.is_nan(), after.is_nan()) {
            (false, false) => 0.5 * (after - before),
            (true, false) => after - here,
            (false, true) => here - before,
            (true, true) => 0.0,
        }
    }
}
