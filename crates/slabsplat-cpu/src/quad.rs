//! Four pixels side by side: the unit in which tiles are stored, splatted and composited.

use fearless_simd::{Simd, f32x16, prelude::*};

/// Pixels in a [`Quad`].
pub(crate) const QUAD: usize = 4;

/// Red, green, blue and opacity (or what a sheet sums) of four pixels, pixel by pixel. It fills a cache line
/// and the widest register, and is only ever loaded and stored as a whole, at one place: a load that
/// overlapped two earlier stores would have to wait for both.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(64))]
pub(crate) struct Quad(pub(crate) [f32; 4 * QUAD]);

impl Quad {
    pub(crate) const ZERO: Self = Self([0.0; 4 * QUAD]);

    /// One pixel.
    #[inline(always)]
    pub(crate) fn pixel(&self, idx: usize) -> [f32; 4] {
        std::array::from_fn(|channel| self.0[4 * idx + channel])
    }

    /// The last channel of one pixel.
    #[inline(always)]
    pub(crate) fn opacity(&self, idx: usize) -> f32 {
        self.0[4 * idx + 3]
    }

    /// Adds to every pixel `addend`'s, multiplied with the pixel's weight.
    #[inline(always)]
    pub(crate) fn add_weighted<S: Simd>(
        &mut self,
        simd: S,
        [a, b, c, d]: [f32; QUAD],
        addend: f32x16<S>,
    ) {
        let weights: f32x16<S> = [a, a, a, a, b, b, b, b, c, c, c, c, d, d, d, d].simd_into(simd);
        let sum = weights.mul_add(addend, f32x16::from_slice(simd, &self.0));
        sum.store_slice(&mut self.0);
    }
}
