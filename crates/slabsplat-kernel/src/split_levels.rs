//! Merged sections (paper §7, model §7): which slab faces split a voxel's kernel, and which may be skipped.
//!
//! ```text
//! split level of a voxel = the least i with λ·max(μ, s)·T(iR/32) ≤ tolerance/2
//! drawn in               = the slabs that meet z ± i/32 of the kernel's half-depth
//! first section          = all of the kernel before the first face between them
//! last section           = all of the kernel behind the last one
//! ```
//!
//! A face is skipped if the extinction beyond it, added up over a layer of such voxels, is at most half the
//! tolerance; what lies beyond is *merged* into the section before it. So a faint voxel is
//! splatted whole, into the slab that holds its centre, and an opaque one in all its sections, but
//! for slivers at its ends. [Numerics] says why this bounds a pixel's error.
//!
//! A cell (model §16) is whole however opaque it is, but for the sake of steep rays, with 0 for `μ`: its own
//! voxels lie deeper apart than its kernel is thick, and where a pixel could tell, no cells are drawn.
//!
//! [Numerics]: https://github.com/slabsplat/slabsplat/blob/main/docs/numerics.md
//!
//! This knows neither slabs nor voxels: a level is a number, and a split half-depth is a share of the
//! kernel's.

use crate::{ErrorBudget, Kernel};
use slabsplat_core::RenderSettings;
use std::f64::consts::PI;

/// How slabs split a voxel's kernel, by its extinction.
#[derive(Clone, Debug, PartialEq)]
pub struct SplitLevels {
    /// The greatest extinction of a voxel that is split like this, unless one before allows it: first whole
    /// in slabs 4 and 2 times as thick, then by split level. The last is infinite.
    max_extinctions: [f32; N_SPLITS],
    /// By the leading bits of an extinction: which of those the least number with these bits has.
    first_splits: Vec<u8>,
}

/// How much of a kernel lies beyond a face at each level but the last, in any view. It takes some 16,000
/// values of the kernel, so that it is worth being cached.
#[derive(Clone, Debug, PartialEq)]
pub struct KernelTails([f64; N_LEVELS - 1]);

/// How slabs split a voxel's kernel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlabSplit {
    /// A face splits the kernel if it is nearer to the voxel's centre than this share of the kernel's
    /// half-depth: 0 for a voxel that is splatted whole, 1 if all faces split it.
    pub share_of_half_depth: f32,
    /// How many times as thick the slab is in whose middle a whole voxel goes: 2, 4, or 1 if it stays in the
    /// slab that holds its centre.
    pub n_slabs: f32,
}

/// How a view sees the grid, as far as splits go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SplitView {
    /// `λ = |Aᵀf|/unit`: the kernel's half-depth over its radius, in `unit`s.
    pub layer_depth: f64,
    /// `s`: how far any ray moves sideways per step in depth; 0 in an orthographic view.
    pub steepest_ray: f64,
    /// Whether a region cuts what is seen ([model §11](slabsplat_core::model)).
    pub is_cut: bool,
    /// The level of detail that is seen, 0 for voxels ([model §16](slabsplat_core::model)).
    pub level: u32,
}

/// Level 0 is a whole kernel, and the last level all sections.
const N_LEVELS: usize = 33;

/// Slabs may grow to 2² times their width. Thicker ones would only save sheets, as their voxels are whole in
/// these, and bring voxels to slabs long before any that their kernels meet: much would be drawn that turns
/// out to be occluded.
const MAX_DOUBLINGS: usize = 2;

const N_SPLITS: usize = SplitLevels::N_SPLITS;

/// The bits of a positive number behind its exponent and the first four of its fraction.
const TRAILING_BITS: u32 = 19;

/// The leading bits of positive numbers.
const N_LEADING: usize = 1 << (31 - TRAILING_BITS);

impl KernelTails {
    /// Those of a kernel.
    pub fn of(kernel: &dyn Kernel) -> Self {
        let beyond = |level| fraction_beyond(kernel, kernel.radius() * share_of_half_depth(level));
        Self(std::array::from_fn(beyond))
    }
}

impl SplitLevels {
    /// By how many slabs at most a whole voxel goes before the one that holds its centre: from the last slab
    /// of the thickest one to that behind its middle.
    pub const MOST_SLABS_BEFORE: usize = (1 << (MAX_DOUBLINGS - 1)) - 1;

    /// A voxel that is whole lies on a face if it is less than so many slabs before it: many do, those of
    /// grids along the view and those in the middle of any, and rounding must not choose the slab of these.
    pub const ON_FACE: f32 = 1.0 / 1024.0;

    /// How many ways there are to split a kernel.
    pub const N_SPLITS: usize = MAX_DOUBLINGS + N_LEVELS;

    /// The split of a voxel so faint that no face splits it.
    pub const WHOLE: SlabSplit = SPLITS[0];

