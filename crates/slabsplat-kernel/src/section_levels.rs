//! Sections by opacity (paper §7): which slab faces cut a voxel's kernel, and which may be spared.
//!
//! ```text
//! level of a voxel = the least i with λ·max(μ, s)·T(iR/32) ≤ tolerance/2
//! drawn in         = the slabs that meet z ± i/32 of the kernel's reach in depth
//! first section    = all of the kernel before the first face between them
//! last section     = all of the kernel behind the last one
//! ```
//!
//! A face is spared where what lies beyond it, added up over a layer of such voxels, has at most half the
//! tolerance of extinction; what lies beyond is *folded* onto the section before it. So a faint voxel is
//! splatted whole, into the slab that holds its centre, and an opaque one in all its sections, but
//! for slivers at its ends. `docs/numerics.md` says why this bounds a pixel's error.
//!
//! This knows neither slabs nor voxels: a level is a number, and a reach is a share of the kernel's.

use crate::Kernel;
use slabsplat_core::{Compositing, Method, Normalization, RenderSettings};
use std::f64::consts::PI;

/// How the slabs cut a voxel, by its extinction.
#[derive(Clone, Debug, PartialEq)]
pub struct SectionLevels {
    /// The greatest extinction of a voxel that is cut like this: first whole in slabs 4 and 2 times as thick, then by
    /// level. Never falling; the last is infinite.
    max_extinctions: [f32; N_CUTS],
    /// By the leading bits of an extinction: which of those the least number with these bits has.
    first_cuts: Vec<u8>,
}

/// How slabs cut a voxel's kernel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlabCuts {
    /// A face cuts the kernel if it is nearer to the voxel's centre than this share of the kernel's reach in depth: 0 for
    /// a voxel that is splatted whole, 1 if all faces cut it.
    pub share_of_reach: f32,
    /// How many times as thick the slab is in whose middle a whole voxel goes: 2, 4, or 1 if it stays in the slab that
    /// holds its centre.
    pub n_slabs: f32,
}

/// How a view sees the grid, as far as levels go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelView {
    /// `λ = |Aᵀf|/unit`: the kernel's reach in depth over its radius, in `unit`s.
    pub layer_depth: f64,
    /// `s`: how far any ray moves sideways per step in depth; 0 in an orthographic view.
    pub steepest_ray: f64,
}

/// Level 0 is a whole kernel, and the last level all sections.
const N_LEVELS: usize = 33;

/// Slabs may grow to 2² times their width. Thicker ones would only spare sheets, as their voxels are whole in these, and
/// bring voxels to slabs long before any that their kernels meet: much would be drawn that turns out to be hidden.
const MAX_DOUBLINGS: usize = 2;

const N_CUTS: usize = MAX_DOUBLINGS + N_LEVELS;

/// The bits of a positive number behind its exponent and the first four of its fraction.
const TRAILING_BITS: u32 = 19;

/// The leading bits of positive numbers.
const N_LEADING: usize = 1 << (31 - TRAILING_BITS);

/// No pixel sees more layers of voxels than this folded over one face: kernels reach two steps.
const LAYERS_PER_FACE: f64 = 2.0;

impl SectionLevels {
    /// By how many slabs at most a whole voxel goes before the one that holds its centre: from the last slab of the thickest
    /// one to that behind its middle.
    pub const MOST_SLABS_BEFORE: usize = (1 << (MAX_DOUBLINGS - 1)) - 1;

    /// The levels that `settings.tolerance` allows. Where the picture hangs on the slab width by
    /// definition, or no slabs cut anything, every voxel has the last.
    pub fn new(settings: &RenderSettings, kernel: &dyn Kernel, view: LevelView) -> Self {
        let is_additive = settings.method == Method::ImageAligned
            && settings.compositing == Compositing::Extinction
            && settings.normalization == Normalization::None;
        let budget = if is_additive { settings.tolerance / LAYERS_PER_FACE } else { 0.0 };
        // The ray's slope counts as extinction: where it is too steep, this level is for none.
        let at_level = |level: usize| {
            let distance = kernel.radius() * share_of_reach(level);
            let allowed = budget / (view.layer_depth * fraction_beyond(kernel, distance));
            let is_too_steep = budget <= 0.0 || allowed < view.steepest_ray;
            if is_too_steep { f32::NEG_INFINITY } else { allowed as f32 }
        };
        let in_thick = |n_doublings: usize| {
            // A layer goes as far as from a face of the thick slab to its middle, and the kernels with it.
            let layers =
                0.5 * settings.slab_width * f64::from(1_u32 << n_doublings) + view.layer_depth;
            let is_allowed = 0.0 < budget && view.steepest_ray == 0.0;
            if is_allowed { (LAYERS_PER_FACE * budget / layers) as f32 } else { f32::NEG_INFINITY }
        };
        let max_extinctions = std::array::from_fn(|cut| match cut.checked_sub(MAX_DOUBLINGS) {
            None => in_thick(MAX_DOUBLINGS - cut),
            Some(level) if level < N_LEVELS - 1 => at_level(level),
            Some(_) => f32::INFINITY,
        });
        let first_cut = |leading: usize| {
            let least = f32::from_bits((leading as u32) << TRAILING_BITS);
            max_extinctions.iter().take_while(|max| **max < least).count() as u8
        };
        Self { max_extinctions, first_cuts: (0..N_LEADING).map(first_cut).collect() }
    }

