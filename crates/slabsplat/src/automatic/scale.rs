//! A scale of values in levels, on which whole numbers fall into the middle of theirs.

/// Levels of equal width over a range of values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scale {
    lo: f64,
    width: f64,
    step: f64,
    n: usize,
}

impl Scale {
    /// Up to `n` levels over `[lo, hi]`, each of a multiple of `step` values; `None` if nothing differs.
    pub(super) fn new([lo, hi]: [f64; 2], n: usize, step: f64) -> Option<Self> {
        let span = hi - lo;
        if !span.is_finite() || !span.is_normal() || span < 0.0 {
            return None;
        }
        if step == 0.0 {
            let width = span / n as f64;
            return width.is_normal().then_some(Self { lo, width, step, n });
        }
        let n_values = (span / step).round() + 1.0;
        let width = step * (n_values / n as f64).ceil();
        let n = (n_values * step / width).ceil() as usize;
        Some(Self { lo: lo - 0.5 * step, width, step, n })
    }

    /// How many levels there are.
    pub(super) fn n(&self) -> usize {
        self.n
    }

    /// Values of a level.
    pub(super) fn width(&self) -> f64 {
        self.width
    }

    /// Where a level begins.
    pub(super) fn start(&self, level: usize) -> f64 {
        self.lo + self.width * level as f64
    }

    /// The values of some levels that lie within a range.
    pub(super) fn values_of(&self, [first, last]: [usize; 2], [lo, hi]: [f64; 2]) -> [f64; 2] {
        let half = 0.5 * self.step;
        [(self.start(first) + half).max(lo), (self.start(last + 1) - half).min(hi)]
    }

    /// The middle of a level.
    pub(super) fn middle(&self, level: usize) -> f64 {
        self.lo + self.width * (level as f64 + 0.5)
    }

    /// The level of a finite value; beyond the ends that at the end.
    pub(super) fn level_of(&self, value: f64) -> Option<usize> {
        let level = (value - self.lo) / self.width;
        value.is_finite().then(|| (level.max(0.0) as usize).min(self.n - 1))
    }
}