    /// The split levels that `settings.tolerance` allows. Where the picture depends on the slab width by
    /// definition, or no slabs split anything, every voxel has the last.
    pub fn new(settings: &RenderSettings, tails: &KernelTails, view: SplitView) -> Self {
        let budget = ErrorBudget::new(settings);
        // The ray's slope counts as extinction: where it is too steep, this level is for none. Of cells it is
        // all that counts.
        let at_level = |level: usize| {
            let allowed = budget.per_face() / (view.layer_depth * tails.0[level]);
            let is_too_steep = budget.per_face() <= 0.0 || allowed < view.steepest_ray;
            let allowed = if view.level == 0 { allowed as f32 } else { f32::INFINITY };
            if is_too_steep { f32::NEG_INFINITY } else { allowed }
        };
        let in_thick = |n_doublings: usize| {
            // A layer goes as far as from a face of the thick slab to its middle, and the kernels with it. A
            // region may show the one slab alone in which they all are.
            let n_slabs = f64::from(1_u32 << n_doublings);
            let n_others = if view.is_cut { n_slabs - 1.0 } else { 0.5 * n_slabs };
            let layers = n_others * settings.slab_width + view.layer_depth;
            let is_allowed = 0.0 < budget.per_thick_slab() && view.steepest_ray == 0.0;
            // A cell goes where a voxel of its voxels' mean extinction would: 4ˡ times that is its own, and
            // 2ˡ times as many layers are as deep, as these count steps of its grid.
            let of_cells = f64::from(1_u32 << view.level);
            let allowed = (of_cells * budget.per_thick_slab() / layers) as f32;
            if is_allowed { allowed } else { f32::NEG_INFINITY }
        };
        Self::up_to(std::array::from_fn(|split| match split.checked_sub(MAX_DOUBLINGS) {
            None => in_thick(MAX_DOUBLINGS - split),
            Some(level) if level < N_LEVELS - 1 => at_level(level),
            Some(_) => f32::INFINITY,
        }))
    }

    fn up_to(max_extinctions: [f32; N_SPLITS]) -> Self {
        let mut split = 0;
        let first_split = |leading: usize| {
            // They rise with their leading bits, as positive numbers do.
            let least = f32::from_bits((leading as u32) << TRAILING_BITS);
            while max_extinctions[split] < least {
                split += 1;
            }
            split as u8
        };
        let first_splits = (0..N_LEADING).map(first_split).collect();
        Self { max_extinctions, first_splits }
    }

    /// All ways to split a kernel, each with the most extinction of the voxels that have it, unless they have
    /// one before: it rises, and of the last, which has all sections, it is infinite.
    pub fn all(&self) -> impl Iterator<Item = (f32, SlabSplit)> {
        let rising = self.max_extinctions.iter().scan(f32::NEG_INFINITY, |most, &of_split| {
            *most = most.max(of_split);
            Some(*most)
        });
        rising.zip(SPLITS)
    }

    /// How slabs split a voxel of extinction `mu`.
    #[inline(always)]
    pub fn split(&self, mu: f32) -> SlabSplit {
        let mut split =
            usize::from(self.first_splits[(mu.to_bits() >> TRAILING_BITS) as usize % N_LEADING]);
        // Hardly ever more than once: what two neighbouring levels allow has other leading bits.
        while self.max_extinctions[split] < mu {
            split += 1;
        }
        SPLITS[split]
    }

    /// Whether every voxel has all its sections.
    pub fn are_all_last(&self) -> bool {
        self.max_extinctions[N_SPLITS - 2] < 0.0
    }
}

/// What the entries of `max_extinctions` mean.
const SPLITS: [SlabSplit; N_SPLITS] = {
    let mut splits = [SlabSplit { share_of_half_depth: 0.0, n_slabs: 1.0 }; N_SPLITS];
    let mut split = 0;
    while split < N_SPLITS {
        if split < MAX_DOUBLINGS {
            splits[split].n_slabs = (1 << (MAX_DOUBLINGS - split)) as f32;
        } else {
            splits[split].share_of_half_depth = share_of_half_depth(split - MAX_DOUBLINGS) as f32;
        }
        split += 1;
    }
    splits
};

const fn share_of_half_depth(level: usize) -> f64 {
    level as f64 / (N_LEVELS - 1) as f64
}

