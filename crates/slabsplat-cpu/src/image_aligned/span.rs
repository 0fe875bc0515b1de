//! Which slabs a voxel is drawn in (`docs/algorithm.md`, "Sections by opacity").

use crate::by_sheet::N_AT_ONCE;
use crate::image_aligned::Slabs;
use crate::image_aligned::prepare::Kind;
use crate::voxel::Voxel;
use fearless_simd::{Simd, f32x8, prelude::*, u32x8};

/// The first slab of a voxel, and how many more there are; in the 32 bits that a voxel has for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Span(u32);

/// Bits for the number of slabs behind the first; the other 22 are enough for any slab's index.
const BITS: u32 = 10;

const ALL: u32 = (1 << BITS) - 1;

/// Classes of spans: one slab, up to three, more.
const N_SPAN_CLASSES: usize = 3;

/// Voxels of a class wait for equally many slabs. First those that may be drawn as products, by their
/// spans, then the others.
pub(crate) const N_CLASSES: usize = 2 * N_SPAN_CLASSES;

impl Span {
    /// That many slabs or more, or a voxel that has all its sections: what slabs cut is then found by their faces.
    pub(crate) const ALL: u32 = ALL;

    pub(crate) fn from_bits(bits: u32) -> Self {
        Self(bits)
    }

    /// The first slab.
    #[inline(always)]
    pub(crate) fn first(self) -> usize {
        (self.0 >> BITS) as usize
    }

    /// First slabs and numbers of slabs behind them.
    #[inline(always)]
    pub(crate) fn parts<S: Simd>(simd: S, spans: u32x8<S>) -> [u32x8<S>; 2] {
        [spans >> BITS, spans & u32x8::splat(simd, ALL)]
    }

    #[inline(always)]
    fn class(self) -> usize {
        match self.0 & ALL {
            0 => 0,
            1..=2 => 1,
            _ => 2,
        }
    }
}

impl Slabs<'_> {
    /// The slabs of eight voxels, given by their depths and extinctions (or whatever the compositing sums).
    #[inline(always)]
    pub(crate) fn spans<S: Simd>(
        &self,
        simd: S,
        depths: &[f32; N_AT_ONCE],
        extinctions: &[f32; N_AT_ONCE],
    ) -> [u32; N_AT_ONCE] {
        let (mut shares, mut n_slabs) = ([1.0; N_AT_ONCE], [1.0; N_AT_ONCE]);
        if let Some(fewer) = &self.fewer {
            for (idx, &extinction) in extinctions.iter().enumerate() {
                let cuts = fewer.levels.cuts(extinction);
                (shares[idx], n_slabs[idx]) = (cuts.share_of_reach, cuts.n_slabs);
            }
        }
        let (shares, n_slabs) =
            (f32x8::from_slice(simd, &shares), f32x8::from_slice(simd, &n_slabs));
        let depths: f32x8<S> = (*depths).simd_into(simd);
        // Numbers of slabs, counted from the grid's centre; whole and exact, as there are at most 2²² of them.
        let reach = shares * self.raster.reach;
        let near = ((depths - reach) * self.slabs_per_depth).floor();
        let far = (((depths + reach) * self.slabs_per_depth).ceil() - 1.0).max(near);
        // A voxel that has as many slabs as can be told is drawn in all that it meets, to be sure.
        let is_all = shares.simd_ge(f32x8::splat(simd, 1.0))
            | (far - near).simd_ge(f32x8::splat(simd, ALL as f32));
        let first =
            is_all.select(((depths - self.raster.reach) * self.slabs_per_depth).floor(), near);
        let is_thick = n_slabs.simd_gt(f32x8::splat(simd, 1.0));
        let middle = (near / n_slabs).floor().mul_add(n_slabs, n_slabs * 0.5);
        let first = is_thick.select(middle, first) - self.first_slab;
        let last_slab = (self.grid.n_slabs() - 1) as f32;
        let first: u32x8<S> =
            first.max(f32x8::splat(simd, 0.0)).min(f32x8::splat(simd, last_slab)).to_int();
        let n_more: u32x8<S> = is_all.select(f32x8::splat(simd, ALL as f32), far - near).to_int();
        (first << BITS | n_more).into()
    }

    #[inline(always)]
    pub(crate) fn class_of(&self, voxel: &Voxel) -> usize {
        let span = Span::from_bits(voxel.sheets).class();
        if voxel.color[3] <= self.most_of_products { span } else { N_SPAN_CLASSES + span }
    }

    /// Whether voxels of a class may be drawn as products.
    pub(crate) fn may_be_products(class: usize) -> bool {
        class < N_SPAN_CLASSES
    }

    /// What the sections of a class are like.
    pub(crate) fn kind_of(&self, class: usize) -> Kind {
        match (class % N_SPAN_CLASSES, self.fewer) {
            (0, Some(_)) => Kind::Whole,
            _ if self.reads_table => Kind::ByTable,
            _ => Kind::Upright,
        }
    }

    /// How many slabs before a slab the voxels of a class may start that are drawn in it.
    pub(crate) fn n_before(&self, class: usize) -> usize {
        [0, 2, self.n_before][class % N_SPAN_CLASSES].min(self.n_before)
    }
}
