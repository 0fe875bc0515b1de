//! A slab, and where it cuts eight voxels.

use super::shared::Sections;
use super::span::{Span, SpannedVoxel};
use crate::footprints::raster::PixelShape;
use crate::pixels::tile::Tile;
use crate::voxels::by_sheet::{N_AT_ONCE, Run};
use fearless_simd::{Simd, f32x8, mask32x8, prelude::*, u32x8};

/// Voxels of a tile, with the slabs in which they are drawn.
pub(crate) type Voxels<'a> = Run<'a, SpannedVoxel>;

/// A slab that is about to be splatted.
pub(crate) struct SlabCut<'a> {
    pub(crate) sections: &'a Sections<'a>,
    pub(crate) slab: usize,
    /// The footprint of its sections.
    pub(crate) shape: PixelShape,
    /// What voxels' colours are multiplied with: 1, or 0 in channels that have the sums of another slab.
    pub(crate) channels: [f32; 4],
    /// Depths of its faces.
    pub(crate) faces: [f32; 2],
}

/// Eight voxels, component by component.
pub(crate) struct Components<S: Simd> {
    pub(crate) right: f32x8<S>,
    pub(crate) up: f32x8<S>,
    pub(crate) depth: f32x8<S>,
    /// [`Span`]s in their bits.
    pub(crate) spans: u32x8<S>,
}

/// How a slab's faces cut eight voxels.
pub(crate) struct Cuts<S: Simd> {
    /// Index units from voxels to the faces that cut them.
    pub(crate) faces: [f32x8<S>; 2],
    /// Whether other faces were skipped.
    pub(crate) is_merged: mask32x8<S>,
    /// Whether they are drawn in this slab, if it cuts them.
    pub(crate) is_drawn: mask32x8<S>,
}

impl<S: Simd> Components<S> {
    #[inline(always)]
    pub(crate) fn of(simd: S, voxels: &[SpannedVoxel; N_AT_ONCE]) -> Self {
        let voxels = voxels.each_ref();
        let component = |axis: usize| voxels.map(|voxel| voxel.point[axis]);
        let [right, up, depth] = [component(0), component(1), component(2)];
        Self {
            right: right.simd_into(simd),
            up: up.simd_into(simd),
            depth: depth.simd_into(simd),
            spans: voxels.map(|voxel| voxel.sheets.0).simd_into(simd),
        }
    }
}

impl SlabCut<'_> {
    /// The centres of footprints, in pixels from the tile's upper left corner.
    #[inline(always)]
    pub(crate) fn centers_of<S: Simd>(
        &self,
        simd: S,
        voxels: &Components<S>,
        tile: &Tile,
    ) -> [f32x8<S>; 2] {
        let origin = tile.origin.map(|pixel| pixel as f32);
        let [x, y] = self.sections.raster.center();
        let (right, down) = (self.shape.scale, -self.shape.scale);
        [
            voxels.right.mul_add(f32x8::splat(simd, right), f32x8::splat(simd, x - origin[0])),
            voxels.up.mul_add(f32x8::splat(simd, down), f32x8::splat(simd, y - origin[1])),
        ]
    }

    #[inline(always)]
    pub(crate) fn cuts_of<S: Simd>(&self, simd: S, voxels: &Components<S>) -> Cuts<S> {
        let index_per_depth = self.sections.raster.index_per_depth;
        let [front, back] = self.faces;
        let front = (f32x8::splat(simd, front) - voxels.depth) * index_per_depth;
        let back = (f32x8::splat(simd, back) - voxels.depth) * index_per_depth;
        let [firsts, n_more] = Span::parts(simd, voxels.spans);
        let may_merge = !n_more.simd_eq(u32x8::splat(simd, Span::ALL));
        let nth = u32x8::splat(simd, self.slab as u32) - firsts;
        let is_first = may_merge & nth.simd_eq(u32x8::splat(simd, 0));
        let is_last = may_merge & nth.simd_eq(n_more);
        let far = f32x8::splat(simd, 2.0 * self.sections.half_depth_in_index);
        Cuts {
            faces: [is_first.select(-far, front), is_last.select(far, back)],
            is_merged: is_first | is_last,
            // A slab before the first wraps around.
            is_drawn: !may_merge | nth.simd_le(n_more),
        }
    }
}

/// The indices of the bits that are set.
#[inline(always)]
pub(crate) fn bits(mut mask: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let idx = mask.trailing_zeros() as usize;
        mask &= mask.checked_sub(1)?;
        Some(idx)
    })
}
