//! A section table that is read by cubics: for methods that take differences between neighbouring pixels
//! and slabs, where the kinks of linear interpolation would show as facets.
//!
//! Like a [`SectionTable`](crate::SectionTable) it runs over the half chord `√(R² − ρ²)` within a row, and over
//! the reach of the slab into the kernel from row to row. A row is cut into few cells, each with the four
//! coefficients of the cubic through four exact sections; between rows it is interpolated through the four
//! nearest. A row of 64 cells takes as much memory as one of 256 samples, and a look-up is one load instead
//! of two.

use crate::SectionDesc;
use crate::kernel::half_chord;

/// Cells in a row: the kernel's radius is 2 voxel steps or less.
const N_CELLS: usize = 64;

/// Rows per index unit, unless the slab is thin.
const ROWS_PER_INDEX: f64 = 64.0;

/// Rows over the thickness of a thin slab, as far as there may be so many.
const ROWS_PER_SLAB: f64 = 4.0;

/// Rows over a whole kernel, of which half are stored: 4 MiB.
const MAX_ROWS: f64 = 8192.0;

/// Sections of one kernel by slabs of one width, never normalised.
#[derive(Clone, Debug, PartialEq)]
pub struct CubicSectionTable {
    radius: f32,
    rows_per_index: f32,
    /// The last row that a reach may come before; one more lies behind it.
    last_row: f32,
    cells_per_index: f32,
    /// By rows, cells and powers. Row `k` is that of the reach `(k − 1)/rows_per_index`.
    coefficients: Vec<[f32; 4]>,
}

impl CubicSectionTable {
    /// Values in a row: the cells, and one that holds the value at their end.
    pub const ROW_LEN: usize = N_CELLS + 1;

    /// Samples the plain sections of `desc`; some ten thousand exact integrals.
    pub fn new(desc: &SectionDesc<'_>) -> Self {
        let radius = desc.kernel.radius();
        // A slab wider than the kernel cuts just what one as wide as it does.
        let width = desc.width.min(2.0 * radius / desc.kappa);
        let width_in_index = width * desc.kappa;
        let rows_per_index =
            (ROWS_PER_SLAB / width_in_index).clamp(ROWS_PER_INDEX, MAX_ROWS / (2.0 * radius));
        let deepest = radius + 0.5 * width_in_index;
        let n_rows = (deepest * rows_per_index).ceil() as usize + 4;
        let row = |row_idx: usize| {
            let reach = (row_idx as f64 - 1.0) / rows_per_index;
            let front = reach - radius - width_in_index;
            row_of_cells(radius, move |rho| desc.plain(rho, front, width))
        };
        Self {
            radius: radius as f32,
            rows_per_index: rows_per_index as f32,
            last_row: (deepest * rows_per_index) as f32,
            cells_per_index: (N_CELLS as f64 / radius) as f32,
            coefficients: (0..n_rows).flat_map(row).collect(),
        }
    }

    /// Cells in a row per index unit of half chord.
    pub fn cells_per_index(&self) -> f32 {
        self.cells_per_index
    }

    /// Writes the section between two faces, which cut the ray that many index units behind its point nearest
    /// to the voxel, to `row`, to be read by [`cubic_at`].
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

    /// One weight of the section between two faces, `position` cells from the start of a row; exactly 0 where the slab
    /// does not cut the ray within the kernel.
    #[inline]
    pub fn weight(&self, position: f32, faces: [f32; 2]) -> f32 {
        let half_chord = position / self.cells_per_index;
        if half_chord <= faces[0] || faces[1] <= -half_chord {
            return 0.0;
        }
        let (rows, shares) = self.rows_at(faces);
        let at = |k: usize| shares[k] * cubic_at(&rows[k * Self::ROW_LEN..], position);
        at(0) + at(1) + at(2) + at(3)
    }

