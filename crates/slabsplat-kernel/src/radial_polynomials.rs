//! The rows of a table as polynomials of the squared distance, for backends with wide registers.
//!
//! A look-up in a [`SectionTable`] needs a square root, and two loads from addresses that differ for every
//! pixel: the one thing that vector units are bad at. A polynomial in `ρ²` needs neither: `ρ²` is what a
//! pixel's position gives at once, a handful of multiply-adds do 4, 8 or 16 pixels at a time, and a row
//! blended from two neighbouring rows is the polynomial with the blended coefficients.
//!
//! A truncated kernel ends with a step: what is left of it at `R` counts as far as the ray is inside the ball
//! and the slab, and that length, the *chord*, has kinks where a slab's face meets the ball, and ends like a
//! square root. No polynomial follows that closely. Where the last digits count, the last coefficient is that
//! of the chord instead of a power: some ten thousandths of a weight, and yet the most that would be wrong
//! with an opaque voxel's edge, where nothing hides it.
//!
//! A row is fitted by least squares with more weight towards the ends of its disc, `(1 − y²)^(−3/4)` for `y`
//! from −1 at its centre to 1 at its edge. With equal weights the errors there would be twice as large, and
//! are what shows: at the edge of an opaque voxel, or all over a row of them.

use crate::{FootprintTable, SectionTable, lerp_radial};
use slabsplat_core::{Cancelled, FrameHandle, extinction};

/// Most coefficients of a polynomial.
pub const MAX_COEFFICIENTS: usize = 12;

/// Of what degree polynomials are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Degree {
    /// Powers up to the seventh.
    Low,
    /// Powers up to the tenth, and the chord.
    High,
}

/// Points in a disc at which a row is fitted.
const N_NODES: usize = 256;

/// A chord with less of its own, squared and summed over the nodes, is none: the slab just touches the ball.
const NO_CHORD: f64 = 1e-9;

/// Rows of weights, each a polynomial in `x = 2·(ρ/R)² − 1`; the last coefficient is that of the chord, see
/// [`weight`](Self::weight).
#[derive(Clone, Debug, PartialEq)]
pub struct RadialPolynomials {
    /// From the constant on; 0 from the eighth on if the degree is low.
    rows: Vec<[f32; MAX_COEFFICIENTS]>,
    errors: Errors,
}

/// How far fits are off, at most, where they were made.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Errors {
    /// A weight.
    of_weight: f64,
    /// A pixel before which there is one voxel, of the extinction that shows it most.
    of_pixel: f64,
}

impl RadialPolynomials {
    /// Fits the rows of a table of sections; row `n` is the table's.
    pub fn of_sections(table: &SectionTable, degree: Degree) -> Self {
        Self::of_sections_for_frame(table, degree, &FrameHandle::new())
            .expect("nobody cancels the frame")
    }

    /// The same for a frame: of thousands of rows they take a tenth of a second.
    ///
    /// # Errors
    /// If that is cancelled.
    pub fn of_sections_for_frame(
        table: &SectionTable,
        degree: Degree,
        frame: &FrameHandle,
    ) -> Result<Self, Cancelled> {
        let units = chord_units_per_index(table.rows().radius.into());
        let faces = |row_idx| table.faces_of_row(row_idx).map(|face| face * units);
        Self::of_rows(&table.all_rows(), faces, degree, frame)
    }

    /// Fits a footprint: one row.
    pub fn of_footprint(table: &FootprintTable, degree: Degree) -> Self {
        Self::of_rows(&[table.row()], |_| WHOLE, degree, &FrameHandle::new())
            .expect("nobody cancels the frame")
    }

    /// Fits one row over the whole disc by a low degree.
    pub(crate) fn short(row: &[f32]) -> [f32; MAX_COEFFICIENTS] {
        Basis::new().fit(row, 1.0, WHOLE, Degree::Low).0
    }

