//! Separable sections: one function of the column times the same one of the row.
//!
//! A Gaussian is such a product, and a slab parallel to the image cuts its sections to one shape: they differ
//! by a factor. Only its end at `R` spoils that, by some thousandths of a footprint's peak. A sum of
//! products over many voxels is taken along columns first and along rows then, which is cheaper by far. So
//! faint voxels are drawn as products.
//!
//! The function, the *profile* `g`, is the first singular vector of the whole footprint `F(√(x² + y²))`: no
//! other product is nearer to it in the mean square (Eckart and Young 1936). It is scaled so that `g(x)·g(y)`
//! integrates to 1, and a section's factor is its integral. So sections keep all their extinction, those of a
//! voxel still sum to the whole, and what is as dense everywhere looks just as it should.

use crate::radial_polynomials::polynomial;
use crate::{MAX_COEFFICIENTS, RadialPolynomials, SectionTable, lerp_radial};
use slabsplat_core::{Cancelled, FrameHandle};

/// Points along a radius at which footprints are compared and integrated.
const N_POINTS: usize = 20;

/// Rounds of the power iteration; the second singular value is a few hundredths of the first at most.
const N_ROUNDS: usize = 8;

/// Steps through a kernel over which variances are summed.
const N_STEPS: usize = 128;

/// Samples of the profile, from its edge to its middle.
const N_SAMPLES: usize = 256;

/// What stands for the sections of two tables.
#[derive(Clone, Debug, PartialEq)]
pub struct SeparableSections {
    profile: [f32; MAX_COEFFICIENTS],
    whole: f32,
    masses: [f32; N_POWERS],
    moments: [f32; N_POWERS],
    radius: f64,
    error: f64,
}

/// Coefficients of functions of a face; they are smooth.
const N_POWERS: usize = 9;

impl SeparableSections {
    /// Those of sections, and of what lies beyond a face; the last row of `merged` must be the whole
    /// footprint.
    pub fn new(sections: &SectionTable, merged: &SectionTable) -> Self {
        Self::for_frame(sections, merged, &FrameHandle::new()).expect("nobody cancels the frame")
    }

