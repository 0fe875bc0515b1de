//! The rows of a table as polynomials of the squared distance, for backends with wide registers.
//!
//! A look-up in a [`SectionTable`] needs a square root, and two loads from places that differ for every pixel: the
//! one thing that vector units are bad at. A polynomial in `ρ²` needs neither: `ρ²` is what a pixel's place gives
//! at once, a handful of multiply-adds do 4, 8 or 16 pixels at a time, and a row blended from two neighbouring rows is
//! the polynomial with the blended coefficients.
//!
//! A row is fitted by least squares over the area of its disc (Legendre polynomials in `ρ²`, as `dρ² ∝ ρ dρ`): the
//! error's mean over the disc is then zero. That matters, since some hundred sections overlap in a pixel, where
//! errors of one sign would add up.

use crate::{FootprintTable, SectionTable, lerp_radial};

/// Most coefficients of a polynomial.
pub const MAX_COEFFICIENTS: usize = 12;

/// Numbers of coefficients that are tried, the least first.
const COEFFICIENT_COUNTS: [usize; 2] = [8, MAX_COEFFICIENTS];

/// A fit is good enough if its mean error is below this part of the largest weight.
const GOOD_ENOUGH: f64 = 1e-4;

/// Places in a disc at which a row is fitted, equally far apart in `ρ²`.
const N_NODES: usize = 512;

/// Rows of weights, each a polynomial in `x = 2·(ρ/R)² − 1`.
#[derive(Clone, Debug, PartialEq)]
pub struct RadialPolynomials {
    n_coefficients: usize,
    /// From the constant on; those from `n_coefficients` on are 0.
    rows: Vec<[f32; MAX_COEFFICIENTS]>,
}

impl RadialPolynomials {
    /// Fits the rows of a table of sections; row `n` is the table's.
    pub fn of_sections(table: &SectionTable) -> Self {
        let rows: Vec<&[f32]> = table.weights().chunks_exact(table.row_len()).collect();
        Self::of_rows(&rows)
    }

    /// Fits a footprint: one row.
    pub fn of_footprint(table: &FootprintTable) -> Self {
        Self::of_rows(&[table.row()])
    }

    fn of_rows(rows: &[&[f32]]) -> Self {
        let discs: Vec<f64> = rows.iter().map(|row| disc_of(row)).collect();
        let peak =
            rows.iter().flat_map(|row| *row).fold(0.0_f64, |peak, &w| peak.max(f64::from(w).abs()));
        let fit = |n_coefficients: usize| -> (Self, f64) {
            let fits: Vec<_> = (0..rows.len())
                .map(|idx| fit_row(rows[idx], domain(&discs, idx), n_coefficients))
                .collect();
            let worst = fits.iter().fold(0.0_f64, |worst, (_, error)| worst.max(*error));
            (Self { n_coefficients, rows: fits.into_iter().map(|(row, _)| row).collect() }, worst)
        };
        let [few, many] = COEFFICIENT_COUNTS;
        let (fitted, mean_error) = fit(few);
        if mean_error <= GOOD_ENOUGH * peak { fitted } else { fit(many).0 }
    }

    /// How many coefficients may differ from 0: 8 or 12.
    pub fn n_coefficients(&self) -> usize {
        self.n_coefficients
    }

    /// The coefficients of one row, from the constant on.
    #[inline]
    pub fn row(&self, row_idx: usize) -> &[f32; MAX_COEFFICIENTS] {
        &self.rows[row_idx]
    }

    /// Writes the coefficients a part `t` of the way from a row to the next, which there must be unless `t`
    /// is 0.
    #[inline(always)]
    pub fn blend(&self, row_idx: usize, t: f32, coefficients: &mut [f32; MAX_COEFFICIENTS]) {
        let near = &self.rows[row_idx];
        let far = &self.rows[(row_idx + 1).min(self.rows.len() - 1)];
        for ((coefficient, near), far) in coefficients.iter_mut().zip(near).zip(far) {
            *coefficient = near + t * (far - near);
        }
    }

    /// The weight that a row has at `x`.
    pub fn weight(&self, row_idx: usize, x: f32) -> f32 {
        self.rows[row_idx].iter().rev().fold(0.0, |sum, coefficient| sum * x + coefficient)
    }
}

/// Where a row's disc ends, as a part of `R²`: rows begin at the edge, with a 0 for every place outside of it.
fn disc_of(row: &[f32]) -> f64 {
    let n_samples = row.len() - 2;
    let n_outside = row.iter().take_while(|weight| **weight == 0.0).count();
    let edge = n_outside.saturating_sub(1) as f64 / n_samples as f64;
    (1.0 - edge * edge).max(0.0)
}

/// Over what part of `R²` a row is fitted: where it or a neighbour, with which it may be blended, is not 0; and
/// at least over a half, as the powers of a polynomial that fits a small part cancel to the last digit.
fn domain(discs: &[f64], idx: usize) -> f64 {
    let near = &discs[idx.saturating_sub(1)..(idx + 2).min(discs.len())];
    near.iter().fold(0.5, |domain: f64, disc| domain.max(*disc))
}

