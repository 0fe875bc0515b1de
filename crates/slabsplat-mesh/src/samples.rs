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
        let mean = |axis: usize| SAMPLES.iter().map(|s| s[axis]).sum::<f64>() / N_SAMPLES as f64;
        assert_eq!([mean(0), mean(1)], [0.5; 2]);
    }
}
