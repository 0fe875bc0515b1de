//! A section table that is read by cubics: for methods that take differences between neighbouring pixels
//! and slabs, where the kinks of linear interpolation would show as facets.
//!
//! Like a [`SectionTable`](crate::SectionTable) it runs over a section from its edge to its middle within a
//! row, and over the depth to which the slab goes into the kernel from row to row. A row is cut into few
//! cells, each with the four coefficients of the cubic through four exact sections; between rows it is
//! interpolated through the four nearest. A look-up is one load instead of two.
//!
//! Cells are equally long in `1 − √(1 − c/R)` of the half chord `c = √(R² − ρ²)`. That is `c/2R` at a
//! section's edge, where the section is smooth in `c`, and `1 − ρ/√2R` in its middle, where it is smooth in
//! `ρ`, even if the kernel has an `r³`.
//!
//! A kernel that does not end at 0 (the Gaussian ends at 1/256 of its peak) has a kink in its sections where
//! a face leaves the ball, and a cubic across a kink has the wrong slope, which is a wrong normal once a
//! pixel is much smaller than a voxel. So the table samples the kernel less its value at the rim; what the
//! rim's value adds is it times the length that the slab cuts from the chord, which is computed.

use crate::SectionDesc;
use crate::kernel::half_chord;
use slabsplat_core::{Cancelled, FrameHandle};

/// Cells in a row: the kernel's radius is no more than [`MAX_RADIUS`](crate::MAX_RADIUS).
const N_CELLS: usize = 32;

/// Rows per index unit, unless the slab is thin.
const ROWS_PER_INDEX: f64 = 64.0;

/// Rows over the thickness of a thin slab, as far as there may be so many.
const ROWS_PER_SLAB: f64 = 4.0;

/// Rows over a whole kernel, of which half are stored: 2 MiB.
const MAX_ROWS: f64 = 8192.0;

/// Sections of one kernel by slabs of one width, never normalised.
#[derive(Clone, Debug, PartialEq)]
pub struct CubicSectionTable {
    radius: f32,
    /// `1/R`.
    per_radius: f32,
    rows_per_index: f32,
    /// The last row that a depth may come before; one more lies behind it.
    last_row: f32,
    /// What the kernel is just within its radius, as a weight per index unit of ray.
    rim: f32,
    /// Sections of the kernel less `rim`. By rows, cells and powers. Row `k` is that of the depth `(k −
    /// 1)/rows_per_index`.
    coefficients: Vec<[f32; 4]>,
}

impl CubicSectionTable {
    /// Values in a row: the cells, and one that holds the value at their end.
    pub const ROW_LEN: usize = N_CELLS + 1;

    /// Samples the plain sections of `desc` for a frame; ten thousand exact integrals, or many more of thin
    /// slabs.
    ///
    /// # Errors
    /// If that is cancelled.
    pub fn for_frame(desc: &SectionDesc<'_>, frame: &FrameHandle) -> Result<Self, Cancelled> {
        let radius = desc.kernel.radius();
        // A slab wider than the kernel cuts just what one as wide as it does.
        let width = desc.width.min(2.0 * radius / desc.kappa);
        let width_in_index = width * desc.kappa;
        let rows_per_index =
            (ROWS_PER_SLAB / width_in_index).clamp(ROWS_PER_INDEX, MAX_ROWS / (2.0 * radius));
        let deepest = radius + 0.5 * width_in_index;
        let n_rows = (deepest * rows_per_index).ceil() as usize + 4;
        let rim = (desc.kernel.value(radius.next_down()) / desc.kappa) as f32;
        let row = |row_idx: usize| {
            let depth = (row_idx as f64 - 1.0) / rows_per_index;
            let front = depth - radius - width_in_index;
            row_of_cells(radius, move |rho| {
                let faces = [front, front + width_in_index].map(|face| face as f32);
                let at_rim = rim * cut_length(faces, half_chord(radius, rho) as f32).max(0.0);
                desc.plain(rho, front, width) - f64::from(at_rim)
            })
        };
        let mut coefficients = Vec::new();
        for row_idx in 0..n_rows {
            frame.check()?;
            coefficients.extend(row(row_idx));
        }
        Ok(Self {
            radius: radius as f32,
            per_radius: (1.0 / radius) as f32,
            rows_per_index: rows_per_index as f32,
            last_row: (deepest * rows_per_index) as f32,
            rim,
            coefficients,
        })
    }

