//! Four pixels side by side: the unit in which tiles are stored, splatted and composited.

use fearless_simd::{Simd, f32x16, prelude::*};

/// Pixels in a [`Quad`].
pub(crate) const QUAD: usize = 4;

/// Red, green, blue and opacity (or what a sheet sums) of four pixels, channel by channel: so four weights
/// are laid on all channels as they are, in registers of whatever width. It fills a cache line and the widest
/// register, and is only ever loaded and stored as a whole, at one place: a load that overlapped two earlier
/// stores would have to wait for both.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(64))]
pub(crate) struct Quad(pub(crate) [f32; 4 * QUAD]);

impl Quad {
    pub(crate) const ZERO: Self = Self([0.0; 4 * QUAD]);

    /// Four pixels of one colour.
    #[inline(always)]
    pub(crate) const fn of([r, g, b, a]: [f32; 4]) -> Self {
        Self([r, r, r, r, g, g, g, g, b, b, b, b, a, a, a, a])
    }

    /// One pixel.
    #[inline(always)]
    pub(crate) fn pixel(&self, idx: usize) -> [f32; 4] {
        [self.0[idx], self.0[QUAD + idx], self.0[2 * QUAD + idx], self.0[3 * QUAD + idx]]
    }

    pub(crate) fn set_pixel(&mut self, idx: usize, [r, g, b, a]: [f32; 4]) {
        self.0[idx] = r;
        self.0[QUAD + idx] = g;
        self.0[2 * QUAD + idx] = b;
        self.0[3 * QUAD + idx] = a;
    }

    /// Its channels, of all four pixels each.
    #[inline(always)]
    pub(crate) fn channels(&self) -> &[[f32; QUAD]; 4] {
        self.0.as_chunks().0.first_chunk().expect("there are four channels")
    }

    /// The same to be changed.
    #[inline(always)]
    pub(crate) fn channels_mut(&mut self) -> &mut [[f32; QUAD]; 4] {
        self.0.as_chunks_mut().0.first_chunk_mut().expect("there are four channels")
    }

    /// The last channel.
    #[inline(always)]
    pub(crate) fn opacities(&self) -> [f32; QUAD] {
        let [.., a, b, c, d] = self.0;
        [a, b, c, d]
    }

    /// Adds to every pixel `addend`'s, multiplied with the pixel's weight.
    #[inline(always)]
    pub(crate) fn add_weighted<S: Simd>(
        &mut self,
        simd: S,
        weights: [f32; QUAD],
        addend: f32x16<S>,
    ) {
        let weights = f32x16::block_splat(weights.simd_into(simd));
        let sum = weights.mul_add(addend, f32x16::from_slice(simd, &self.0));
        sum.store_slice(&mut self.0);
    }
}
