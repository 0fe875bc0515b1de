//! What a section needs before its pixels can be visited, for eight voxels at a time: where it lies, how far its disc
//! reaches, which rows of the table it blends.
//!
//! It takes a square root and a chain of other steps. Side by side they cost little, and the inner loop finds everything
//! ready.

use crate::by_sheet::{N_AT_ONCE, Run};
use crate::image_aligned::sections::SlabCut;
use crate::image_aligned::{Slabs, Span};
use crate::splat::PixelBox;
use crate::tile::{TILE_SIDE, Tile};
use fearless_simd::{Simd, f32x8, mask32x8, prelude::*, u32x8};
use slabsplat_core::Lookup;

/// What eight voxels have in a slab.
pub(crate) struct Eight {
    /// Which of them are drawn, a bit each.
    pub(crate) drawn: u64,
    /// Centres, in pixels from the tile's upper left corner.
    pub(crate) centers: [[f32; N_AT_ONCE]; 2],
    /// Columns and rows, from the first to behind the last: left, top, right, bottom.
    pub(crate) pixels: [[u32; N_AT_ONCE]; 4],
    pub(crate) faces: [[f32; N_AT_ONCE]; 2],
    pub(crate) is_folded: u64,
    pub(crate) edges: [f32; N_AT_ONCE],
    /// Where in their table they are, in rows.
    pub(crate) rows: [f32; N_AT_ONCE],
}

/// What voxels are like that are prepared together.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// They are drawn whole.
    Whole,
    /// Slabs cut them at one depth for all of a footprint.
    Upright,
    /// Their sections are read from the table, pixel by pixel.
    ByTable,
}

impl SlabCut<'_> {
    /// Prepares the voxels from `first` on.
    #[inline(always)]
    pub(crate) fn prepare<S: Simd>(
        &self,
        simd: S,
        kind: Kind,
        voxels: Run<'_>,
        first: usize,
        tile: &Tile,
    ) -> Eight {
        let slabs = self.slabs;
        let ([right, up, depth], spans) = voxels.at_once(simd, first);
        let n_left = (voxels.len - first).min(N_AT_ONCE);
        let mut drawn = u64::MAX >> (64 - n_left);
        let radius = slabs.raster.radius;
        let mut eight = Eight::EMPTY;
        let rho_max = if kind == Kind::Whole {
            f32x8::splat(simd, radius)
        } else {
            let (faces, is_folded, is_drawn) = self.faces_of(simd, depth, spans);
            drawn &= is_drawn.to_bitmask();
            let [front, back] = faces;
            // The disc in which a slab between two faces cuts a ball.
            let nearest = front.max(-back).max(f32x8::splat(simd, 0.0));
            let is_cut = nearest.simd_lt(f32x8::splat(simd, slabs.reach_in_index));
            drawn &= is_cut.to_bitmask();
            eight.is_folded = is_folded.to_bitmask();
            front.store_slice(&mut eight.faces[0]);
            back.store_slice(&mut eight.faces[1]);
            if slabs.raster.is_tilted {
                // Somewhere in the footprint it is cut in its middle.
                f32x8::splat(simd, radius)
            } else {
                let disc_squared = f32x8::splat(simd, radius * radius) - nearest * nearest;
                (disc_squared * f32x8::splat(simd, slabs.edge_per_disc) - f32x8::splat(simd, 1.0))
                    .store_slice(&mut eight.edges);
                slabs.rows_of(simd, front, back, is_folded).store_slice(&mut eight.rows);
                disc_squared.max(f32x8::splat(simd, 0.0)).sqrt()
            }
        };
        for (axis, center) in self.centers_of(simd, right, up, tile).into_iter().enumerate() {
            let half = rho_max * f32x8::splat(simd, self.shape.half_extent[axis])
                + f32x8::splat(simd, MARGIN);
            let (first, end) = (pixel(simd, center - half), pixel(simd, center + half));
            drawn &= first.simd_lt(end).to_bitmask();
            first.store_slice(&mut eight.pixels[axis]);
            end.store_slice(&mut eight.pixels[axis + 2]);
            center.store_slice(&mut eight.centers[axis]);
        }
        Eight { drawn, ..eight }
    }

    /// The centres of footprints, in pixels from the tile's upper left corner.
    #[inline(always)]
    pub(crate) fn centers_of<S: Simd>(
        &self,
        simd: S,
        right: f32x8<S>,
        up: f32x8<S>,
        tile: &Tile,
    ) -> [f32x8<S>; 2] {
        let origin = tile.origin.map(|pixel| pixel as f32);
        let [x, y] = self.slabs.raster.center();
        [
            right.mul_add(f32x8::splat(simd, self.shape.scale), f32x8::splat(simd, x - origin[0])),
            up.mul_add(f32x8::splat(simd, -self.shape.scale), f32x8::splat(simd, y - origin[1])),
        ]
    }

    /// Index units from voxels to the faces that cut them; whether others were spared; whether they are drawn in
    /// this slab.
    #[inline(always)]
    pub(crate) fn faces_of<S: Simd>(
        &self,
        simd: S,
        depth: f32x8<S>,
        spans: u32x8<S>,
    ) -> ([f32x8<S>; 2], mask32x8<S>, mask32x8<S>) {
        let index_per_depth = self.slabs.raster.index_per_depth;
        let [front, back] = self.faces;
        let front = (f32x8::splat(simd, front) - depth) * index_per_depth;
        let back = (f32x8::splat(simd, back) - depth) * index_per_depth;
        let [firsts, n_more] = Span::parts(simd, spans);
        let may_fold = !n_more.simd_eq(u32x8::splat(simd, Span::ALL));
        let place = u32x8::splat(simd, self.slab as u32) - firsts;
        let is_first = may_fold & place.simd_eq(u32x8::splat(simd, 0));
        let is_last = may_fold & place.simd_eq(n_more);
        // A place before the first wraps around.
        let is_drawn = !may_fold | place.simd_le(n_more);
        let far = f32x8::splat(simd, 2.0 * self.slabs.reach_in_index);
        let faces = [is_first.select(-far, front), is_last.select(far, back)];
        (faces, is_first | is_last, is_drawn)
    }
}

