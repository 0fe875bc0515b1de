//! What parts an object from its background, by how often each value is (N. Otsu, "A threshold selection
//! method from gray-level histograms", IEEE Trans. SMC 9(1), 1979).

/// Counts, parted into two sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Split {
    /// The last index of the lower side.
    pub(crate) last: usize,
    /// The variance between the sides, times the square of how many there are.
    pub(crate) between: f64,
}

/// The split with the largest variance between its sides, or the middle of such splits if a gap in the values
/// makes many of them equal. Of fewer than two counts that are not 0 the variance is 0.
pub(crate) fn split(counts: &[u64]) -> Split {
    let n_splits = counts.len().saturating_sub(1);
    let moments = || counts.iter().enumerate().map(|(idx, &n)| (n as f64, idx as f64 * n as f64));
    let (total, total_moment) =
        moments().fold((0.0, 0.0), |(n, m), (n_here, m_here)| (n + n_here, m + m_here));
    let (mut below, mut moment_below) = (0.0, 0.0);
    let (mut best, mut first, mut last) = (0.0, 0, 0);
    for (idx, (n, moment)) in moments().enumerate().take(n_splits) {
        below += n;
        moment_below += moment;
        let above = total - below;
        let apart = moment_below / below - (total_moment - moment_below) / above;
        let between = below * above * apart * apart;
        if best < between {
            (best, first, last) = (between, idx, idx);
        } else if best == between {
            last = idx;
        }
    }
    Split { last: usize::midpoint(first, last), between: best }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the definition: the variance between the two sides' means.
    #[test]
    fn split_is_otsus() {
        let counts = [5, 9, 4, 0, 1, 0, 7, 8, 2_u64];
        let mean = |idxs: std::ops::Range<usize>| -> (f64, f64) {
            let n: u64 = counts[idxs.clone()].iter().sum();
            let sum: f64 = idxs.map(|idx| idx as f64 * counts[idx] as f64).sum();
            (n as f64, sum / n as f64)
        };
        let between = |last: usize| {
            let ((n, low), (m, high)) = (mean(0..last + 1), mean(last + 1..counts.len()));
            n * m * (high - low).powi(2)
        };
        let best = (0..counts.len() - 1).map(between).fold(0.0, f64::max);
        let found = split(&counts);
        assert!((found.between / best - 1.0).abs() < 1e-12, "{found:?}, not {best}");
        assert!((between(found.last) / best - 1.0).abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn split_is_in_the_middle_of_a_gap() {
        let counts = |counts: &[u64]| split(counts).last;
        assert_eq!(counts(&[3, 0, 0, 0, 3]), 1);
        assert_eq!(counts(&[3, 3]), 0);
        for nothing in [&[][..], &[7], &[0, 7, 0]] {
            assert_eq!(split(nothing).between, 0.0, "{nothing:?}");
        }
    }
}