    /// The first `N` coefficients in `x`, −1 to 1, of a smooth function.
    pub(crate) fn smooth<const N: usize>(function: impl Fn(f64) -> f64) -> [f32; N] {
        let basis = Basis::new();
        let parts = basis.parts_of(&basis.at_nodes(function), N);
        let powers = basis.in_powers(&parts, 1.0);
        std::array::from_fn(|power| powers[power] as f32)
    }

    fn of_rows(
        rows: &[&[f32]],
        faces: impl Fn(usize) -> [f64; 2],
        degree: Degree,
        frame: &FrameHandle,
    ) -> Result<Self, Cancelled> {
        let discs: Vec<f64> = rows.iter().map(|row| disc_of(row)).collect();
        let basis = Basis::new();
        let mut errors = Errors::default();
        let fit = |idx: usize| {
            frame.check()?;
            let (row, of_row) = basis.fit(rows[idx], domain(&discs, idx), faces(idx), degree);
            errors = errors.max(of_row);
            Ok(row)
        };
        let rows = (0..rows.len()).map(fit).collect::<Result<_, _>>()?;
        Ok(Self { rows, errors })
    }

    /// By how much any row is off at most, at any point where it was fitted.
    pub fn error(&self) -> f64 {
        self.errors.of_weight
    }

    /// By how much that changes the opacity of a pixel, at most, if one voxel is before it, whatever its
    /// extinction: an opaque voxel hides its own error where its weight is large.
    pub fn pixel_error(&self) -> f64 {
        self.errors.of_pixel
    }

    /// Number of rows.
    pub fn n_rows(&self) -> usize {
        self.rows.len()
    }

    /// The coefficients of one row, from the constant on.
    #[inline]
    pub fn row(&self, row_idx: usize) -> &[f32; MAX_COEFFICIENTS] {
        &self.rows[row_idx]
    }

    /// The coefficients of the last row; in a table of slabs as wide as the kernel, those of the whole
    /// footprint.
    #[inline]
    pub fn last_row(&self) -> &[f32; MAX_COEFFICIENTS] {
        &self.rows[self.rows.len() - 1]
    }

    /// The coefficients of a row and of the one behind it; of the last row twice.
    #[inline(always)]
    pub fn around(&self, row_idx: usize) -> [&[f32; MAX_COEFFICIENTS]; 2] {
        [&self.rows[row_idx], &self.rows[(row_idx + 1).min(self.rows.len() - 1)]]
    }

    /// The weight that a row has at `x`: its polynomial, and its last coefficient times the chord. The slab's
    /// faces are that many units of chords behind the voxel, [`chord_units_per_index`].
    pub fn weight(&self, row_idx: usize, x: f32, faces: [f32; 2]) -> f32 {
        let (powers, per_chord) = self.rows[row_idx].split_at(MAX_COEFFICIENTS - 1);
        polynomial(powers, x) + per_chord[0] * chord(x.into(), faces.map(f64::from)) as f32
    }
}

/// The faces of a slab that cuts nothing.
const WHOLE: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

/// Units of chords in an index unit: in these the ray at `x` leaves the ball `√(1 − x)` behind its nearest
/// point.
pub fn chord_units_per_index(radius: f64) -> f64 {
    std::f64::consts::SQRT_2 / radius
}

/// For how long the ray at `x` is inside both the ball and the slab.
fn chord(x: f64, [front, back]: [f64; 2]) -> f64 {
    let end = (1.0 - x).max(0.0).sqrt();
    (end.min(back) - (-end).max(front)).max(0.0)
}

/// `c₀ + c₁·x + …`.
pub(crate) fn polynomial(coefficients: &[f32], x: f32) -> f32 {
    coefficients.iter().rev().fold(0.0, |sum, coefficient| sum * x + coefficient)
}

/// Where a row's disc ends, as a part of `R²`: rows begin at the edge, with a 0 for every point outside of
/// it.
fn disc_of(row: &[f32]) -> f64 {
    let n_samples = row.len() - 2;
    let n_outside = row.iter().take_while(|weight| **weight == 0.0).count();
    let edge = n_outside.saturating_sub(1) as f64 / n_samples as f64;
    (1.0 - edge * edge).max(0.0)
}

