//! Levels of detail (model §16): when cells of 2, 4 or 8 voxels along every axis may stand for these.
//!
//! ```text
//! v          = ∫ x² h / ∫ h                 variance of the kernel along an axis
//! stretch²   = s²/4ˡ − (1 − 4⁻ˡ)/(12 v)     of cells, where that of voxels is s: as wide together
//! depth      √((4ˡ − 1) / 12) / 2            what a cell is before or behind its voxels, in voxel steps
//! level      = the largest l with stretch ≥ 0.95, depth · λ · μ ≤ tolerance/4, and 8 cells along every axis
//! ```
//!
//! In the image plane nothing is lost: where a pixel covers some voxels their footprints are as wide as that
//! anyway, and cells only need to lie near enough to each other. In depth a cell's kernel is as thin as those
//! of its voxels, which it puts together in one place: that blurs the order in which things hide each other,
//! and is what the tolerance bounds. [Numerics] has where both come from.
//!
//! [Numerics]: https://github.com/slabsplat/slabsplat/blob/main/docs/numerics.md

use crate::{ErrorBudget, Kernel};

/// What cells are made of a kernel's voxels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DetailLevels {
    kernel_variance: f64,
    budget: ErrorBudget,
}

/// A layer as far as levels of detail go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DetailView {
    /// By how much footprints of voxels are stretched, where they are least ([`View::stretch`]).
    ///
    /// [`View::stretch`]: slabsplat_core::View::stretch
    pub stretch: f64,
    /// `λ`: the kernel's half-depth over its radius, in `unit`s.
    pub layer_depth: f64,
    /// `μ` of the most opaque voxel.
    pub extinction: f64,
    /// Voxels along the shortest axis of the grid.
    pub least_dim: usize,
}

/// The coarsest level: a brick of cells has 64³ voxels.
const MAX_LEVEL: u32 = 3;

/// Cells along every axis, at least. Those at the ends of a grid may hold fewer voxels than their place has
/// room for, which of a small volume is a large part.
const LEAST_CELLS: usize = 8;

/// The narrowest footprints that cells may have, against those of voxels on a grid of their own. At 0.95 the
/// sum of all is uneven by twice as much as it is at 1: 3·10⁻³, if these are Gaussians.
const MIN_STRETCH: f64 = 0.95;

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

    /// The coarsest level by which a layer may be drawn; 0 if only by its voxels.
    pub fn coarsest(&self, view: DetailView) -> u32 {
        let is_allowed = |level: &u32| self.is_wide_enough(*level, view.stretch);
        let is_faint =
            |level: &u32| depth(*level) * view.layer_depth * view.extinction <= self.budget.cells();
        let has_cells = |level: &u32| LEAST_CELLS << level <= view.least_dim;
        let levels = (1..=MAX_LEVEL).take_while(has_cells).take_while(is_allowed);
        levels.take_while(is_faint).last().unwrap_or(0)
    }

    fn is_wide_enough(&self, level: u32, stretch: f64) -> bool {
        let n_cells = 0.25_f64.powi(level as i32);
        let spread = (1.0 - n_cells) / (12.0 * self.kernel_variance);
        MIN_STRETCH * MIN_STRETCH <= stretch * stretch * n_cells - spread
    }
}

/// How many steps' worth of extinction cells move across any face of a medium, forward or backward, at most:
/// half of what a voxel is moved by on the average, which is no more than half of the standard deviation.
fn depth(level: u32) -> f64 {
    0.5 * ((4_f64.powi(level as i32) - 1.0) / 12.0).sqrt()
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

    /// Of a Gaussian `exp(−r²·2 ln 2)` that goes on for ever it is 1/(4 ln 2).
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
        let levels = levels("gaussian", 0.05);
        let at = |stretch| {
            levels.coarsest(DetailView {
                stretch,
                layer_depth: 1.0,
                extinction: 1e-6,
                least_dim: 99,
            })
        };
        assert_eq!([1.0, 2.0, 2.15, 4.1, 4.4, 8.3, 9.0, 1e9].map(at), [0, 0, 1, 1, 2, 2, 3, 3]);
    }

    #[test]
    fn detail_levels_are_for_what_is_faint() {
        let with = |layer_depth, extinction, tolerance| {
            let view = DetailView { stretch: 100.0, layer_depth, extinction, least_dim: 99 };
            levels("gaussian", tolerance).coarsest(view)
        };
        assert_eq!([0.01, 0.02, 0.049, 0.051].map(|mu| with(1.0, mu, 0.05)), [3, 2, 1, 0]);
        assert_eq!([0.01, 0.02, 0.049].map(|mu| with(1.7, mu, 0.05)), [2, 1, 0], "deep kernels");
        assert_eq!([0.002, 0.0095, 0.0105].map(|mu| with(1.0, mu, 0.01)), [3, 1, 0]);
        assert_eq!(with(1.0, 1e-9, 0.0), 0, "exact");
        let separate = RenderSettings::default().mode(Mode::Separate);
        let kernel = kernel_named("gaussian").unwrap();
        let levels = DetailLevels::new(&*kernel, ErrorBudget::new(&separate));
        let view = DetailView { stretch: 100.0, layer_depth: 1.0, extinction: 1e-9, least_dim: 99 };
        assert_eq!(levels.coarsest(view), 0, "colours that are no sums");
    }

    #[test]
    fn detail_levels_are_for_volumes_of_some_cells() {
        let of = |least_dim| {
            let levels = levels("gaussian", 0.05);
            let [stretch, layer_depth, extinction] = [100.0, 1.0, 1e-9];
            levels.coarsest(DetailView { stretch, layer_depth, extinction, least_dim })
        };
        assert_eq!([1, 15, 16, 31, 32, 63, 64, 9999].map(of), [0, 0, 1, 1, 2, 2, 3, 3]);
    }
}
