//! The inverse cosine transform of 8 × 8 coefficients (T.81 §A.3.3), along rows and then along columns.

use std::f32::consts::{FRAC_1_SQRT_2, PI};

/// The transform, with its waves.
pub(super) struct Idct {
    /// `basis[x][u]` is C(u)/2 · cos((2x + 1)uπ/16).
    basis: [[f32; 8]; 8],
}

impl Idct {
    pub(super) fn new() -> Self {
        let basis = |x: usize| {
            std::array::from_fn(|u| {
                let scale = if u == 0 { FRAC_1_SQRT_2 } else { 1.0 };
                scale / 2.0 * (((2 * x + 1) * u) as f32 * PI / 16.0).cos()
            })
        };
        Self { basis: std::array::from_fn(basis) }
    }

    /// Values of a block, rows first, without the level shift.
    pub(super) fn inverse(&self, coefficients: &[f32; 64]) -> [f32; 64] {
        let along_rows: [f32; 64] = std::array::from_fn(|at| {
            let (row, x) = (at / 8 * 8, at % 8);
            (0..8).map(|u| self.basis[x][u] * coefficients[row + u]).sum()
        });
        std::array::from_fn(|at| {
            let (y, column) = (at / 8, at % 8);
            (0..8).map(|v| self.basis[y][v] * along_rows[8 * v + column]).sum()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn idct_of_one_coefficient() {
        let mut coefficients = [0.0; 64];
        coefficients[0] = 800.0;
        let flat = Idct::new().inverse(&coefficients);
        assert!(flat.iter().all(|value| (value - 100.0).abs() < 1e-3), "{flat:?}");
        coefficients[0] = 0.0;
        coefficients[8] = 8.0;
        let waves = Idct::new().inverse(&coefficients);
        let expected = (PI / 16.0).cos() * std::f32::consts::SQRT_2;
        assert!((waves[7] - expected).abs() < 1e-5 && (waves[56] + expected).abs() < 1e-5);
    }
}
