//! Separable sections: one function of the column times the same one of the row.
//!
//! A Gaussian is such a product, and a slab parallel to the image cuts its sections to one shape: they differ
//! by a factor. Only its end at `R` spoils that, by some thousandths of a footprint's peak. Of a product the
//! sum over many voxels can be taken along columns and along rows one after the other, which is cheaper by
//! far; so it is what faint voxels are drawn as.
//!
//! The function, the *profile* `g`, is the first singular vector of the whole footprint `F(√(x² + y²))`: no
//! other product is nearer to it in the mean square (Eckart and Young 1936). It is scaled so that `g(x)·g(y)`
//! integrates to 1, and a section's factor is its integral. So sections keep all their extinction, those of a
//! voxel still sum to the whole, and what is as dense everywhere looks just as it should.

use crate::radial_polynomials::polynomial;
use crate::{MAX_COEFFICIENTS, RadialPolynomials, SectionTable, lerp_radial};

/// Places along a radius at which footprints are compared and integrated.
const N_PLACES: usize = 20;

/// Rounds of the power iteration; the second singular value is a few hundredths of the first at most.
const N_ROUNDS: usize = 8;

/// Samples of the profile, from its edge to its middle.
const N_SAMPLES: usize = 256;

/// What stands for the sections of two tables.
#[derive(Clone, Debug, PartialEq)]
pub struct SeparableSections {
    profile: [f32; MAX_COEFFICIENTS],
    /// Of each row of the sections, and then of the merged ones: its factor, and how much more the next row
    /// has.
    factors: Vec<[f32; 2]>,
    n_sections: usize,
    error: f64,
}

impl SeparableSections {
    /// Those of sections, and of what lies beyond a face; the last row of `merged` must be the whole
    /// footprint.
    pub fn new(sections: &SectionTable, merged: &SectionTable) -> Self {
        let radius = f64::from(merged.rows().radius);
        let [section_rows, merged_rows] = [sections, merged].map(SectionTable::all_rows);
        let profile = profile_of(merged_rows[merged_rows.len() - 1], radius);
        let at_places: Vec<f64> =
            (0..N_PLACES).map(|place| value(&profile, place_of(place))).collect();
        let mut error = 0.0_f64;
        let mut factor = |row: &&[f32]| {
            let integral = integral_of(row, radius);
            for (i, j) in pairs() {
                let product = integral * at_places[i] * at_places[j];
                error = error.max((weight(row, i, j) - product).abs());
            }
            integral as f32
        };
        let mut factors = Vec::new();
        for rows in [&section_rows, &merged_rows] {
            let of_rows: Vec<f32> = rows.iter().map(&mut factor).collect();
            let next = of_rows.iter().skip(1).chain(of_rows.last());
            factors.extend(of_rows.iter().zip(next).map(|(factor, next)| [*factor, next - factor]));
        }
        Self { profile, factors, n_sections: section_rows.len(), error }
    }

    /// The coefficients of `g` as a polynomial in `x = 2·(u/R)² − 1`, from the constant on, `u` index units
    /// from the centre; no more than the first eight differ from 0. It is 0 for `u ≥ R`.
    pub fn profile(&self) -> &[f32; MAX_COEFFICIENTS] {
        &self.profile
    }

    /// `g(u)`, `u` given as a part of `R`.
    pub fn profile_at(&self, part: f64) -> f64 {
        value(&self.profile, part)
    }

    /// The factor of every row of the sections, and then of the merged ones: a section's integral over the
    /// image; and how much more the next row has.
    #[inline(always)]
    pub fn factors(&self) -> &[[f32; 2]] {
        &self.factors
    }

    /// Where the rows of the merged sections start.
    #[inline(always)]
    pub fn first_merged(&self) -> u32 {
        self.n_sections as u32
    }

    /// The factor of a whole footprint.
    #[inline(always)]
    pub fn whole(&self) -> f32 {
        self.factors[self.factors.len() - 1][0]
    }

    /// By how much any weight of any section is off at most.
    pub fn error(&self) -> f64 {
        self.error
    }
}

/// The middle of one of `N_PLACES` equal parts, as a part of `R`.
fn place_of(place: usize) -> f64 {
    (place as f64 + 0.5) / N_PLACES as f64
}

fn pairs() -> impl Iterator<Item = (usize, usize)> {
    (0..N_PLACES).flat_map(|i| (0..=i).map(move |j| (i, j)))
}

/// What a row of a table weighs in the `i`-th column and `j`-th row of places.
fn weight(row: &[f32], i: usize, j: usize) -> f64 {
    weight_at(row, place_of(i).powi(2) + place_of(j).powi(2))
}

/// At a squared distance, a part of `R²`.
fn weight_at(row: &[f32], distance_squared: f64) -> f64 {
    let half_chord = (1.0 - distance_squared).max(0.0).sqrt();
    f64::from(lerp_radial(row, (half_chord * (row.len() - 2) as f64) as f32))
}