impl Slabs<'_> {
    /// Where sections are in their tables, in rows.
    #[inline(always)]
    pub(crate) fn rows_of<S: Simd>(
        &self,
        simd: S,
        front: f32x8<S>,
        back: f32x8<S>,
        is_folded: mask32x8<S>,
    ) -> f32x8<S> {
        let (rows, folded) = (self.table.rows(), self.tables(true).0.rows());
        let from_front = back + rows.radius;
        let from_nearer = if rows.mirrored {
            from_front.min(f32x8::splat(simd, rows.radius) - front)
        } else {
            from_front
        };
        let per_index = is_folded.select(
            f32x8::splat(simd, folded.rows_per_index),
            f32x8::splat(simd, rows.rows_per_index),
        );
        let last = is_folded
            .select(f32x8::splat(simd, folded.last_row), f32x8::splat(simd, rows.last_row));
        let row = (from_nearer * per_index).max(f32x8::splat(simd, 0.0)).min(last);
        match self.table.lookup() {
            Lookup::Nearest => (row + 0.5).floor(),
            Lookup::Linear => row,
        }
    }
}

impl Eight {
    const EMPTY: Self = Self {
        drawn: 0,
        centers: [[0.0; N_AT_ONCE]; 2],
        pixels: [[0; N_AT_ONCE]; 4],
        faces: [[0.0; N_AT_ONCE]; 2],
        is_folded: 0,
        edges: [1.0; N_AT_ONCE],
        rows: [0.0; N_AT_ONCE],
    };

    #[inline(always)]
    pub(crate) fn pixels_of(&self, idx: usize) -> PixelBox {
        let [left, top, right, bottom] = &self.pixels;
        let min = [left[idx] as u8, top[idx] as u8];
        PixelBox { min, end: [right[idx] as u8, bottom[idx] as u8] }
    }
}

/// By how many pixels boxes are wider than footprints: what lies right on an edge is left to the weights, or it would count
/// on one side and not on the other.
pub(crate) const MARGIN: f32 = 1.0 / 1024.0;

/// The pixel of a tile whose centre is the first behind each coordinate. NaN gives 0.
///
/// Adding 2²³ rounds to whole numbers and leaves them in the low bits.
#[inline(always)]
pub(crate) fn pixel<S: Simd>(simd: S, at: f32x8<S>) -> u32x8<S> {
    let inside = at.max(f32x8::splat(simd, 0.0)).min(f32x8::splat(simd, TILE_SIDE as f32));
    let rounded: u32x8<S> = (inside + f32x8::splat(simd, 8_388_608.0)).bitcast();
    rounded & u32x8::splat(simd, 0xff)
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
