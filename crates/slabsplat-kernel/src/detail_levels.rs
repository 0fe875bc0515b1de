//! Levels of detail (model §16): when cells of 2, 4 or 8 voxels along every axis may stand for these.
//!
//! ```text
//! v          = ∫ x² h / ∫ h                 variance of the kernel along an axis
//! stretch²   = s²/4ˡ − (1 − 4⁻ˡ)/(12 v)     of cells, where that of voxels is s: as wide together
//! variance   = (4ˡ − 1)/12                  of the depths of a cell's voxels, in steps of λ
//! a brick    by cells of the largest l that are stretched enough where it is nearest,
//!            variance · λ · contrast/2ˡ ≤ a share of the tolerance, and ½·√variance · λ · μ ≤ another
//! ```
//!
//! In the image plane nothing is lost: where a pixel covers some voxels their footprints are as wide as that
//! anyway, and cells only need to lie near enough to each other. In depth a cell's kernel is as thin as those
//! of its voxels, which it puts together in one place: that blurs the order in which things hide each other.
//! What a pixel can tell of that is as much as what changes places differs, and no more than how opaque it
//! is: the tolerance bounds both. [Numerics] has where they come from.
//!
//! In parallel rays all bricks are equally near. They change their level one after the other all the same, or
//! a zoom would show it.
//!
//! [Numerics]: https://github.com/slabsplat/slabsplat/blob/main/docs/numerics.md

use crate::{ErrorBudget, Kernel};

/// What cells are made of a kernel's voxels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DetailLevels {
    kernel_variance: f64,
    budget: ErrorBudget,
}

/// What a brick of cells must not exceed to be drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellLimits {
    /// Difference of lit colours between layers of cells that follow each other, times extinction per voxel
    /// step.
    pub contrast: f64,
    /// The same between single cells side by side, the root of the mean of squares.
    pub noise: f64,
    /// Mean extinction of a cell's voxels, per voxel step.
    pub extinction: f64,
    /// The same in bricks whose cells are lit by mean normals alone; others need second moments of these.
    pub by_mean_normals: f64,
}

impl CellLimits {
    /// Whether a brick may be drawn whose cells differ so much in colours, normals and `noise`, and whose
    /// most opaque one has that mean extinction per voxel step; lit colours differ by `lit` where colours
    /// do by 1, and where normals do.
    pub fn allow(&self, lit: [f64; 2], differ: [f32; 2], noise: f32, extinction: f32) -> bool {
        let contrast: f64 = lit.iter().zip(differ).map(|(lit, by)| lit * f64::from(by)).sum();
        contrast <= self.contrast
            && f64::from(noise) <= self.noise
            && f64::from(extinction) <= self.extinction
    }
}

/// The coarsest level: a brick of cells has 64³ voxels.
const MAX_LEVEL: u32 = MIN_STRETCH.len() as u32;

/// Cells along every axis, at least. Those at the ends of a grid may hold fewer voxels than their place has
/// room for, which of a small volume is a large part.
const LEAST_CELLS: usize = 8;

/// The narrowest footprints that cells of each level may have, against those of voxels on a grid of their
/// own. At 0.95 the sum of all is uneven by twice as much as it is at 1: 3·10⁻³, if these are Gaussians. The
/// coarser a level, the deeper is what lies behind a pixel, and the more it shows of the tails of footprints
/// at a silhouette.
const MIN_STRETCH: [f64; 3] = [0.95, 1.1, 1.3];

/// By how much more footprints of cells must be stretched in the last of all bricks than in the first.
const RANGE_OF_STRETCH: f64 = 1.0 / 24.0;

/// Multiples of these, modulo 1, are as far from each other as they can be (the additive recurrence of three
/// dimensions, [Roberts 2018]): bricks side by side change their level far from each other.
///
/// [Roberts 2018]: https://extremelearning.com.au/unreasonable-effectiveness-of-quasirandom-sequences/
const TURNS: [f64; 3] = [0.8191725133961645, 0.6710436067037893, 0.5497004779019703];

/// The share of bricks that may be drawn by cells of a level, from 1 on, where footprints of these are
/// stretched so far ([`View::stretch`]): none, all, or between both those that come first
/// ([`turn_of_brick`]).
///
/// [`View::stretch`]: slabsplat_core::View::stretch
pub fn share_by_cells(level: u32, stretch: f64) -> f64 {
    let from_first = stretch / MIN_STRETCH[level as usize - 1] - 1.0;
    (from_first / RANGE_OF_STRETCH).clamp(0.0, 1.0)
}