    /// Four rows, the second of which is at or before the faces' reach, and the share of each.
    #[inline]
    fn rows_at(&self, [front, back]: [f32; 2]) -> (&[[f32; 4]], [f32; 4]) {
        let reach = (back + self.radius).min(self.radius - front);
        let position = (reach * self.rows_per_index).clamp(0.0, self.last_row);
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

/// Reads a row `position` cells from its start: the half chord times the table's cells per index unit.
#[inline]
pub fn cubic_at(row: &[[f32; 4]], position: f32) -> f32 {
    // As in `lerp_radial`: rounds without the checks of a cast. At a tie either cell serves.
    const MAGIC: f32 = 12_582_912.0;
    let rounded = (position - 0.5) + MAGIC;
    let idx = rounded.to_bits().wrapping_sub(MAGIC.to_bits()) as usize;
    let t = position - (rounded - MAGIC);
    let [a, b, c, d] = row[idx];
    a + t * (b + t * (c + t * d))
}

/// The cells from the edge of a section to its middle, at equal steps of the half chord.
fn row_of_cells(radius: f64, weight_at: impl Fn(f64) -> f64) -> Vec<[f32; 4]> {
    let step = radius / (3 * N_CELLS) as f64;
    let samples: Vec<f64> =
        (0..=3 * N_CELLS).map(|i| weight_at(half_chord(radius, i as f64 * step))).collect();
    let cubic = |cell: usize| {
        let [y0, y1, y2, y3] = [0, 1, 2, 3].map(|i| samples[3 * cell + i]);
        let slope = -5.5 * y0 + 9.0 * y1 - 4.5 * y2 + y3;
        let square = 9.0 * y0 - 22.5 * y1 + 18.0 * y2 - 4.5 * y3;
        let cube = -4.5 * y0 + 13.5 * y1 - 13.5 * y2 + 4.5 * y3;
        [y0, slope, square, cube].map(|c| c as f32)
    };
    let end = [samples[3 * N_CELLS] as f32, 0.0, 0.0, 0.0];
    (0..N_CELLS).map(cubic).chain([end]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{KERNEL_NAMES, kernel_named};
    use slabsplat_core::Normalization;

    /// Largest and mean error over offsets and distances that hit no sample.
    fn errors(desc: &SectionDesc<'_>) -> (f64, f64) {
        let table = CubicSectionTable::new(desc);
        let (radius, width) = (desc.kernel.radius(), desc.width_in_index());
        let (n_offsets, n_radii) = (211, 173);
        let (mut worst, mut sum) = (0.0_f64, 0.0);
        for i in 0..n_offsets {
            let reach =
                (2.0 * radius + width.min(3.0)) * (f64::from(i) + 0.37) / f64::from(n_offsets);
            let front = reach - radius - width;
            let faces = [front as f32, (front + width) as f32];
            let mut row = [[0.0; 4]; CubicSectionTable::ROW_LEN];
            table.blend(faces, &mut row);
            for j in 0..n_radii {
                let rho = radius * (f64::from(j) + 0.41) / f64::from(n_radii);
                let position = half_chord(radius, rho) as f32 * table.cells_per_index();
                let read = cubic_at(&row, position);
                let half_chord = half_chord(radius, rho);
                if front < half_chord && -half_chord < front + width {
                    assert!((read - table.weight(position, faces)).abs() < 2e-7, "{rho} {front}");
                } else {
                    assert_eq!(table.weight(position, faces), 0.0, "{rho} {front}");
                }
                let error = (f64::from(read) - desc.plain(rho, front, desc.width)).abs();
                worst = worst.max(error);
                sum += error;
            }
        }
        (worst, sum / f64::from(n_offsets * n_radii))
    }

    #[test]
    fn cubic_section_table_error_is_small() {
        for &name in KERNEL_NAMES {
            for (width, kappa) in
                [(0.05, 1.0), (0.3, 1.0), (1.0, 1.0), (1.0, 0.3), (2.0, 1.0), (100.0, 1.0)]
            {
                let kernel = kernel_named(name).unwrap();
                let desc = SectionDesc {
                    kernel: &*kernel,
                    width,
                    kappa,
                    normalization: Normalization::None,
                    base_width: 0.5,
                };
                let (worst, mean) = errors(&desc);
                println!("{name} w={width} kappa={kappa}: {worst:.1e} (mean {mean:.1e})");
                assert!(kappa * worst < 2e-5, "{name} w={width} kappa={kappa}: {worst}");
                assert!(kappa * mean < 1e-6, "{name} w={width} kappa={kappa}: {mean}");
            }
        }
    }

    #[test]
    fn cubic_section_table_is_zero_where_nothing_is_cut() {
        let kernel = kernel_named("gaussian").unwrap();
        let desc = SectionDesc {
            kernel: &*kernel,
            width: 1.0,
            kappa: 1.0,
            normalization: Normalization::None,
            base_width: 0.5,
        };
        let table = CubicSectionTable::new(&desc);
        for front in [-50.0, -3.0, 2.0, 50.0] {
            for position in [0.0, 7.7, N_CELLS as f32] {
                let weight = table.weight(position, [front, front + 1.0]);
                assert_eq!(weight, 0.0, "{front} {position}");
            }
        }
    }
}
