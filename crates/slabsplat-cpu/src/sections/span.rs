//! Which slabs a voxel is drawn in (model §7), in the 32 bits that a voxel has for it.

use crate::voxels::voxel::Voxel;
use fearless_simd::{Simd, prelude::*, u32x8};

/// A voxel with the slabs in which it is drawn.
pub(crate) type SpannedVoxel = Voxel<Span>;

/// The first slab of a voxel, and how many more there are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Span(pub(crate) u32);

/// Bits for the number of slabs behind the first; the other 22 are enough for any slab's index.
const BITS: u32 = 10;

impl Span {
    /// That many slabs more, or a voxel that has all its sections: what slabs cut is then found by their
    /// faces.
    pub(crate) const ALL: u32 = (1 << BITS) - 1;

    /// Spans in their bits.
    #[inline(always)]
    pub(crate) fn bits<S: Simd>(first: u32x8<S>, n_more: u32x8<S>) -> u32x8<S> {
        first << BITS | n_more
    }

    /// First slabs, and numbers of slabs behind them, of spans in their bits.
    #[inline(always)]
    pub(crate) fn parts<S: Simd>(simd: S, spans: u32x8<S>) -> [u32x8<S>; 2] {
        [spans >> BITS, spans & u32x8::splat(simd, Self::ALL)]
    }

    /// The first slab.
    #[inline(always)]
    pub(crate) fn first(self) -> usize {
        (self.0 >> BITS) as usize
    }

    /// How many slabs there are behind it.
    #[inline(always)]
    pub(crate) fn n_more(self) -> u32 {
        self.0 & Self::ALL
    }
}
