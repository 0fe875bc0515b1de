//! Levels of detail (model §16): when cells of 2, 4 or 8 voxels along every axis may stand for these.
//!
//! ```text
//! v          = ∫ x² h / ∫ h                 variance of the kernel along an axis
//! stretch²   = s²/4ˡ − (1 − 4⁻ˡ)/(12 v)     of cells, where that of voxels is s: as wide together
//! variance   = (4ˡ − 1)/12                  of the depths of a cell's voxels, in steps of λ
//! a brick    by cells of the largest l that are stretched enough where it is nearest,
//!            variance · λ · contrast/2ˡ ≤ a share of the tolerance, and √variance · λ · spread ≤ another
//! ```
//!
//! In the image plane nothing is lost: where a pixel covers some voxels their footprints are as wide as that
//! anyway, and cells only need to lie near enough to each other. In depth a cell's kernel is as thin as those
//! of its voxels, which it puts together in one place: that blurs the order in which things hide each other.
//! What a pixel can tell of that is as much as what changes places differs, from cell to cell and within
//! them, times how opaque it is: the tolerance bounds both. [Numerics] has where they come from.
//!
//! In parallel rays all bricks are equally near. They change their level one after the other all the same, or
//! a zoom would show it.
//!
//! [Numerics]: https://github.com/slabsplat/slabsplat/blob/main/docs/numerics.md

use crate::{ErrorBudget, Kernel};
use slabsplat_core::Phong;

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
    /// Standard deviation of lit colours among voxels side by side, times the same; and of the latter.
    pub spread: f64,
    /// The same before directions, and times the root of the extinction.
    pub noise: f64,
    /// Difference of colours before light between single cells side by side, the root of the mean of squares,
    /// times extinction; more of what has little contrast.
    pub step_noise: f64,
    /// Difference of lit colours over layers of cells as of `contrast`, without the extinction.
    pub little_contrast: f64,
    /// Mean extinction of a cell's voxels, per voxel step.
    pub extinction: f64,
    /// The same in bricks whose cells are lit by mean normals alone; others need second moments of these.
    pub by_mean_normals: f64,
}

/// How unlike the voxels of a brick of cells are, from wherever they are seen; all times extinction per voxel
/// step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CellDifferences {
    /// From one layer of cells to the next: colours, and normals.
    pub contrast: [f32; 2],
    /// Standard deviations among the voxels of some cells side by side: of colours; of what light makes of
    /// their directions, where 1 is the most that it makes of any; and the second times the mean colour.
    pub spread: [f32; 3],
    /// Of extinction alone.
    pub spread_of_extinction: f32,
    /// The root of the mean of squares over the brick: the first of `spread`, but times the root of the
    /// extinction; and differences of colours between cells side by side.
    pub noise: [f32; 2],
    /// The mean extinction of the most opaque cell's voxels.
    pub extinction: f32,
}

/// What light makes of differences, at most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LitDifferences {
    /// By how much lit colours differ where colours do by 1.
    pub colors: f64,
    /// By how much where normals do.
    pub normals: f64,
    /// The standard deviation of highlights where directions differ most.
    pub highlights: f64,
    /// That of diffuse light on white.
    pub diffuse: f64,
}

/// The standard deviations of `|n·l|` and of `max(n·l, 0)` where directions differ most: they are 0.29 and
/// 0.32 where all are alike likely, and 0.33 and 0.40 for von Mises–Fisher distributions of a mean length of
/// ½. No power of them has a larger one.
const OF_DIRECTIONS: [f64; 2] = [1.0 / 3.0, 0.41];

impl LitDifferences {
    /// Without light.
    pub const UNLIT: Self = Self { colors: 1.0, normals: 0.0, highlights: 0.0, diffuse: 0.0 };

    /// In the light of all `lights` together, in their brightest channel.
    pub fn new(phong: &Phong, lights: f64) -> Self {
        let [diffuse, specular] = [phong.diffuse, phong.specular].map(|share| share * lights);
        let [two_sided, one_sided] = OF_DIRECTIONS;
        let of_directions = if phong.two_sided { two_sided } else { one_sided };
        Self {
            colors: (phong.ambient + diffuse).max(1.0),
            normals: diffuse + specular,
            highlights: of_directions * specular,
            diffuse: of_directions * diffuse,
        }
    }
}

impl CellLimits {
    /// Whether a brick may be drawn whose cells differ so much, in such a light.
    pub fn allow(&self, lit: LitDifferences, differ: &CellDifferences) -> bool {
        let [color, normal] = differ.contrast.map(f64::from);
        let extinction = f64::from(differ.extinction);
        lit.colors * color + lit.normals * normal <= self.contrast
            && extinction <= self.extinction
            && (0.5 * extinction <= self.spread || self.allow_spread(lit, differ))
            && (f64::from(differ.noise[1]) <= self.step_noise || self.allow_noise(lit, differ))
    }

