//! Which slabs a voxel is drawn in (model §7).

use super::slab_view::SlabView;
use crate::sections::span::Span;
use crate::voxels::by_sheet::N_AT_ONCE;
use fearless_simd::{Simd, f32x8, prelude::*, u32x8};
use slabsplat_kernel::{SlabSplit, SplitLevels};

/// Finds the slabs of voxels by their depths and extinctions.
pub(super) struct SpanFinder<'a> {
    splits: Splits<'a>,
    half_depth: f32,
    slabs_per_depth: f32,
    /// The number of the first slab, counted from the centre.
    first_slab: f32,
    /// The index of the last one.
    last_slab: f32,
}

/// Which faces split kernels.
#[derive(Clone, Copy)]
pub(super) enum Splits<'a> {
    /// All that meet them.
    All,
    /// Those that these levels name, by a voxel's extinction.
    ByExtinction(&'a SplitLevels),
    /// None.
    Never,
}

impl<'a> SpanFinder<'a> {
    pub(super) fn new(slabs: &SlabView<'_>, splits: Splits<'a>) -> Self {
        let grid = slabs.grid;
        Self {
            splits,
            half_depth: slabs.raster.half_depth,
            slabs_per_depth: (1.0 / grid.thickness()) as f32,
            first_slab: (grid.front(0) / grid.thickness()).round() as f32,
            last_slab: (grid.n_slabs() - 1) as f32,
        }
    }

    /// How many slabs before all that its kernel meets a voxel may go to: where slabs are thick, a whole one
    /// may, of this level or of a finer one. What rounding does at a face is in the bounds.
    pub(super) fn most_slabs_before(&self, has_finer: bool) -> usize {
        let n_met_before = (self.half_depth * self.slabs_per_depth) as usize;
        match self.splits {
            Splits::All if !has_finer => 0,
            _ => SplitLevels::MOST_SLABS_BEFORE.saturating_sub(n_met_before),
        }
    }

    /// The slabs of eight voxels, given by their depths and extinctions (or whatever the compositing sums).
    #[inline(always)]
    pub(super) fn spans<S: Simd>(
        &self,
        simd: S,
        depths: &[f32; N_AT_ONCE],
        extinctions: &[f32; N_AT_ONCE],
    ) -> [Span; N_AT_ONCE] {
        let (mut shares, mut n_slabs) = ([1.0; N_AT_ONCE], [1.0; N_AT_ONCE]);
        match self.splits {
            Splits::All => {}
            Splits::ByExtinction(levels) => {
                for (idx, &extinction) in extinctions.iter().enumerate() {
                    let split = levels.split(extinction);
                    (shares[idx], n_slabs[idx]) = (split.share_of_half_depth, split.n_slabs);
                }
            }
            Splits::Never => {
                let SlabSplit { share_of_half_depth, n_slabs: of_all } = SplitLevels::WHOLE;
                (shares, n_slabs) = ([share_of_half_depth; N_AT_ONCE], [of_all; N_AT_ONCE]);
            }
        }
        let (shares, n_slabs) =
            (f32x8::from_slice(simd, &shares), f32x8::from_slice(simd, &n_slabs));
        let depths: f32x8<S> = (*depths).simd_into(simd);
        // Numbers of slabs, counted from the centre; whole and exact, as there are at most 2²² of
        // them.
        let split_half_depth = shares * self.half_depth;
        let near = ((depths - split_half_depth) * self.slabs_per_depth).floor();
        let far = (((depths + split_half_depth) * self.slabs_per_depth).ceil() - 1.0).max(near);
        // A voxel that has as many slabs as a span can hold is drawn in all that it meets, to be sure.
        let all = f32x8::splat(simd, Span::ALL as f32);
        let is_all = shares.simd_ge(f32x8::splat(simd, 1.0)) | (far - near).simd_ge(all);
        let first =
            is_all.select(((depths - self.half_depth) * self.slabs_per_depth).floor(), near);
        let is_thick = n_slabs.simd_gt(f32x8::splat(simd, 1.0));
        let middle = (near / n_slabs).floor().mul_add(n_slabs, n_slabs * 0.5);
        let first = is_thick.select(middle, first) - self.first_slab;
        let last_slab = f32x8::splat(simd, self.last_slab);
        let first: u32x8<S> = first.max(f32x8::splat(simd, 0.0)).min(last_slab).to_int();
        let n_more: u32x8<S> = is_all.select(all, far - near).to_int();
        <[u32; N_AT_ONCE]>::from(Span::bits(first, n_more)).map(Span)
    }
}