/// The polynomial in `x` that fits a row over `domain`, and its mean error there.
fn fit_row(row: &[f32], domain: f64, n_coefficients: usize) -> ([f32; MAX_COEFFICIENTS], f64) {
    let n_samples = (row.len() - 2) as f64;
    let nodes = (0..N_NODES).map(|node| (node as f64 + 0.5) / N_NODES as f64);
    let weights: Vec<(f64, f64)> = nodes
        .map(|part| {
            let half_chord = (1.0 - part * domain).max(0.0).sqrt();
            (2.0 * part - 1.0, f64::from(lerp_radial(row, (half_chord * n_samples) as f32)))
        })
        .collect();
    let mut legendre = [0.0; MAX_COEFFICIENTS];
    for &(y, weight) in &weights {
        for (k, value) in legendre_values(y).into_iter().enumerate().take(n_coefficients) {
            legendre[k] += (2 * k + 1) as f64 * weight * value / N_NODES as f64;
        }
    }
    let value =
        |y: f64| -> f64 { legendre_values(y).iter().zip(legendre).map(|(p, c)| p * c).sum() };
    let error: f64 = weights.iter().map(|&(y, weight)| (value(y) - weight).abs()).sum();
    (in_powers(&legendre, domain).map(|coefficient| coefficient as f32), error / N_NODES as f64)
}

/// The Legendre polynomials at `y`, −1 … 1.
fn legendre_values(y: f64) -> [f64; MAX_COEFFICIENTS] {
    let mut values = [1.0; MAX_COEFFICIENTS];
    values[1] = y;
    for k in 2..MAX_COEFFICIENTS {
        let n = k as f64;
        values[k] = ((2.0 * n - 1.0) * y * values[k - 1] - (n - 1.0) * values[k - 2]) / n;
    }
    values
}

/// A sum of Legendre polynomials in `y`, in powers of `x`: `y = ((x + 1)/domain) − 1`.
fn in_powers(legendre: &[f64; MAX_COEFFICIENTS], domain: f64) -> [f64; MAX_COEFFICIENTS] {
    let times_y = |p: &[f64; MAX_COEFFICIENTS]| -> [f64; MAX_COEFFICIENTS] {
        let (slope, constant) = (1.0 / domain, 1.0 / domain - 1.0);
        std::array::from_fn(|k| constant * p[k] + if 0 < k { slope * p[k - 1] } else { 0.0 })
    };
    let mut before = [0.0; MAX_COEFFICIENTS];
    let mut here = [0.0; MAX_COEFFICIENTS];
    here[0] = 1.0;
    let mut sum = [0.0; MAX_COEFFICIENTS];
    for (k, weight) in legendre.iter().enumerate() {
        let n = k as f64;
        for (sum, power) in sum.iter_mut().zip(here) {
            *sum += weight * power;
        }
        let by_y = times_y(&here);
        let next = std::array::from_fn(|i| ((2.0 * n + 1.0) * by_y[i] - n * before[i]) / (n + 1.0));
        (before, here) = (here, next);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{KERNEL_NAMES, SectionDesc, TableDesc, kernel_named};
    use slabsplat_core::{Lookup, Normalization};

    /// Largest and mean difference from the exact integral over the whole disc of radius `R`, at rows and
    /// half way between them.
    fn errors(name: &str, width: f64, normalization: Normalization) -> (f64, f64) {
        let kernel = kernel_named(name).unwrap();
        let desc =
            SectionDesc { kernel: &*kernel, width, kappa: 1.0, normalization, base_width: 0.5 };
        let table = TableDesc { sections: 128, radial_samples: 256, lookup: Lookup::Linear };
        let table = SectionTable::new(&desc, table);
        let polynomials = RadialPolynomials::of_sections(&table);
        let radius = kernel.radius();
        let (mut worst, mut sum, mut n) = (0.0_f64, 0.0, 0.0);
        for step in 1..2 * table.n_rows() - 2 {
            let reach = 0.5 * step as f64 / f64::from(table.rows().rows_per_index);
            let front = reach - radius - width;
            let near = (-(front + width)).max(front).max(0.0);
            for i in 0..200 {
                let part = (f64::from(i) + 0.4) / 200.0;
                let rho = radius * part.sqrt();
                let exact = desc.weight(rho, front);
                let x = (2.0 * part - 1.0) as f32;
                let fitted = 0.5
                    * (polynomials.weight(step / 2, x) + polynomials.weight(step.div_ceil(2), x));
                let inside = rho * rho < radius * radius - near * near;
                let error = if inside { (f64::from(fitted) - exact).abs() } else { 0.0 };
                (worst, sum, n) = (worst.max(error), sum + error, n + 1.0);
            }
        }
        (worst, sum / n)
    }

    #[test]
    fn polynomials_are_the_sections() {
        for &name in KERNEL_NAMES {
            for width in [0.25, 0.5, 1.0, 2.0, 4.0] {
                let (worst, mean) = errors(name, width, Normalization::None);
                println!("{name} w={width}: {worst:.1e} (mean {mean:.1e})");
                // The largest errors of crawfis-max are at the very centre, where it has a kink in ρ².
                let most = if name == "gaussian" { [2.5e-4, 1e-5] } else { [1.3e-3, 4e-5] };
                assert!(worst < most[0] && mean < most[1], "{name} w={width}: {worst} {mean}");
            }
            let (worst, mean) = errors(name, 2.0, Normalization::Product);
            println!("{name} product: {worst:.1e} (mean {mean:.1e})");
            assert!(worst < 6e-4 && mean < 3e-5, "{name} product: {worst} {mean}");
        }
    }

    #[test]
    fn polynomials_of_the_default_kernel_are_short() {
        let kernel = kernel_named("gaussian").unwrap();
        let footprint = RadialPolynomials::of_footprint(&FootprintTable::new(&*kernel, 1.0, 256));
        assert_eq!(footprint.n_coefficients(), 8);
        for part in [0.0, 0.2, 0.5, 0.9, 0.99] {
            let exact = kernel.footprint(2.0 * f64::sqrt(part));
            let fitted = f64::from(footprint.weight(0, (2.0 * part - 1.0) as f32));
            assert!((fitted - exact).abs() < 2.5e-4, "{part}: {fitted} {exact}");
        }
    }
}
