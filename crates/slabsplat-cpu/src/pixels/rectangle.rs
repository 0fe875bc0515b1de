//! A rectangle of pixels within a tile.

use fearless_simd::{Simd, f32x8, prelude::*, u32x8};

/// Pixels along the side of a tile. The sums of 32² pixels fill half of a first-level cache; smaller tiles
/// would share too many footprints.
pub(crate) const TILE_SIDE: usize = 32;

/// By how many pixels boxes are wider than footprints: what lies right on an edge is left to the weights, or
/// it would count on one side and not on the other.
pub(crate) const MARGIN: f32 = 1.0 / 1024.0;

/// A rectangle of pixels in a tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PixelBox {
    /// First column and row.
    pub(crate) min: [u8; 2],
    /// The column and row behind the last.
    pub(crate) end: [u8; 2],
}

impl PixelBox {
    /// The pixels of a tile that have their centres within `half` of `center`; `None` if there are none.
    #[inline(always)]
    pub(crate) fn within_tile<S: Simd>(simd: S, center: [f32; 2], half: [f32; 2]) -> Option<Self> {
        let [x, y] = center;
        let [w, h] = half.map(|half| half + MARGIN);
        let ends = pixel(simd, [x - w, y - h, x + w, y + h, 0.0, 0.0, 0.0, 0.0].simd_into(simd));
        let [left, top, right, bottom, ..] = <[u32; 8]>::from(ends).map(|end| end as u8);
        (left < right && top < bottom).then_some(Self { min: [left, top], end: [right, bottom] })
    }
}

/// The pixel of a tile whose centre is the first behind each coordinate. NaN gives 0.
///
/// Adding 2²³ rounds to whole numbers and leaves them in the low bits.
#[inline(always)]
pub(crate) fn pixel<S: Simd>(simd: S, at: f32x8<S>) -> u32x8<S> {
    column(simd, at, TILE_SIDE)
}

/// The same among `n_columns`, 256 at most.
#[inline(always)]
pub(crate) fn column<S: Simd>(simd: S, at: f32x8<S>, n_columns: usize) -> u32x8<S> {
    let inside = at.max(f32x8::splat(simd, 0.0)).min(f32x8::splat(simd, n_columns as f32));
    let rounded: u32x8<S> = (inside + f32x8::splat(simd, 8_388_608.0)).bitcast();
    rounded & u32x8::splat(simd, 0xff)
}