/// `∫∫` of a row over the image, in rings of equal areas.
fn integral_of(row: &[f32], radius: f64) -> f64 {
    let n = 4 * N_PLACES;
    let ring = |ring: usize| weight_at(row, (ring as f64 + 0.5) / n as f64);
    std::f64::consts::PI * radius * radius / n as f64 * (0..n).map(ring).sum::<f64>()
}

/// The first singular vector of a footprint, as a polynomial.
fn profile_of(footprint: &[f32], radius: f64) -> [f32; MAX_COEFFICIENTS] {
    let mut vector = [1.0; N_PLACES];
    let along = |vector: &[f64; N_PLACES], squared: f64| -> f64 {
        let places = vector.iter().enumerate();
        places.map(|(j, v)| v * weight_at(footprint, squared + place_of(j).powi(2))).sum()
    };
    let integral = |values: &[f64]| 2.0 * radius / N_PLACES as f64 * values.iter().sum::<f64>();
    for _ in 0..N_ROUNDS {
        let next = std::array::from_fn(|i| along(&vector, place_of(i).powi(2)));
        let scale = 1.0 / integral(&next);
        vector = next.map(|value| value * scale);
    }
    let at_places: Vec<f64> = (0..N_PLACES).map(|i| along(&vector, place_of(i).powi(2))).collect();
    let scale = 1.0 / integral(&at_places);
    let sample = |sample: usize| {
        let half_chord = sample.min(N_SAMPLES) as f64 / N_SAMPLES as f64;
        (scale * along(&vector, 1.0 - half_chord * half_chord)) as f32
    };
    let samples: Vec<f32> = (0..N_SAMPLES + 2).map(sample).collect();
    RadialPolynomials::short(&samples)
}

fn value(profile: &[f32; MAX_COEFFICIENTS], part: f64) -> f64 {
    if 1.0 <= part.abs() {
        return 0.0;
    }
    f64::from(polynomial(profile, (2.0 * part * part - 1.0) as f32))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{KERNEL_NAMES, SectionDesc, TableDesc, kernel_named};
    use slabsplat_core::{Lookup, Normalization};

    fn separable(name: &str, width: f64) -> (SeparableSections, SectionTable) {
        let kernel = kernel_named(name).unwrap();
        let table = |width: f64| {
            let normalization = Normalization::None;
            let desc =
                SectionDesc { kernel: &*kernel, width, kappa: 1.0, normalization, base_width: 0.5 };
            let table = TableDesc { sections: 128, radial_samples: 256, lookup: Lookup::Linear };
            SectionTable::new(&desc, table)
        };
        let sections = table(width);
        (SeparableSections::new(&sections, &table(4.0)), sections)
    }

    /// `error` holds at places where nothing was compared, and separable sections keep what sections hold.
    #[test]
    fn separable_is_nearly_the_section() {
        for &name in KERNEL_NAMES {
            for width in [0.5, 1.0, 2.0] {
                let (separable, table) = separable(name, width);
                let rows = table.rows();
                let (mut worst, mut most_lost) = (0.0_f64, 0.0_f64);
                for step in 0..60 {
                    let front = -rows.radius - 1.0 + 0.05 * step as f32;
                    let back = front + width as f32;
                    let (row, t) = table.row_at(front, back);
                    let [factor, more] = separable.factors()[row].map(f64::from);
                    let factor = factor + f64::from(t) * more;
                    let mut lost = 0.0;
                    let n = 90;
                    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                        let [x, y] = [i, j].map(|c| (f64::from(c) + 0.5) / f64::from(n));
                        let rho = rows.radius * (x * x + y * y).sqrt() as f32;
                        let exact =
                            if rho < rows.radius { table.sample(rho, front, back) } else { 0.0 };
                        let product = factor * separable.profile_at(x) * separable.profile_at(y);
                        worst = worst.max((f64::from(exact) - product).abs());
                        lost += f64::from(exact) - product;
                    }
                    lost *= 4.0 * f64::from(rows.radius / n as f32).powi(2);
                    most_lost = most_lost.max(lost.abs());
                }
                println!("{name} w={width}: {:.2e} {worst:.2e} {most_lost:.1e}", separable.error());
                assert!(worst < 1.1 * separable.error() + 1e-5, "{name} {width}: {worst}");
                assert!(most_lost < 1e-3, "{name} {width}: {most_lost}");
            }
        }
    }

    /// What its end at `R` leaves of the Gaussian's being a product.
    #[test]
    fn separable_gaussian_is_close() {
        let (separable, _) = separable("gaussian", 1.0);
        assert!(separable.error() < 2.5e-3, "{}", separable.error());
        assert!((separable.whole() - 0.9993).abs() < 1e-3, "{}", separable.whole());
    }
}
