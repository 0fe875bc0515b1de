//! The inner loop: one footprint's weights over the pixels of a tile.
//!
//! ```text
//! for every 8 columns that the footprint's box meets, from a multiple of 4 on:
//!     for every row of the box:
//!         8 weights at once, 0 outside of the footprint
//!         for every 4 of them that the box meets: sheet += weight·colour, 4 pixels at once
//! ```
//!
//! Nothing in it depends on a pixel's place but the weights, so that processors guess every branch within a
//! footprint. The rest, which footprint lies where, is prepared before for many of them (`section.rs`), or each
//! would have to wait for its own square root.

use crate::quad::QUAD;
use crate::raster::PixelShape;
use crate::sheet::Sheet;
use crate::weights::{LANES, Weigh};
use fearless_simd::{Simd, f32x16, prelude::*};

/// A rectangle of pixels in a tile.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct PixelBox {
    /// First column and row.
    pub(crate) min: [u8; 2],
    /// The column and row behind the last.
    pub(crate) end: [u8; 2],
}

/// A footprint that is about to be splatted.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Footprint {
    /// Its centre, in pixels from the tile's upper left corner.
    pub(crate) center: [f32; 2],
    /// The pixels that it may touch.
    pub(crate) pixels: PixelBox,
    /// What a sheet sums, at weight 1.
    pub(crate) color: [f32; 4],
}

/// Adds a footprint to a sheet.
#[inline(always)]
pub(crate) fn splat<S: Simd>(
    simd: S,
    sheet: &mut Sheet,
    shape: &PixelShape,
    footprint: &Footprint,
    weigh: &impl Weigh<S>,
) {
    let [r, g, b, a] = footprint.color;
    let color: f32x16<S> = [r, g, b, a, r, g, b, a, r, g, b, a, r, g, b, a].simd_into(simd);
    let [first_row, end_row] = [footprint.pixels.min[1], footprint.pixels.end[1]].map(usize::from);
    let [first_column, end_column] =
        [footprint.pixels.min[0], footprint.pixels.end[0]].map(usize::from);
    let mut quad = first_column / QUAD;
    let end_quad = end_column.div_ceil(QUAD);
    while quad < end_quad {
        let columns =
            weigh.columns(simd, shape, (quad * QUAD) as f32 - footprint.center[0]);
        let mut dy = first_row as f32 + 0.5 - footprint.center[1];
        let rows = sheet.rows_mut(first_row..end_row);
        if quad + 1 < end_quad {
            for row in rows {
                let [left, right] = quads_of(weigh.row(simd, shape, columns, dy));
                dy += 1.0;
                row[quad].add_weighted(simd, left, color);
                row[quad + 1].add_weighted(simd, right, color);
            }
        } else {
            for row in rows {
                let [left, _] = quads_of(weigh.row(simd, shape, columns, dy));
                dy += 1.0;
                row[quad].add_weighted(simd, left, color);
            }
        }
        quad += LANES / QUAD;
    }
}

#[inline(always)]
fn quads_of([a, b, c, d, e, f, g, h]: [f32; LANES]) -> [[f32; QUAD]; 2] {
    [[a, b, c, d], [e, f, g, h]]
}