    /// How slabs cut a voxel of extinction `mu`.
    #[inline(always)]
    pub fn cuts(&self, mu: f32) -> SlabCuts {
        let mut cut =
            usize::from(self.first_cuts[(mu.to_bits() >> TRAILING_BITS) as usize % N_LEADING]);
        // Hardly ever more than once: what two neighbouring levels allow has other leading bits.
        while self.max_extinctions[cut] < mu {
            cut += 1;
        }
        CUTS[cut]
    }

    /// Whether every voxel has all its sections.
    pub fn are_all_last(&self) -> bool {
        self.max_extinctions[N_CUTS - 2] < 0.0
    }
}

/// What the entries of `max_extinctions` mean.
const CUTS: [SlabCuts; N_CUTS] = {
    let mut cuts = [SlabCuts { share_of_reach: 0.0, n_slabs: 1.0 }; N_CUTS];
    let mut cut = 0;
    while cut < N_CUTS {
        if cut < MAX_DOUBLINGS {
            cuts[cut].n_slabs = (1 << (MAX_DOUBLINGS - cut)) as f32;
        } else {
            cuts[cut].share_of_reach = share_of_reach(cut - MAX_DOUBLINGS) as f32;
        }
        cut += 1;
    }
    cuts
};

const fn share_of_reach(level: usize) -> f64 {
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

    const UPRIGHT: LevelView = LevelView { layer_depth: 1.0, steepest_ray: 0.0 };

    fn levels(tolerance: f64, view: LevelView) -> SectionLevels {
        let settings = RenderSettings { tolerance, ..RenderSettings::default() };
        SectionLevels::new(&settings, &Gaussian, view)
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
    fn level(levels: &SectionLevels, mu: f32) -> usize {
        (levels.cuts(mu).share_of_reach * (N_LEVELS - 1) as f32) as usize
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
        assert_eq!(levels.cuts(f32::MAX).share_of_reach, 1.0);
    }

    /// Layers of 1 + n/2 voxels have 2n slabs folded into one.
    #[test]
    fn levels_of_faint_voxels_are_thick_slabs() {
        let levels = levels(2e-3, UPRIGHT);
        for (n_slabs, layers) in [(2.0, 2.0), (4.0, 3.0)] {
            let most = 2e-3 / layers;
            assert_eq!(levels.cuts(most * 0.999).n_slabs, n_slabs);
            assert!(levels.cuts(most * 1.001).n_slabs < n_slabs);
        }
        assert_eq!(levels.cuts(0.0).n_slabs, 4.0);
    }

    /// What a level promises, between its own bound and the next.
    #[test]
    fn levels_keep_within_the_budget() {
        for (layer_depth, tolerance) in [(1.0, 1e-4), (2.5, 1e-3), (0.8, 1e-2)] {
            let levels = levels(tolerance, LevelView { layer_depth, steepest_ray: 0.0 });
            for step in 1..2000 {
                let mu = 0.007 * step as f32;
                let level = level(&levels, mu);
                let folded = |level: usize| {
                    let distance = 2.0 * share_of_reach(level);
                    layer_depth * f64::from(mu) * fraction_beyond(&Gaussian, distance)
                };
                assert!(2.0 * folded(level) <= tolerance * 1.000_001, "{mu}: level {level}");
                assert!(
                    level == 0 || tolerance < 2.0 * folded(level - 1) * 1.000_001,
                    "{mu}: {level}"
                );
            }
        }
    }

    #[test]
    fn levels_in_perspective_have_no_thick_slabs() {
        let levels = levels(2e-3, LevelView { layer_depth: 1.0, steepest_ray: 1e-9 });
        assert_eq!(levels.cuts(0.0), SlabCuts { share_of_reach: 0.0, n_slabs: 1.0 });
    }

    #[test]
    fn levels_are_finer_where_rays_are_steep() {
        let steep = levels(2e-3, LevelView { layer_depth: 1.0, steepest_ray: 0.4 });
        let upright = levels(2e-3, UPRIGHT);
        assert_eq!(level(&steep, 1e-6), level(&upright, 0.4));
        assert_eq!(level(&steep, 2.0), level(&upright, 2.0));
    }

    #[test]
    fn levels_are_the_last_where_slab_width_is_seen() {
        let exact = |settings: RenderSettings| {
            let levels = SectionLevels::new(&settings, &Gaussian, UPRIGHT);
            assert!(levels.are_all_last(), "{settings:?}");
            for mu in [0.0, 13.8] {
                let all = SlabCuts { share_of_reach: 1.0, n_slabs: 1.0 };
                assert_eq!(levels.cuts(mu), all, "{settings:?}");
            }
        };
        exact(RenderSettings { tolerance: 0.0, ..RenderSettings::default() });
        for compositing in [Compositing::Separate, Compositing::Associated] {
            exact(RenderSettings { compositing, ..RenderSettings::default() });
        }
        exact(RenderSettings { normalization: Normalization::Paper, ..RenderSettings::default() });
        assert!(!levels(1e-6, UPRIGHT).are_all_last());
    }
}
