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

    /// The first and the last slab that the kernels of eight voxels at those depths meet.
    #[inline(always)]
    pub(super) fn met<S: Simd>(&self, simd: S, depths: &[f32; N_AT_ONCE]) -> [[u32; N_AT_ONCE]; 2] {
        let depths: f32x8<S> = (*depths).simd_into(simd);
        let near = ((depths - self.half_depth) * self.slabs_per_depth).floor();
        let far = ((depths + self.half_depth) * self.slabs_per_depth).ceil() - 1.0;
        [near, far.max(near)].map(|slabs| self.indices(simd, slabs).into())
    }

    /// The indices of slabs, given by their numbers counted from the centre.
    #[inline(always)]
    fn indices<S: Simd>(&self, simd: S, slabs: f32x8<S>) -> u32x8<S> {
        let last = f32x8::splat(simd, self.last_slab);
        (slabs - self.first_slab).max(f32x8::splat(simd, 0.0)).min(last).to_int()
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
        let is_whole = shares.simd_eq(f32x8::splat(simd, 0.0));
        let on_face =
            is_whole.select(f32x8::splat(simd, SplitLevels::ON_FACE), f32x8::splat(simd, 0.0));
        let near =
            (depths - split_half_depth).mul_add(f32x8::splat(simd, self.slabs_per_depth), on_face);
        let near = near.floor();
        let far = (((depths + split_half_depth) * self.slabs_per_depth).ceil() - 1.0).max(near);
        // A voxel that has as many slabs as a span can hold is drawn in all that it meets, to be sure.
        let all = f32x8::splat(simd, Span::ALL as f32);
        let is_all = shares.simd_ge(f32x8::splat(simd, 1.0)) | (far - near).simd_ge(all);
        let first =
            is_all.select(((depths - self.half_depth) * self.slabs_per_depth).floor(), near);
        let is_thick = n_slabs.simd_gt(f32x8::splat(simd, 1.0));
        let middle = (near / n_slabs).floor().mul_add(n_slabs, n_slabs * 0.5);
        let first = self.indices(simd, is_thick.select(middle, first));
        let n_more: u32x8<S> = is_all.select(all, far - near).to_int();
        <[u32; N_AT_ONCE]>::from(Span::bits(first, n_more)).map(Span)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};
    use slabsplat_core::SlabGrid;
    use slabsplat_seeds::for_each_seed;

    /// Also of depths before and behind all slabs. Where an end of a kernel is next to a face, rounding may
    /// put it on either side.
    #[test]
    fn span_finder_meets_the_slabs_of_the_grid() {
        for_each_seed(1, |mut rng| {
            let thickness = 0.1 + 2.0 * rng.f64();
            let ends = [-1.0, 1.0].map(|sign| sign * (1.0 + 50.0 * rng.f64()));
            let grid = SlabGrid::covering(ends, thickness).unwrap();
            let half_depth = 0.05 + 4.0 * rng.f32();
            let finder = SpanFinder {
                splits: Splits::All,
                half_depth,
                slabs_per_depth: (1.0 / thickness) as f32,
                first_slab: (grid.front(0) / thickness).round() as f32,
                last_slab: (grid.n_slabs() - 1) as f32,
            };
            for _ in 0..500 {
                let depths = std::array::from_fn(|_| 120.0 * rng.f32() - 60.0);
                let found = dispatch!(Level::new(), simd => finder.met(simd, &depths));
                let spans = dispatch!(Level::new(), simd => finder.spans(simd, &depths, &depths));
                for (idx, depth) in depths.into_iter().enumerate() {
                    let [near, far] = [depth - half_depth, depth + half_depth].map(f64::from);
                    let expected = grid.meeting(near, far);
                    let is_at_face = |end: f64| {
                        let slabs = end / thickness;
                        (slabs - slabs.round()).abs() < 1e-3
                    };
                    let found = found.map(|slabs| slabs[idx] as usize);
                    assert_eq!(spans[idx].first(), found[0]);
                    if !is_at_face(near) && !is_at_face(far) {
                        assert_eq!(found, expected, "{depth} ± {half_depth}, {thickness} thick");
                    }
                }
            }
        });
    }
}