/// When a brick with those indices changes its level, 0 … 1: if a larger share of all does.
pub fn turn_of_brick(brick: [usize; 3]) -> f64 {
    let turn: f64 = brick.into_iter().zip(TURNS).map(|(at, step)| at as f64 * step).sum();
    turn.fract()
}

/// Shells of a kernel by which its variance is found, to five digits.
const N_SHELLS: u32 = 256;

impl DetailLevels {
    /// Those of a kernel that a picture's budget allows.
    pub fn new(kernel: &dyn Kernel, budget: ErrorBudget) -> Self {
        Self { kernel_variance: variance(kernel), budget }
    }

    /// The variance of the kernel along any axis, in voxel steps.
    pub fn kernel_variance(&self) -> f64 {
        self.kernel_variance
    }

    /// The coarsest level by which anything of a layer may be drawn, whose shortest axis has so many voxels,
    /// and whose voxels' footprints are stretched by up to `stretch` ([`View::stretch`]); 0 if only by its
    /// voxels.
    ///
    /// [`View::stretch`]: slabsplat_core::View::stretch
    pub fn coarsest(&self, stretch: f64, least_dim: usize) -> u32 {
        if self.budget.is_exact() {
            return 0;
        }
        let has_cells = |level: &u32| LEAST_CELLS << level <= least_dim;
        let is_wide_enough = |level: &u32| self.least_stretch(*level) <= stretch;
        (1..=MAX_LEVEL).take_while(has_cells).take_while(is_wide_enough).last().unwrap_or(0)
    }

    /// How far footprints of voxels are stretched where any cells of a level may be drawn, at least.
    fn least_stretch(&self, level: u32) -> f64 {
        let n_voxels = 4_f64.powi(level as i32);
        let spread = (1.0 - 1.0 / n_voxels) / (12.0 * self.kernel_variance);
        let least = MIN_STRETCH[level as usize - 1];
        (n_voxels * (least * least + spread)).sqrt()
    }

    /// What bricks of cells of a level are drawn, of a layer whose kernel has the half-depth `λ` over its
    /// radius, in `unit`s. `lit` is by how much colours differ at most whose normals differ by 1; 0 without
    /// light.
    pub fn limits(&self, level: u32, layer_depth: f64, lit: f64) -> CellLimits {
        let side = 2_f64.powi(level as i32);
        let [by_mean_normals, by_moments] = self.budget.light_of_cells().map(|mu| mu / (lit * lit));
        let in_depth = self.budget.opaque_cells() / (depth(level) * layer_depth);
        CellLimits {
            contrast: self.budget.cells() / (variance_of_depth(level) / side * layer_depth),
            noise: self.budget.noise_of_cells() / (depth(level) * layer_depth),
            extinction: in_depth.min(by_moments),
            by_mean_normals,
        }
    }
}

/// How many steps' worth of extinction cells move across any face of a medium, forward or backward, at most:
/// half of what a voxel is moved by on the average, which is no more than half of the standard deviation.
fn depth(level: u32) -> f64 {
    0.5 * variance_of_depth(level).sqrt()
}

/// Of the voxels of a cell, in voxel steps.
fn variance_of_depth(level: u32) -> f64 {
    (4_f64.powi(level as i32) - 1.0) / 12.0
}

