//! Which slabs a voxel is drawn in (`docs/algorithm.md`, "Sections by opacity").

use crate::image_aligned::Slabs;
use fearless_simd::{Simd, prelude::*, u32x8};
use slabsplat_kernel::SectionLevels;

/// The first slab of a voxel, and how many more there are; in the 32 bits that a voxel has for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Span(u32);

/// Bits for the number of slabs behind the first; the other 22 are enough for any slab's index.
const BITS: u32 = 10;

const ALL: u32 = (1 << BITS) - 1;

/// By how many slabs voxels are held apart: one slab, up to three, more.
pub(crate) const N_CLASSES: usize = 3;

impl Span {
    /// That many slabs or more, or a voxel that has all its sections: what slabs cut is then found by their faces.
    pub(crate) const ALL: u32 = ALL;

    pub(crate) fn from_bits(bits: u32) -> Self {
        Self(bits)
    }

    pub(crate) fn bits(self) -> u32 {
        self.0
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

    /// Voxels of a class wait for equally many slabs; see [`Slabs::n_before`].
    #[inline(always)]
    pub(crate) fn class(self) -> usize {
        match self.0 & ALL {
            0 => 0,
            1..=2 => 1,
            _ => 2,
        }
    }
}

impl Slabs<'_> {
    /// The slabs of a voxel at a depth, of an extinction (or whatever the compositing sums).
    #[inline]
    pub(crate) fn span(&self, depth: f32, extinction: f32) -> Span {
        let Some(fewer) = &self.fewer else {
            return Span((self.meeting(depth)[0] as u32) << BITS | ALL);
        };
        if let Some(n_doublings) = fewer.levels.thick_slab(extinction) {
            return Span((self.grid.middle_of_thick(depth.into(), n_doublings) as u32) << BITS);
        }
        let share = SectionLevels::share_of_reach(fewer.levels.level(extinction));
        let reach = share * self.raster.reach;
        let [first, last] = self.grid.meeting(f64::from(depth - reach), f64::from(depth + reach));
        let n_more = if share < 1.0 { ((last - first) as u32).min(ALL) } else { ALL };
        // A voxel that has as many slabs as can be told is drawn in all that it meets, to be sure.
        let first = if n_more == ALL { self.meeting(depth)[0] } else { first };
        Span((first as u32) << BITS | n_more)
    }

    /// How many slabs before a slab the voxels of a class may start that are drawn in it.
    pub(crate) fn n_before(&self, class: usize) -> usize {
        [0, 2, self.n_before][class].min(self.n_before)
    }
}