/// `T(δ)`: how much of the kernel lies beyond a plane at the distance `δ` from its centre. A shell of
/// radius `r` has the share `(1 − δ/r)/2` of its area there. By the midpoint rule, which never asks
/// for the value at the radius, where the Gaussian has a step.
fn fraction_beyond(kernel: &dyn Kernel, distance: f64) -> f64 {
    let n = 512;
    let step = (kernel.radius() - distance) / f64::from(n);
    let shell = |i: i32| {
        let r = distance + step * (f64::from(i) + 0.5);
        2.0 * PI * r * (r - distance) * kernel.value(r) * step
    };
    (0..n).map(shell).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Gaussian, KERNEL_NAMES, kernel_named};
    use slabsplat_core::{Compositing, Normalization};

    const UPRIGHT: SplitView =
        SplitView { layer_depth: 1.0, steepest_ray: 0.0, is_cut: false, level: 0 };

    fn levels(tolerance: f64, view: SplitView) -> SplitLevels {
        let settings = RenderSettings::default().tolerance(tolerance);
        SplitLevels::new(&settings, &KernelTails::of(&Gaussian), view)
    }

    /// The same as a sum of the kernel's line integrals over rings about its axis.
    #[test]
    fn levels_fraction_beyond_matches_line_integrals() {
        for &name in KERNEL_NAMES {
            let kernel = kernel_named(name).unwrap();
            let radius = kernel.radius();
            let ring = radius / 20_000.0;
            for distance in [0.0, 0.3, 1.0, 1.4] {
                let expected: f64 = (0..20_000)
                    .map(|i| ring * (f64::from(i) + 0.5))
                    .map(|rho| 2.0 * PI * rho * ring * kernel.line_integral(rho, distance, radius))
                    .sum();
                let beyond = fraction_beyond(&*kernel, distance);
                assert!((beyond - expected).abs() < 1e-5, "{name} {distance}: {beyond} {expected}");
            }
            assert_eq!(fraction_beyond(&*kernel, radius), 0.0);
        }
    }

    /// The level of a voxel that stays where it is or goes into a thick slab.
    fn level(levels: &SplitLevels, mu: f32) -> usize {
        (levels.split(mu).share_of_half_depth * (N_LEVELS - 1) as f32) as usize
    }

    #[test]
    fn levels_rise_with_extinction() {
        let levels = levels(2e-3, UPRIGHT);
        assert_eq!(level(&levels, 0.0), 0);
        assert_eq!(level(&levels, 1.9e-3), 0, "half of it is half the tolerance");
        assert_eq!(level(&levels, 2.1e-3), 1);
        let rising: Vec<usize> = (0..140).map(|i| level(&levels, 0.1 * i as f32)).collect();
        assert!(rising.is_sorted(), "{rising:?}");
        assert!(24 < level(&levels, 13.8), "a solid voxel has nearly all its sections");
        assert_eq!(levels.split(f32::MAX).share_of_half_depth, 1.0);
    }

    /// Layers of 1 + n/2 voxels have 2n slabs merged into one.
    #[test]
    fn levels_of_faint_voxels_are_thick_slabs() {
        let levels = levels(2e-3, UPRIGHT);
        for (n_slabs, layers) in [(2.0, 2.0), (4.0, 3.0)] {
            let most = 2e-3 / layers;
            assert_eq!(levels.split(most * 0.999).n_slabs, n_slabs);
            assert!(levels.split(most * 1.001).n_slabs < n_slabs);
        }
        assert_eq!(levels.split(0.0).n_slabs, 4.0);
    }

    /// What a level promises, between its own bound and the next.
    #[test]
    fn levels_keep_within_the_budget() {
        for (layer_depth, tolerance) in [(1.0, 1e-4), (2.5, 1e-3), (0.8, 1e-2)] {
            let levels = levels(tolerance, SplitView { layer_depth, ..UPRIGHT });
            for step in 1..2000 {
                let mu = 0.007 * step as f32;
                let level = level(&levels, mu);
                let merged = |level: usize| {
                    let distance = 2.0 * share_of_half_depth(level);
                    layer_depth * f64::from(mu) * fraction_beyond(&Gaussian, distance)
                };
                assert!(2.0 * merged(level) <= tolerance * 1.000_001, "{mu}: level {level}");
                assert!(
                    level == 0 || tolerance < 2.0 * merged(level - 1) * 1.000_001,
                    "{mu}: {level}"
                );
            }
        }
    }

    /// Each bound is the greatest extinction that is split like this.
    #[test]
    fn levels_end_at_their_bounds() {
        let levels = levels(2e-3, UPRIGHT);
        for (split, &most) in levels.max_extinctions.iter().enumerate().take(N_SPLITS - 1) {
            assert_eq!(levels.split(most), SPLITS[split], "{most}");
            assert_eq!(levels.split(most.next_up()), SPLITS[split + 1], "{most}");
        }
    }

    /// What searches among all finds what `split` does.
    #[test]
    fn levels_are_among_all() {
        for (tolerance, level, is_cut) in
            [(2e-3, 0, false), (5e-2, 0, true), (5e-2, 2, false), (0.8, 0, false)]
        {
            let levels =
                levels(tolerance, SplitView { layer_depth: 1.7, level, is_cut, ..UPRIGHT });
            let all: Vec<_> = levels.all().collect();
            assert!(all.is_sorted_by(|a, b| a.0 <= b.0));
            for step in 0..2000 {
                let mu = 0.007 * step as f32;
                let first = all.partition_point(|(most, _)| *most < mu);
                assert_eq!(all[first].1, levels.split(mu), "{mu}");
            }
        }
    }

    /// Of four slabs the last is one slab behind that behind their middle.
    /// A region may show one slab in which there are all voxels of four.
    #[test]
    fn levels_of_what_is_cut_go_into_less_thick_slabs() {
        let thickness =
            |mu: f32, is_cut: bool| levels(2e-3, SplitView { is_cut, ..UPRIGHT }).split(mu).n_slabs;
        for (mu, whole, cut) in [(4e-4, 4.0, 4.0), (6e-4, 4.0, 2.0), (9e-4, 2.0, 2.0)] {
            assert_eq!([thickness(mu, false), thickness(mu, true)], [whole, cut], "{mu}");
        }
    }

    /// In steps of their own grid cells of 2ˡ voxels have slabs and kernels a part as thick.
    #[test]
    fn levels_of_cells_are_thick_slabs_where_those_of_their_voxels_are() {
        let of_voxels = levels(2e-3, UPRIGHT);
        let side = |level: u32| f64::from(1 << level);
        for level in [1, 2, 3] {
            let layer_depth = 1.0 / side(level);
            let settings = RenderSettings::default().tolerance(2e-3).slab_width(layer_depth);
            let view = SplitView { layer_depth, level, ..UPRIGHT };
            let of_cells = SplitLevels::new(&settings, &KernelTails::of(&Gaussian), view);
            for step in 0..1000 {
                let mu = 1.1e-6 * step as f32;
                let n_slabs = of_cells.split(mu * side(level).powi(2) as f32).n_slabs;
                assert_eq!(n_slabs, of_voxels.split(mu).n_slabs, "level {level}: {mu}");
            }
        }
    }

    #[test]
    fn levels_of_cells_go_by_the_slope_of_rays_alone() {
        let most_at = |steepest_ray: f64, level: u32| {
            let of_cells = levels(2e-3, SplitView { steepest_ray, level, ..UPRIGHT });
            of_cells.split(1e9).share_of_half_depth
        };
        for level in [1, 2, 3] {
            assert_eq!(most_at(0.0, level), 0.0);
            for slope in [1e-4, 2e-3, 0.1, 0.6] {
                let voxel_as_opaque = levels(2e-3, UPRIGHT).split(slope as f32);
                assert_eq!(most_at(slope, level), voxel_as_opaque.share_of_half_depth, "{slope}");
            }
        }
    }

    #[test]
    fn levels_bring_voxels_few_slabs_forward() {
        assert_eq!(levels(2e-3, UPRIGHT).split(0.0).n_slabs, 4.0);
        assert_eq!(SplitLevels::MOST_SLABS_BEFORE, 3 - 2);
    }

    #[test]
    fn levels_in_perspective_have_no_thick_slabs() {
        let levels = levels(2e-3, SplitView { layer_depth: 1.0, steepest_ray: 1e-9, ..UPRIGHT });
        assert_eq!(levels.split(0.0), SlabSplit { share_of_half_depth: 0.0, n_slabs: 1.0 });
    }

    #[test]
    fn levels_are_finer_where_rays_are_steep() {
        let steep = levels(2e-3, SplitView { layer_depth: 1.0, steepest_ray: 0.4, ..UPRIGHT });
        let upright = levels(2e-3, UPRIGHT);
        assert_eq!(level(&steep, 1e-6), level(&upright, 0.4));
        assert_eq!(level(&steep, 2.0), level(&upright, 2.0));
        let steepest = levels(2e-3, SplitView { layer_depth: 1.0, steepest_ray: 13.0, ..UPRIGHT });
        assert!(!steepest.are_all_last(), "the last face but one is skipped by more than that");
    }

    #[test]
    fn levels_are_the_last_where_slab_width_is_seen() {
        let exact = |settings: RenderSettings| {
            let levels = SplitLevels::new(&settings, &KernelTails::of(&Gaussian), UPRIGHT);
            assert!(levels.are_all_last(), "{settings:?}");
            for mu in [0.0, 13.8] {
                let all = SlabSplit { share_of_half_depth: 1.0, n_slabs: 1.0 };
                assert_eq!(levels.split(mu), all, "{settings:?}");
            }
        };
        exact(RenderSettings::default().tolerance(0.0));
        for compositing in [Compositing::Separate, Compositing::Associated] {
            exact(RenderSettings::default().mode(compositing.into()));
        }
        exact(RenderSettings::default().normalization(Normalization::Paper));
        assert!(!levels(1e-6, UPRIGHT).are_all_last());
    }
}
