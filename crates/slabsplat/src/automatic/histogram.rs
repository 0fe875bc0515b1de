//! How many voxels have values of which level, and what their surroundings are like; and what that says of
//! background, noise and materials.

use super::scale::Scale;
use crate::otsu;

/// Levels of the scale.
pub(super) const N_BINS: usize = 1024;

/// Standard deviations of noise that lie within the median deviation of it, of a normal distribution.
const DEVIATIONS_OF_MEDIAN: f64 = 1.4826;

/// Standard deviations beyond which noise is rare enough not to be seen: 0.6 % of it.
pub(super) const NOISE: f64 = 2.5;

/// Peaks for which the scale has room.
const PEAKS: usize = 64;

/// Share of voxels that an object has at least.
const LEAST_OBJECT: f64 = 1e-4;

/// What is known of the voxels of a level.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Bin {
    /// How many there are.
    pub(super) n: u64,
    /// How many have a neighbour along x with the same value.
    n_equal: u64,
    /// Sums of first and second differences along x, both halved.
    differences: [f64; 2],
}

/// Voxels by the level of their values.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Histogram {
    pub(super) scale: Scale,
    pub(super) bins: Vec<Bin>,
}

/// What lies around the object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Background {
    /// Its last level.
    pub(super) last: usize,
    /// Its most frequent value.
    pub(super) value: f64,
    /// The standard deviation of its noise.
    pub(super) noise: f64,
}

impl Histogram {
    pub(super) fn empty(scale: Scale) -> Self {
        Self { scale, bins: vec![Bin::default(); scale.n()] }
    }

    pub(super) fn add(&mut self, other: &Self) {
        for (bin, other) in self.bins.iter_mut().zip(&other.bins) {
            bin.n += other.n;
            bin.n_equal += other.n_equal;
            let [first, second] = other.differences;
            bin.differences[0] += first;
            bin.differences[1] += second;
        }
    }

    /// A voxel of a finite value.
    pub(super) fn add_voxel(&mut self, value: f64, [first, second]: [f64; 2], is_equal: bool) {
        let Some(level) = self.scale.level_of(value) else { return };
        let bin = &mut self.bins[level];
        bin.n += 1;
        bin.n_equal += u64::from(is_equal);
        bin.differences[0] += first;
        bin.differences[1] += second;
    }

    /// Voxels of the levels from `first` on.
    pub(super) fn n_from(&self, first: usize) -> u64 {
        self.bins[first.min(self.bins.len())..].iter().map(|bin| bin.n).sum()
    }

    /// The share of voxels from a level on, of all.
    pub(super) fn share_from(&self, first: usize) -> f64 {
        self.n_from(first) as f64 / self.n_from(0).max(1) as f64
    }

    /// The mean of values from a level on.
    pub(super) fn mean_from(&self, first: usize) -> f64 {
        let sum: f64 = (first..self.bins.len())
            .map(|level| self.bins[level].n as f64 * self.scale.middle(level))
            .sum();
        match self.n_from(first) {
            0 => self.scale.start(first),
            n => sum / n as f64,
        }
    }

    /// The value that the share `share` of the voxels from level `first` on do not exceed.
    pub(super) fn quantile_from(&self, first: usize, share: f64) -> f64 {
        let wanted = share * self.n_from(first) as f64;
        let mut n = 0;
        for level in first..self.bins.len() {
            n += self.bins[level].n;
            if wanted <= n as f64 && 0 < n {
                return self.scale.middle(level);
            }
        }
        self.scale.middle(self.bins.len() - 1)
    }

    /// The level with the most voxels among some.
    pub(super) fn most_frequent(&self, levels: std::ops::Range<usize>) -> usize {
        levels.rev().max_by_key(|&level| self.bins[level].n).unwrap_or(0)
    }

    /// Of the voxels from a level on, the share that has an equal neighbour.
    pub(super) fn evenness_from(&self, first: usize) -> f64 {
        let n_equal: u64 = self.bins[first.min(self.bins.len())..].iter().map(|b| b.n_equal).sum();
        n_equal as f64 / self.n_from(first).max(1) as f64
    }

    /// How rough values are from a level on: second differences over first ones. Of noise they are larger, as
    /// each voxel strays by itself; a smooth function has next to none.
    pub(super) fn roughness_from(&self, first: usize) -> f64 {
        let sum = |order: usize| -> f64 {
            self.bins[first.min(self.bins.len())..].iter().map(|bin| bin.differences[order]).sum()
        };
        sum(1) / sum(0).max(f64::MIN_POSITIVE)
    }

    /// What lies around the object: up to Otsu's threshold, or to the end of noise that this threshold parts.
    ///
    /// Noise is measured below the most frequent value, where nothing else is.
    pub(super) fn background(&self) -> Background {
        let threshold = self.split().last;
        let peak = self.peak(threshold);
        let below = self.bins[..peak].iter().rev().map(|bin| bin.n);
        let n: u64 = self.bins[..peak].iter().map(|bin| bin.n).sum();
        let deviation = match n {
            0 => 0,
            n => 1 + median(below, n),
        };
        let noise = DEVIATIONS_OF_MEDIAN * deviation as f64 * self.scale.width();
        let value = self.scale.middle(peak);
        let end = self.scale.level_of(value + NOISE * noise).unwrap_or(0);
        let last =
            if LEAST_OBJECT < self.share_from(end + 1) { end.max(threshold) } else { threshold };
        Background { last, value, noise }
    }

    /// The level up to `last` around which most voxels are.
    fn peak(&self, last: usize) -> usize {
        let radius = self.bins.len() / PEAKS;
        let around = |level: usize| -> u64 {
            let window = level.saturating_sub(radius)..(level + radius + 1).min(self.bins.len());
            self.bins[window].iter().map(|bin| bin.n).sum()
        };
        let peak = (0..=last).rev().max_by_key(|&level| around(level)).unwrap_or(0);
        // Around a single value all levels have as many.
        let window = peak.saturating_sub(radius)..(peak + radius + 1).min(self.bins.len());
        let most = self.most_frequent(window);
        if around(peak) < 2 * self.bins[most].n { most } else { peak }
    }

    /// How clearly Otsu's threshold parts the values, from 0 to 1, where both sides have one value each: the
    /// variance between the sides, of all.
    pub(super) fn separability(&self) -> f64 {
        let n = self.n_from(0).max(1) as f64;
        let sum = |power: i32| -> f64 {
            let of = |(level, bin): (usize, &Bin)| bin.n as f64 * (level as f64).powi(power);
            self.bins.iter().enumerate().map(of).sum::<f64>() / n
        };
        let variance = sum(2) - sum(1).powi(2);
        self.split().between / (n * n * variance.max(f64::MIN_POSITIVE))
    }

    /// The last level of the background, and the variance that parts it from the rest.
    fn split(&self) -> otsu::Split {
        otsu::split(&self.bins.iter().map(|bin| bin.n).collect::<Vec<_>>())
    }
}

/// The first index up to which half of `n` are.
fn median(counts: impl Iterator<Item = u64>, n: u64) -> usize {
    let mut n_before = 0;
    for (idx, count) in counts.enumerate() {
        n_before += count;
        if n <= 2 * n_before {
            return idx;
        }
    }
    0
}