    /// Whether voxels are so much alike that it does not matter how opaque they are.
    fn allow_spread(&self, lit: LitDifferences, differ: &CellDifferences) -> bool {
        let [of_colors, of_directions, of_lit_colors] = differ.spread.map(f64::from);
        let of_light = lit.highlights * of_directions + lit.diffuse * of_lit_colors;
        (lit.colors * of_colors).hypot(of_light) <= self.spread
            && f64::from(differ.spread_of_extinction) <= self.spread
    }

    /// Whether colours are so much alike that it does not matter which of them a pixel sees.
    fn allow_noise(&self, lit: LitDifferences, differ: &CellDifferences) -> bool {
        let [color, _] = differ.contrast.map(f64::from);
        lit.colors * f64::from(differ.noise[0]) <= self.noise
            && lit.colors * color <= self.little_contrast * f64::from(differ.extinction)
    }
}

/// The coarsest level: a brick of cells has 64³ voxels.
const MAX_LEVEL: u32 = MIN_STRETCH.len() as u32;

/// Cells along every axis, at least. Those at the ends of a grid may hold fewer voxels than their place has
/// room for, which of a small volume is a large part.
const LEAST_CELLS: usize = 8;

/// The narrowest footprints that cells of each level may have, against those of voxels on a grid of their
/// own. At 0.87 the sum of all is uneven by 9·10⁻³ if these are Gaussians, which a pixel shows a third of at
/// most; and all that two voxels a pixel or more are seen of is drawn by cells.
const MIN_STRETCH: [f64; 3] = [0.87, 0.9, 0.9];

/// The same in bricks at an end of the grid, where a solid ends at once and along a whole face. The coarser a
/// level, the deeper is what lies behind a pixel, and the more it shows of the tails of footprints at such a
/// silhouette.
const MIN_STRETCH_AT_ENDS: [f64; 3] = [0.95, 1.1, 1.3];

/// By how much more footprints of cells must be stretched in the last of all bricks than in the first.
const RANGE_OF_STRETCH: f64 = 1.0 / 24.0;

/// Multiples of these, modulo 1, are as far from each other as they can be (the additive recurrence of three
/// dimensions, [Roberts 2018]): bricks side by side change their level far from each other.
///
/// [Roberts 2018]: https://extremelearning.com.au/unreasonable-effectiveness-of-quasirandom-sequences/
const TURNS: [f64; 3] = [0.8191725133961645, 0.6710436067037893, 0.5497004779019703];

/// The share of bricks that may be drawn by cells of a level: none, all, or between both those that come
/// first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShareByCells {
    /// Of those inside of the grid, 0 … 1.
    inside: f64,
    /// Of those at an end of it.
    at_ends: f64,
}

impl ShareByCells {
    /// That of a level, from 1 on, where footprints of cells are stretched so far ([`View::stretch`]).
    ///
    /// [`View::stretch`]: slabsplat_core::View::stretch
    pub fn new(level: u32, stretch: f64) -> Self {
        let share = |least: &[f64; 3]| {
            let from_first = stretch / least[level as usize - 1] - 1.0;
            (from_first / RANGE_OF_STRETCH).clamp(0.0, 1.0)
        };
        Self { inside: share(&MIN_STRETCH), at_ends: share(&MIN_STRETCH_AT_ENDS) }
    }

    /// The same in whole parts of so many, rounded down.
    #[must_use]
    pub fn in_parts_of(self, n: u32) -> Self {
        let n = f64::from(n);
        let [inside, at_ends] = [self.inside, self.at_ends].map(|share| (share * n).floor() / n);
        Self { inside, at_ends }
    }

    /// Whether the brick with those indices is among them.
    pub fn includes(&self, brick: [usize; 3], is_at_end: bool) -> bool {
        turn_of_brick(brick) < if is_at_end { self.at_ends } else { self.inside }
    }

    /// Whether all are.
    pub fn is_all(&self) -> bool {
        self.inside.min(self.at_ends) == 1.0
    }
}