    /// The same for a frame: tables may have thousands of rows.
    ///
    /// # Errors
    /// If that is cancelled.
    pub fn for_frame(
        sections: &SectionTable,
        merged: &SectionTable,
        frame: &FrameHandle,
    ) -> Result<Self, Cancelled> {
        let radius = f64::from(merged.rows().radius);
        let [section_rows, merged_rows] = [sections, merged].map(SectionTable::all_rows);
        let profile = profile_of(merged_rows[merged_rows.len() - 1], radius);
        let at_points: Vec<f64> =
            (0..N_POINTS).map(|idx| value(&profile, position_of(idx))).collect();
        let mut error = 0.0_f64;
        let mut mass = |row: &&[f32]| {
            frame.check()?;
            let integral = integral_of(row, radius);
            for (i, j) in pairs() {
                let product = integral * at_points[i] * at_points[j];
                error = error.max((weight(row, i, j) - product).abs());
            }
            Ok(integral)
        };
        section_rows.iter().try_for_each(|row| mass(row).map(drop))?;
        // What lies before a face, as the slab is as wide as the kernel.
        let masses: Vec<f64> = merged_rows.iter().map(mass).collect::<Result<_, _>>()?;
        let steps_per_index = f64::from(merged.rows().rows_per_index);
        let moments = moments_of(&masses, steps_per_index, radius);
        let whole = masses[masses.len() - 1];
        let face_of = |x: f64| radius * (0.5 * (x + 1.0)).sqrt();
        let at = |values: &[f64], face: f64| cubic(values, (face + radius) * steps_per_index);
        Ok(Self {
            profile,
            whole: whole as f32,
            masses: RadialPolynomials::smooth(|x| {
                (at(&masses, face_of(x)) - 0.5 * whole) / face_of(x)
            }),
            moments: RadialPolynomials::smooth(|x| at(&moments, face_of(x))),
            radius,
            error,
        })
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

    /// `∫ u²·g(u) du / ∫ g(u) du`, as a part of `R²`.
    pub fn profile_variance(&self) -> f64 {
        let n = 4 * N_POINTS;
        let part = |idx: usize| (idx as f64 + 0.5) / n as f64;
        let sum = |power: i32| -> f64 {
            (0..n).map(|idx| part(idx).powi(power) * self.profile_at(part(idx))).sum()
        };
        sum(2) / sum(0)
    }

    /// What lies before a face `s` index units behind the voxel, across the slab, of the integral of a whole
    /// footprint over the image, is half of it and `s·p(x)`: the coefficients of `p` in `x = 2·(s/R)² − 1`,
    /// from the constant on. The factor of a section is what its two faces differ by.
    #[inline(always)]
    pub fn masses(&self) -> &[f32; N_POWERS] {
        &self.masses
    }

    /// The same times how far behind the voxel it lies, a polynomial in `x`. What the faces of a section
    /// differ by, over its factor, is where its middle lies.
    #[inline(always)]
    pub fn moments(&self) -> &[f32; N_POWERS] {
        &self.moments
    }

    /// The factor of the section between two faces, and the same times how far its middle lies behind the
    /// voxel; faces beyond the kernel are at its ends.
    pub fn factor_and_moment(&self, faces: [f64; 2]) -> [f64; 2] {
        let at = |face: f64| {
            let face = face.clamp(-self.radius, self.radius);
            let x = (2.0 * (face / self.radius).powi(2) - 1.0) as f32;
            let [mass, moment] = [&self.masses, &self.moments].map(|c| f64::from(polynomial(c, x)));
            [face * mass, moment]
        };
        let [front, back] = faces.map(at);
        [back[0] - front[0], back[1] - front[1]]
    }

    /// The kernel's radius in index units.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// How much of the kernel's variance across slabs is left within sections by slabs of `width` index
    /// units, in the mean of all sections: 0 for the thinnest, 1 for the thickest.
    pub(crate) fn variance_left(&self, width: f64) -> f64 {
        let step = (2.0 * self.radius + width) / N_STEPS as f64;
        // A whole kernel's first moment is 0, and what its sections have lost of its variance is that of
        // their middles.
        let (mut of_middles, mut sum) = (0.0, 0.0);
        for idx in 0..N_STEPS {
            let back = (idx as f64 + 0.5) * step - self.radius;
            let [factor, moment] = self.factor_and_moment([back - width, back]);
            if 0.0 < factor {
                of_middles += moment * moment / factor;
                sum += factor;
            }
        }
        (1.0 - of_middles / (sum * self.variance())).clamp(0.0, 1.0)
    }

    /// The kernel's variance across slabs, in squared index units.
    fn variance(&self) -> f64 {
        let step = 2.0 * self.radius / N_STEPS as f64;
        let front = |idx: usize| idx as f64 * step - self.radius;
        let part = |idx: usize| {
            let [_, moment] = self.factor_and_moment([front(idx), front(idx + 1)]);
            (front(idx) + 0.5 * step) * moment
        };
        (0..N_STEPS).map(part).sum::<f64>() / f64::from(self.whole)
    }

    /// The factor of a whole footprint.
    #[inline(always)]
    pub fn whole(&self) -> f32 {
        self.whole
    }

    /// By how much any weight of any section is off at most.
    pub fn error(&self) -> f64 {
        self.error
    }
}

/// The value at a position among others, by the cubic through the four around it.
fn cubic(values: &[f64], position: f64) -> f64 {
    let last = values.len() - 1;
    let position = position.clamp(0.0, last as f64);
    let step = (position as usize).min(last.saturating_sub(1));
    let t = position - step as f64;
    let at = |idx: usize| values[idx.min(last)];
    let [a, b, c, d] = [at(step.saturating_sub(1)), at(step), at(step + 1), at(step + 2)];
    let slopes = [0.5 * (c - a), 0.5 * (d - b)];
    let (rest, bend) = (1.0 - t, t * (1.0 - t));
    rest * b + t * c + bend * (rest * (slopes[0] - (c - b)) - t * (slopes[1] - (c - b)))
}

/// `∫ s dm` up to each step, by parts: `s·m − ∫ m ds`.
fn moments_of(masses: &[f64], steps_per_index: f64, radius: f64) -> Vec<f64> {
    let step = 1.0 / steps_per_index;
    let mut integral = 0.0;
    let moment = |idx: usize| {
        if 0 < idx {
            integral += 0.5 * step * (masses[idx - 1] + masses[idx]);
        }
        (idx as f64 * step - radius) * masses[idx] - integral
    };
    (0..masses.len()).map(moment).collect()
}

/// The middle of one of `N_POINTS` equal parts, as a part of `R`.
fn position_of(idx: usize) -> f64 {
    (idx as f64 + 0.5) / N_POINTS as f64
}

fn pairs() -> impl Iterator<Item = (usize, usize)> {
    (0..N_POINTS).flat_map(|i| (0..=i).map(move |j| (i, j)))
}

/// What a row of a table weighs in the `i`-th column and `j`-th row of points.
fn weight(row: &[f32], i: usize, j: usize) -> f64 {
    weight_at(row, position_of(i).powi(2) + position_of(j).powi(2))
}

/// At a squared distance, a part of `R²`.
fn weight_at(row: &[f32], distance_squared: f64) -> f64 {
    let half_chord = (1.0 - distance_squared).max(0.0).sqrt();
    f64::from(lerp_radial(row, (half_chord * (row.len() - 2) as f64) as f32))
}

/// `∫∫` of a row over the image, in rings of equal areas.
fn integral_of(row: &[f32], radius: f64) -> f64 {
    let n = 4 * N_POINTS;
    let ring = |ring: usize| weight_at(row, (ring as f64 + 0.5) / n as f64);
    std::f64::consts::PI * radius * radius / n as f64 * (0..n).map(ring).sum::<f64>()
}

/// The first singular vector of a footprint, as a polynomial.
fn profile_of(footprint: &[f32], radius: f64) -> [f32; MAX_COEFFICIENTS] {
    let mut vector = [1.0; N_POINTS];
    let along = |vector: &[f64; N_POINTS], squared: f64| -> f64 {
        let points = vector.iter().enumerate();
        points.map(|(j, v)| v * weight_at(footprint, squared + position_of(j).powi(2))).sum()
    };
    let integral = |values: &[f64]| 2.0 * radius / N_POINTS as f64 * values.iter().sum::<f64>();
    for _ in 0..N_ROUNDS {
        let next = std::array::from_fn(|i| along(&vector, position_of(i).powi(2)));
        let scale = 1.0 / integral(&next);
        vector = next.map(|value| value * scale);
    }
    let at_points: Vec<f64> =
        (0..N_POINTS).map(|i| along(&vector, position_of(i).powi(2))).collect();
    let scale = 1.0 / integral(&at_points);
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

    /// `error` holds at points where nothing was compared, and separable sections keep what sections hold.
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
                    let [factor, _] = separable.factor_and_moment([front, back].map(f64::from));
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

    #[test]
    fn separable_profile_has_the_area_of_one() {
        for &name in KERNEL_NAMES {
            let (separable, table) = separable(name, 1.0);
            let n = 2000;
            let positions = (0..n).map(|idx| 2.0 * (f64::from(idx) + 0.5) / f64::from(n) - 1.0);
            let sum: f64 = positions.map(|part| separable.profile_at(part)).sum();
            let area = sum * 2.0 * f64::from(table.rows().radius) / f64::from(n);
            assert!((area - 1.0).abs() < 1e-3, "{name}: {area}");
            assert_eq!([-1.0, 1.0, 1.5].map(|part| separable.profile_at(part)), [0.0; 3]);
            for part in [0.0, 0.3, -0.9] {
                let value = polynomial(separable.profile(), (2.0 * part * part - 1.0) as f32);
                assert!((separable.profile_at(part) - f64::from(value)).abs() < 1e-6, "{part}");
            }
        }
    }

    /// Sections that follow each other have all of the kernel together, and a half of it lies to one side.
    #[test]
    fn separable_factors_sum_to_the_whole() {
        for &name in KERNEL_NAMES {
            let (separable, _) = separable(name, 1.0);
            let whole = f64::from(separable.whole());
            for width in [0.1, 0.7, 3.0] {
                let faces =
                    |slab: i32| [f64::from(slab) * width - 9.0, f64::from(slab + 1) * width - 9.0];
                let sections: Vec<[f64; 2]> =
                    (0..200).map(|slab| separable.factor_and_moment(faces(slab))).collect();
                let sum = |of: usize| sections.iter().map(|section| section[of]).sum::<f64>();
                assert!((sum(0) - whole).abs() < 1e-5, "{name} {width}: {}", sum(0));
                assert!(sum(1).abs() < 1e-5, "{name} {width}: {}", sum(1));
            }
            let [half, moment] = separable.factor_and_moment([-9.0, 0.0]);
            assert!((half - 0.5 * whole).abs() < 1e-5);
            let mirrored = separable.factor_and_moment([0.0, 9.0]);
            assert!((mirrored[0] - half).abs() < 1e-5 && (mirrored[1] + moment).abs() < 1e-5);
            assert!(-0.5 < moment / half && moment / half < -0.3, "{name}: {}", moment / half);
        }
    }

    /// What backends compute by vectors is what `factor_and_moment` says.
    #[test]
    fn separable_factors_are_polynomials_of_faces() {
        let (separable, _) = separable("gaussian", 1.0);
        for face in [-1.4_f32, 0.3, 1.9] {
            let x = 2.0 * (face / separable.radius() as f32).powi(2) - 1.0;
            let before = 0.5 * separable.whole() + face * polynomial(separable.masses(), x);
            let moment = polynomial(separable.moments(), x) - polynomial(separable.moments(), 1.0);
            let expected = separable.factor_and_moment([-9.0, face.into()]);
            let off = [before, moment].map(f64::from);
            assert!((off[0] - expected[0]).abs() < 1e-5, "{face}: {before} {expected:?}");
            assert!((off[1] - expected[1]).abs() < 1e-5, "{face}: {moment} {expected:?}");
        }
    }

    /// A Gaussian's variance is `1/(4·ln 2)`, some of which is beyond its end.
    #[test]
    fn separable_variance_is_lost_between_sections() {
        let (separable, _) = separable("gaussian", 1.0);
        assert!(
            (separable.variance() - 0.25 / 2.0_f64.ln()).abs() < 0.02,
            "{}",
            separable.variance()
        );
        let part = separable.profile_variance() * separable.radius().powi(2);
        assert!((part - 0.25 / 2.0_f64.ln()).abs() < 0.02, "{part}");
        // What is as dense everywhere within a section has a twelfth of its squared width.
        let left = separable.variance_left(0.2) * separable.variance();
        assert!((left - 0.04 / 12.0).abs() < 2e-4, "{left}");
        assert!(0.98 < separable.variance_left(100.0));
    }

    /// What its end at `R` leaves of the Gaussian's being a product.
    #[test]
    fn separable_gaussian_is_close() {
        let (separable, _) = separable("gaussian", 1.0);
        assert!(separable.error() < 2.5e-3, "{}", separable.error());
        assert!((separable.whole() - 0.9993).abs() < 1e-3, "{}", separable.whole());
    }
}