/// Over what part of `R²` a row is fitted: where it or a neighbour, with which it may be blended, is not 0;
/// and at least over a half, as the powers of a polynomial that fits a small part cancel to the last digit.
fn domain(discs: &[f64], idx: usize) -> f64 {
    let near = &discs[idx.saturating_sub(1)..(idx + 2).min(discs.len())];
    near.iter().fold(0.5, |domain: f64, disc| domain.max(*disc))
}

impl Errors {
    /// Those of a weight that is off.
    fn of(off: f64, weight: f64) -> Self {
        // e^(−μw) − e^(−μ(w + off)) is at most off·μ·e^(−μw), which is largest at μ = 1/w.
        let most = 1.0 / (std::f64::consts::E * weight.max(0.0));
        Self { of_weight: off.abs(), of_pixel: off.abs() * most.min(extinction(1.0)) }
    }

    fn max(self, other: Self) -> Self {
        Self {
            of_weight: self.of_weight.max(other.of_weight),
            of_pixel: self.of_pixel.max(other.of_pixel),
        }
    }
}

/// A point at which rows are fitted.
struct Node {
    y: f64,
    weight: f64,
    /// Of the polynomials, there.
    values: [f64; MAX_COEFFICIENTS],
}

/// Polynomials in `y`, −1 … 1, that are orthogonal over the nodes and their weights; the `k`-th is
/// `(y − shift[k−1])·` the one before `− lag[k−1]·` the one before that (Stieltjes).
struct Basis {
    nodes: Vec<Node>,
    shifts: [f64; MAX_COEFFICIENTS],
    lags: [f64; MAX_COEFFICIENTS],
    norms: [f64; MAX_COEFFICIENTS],
}

impl Basis {
    fn new() -> Self {
        // Equally far apart in the angle, nodes have the weight (1 − y²)^(−1/2) already.
        let angle = |node: usize| std::f64::consts::PI * (node as f64 + 0.5) / N_NODES as f64;
        let node = |node: usize| Node {
            y: -angle(node).cos(),
            weight: angle(node).sin().powf(-0.5),
            values: [1.0; MAX_COEFFICIENTS],
        };
        let mut basis = Self {
            nodes: (0..N_NODES).map(node).collect(),
            shifts: [0.0; MAX_COEFFICIENTS],
            lags: [0.0; MAX_COEFFICIENTS],
            norms: [0.0; MAX_COEFFICIENTS],
        };
        for k in 0..MAX_COEFFICIENTS {
            let (mut norm, mut moment) = (0.0, 0.0);
            for Node { y, weight, values } in &basis.nodes {
                let square = weight * values[k] * values[k];
                norm += square;
                moment += square * y;
            }
            basis.norms[k] = norm;
            basis.shifts[k] = moment / norm;
            basis.lags[k] = if k == 0 { 0.0 } else { norm / basis.norms[k - 1] };
            for Node { y, values, .. } in &mut basis.nodes {
                let before = if k == 0 { 0.0 } else { values[k - 1] };
                if k + 1 < MAX_COEFFICIENTS {
                    values[k + 1] = (*y - basis.shifts[k]) * values[k] - basis.lags[k] * before;
                }
            }
        }
        basis
    }