/// When a brick with those indices changes its level, 0 … 1: if a larger share of all does.
fn turn_of_brick(brick: [usize; 3]) -> f64 {
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
    /// radius, in `unit`s.
    pub fn limits(&self, level: u32, layer_depth: f64, lit: LitDifferences) -> CellLimits {
        let side = 2_f64.powi(level as i32);
        let per_extinction = lit.normals * lit.normals;
        let [by_mean_normals, by_moments] =
            self.budget.light_of_cells().map(|mu| mu / per_extinction);
        CellLimits {
            contrast: self.budget.cells() / (variance_of_depth(level) / side * layer_depth),
            spread: self.budget.spread_of_cells() / (variance_of_depth(level).sqrt() * layer_depth),
            noise: self.budget.noise_of_cells(),
            step_noise: self.budget.steps_of_cells()
                / (0.5 * variance_of_depth(level).sqrt() * layer_depth),
            little_contrast: self.budget.contrast_of_cells(),
            extinction: by_moments,
            by_mean_normals,
        }
    }
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
        assert_eq!([1.0, 1.9, 1.96, 4.0, 4.1, 8.1, 8.2, 1e9].map(at), [0, 0, 1, 1, 2, 2, 3, 3]);
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
    }

    /// Those at an end of the grid later.
    #[test]
    fn detail_levels_are_shares_of_bricks() {
        let bricks: Vec<_> = (0..1000).map(|idx| [idx % 10, idx / 10 % 10, idx / 100]).collect();
        for (is_at_end, all_least) in [(false, MIN_STRETCH), (true, MIN_STRETCH_AT_ENDS)] {
            for (level, least) in (1..).zip(all_least) {
                let share = |of_range: f64| {
                    let share =
                        ShareByCells::new(level, least * (1.0 + of_range * RANGE_OF_STRETCH));
                    let among = |brick: &&[usize; 3]| share.includes(**brick, is_at_end);
                    assert_eq!(share.in_parts_of(1 << 20).is_all(), share.is_all());
                    (bricks.iter().filter(among).count(), share.is_all())
                };
                assert_eq!(share(-1.0), (0, false));
                assert_eq!(share(0.0), (0, false));
                assert!((240..=260).contains(&share(0.25).0), "{:?}", share(0.25));
                assert_eq!(share(1.0001), (1000, is_at_end));
            }
        }
        let half = ShareByCells { inside: 0.499, at_ends: 0.27 }.in_parts_of(4);
        assert_eq!(half, ShareByCells { inside: 0.25, at_ends: 0.25 });
    }

    #[test]
    fn detail_levels_spend_the_tolerance() {
        let unlit = LitDifferences::UNLIT;
        let at = |level, layer_depth| levels("gaussian", 0.05).limits(level, layer_depth, unlit);
        // Two voxels lie half a step before and behind their middle.
        let unlit_limits = at(1, 1.0);
        let CellLimits { contrast, spread, noise, step_noise, .. } = unlit_limits;
        let of_light = [unlit_limits.by_mean_normals, unlit_limits.extinction];
        assert_eq!(of_light, [f64::INFINITY; 2], "no light");
        assert!((contrast - 0.8).abs() < 1e-12);
        assert!((spread - 0.25).abs() < 1e-12, "of black and white of extinction 0.5");
        assert!((noise - 0.1).abs() < 1e-12, "of black and white of extinction 0.04");
        assert!((step_noise - 0.01).abs() < 1e-12, "of cells of such");
        assert!((unlit_limits.little_contrast - 0.2).abs() < 1e-12);
        let in_light = |normals| LitDifferences {
            normals,
            highlights: 0.1,
            diffuse: 0.2,
            ..LitDifferences::UNLIT
        };
        let of_light = |normals| levels("gaussian", 0.05).limits(1, 1.0, in_light(normals));
        assert!((of_light(2.0).by_mean_normals - 0.0225 / 4.0).abs() < 1e-12);
        assert!((of_light(2.0).extinction - 0.49 / 4.0).abs() < 1e-12, "bright light");
        let (lit, limits) = (in_light(0.5), of_light(1.0));
        let even = CellDifferences::default();
        let opaque = CellDifferences {
            contrast: [0.08, 0.5],
            spread: [0.2, 0.4, 0.4],
            spread_of_extinction: 0.24,
            noise: [0.09, 0.08],
            extinction: 0.48,
        };
        // Of extinction 0.5 all may differ in depth, were it not for light.
        let opaque_in_depth = CellDifferences { extinction: 0.6, ..opaque };
        assert!(limits.allow(lit, &opaque) && limits.allow(lit, &even));
        assert!(unlit_limits.allow(LitDifferences::UNLIT, &opaque_in_depth));
        for (beyond, limits) in [
            (CellDifferences { contrast: [0.5, 0.7], ..even }, limits),
            (CellDifferences { spread: [0.26, 0.0, 0.0], ..opaque_in_depth }, unlit_limits),
            (CellDifferences { spread_of_extinction: 0.26, ..opaque_in_depth }, unlit_limits),
            (CellDifferences { noise: [0.11, 0.02], ..opaque }, limits),
            (CellDifferences { contrast: [0.1, 0.0], ..opaque }, limits),
            (CellDifferences { extinction: 0.5, ..even }, limits),
        ] {
            assert!(!limits.allow(lit, &beyond), "{beyond:?}");
        }
        let in_light = CellLimits { extinction: 1.0, ..limits };
        let directions = CellDifferences { spread: [0.2, 0.6, 0.5], ..opaque_in_depth };
        assert!(unlit_limits.allow(LitDifferences::UNLIT, &directions));
        assert!(!in_light.allow(lit, &directions), "they are lit otherwise");
        let faint = CellDifferences { extinction: 0.49, ..directions };
        assert!(in_light.allow(lit, &faint), "faint, whatever is in it");
        let calm = CellDifferences { noise: [0.9, 0.009], ..opaque };
        assert!(limits.allow(lit, &calm), "alike from cell to cell, whatever is in these");
        assert_eq!(at(1, 2.0).contrast, 0.5 * contrast, "deep kernels");
        assert_eq!(at(1, 2.0).spread, 0.5 * spread, "deep kernels");
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
