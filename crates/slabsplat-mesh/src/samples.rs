//! Where a pixel is sampled.

/// Samples of a pixel.
pub const N_SAMPLES: usize = 8;

/// The row of the sample in each eighth of a pixel's width. No two are in one row, one column or one
/// diagonal, so that edges of any slope are met by one after the other.
const ROWS: [usize; N_SAMPLES] = [4, 6, 0, 2, 7, 5, 3, 1];

/// Where they are, in pixels from its upper left corner.
pub(crate) const SAMPLES: [[f64; 2]; N_SAMPLES] = {
    let mut samples = [[0.0; 2]; N_SAMPLES];
    let mut column = 0;
    while column < N_SAMPLES {
        samples[column] = [middle_of(column), middle_of(ROWS[column])];
        column += 1;
    }
    samples
};

/// Some samples of a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SampleSet(u8);

impl SampleSet {
    /// Those of a pixel within a rectangle, or on its rim: exactly, as all numbers are.
    #[inline(always)]
    pub(crate) fn within([min, max]: [[f64; 2]; 2], pixel: [f64; 2]) -> Self {
        let mut bits = 0;
        for (sample, place) in SAMPLES.iter().enumerate() {
            let [x, y] = [pixel[0] + place[0], pixel[1] + place[1]];
            let is_within = (min[0] <= x) & (x <= max[0]) & (min[1] <= y) & (y <= max[1]);
            bits |= u8::from(is_within) << sample;
        }
        Self(bits)
    }

    pub(crate) fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Their numbers, rising.
    #[inline(always)]
    pub(crate) fn iter(self) -> impl Iterator<Item = usize> {
        let mut bits = self.0;
        std::iter::from_fn(move || {
            let next = bits.trailing_zeros() as usize;
            bits &= bits.wrapping_sub(1);
            (next < N_SAMPLES).then_some(next)
        })
    }
}

const fn middle_of(eighth: usize) -> f64 {
    (2 * eighth + 1) as f64 / (2 * N_SAMPLES) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_share_no_row_column_or_diagonal() {
        for (idx, a) in SAMPLES.iter().enumerate() {
            for b in &SAMPLES[..idx] {
                let [across, down] = [0, 1].map(|axis| (a[axis] - b[axis]).abs());
                assert!(0.0 < across && 0.0 < down && across != down, "{a:?} {b:?}");
            }
        }
        let [min, max] = [[3.0 - 0.25, 7.0], [3.25, 8.0]];
        let some = SampleSet::within([min, max], [3.0, 7.0]);
        assert_eq!(some.iter().collect::<Vec<_>>(), [0, 1]);
        assert!(SampleSet::within([min, max], [4.0, 7.0]).is_empty());
        let rim = SampleSet::within([SAMPLES[3], SAMPLES[3]], [0.0; 2]);
        assert_eq!(rim.iter().collect::<Vec<_>>(), [3]);
        let mean = |axis: usize| SAMPLES.iter().map(|s| s[axis]).sum::<f64>() / N_SAMPLES as f64;
        assert_eq!([mean(0), mean(1)], [0.5; 2]);
    }
}