    /// The polynomial in `x` that fits a row over `domain`, and its errors there.
    fn fit(
        &self,
        row: &[f32],
        domain: f64,
        faces: [f64; 2],
        degree: Degree,
    ) -> ([f32; MAX_COEFFICIENTS], Errors) {
        let n_samples = (row.len() - 2) as f64;
        let exact: Vec<f64> = self.at_nodes(|y| {
            let half_chord = (1.0 - 0.5 * (y + 1.0) * domain).max(0.0).sqrt();
            f64::from(lerp_radial(row, (half_chord * n_samples) as f32))
        });
        let (n_powers, has_chord) = match degree {
            Degree::Low => (8, false),
            Degree::High => (MAX_COEFFICIENTS - 1, true),
        };
        let mut parts = self.parts_of(&exact, n_powers);
        let chord = if has_chord {
            self.at_nodes(|y| chord((y + 1.0) * domain - 1.0, faces))
        } else {
            Vec::new()
        };
        let per_chord = self.take_out(&chord, &exact, &mut parts);
        let mut fitted = self.sums(&parts);
        fitted.iter_mut().zip(&chord).for_each(|(sum, chord)| *sum += per_chord * chord);
        let errors =
            fitted.iter().zip(&exact).map(|(fitted, exact)| Errors::of(fitted - exact, *exact));
        let errors = errors.fold(Errors::default(), Errors::max);
        let mut coefficients = self.in_powers(&parts, domain);
        if has_chord {
            coefficients[MAX_COEFFICIENTS - 1] = per_chord;
        }
        (coefficients.map(|coefficient| coefficient as f32), errors)
    }

    /// How much of what no polynomial has of `chord` is in `row`, whose `parts` then are those without it.
    fn take_out(&self, chord: &[f64], row: &[f64], parts: &mut [f64; MAX_COEFFICIENTS]) -> f64 {
        if chord.is_empty() {
            return 0.0;
        }
        let of_chord = self.parts_of(chord, MAX_COEFFICIENTS - 1);
        let sums = self.sums(&of_chord);
        let lone: Vec<f64> = chord.iter().zip(&sums).map(|(chord, sum)| chord - sum).collect();
        let norm = self.product(&lone, &lone);
        if norm < NO_CHORD {
            return 0.0;
        }
        let per_chord = self.product(row, &lone) / norm;
        parts.iter_mut().zip(of_chord).for_each(|(part, of_chord)| *part -= per_chord * of_chord);
        per_chord
    }

    fn at_nodes(&self, function: impl Fn(f64) -> f64) -> Vec<f64> {
        self.nodes.iter().map(|node| function(node.y)).collect()
    }

    /// The inner product of two functions.
    fn product(&self, a: &[f64], b: &[f64]) -> f64 {
        self.nodes.iter().zip(a).zip(b).map(|((node, a), b)| node.weight * a * b).sum()
    }

    /// What part each of the first `n` polynomials has in a function.
    fn parts_of(&self, function: &[f64], n: usize) -> [f64; MAX_COEFFICIENTS] {
        let mut parts = [0.0; MAX_COEFFICIENTS];
        for (node, value) in self.nodes.iter().zip(function) {
            for (part, of_basis) in parts.iter_mut().zip(node.values).take(n) {
                *part += node.weight * value * of_basis;
            }
        }
        parts.iter_mut().zip(self.norms).for_each(|(part, norm)| *part /= norm);
        parts
    }

    /// A sum of the polynomials at every node.
    fn sums(&self, parts: &[f64; MAX_COEFFICIENTS]) -> Vec<f64> {
        let sum =
            |node: &Node| node.values.iter().zip(parts).map(|(value, part)| value * part).sum();
        self.nodes.iter().map(sum).collect()
    }

    /// A sum of the polynomials, in powers of `x`: `y = (x + 1)/domain − 1`.
    fn in_powers(&self, parts: &[f64; MAX_COEFFICIENTS], domain: f64) -> [f64; MAX_COEFFICIENTS] {
        let (slope, constant) = (1.0 / domain, 1.0 / domain - 1.0);
        let mut before = [0.0; MAX_COEFFICIENTS];
        let mut here = before;
        here[0] = 1.0;
        let mut sum = [0.0; MAX_COEFFICIENTS];
        for (k, part) in parts.iter().enumerate() {
            sum.iter_mut().zip(here).for_each(|(sum, power)| *sum += part * power);
            let next = std::array::from_fn(|i| {
                let by_x = if 0 < i { here[i - 1] } else { 0.0 };
                slope * by_x + (constant - self.shifts[k]) * here[i] - self.lags[k] * before[i]
            });
            (before, here) = (here, next);
        }
        sum
    }
}

#[cfg(test)]
mod tests;