    /// Writes the section between two faces, which cut the ray that many index units behind its point nearest
    /// to the voxel, to `row`, to be read by [`Self::weight_in`].
    #[inline]
    pub fn blend(&self, faces: [f32; 2], row: &mut [[f32; 4]; Self::ROW_LEN]) {
        let (rows, shares) = self.rows_at(faces);
        let [a, b, c, d] =
            [0, 1, 2, 3].map(|k| rows[k * Self::ROW_LEN..][..Self::ROW_LEN].as_flattened());
        // Flat, or the compiler turns cells into powers and back.
        let sections = a.iter().zip(b).zip(c).zip(d);
        for (out, (((a, b), c), d)) in row.as_flattened_mut().iter_mut().zip(sections) {
            *out = shares[0] * a + shares[1] * b + shares[2] * c + shares[3] * d;
        }
    }

    /// One weight of the section between two faces, to which [`Self::blend`] has set `row`, where the ray
    /// that passes the voxel at the root of `rho_squared` index units is cut.
    #[inline(always)]
    pub fn weight_in(
        &self,
        row: &[[f32; 4]; Self::ROW_LEN],
        rho_squared: f32,
        faces: [f32; 2],
    ) -> f32 {
        let half_chord = self.half_chord(rho_squared);
        cubic_at(&row[..], self.position(half_chord)) + self.rim * cut_length(faces, half_chord)
    }

    /// One weight of the section between two faces, at the root of `rho_squared` index units from the voxel;
    /// exactly 0 where the slab does not cut the ray within the kernel.
    #[inline]
    pub fn weight(&self, rho_squared: f32, faces: [f32; 2]) -> f32 {
        let half_chord = self.half_chord(rho_squared);
        if half_chord <= faces[0] || faces[1] <= -half_chord {
            return 0.0;
        }
        let (rows, shares) = self.rows_at(faces);
        let position = self.position(half_chord);
        let at = |k: usize| shares[k] * cubic_at(&rows[k * Self::ROW_LEN..], position);
        at(0) + at(1) + at(2) + at(3) + self.rim * cut_length(faces, half_chord)
    }

    /// The cubics, in powers of the position in a cell: [`Self::ROW_LEN`] for each row. Row `k` is that of
    /// the depth `(k − 1)/rows_per_index` to which a slab goes into the kernel.
    pub fn coefficients(&self) -> &[[f32; 4]] {
        &self.coefficients
    }

    /// Rows per index unit of that depth, and the last row that a depth may come before, less one.
    pub fn rows(&self) -> [f32; 2] {
        [self.rows_per_index, self.last_row]
    }

    /// What the kernel is just within its radius, as a weight per index unit of ray: by how much a section is
    /// more than its cubic.
    pub fn rim(&self) -> f32 {
        self.rim
    }

    #[inline]
    fn half_chord(&self, rho_squared: f32) -> f32 {
        // Rounding may make the square negative at the edge.
        (self.radius * self.radius - rho_squared).max(0.0).sqrt()
    }

    /// Cells from the start of a row.
    #[inline]
    fn position(&self, half_chord: f32) -> f32 {
        let root = (1.0 - half_chord * self.per_radius).max(0.0).sqrt();
        N_CELLS as f32 - N_CELLS as f32 * root
    }

    /// Four rows, the second of which is at or before the faces' depth, and the share of each.
    #[inline]
    fn rows_at(&self, [front, back]: [f32; 2]) -> (&[[f32; 4]], [f32; 4]) {
        let depth = (back + self.radius).min(self.radius - front);
        let position = (depth * self.rows_per_index).clamp(0.0, self.last_row);
        let row_idx = position as usize;
        let t = position - row_idx as f32;
        let [before, after, second] = [t + 1.0, 1.0 - t, 2.0 - t];
        let shares = [
            -t * after * second / 6.0,
            0.5 * before * after * second,
            0.5 * before * t * second,
            -before * t * after / 6.0,
        ];
        (&self.coefficients[row_idx * Self::ROW_LEN..][..4 * Self::ROW_LEN], shares)
    }
}

/// Reads a row `position` cells from its start.
#[inline]
fn cubic_at(row: &[[f32; 4]], position: f32) -> f32 {
    // As in `lerp_radial`: rounds without the checks of a cast. At a tie either cell serves.
    const MAGIC: f32 = 12_582_912.0;
    let rounded = (position - 0.5) + MAGIC;
    let idx = rounded.to_bits().wrapping_sub(MAGIC.to_bits()) as usize;
    let t = position - (rounded - MAGIC);
    let [a, b, c, d] = row[idx];
    a + t * (b + t * (c + t * d))
}

/// How much of a chord lies between two faces that cut it, where both are counted from its middle.
#[inline]
fn cut_length([front, back]: [f32; 2], half_chord: f32) -> f32 {
    back.min(half_chord) + half_chord.min(-front)
}

