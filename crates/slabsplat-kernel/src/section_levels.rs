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

/// For every level the greatest extinction that a voxel of that level may have.
#[derive(Clone, Debug, PartialEq)]
pub struct SectionLevels {
    /// Never falling; infinite for the last level.
    max_extinctions: [f32; N_LEVELS],
    /// The same for slabs 2, 4, … times as thick, into which whole kernels go; falling.
    max_in_thick: [f32; MAX_DOUBLINGS],
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
const N_LEVELS: usize = SectionLevels::LAST as usize + 1;

/// Slabs may grow to 2⁴ times their width.
const MAX_DOUBLINGS: usize = 4;

/// No pixel sees more layers of voxels than this folded over one face: kernels reach two steps.
const LAYERS_PER_FACE: f64 = 2.0;

impl SectionLevels {
    /// The level at which all faces cut.
    pub const LAST: u8 = 32;

    /// By how many slabs at most a whole voxel goes before the one that holds its centre: from the end of the
    /// thickest slab to its middle.
    pub const MOST_SLABS_BEFORE: usize = 1 << (MAX_DOUBLINGS - 1);

    /// The levels that `settings.tolerance` allows. Where the picture hangs on the slab width by
    /// definition, or no slabs cut anything, every voxel has the last.
    pub fn new(settings: &RenderSettings, kernel: &dyn Kernel, view: LevelView) -> Self {
        let is_additive = settings.method == Method::ImageAligned
            && settings.compositing == Compositing::Extinction
            && settings.normalization == Normalization::None;
        let budget = if is_additive { settings.tolerance / LAYERS_PER_FACE } else { 0.0 };
        let mut max_extinctions = [f32::INFINITY; N_LEVELS];
        for (level, max_extinction) in max_extinctions.iter_mut().enumerate().take(N_LEVELS - 1) {
            let distance = kernel.radius() * share_of_reach(level as u8);
            let allowed = budget / (view.layer_depth * fraction_beyond(kernel, distance));
            // The ray's slope counts as extinction: where it is too steep, this level is for none.
            let is_too_steep = budget <= 0.0 || allowed < view.steepest_ray;
            *max_extinction = if is_too_steep { f32::NEG_INFINITY } else { allowed as f32 };
        }
        let max_in_thick = std::array::from_fn(|n| {
            // A layer goes as far as from a face of the thick slab to its middle, and the kernels with it.
            let layers = 0.5 * settings.slab_width * f64::from(2_u32 << n) + view.layer_depth;
            let is_allowed = 0.0 < budget && view.steepest_ray == 0.0;
            if is_allowed { (LAYERS_PER_FACE * budget / layers) as f32 } else { f32::NEG_INFINITY }
        });
        Self { max_extinctions, max_in_thick }
    }

    /// By how many doublings the slab may be thicker into which a voxel of extinction `mu` is splatted whole, 1 … 4;
    /// `None` if it may not.
    #[inline]
    pub fn thick_slab(&self, mu: f32) -> Option<u32> {
        let n_doublings = self.max_in_thick.iter().filter(|&&max| mu <= max).count();
        (0 < n_doublings).then_some(n_doublings as u32)
    }

    /// The level of a voxel of extinction `mu`, from 0 (splatted whole) to [`Self::LAST`].
    #[inline]
    pub fn level(&self, mu: f32) -> u8 {
        // Counted instead of searched for: that has no branches to guess.
        let n_below: u32 = self.max_extinctions.iter().map(|&max| u32::from(max < mu)).sum();
        n_below.min(u32::from(Self::LAST)) as u8
    }

    /// A face cuts a kernel if less than this share of the kernel's reach in depth lies between the
    /// face and the voxel's centre.
    #[inline]
    pub fn share_of_reach(level: u8) -> f32 {
        f32::from(level) / f32::from(Self::LAST)
    }

    /// Whether every voxel has all its sections.
    pub fn are_all_last(&self) -> bool {
        self.max_extinctions[N_LEVELS - 2] < 0.0
    }
}

fn share_of_reach(level: u8) -> f64 {
    f64::from(level) / f64::from(SectionLevels::LAST)
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

    #[test]
    fn levels_rise_with_extinction() {
        let levels = levels(2e-3, UPRIGHT);
        assert_eq!(levels.level(0.0), 0);
        assert_eq!(levels.level(1.9e-3), 0, "half of it is half the tolerance");
        assert_eq!(levels.level(2.1e-3), 1);
        let rising: Vec<u8> = (0..140).map(|i| levels.level(0.1 * i as f32)).collect();
        assert!(rising.is_sorted(), "{rising:?}");
        assert!(24 < levels.level(13.8), "a solid voxel has nearly all its sections");
        assert_eq!(SectionLevels::share_of_reach(SectionLevels::LAST), 1.0);
    }

    /// What a level promises, between its own bound and the next.
    #[test]
    fn levels_keep_within_the_budget() {
        for (layer_depth, tolerance) in [(1.0, 1e-4), (2.5, 1e-3), (0.8, 1e-2)] {
            let levels = levels(tolerance, LevelView { layer_depth, steepest_ray: 0.0 });
            for step in 1..2000 {
                let mu = 0.007 * step as f32;
                let level = levels.level(mu);
                let folded = |level: u8| {
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
    fn levels_are_finer_where_rays_are_steep() {
        let steep = levels(2e-3, LevelView { layer_depth: 1.0, steepest_ray: 0.4 });
        let upright = levels(2e-3, UPRIGHT);
        assert_eq!(steep.level(1e-6), upright.level(0.4));
        assert_eq!(steep.level(2.0), upright.level(2.0));
    }

    #[test]
    fn levels_are_the_last_where_slab_width_is_seen() {
        let exact = |settings: RenderSettings| {
            let levels = SectionLevels::new(&settings, &Gaussian, UPRIGHT);
            assert!(levels.are_all_last(), "{settings:?}");
            assert_eq!(levels.level(0.0), SectionLevels::LAST, "{settings:?}");
            assert_eq!(levels.level(13.8), SectionLevels::LAST, "{settings:?}");
        };
        exact(RenderSettings { tolerance: 0.0, ..RenderSettings::default() });
        for compositing in [Compositing::Separate, Compositing::Associated] {
            exact(RenderSettings { compositing, ..RenderSettings::default() });
        }
        exact(RenderSettings { normalization: Normalization::Paper, ..RenderSettings::default() });
        assert!(!levels(1e-6, UPRIGHT).are_all_last());
    }
}