fn variance(kernel: &dyn Kernel) -> f64 {
    let [mut of_all, mut squares] = [0.0; 2];
    for shell in 0..N_SHELLS {
        let r = (f64::from(shell) + 0.5) / f64::from(N_SHELLS) * kernel.radius();
        let of_shell = kernel.value(r) * r * r;
        of_all += of_shell;
        squares += of_shell * r * r / 3.0;
    }
    squares / of_all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{KERNEL_NAMES, kernel_named};
    use slabsplat_core::{Mode, RenderSettings};

    fn levels(name: &str, tolerance: f64) -> DetailLevels {
        let settings = RenderSettings::default().tolerance(tolerance);
        DetailLevels::new(&*kernel_named(name).unwrap(), ErrorBudget::new(&settings))
    }

    /// Of a Gaussian `exp(−r²·2 ln 2)` without an end it is 1/(4 ln 2).
    #[test]
    fn detail_levels_know_the_variance() {
        let gaussian = levels("gaussian", 0.05).kernel_variance();
        assert!((gaussian - 0.36).abs() < 0.015, "{gaussian}");
        for name in KERNEL_NAMES {
            let kernel = kernel_named(name).unwrap();
            // Along x, from planes of footprints: ∫∫ x² F(√(x² + y²)) over ∫∫ F.
            let (n, radius) = (200, kernel.radius());
            let at = |idx: i32| (f64::from(idx) + 0.5) / f64::from(n) * radius;
            let [mut all, mut squares] = [0.0; 2];
            for (x, y) in (-n..n).flat_map(|x| (-n..n).map(move |y| (at(x), at(y)))) {
                let footprint = kernel.footprint(x.hypot(y));
                all += footprint;
                squares += x * x * footprint;
            }
            let found = levels(name, 0.05).kernel_variance();
            assert!((found - squares / all).abs() < 1e-3, "{name}: {found}");
        }
    }

    #[test]
    fn detail_levels_need_pixels_larger_than_voxels() {
        let at = |stretch| levels("gaussian", 0.05).coarsest(stretch, 99);
        assert_eq!([1.0, 2.0, 2.15, 4.6, 4.8, 10.8, 11.2, 1e9].map(at), [0, 0, 1, 1, 2, 2, 3, 3]);
        for level in 1..=MAX_LEVEL {
            let least = levels("gaussian", 0.05).least_stretch(level);
            assert_eq!([0.999, 1.001].map(|by| at(by * least)), [level - 1, level]);
        }
    }

    /// A tenth of all bricks in each tenth of the range, and those side by side far from each other.
    #[test]
    fn detail_levels_change_brick_by_brick() {
        let mut tenths = [0; 10];
        for brick in (0..1000).map(|idx| [idx % 10, idx / 10 % 10, idx / 100]) {
            tenths[(10.0 * turn_of_brick(brick)) as usize] += 1;
            for axis in 0..3 {
                let mut beside = brick;
                beside[axis] += 1;
                let apart = (turn_of_brick(beside) - turn_of_brick(brick)).abs();
                assert!(0.15 < apart.min(1.0 - apart), "{brick:?}, {beside:?}: {apart}");
            }
        }
        assert!(tenths.iter().all(|n| (90..=110).contains(n)), "{tenths:?}");
        for (level, least) in (1..).zip(MIN_STRETCH) {
            let share =
                |of_range: f64| share_by_cells(level, least * (1.0 + of_range * RANGE_OF_STRETCH));
            let [before, first, quarter, all] = [-1.0, 0.0, 0.25, 1.0001].map(share);
            assert_eq!((before, first, all), (0.0, 0.0, 1.0));
            assert!((quarter - 0.25).abs() < 1e-9);
        }
    }

    #[test]
    fn detail_levels_spend_the_tolerance() {
        let at = |level, layer_depth| levels("gaussian", 0.05).limits(level, layer_depth, 0.0);
        // Two voxels lie half a step before and behind their middle.
        let CellLimits { contrast, noise, extinction, by_mean_normals } = at(1, 1.0);
        assert_eq!(by_mean_normals, f64::INFINITY, "no light");
        let (limits, lit) = (at(1, 1.0), [1.0, 0.5]);
        assert!(limits.allow(lit, [0.5, 0.5], 0.009, 0.49), "0.75 of 0.8");
        for (differ, noise, extinction) in
            [([0.5, 0.7], 0.0, 0.0), ([0.0; 2], 0.011, 0.0), ([0.0; 2], 0.0, 0.51)]
        {
            assert!(!limits.allow(lit, differ, noise, extinction), "{differ:?} {noise}");
        }
        let lit = levels("gaussian", 0.05).limits(1, 1.0, 2.0);
        assert!((lit.by_mean_normals - 0.0225 / 4.0).abs() < 1e-12);
        assert!((lit.extinction - 0.49 / 4.0).abs() < 1e-12, "bright light");
        assert!((noise - 0.01).abs() < 1e-12, "of white noise of extinction 0.04");
        assert!((contrast - 0.8).abs() < 1e-12 && (extinction - 0.5).abs() < 1e-12);
        assert_eq!(at(1, 2.0).contrast, 0.5 * contrast, "deep kernels");
        assert!((at(2, 1.0).contrast / contrast - 0.4).abs() < 1e-12);
        assert_eq!(levels("gaussian", 0.0).coarsest(100.0, 99), 0, "exact");
        let separate = RenderSettings::default().mode(Mode::Separate);
        let kernel = kernel_named("gaussian").unwrap();
        let levels = DetailLevels::new(&*kernel, ErrorBudget::new(&separate));
        assert_eq!(levels.coarsest(100.0, 99), 0, "colours that are no sums");
    }

    #[test]
    fn detail_levels_are_for_volumes_of_some_cells() {
        let of = |least_dim| levels("gaussian", 0.05).coarsest(100.0, least_dim);
        assert_eq!([1, 15, 16, 31, 32, 63, 64, 9999].map(of), [0, 0, 1, 1, 2, 2, 3, 3]);
    }
}