/// The cells from the edge of a section to its middle.
fn row_of_cells(radius: f64, weight_at: impl Fn(f64) -> f64) -> Vec<[f32; 4]> {
    let n_steps = 3 * N_CELLS;
    let sample = |step: usize| {
        let root = 1.0 - step as f64 / n_steps as f64;
        let half_chord = radius * (1.0 - root * root);
        weight_at((radius * radius - half_chord * half_chord).max(0.0).sqrt())
    };
    let samples: Vec<f64> = (0..=n_steps).map(sample).collect();
    let cubic = |cell: usize| {
        let [y0, y1, y2, y3] = [0, 1, 2, 3].map(|i| samples[3 * cell + i]);
        let slope = -5.5 * y0 + 9.0 * y1 - 4.5 * y2 + y3;
        let square = 9.0 * y0 - 22.5 * y1 + 18.0 * y2 - 4.5 * y3;
        let cube = -4.5 * y0 + 13.5 * y1 - 13.5 * y2 + 4.5 * y3;
        [y0, slope, square, cube].map(|c| c as f32)
    };
    let end = [samples[n_steps] as f32, 0.0, 0.0, 0.0];
    (0..N_CELLS).map(cubic).chain([end]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{KERNEL_NAMES, Kernel, kernel_named};
    use slabsplat_core::Normalization;

    fn desc(kernel: &dyn Kernel, width: f64, kappa: f64) -> SectionDesc<'_> {
        SectionDesc { kernel, width, kappa, normalization: Normalization::None, base_width: 0.5 }
    }

    /// How far a table is off, at most and on average.
    #[derive(Debug, Default)]
    struct Errors {
        value: [f64; 2],
        /// Per index unit across the ray, between points that are a pixel of a picture far zoomed in apart.
        slope: [f64; 2],
    }

    /// Over offsets and distances that hit no sample.
    fn errors(desc: &SectionDesc<'_>) -> Errors {
        let table = CubicSectionTable::for_frame(desc, &FrameHandle::new()).unwrap();
        let (radius, width) = (desc.kernel.radius(), desc.width_in_index());
        let (n_offsets, n_radii) = (211, 173);
        let n = f64::from(n_offsets * n_radii);
        let mut errors = Errors::default();
        for i in 0..n_offsets {
            let depth =
                (2.0 * radius + width.min(3.0)) * (f64::from(i) + 0.37) / f64::from(n_offsets);
            let front = depth - radius - width;
            let faces = [front as f32, (front + width) as f32];
            let mut row = [[0.0; 4]; CubicSectionTable::ROW_LEN];
            table.blend(faces, &mut row);
            let error_at = |rho: f64| {
                let half_chord = half_chord(radius, rho);
                let weight = table.weight((rho * rho) as f32, faces);
                if front < half_chord && -half_chord < front + width {
                    let read = table.weight_in(&row, (rho * rho) as f32, faces);
                    assert!((read - weight).abs() < 2e-7, "{rho} {front}");
                } else {
                    assert_eq!(weight, 0.0, "{rho} {front}");
                }
                f64::from(weight) - desc.plain(rho, front, desc.width)
            };
            for j in 0..n_radii {
                let rho = radius * (f64::from(j) + 0.41) / f64::from(n_radii);
                let value = error_at(rho);
                let slope = (error_at(rho + PIXEL) - value) / PIXEL;
                for ([most, mean], error) in
                    [(&mut errors.value, value), (&mut errors.slope, slope)]
                {
                    *most = most.max(error.abs());
                    *mean += error.abs() / n;
                }
            }
        }
        errors
    }

    /// In index units.
    const PIXEL: f64 = 1.0 / 128.0;

    #[test]
    fn cubic_section_table_error_is_small() {
        for &name in KERNEL_NAMES {
            for (width, kappa) in
                [(0.05, 1.0), (0.3, 1.0), (1.0, 1.0), (1.0, 0.3), (2.0, 1.0), (100.0, 1.0)]
            {
                let kernel = kernel_named(name).unwrap();
                let Errors { value, slope } = errors(&desc(&*kernel, width, kappa));
                println!("{name} w={width} kappa={kappa}: {value:?}, slopes {slope:?}");
                for ([most, mean], bounds) in [(value, [2e-6, 2e-7]), (slope, [1e-4, 2e-5])] {
                    let what = format!("{name} w={width} kappa={kappa}");
                    assert!(kappa * most < bounds[0], "{what}: {most}");
                    assert!(kappa * mean < bounds[1], "{what}: {mean} on average");
                }
            }
        }
    }

    #[test]
    fn cubic_section_table_is_zero_where_nothing_is_cut() {
        let kernel = kernel_named("gaussian").unwrap();
        let desc = desc(&*kernel, 1.0, 1.0);
        let table = CubicSectionTable::for_frame(&desc, &FrameHandle::new()).unwrap();
        for front in [-50.0, -3.0, 2.0, 50.0] {
            for rho_squared in [0.0, 0.77, 4.0] {
                let weight = table.weight(rho_squared, [front, front + 1.0]);
                assert_eq!(weight, 0.0, "{front} {rho_squared}");
            }
        }
    }
}
