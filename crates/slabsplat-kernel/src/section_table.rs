//! The section table (paper §3.2, figure 5): a kernel's sections by one slab width, sampled along the
//! radius and along the offset of the slab from the voxel.
//!
//! A row holds one section from its edge to its middle, at equal steps of the *half chord* `√(R² − ρ²)`. A
//! truncated kernel ends like a square root of the distance from its edge, which equal steps of `ρ` miss by
//! far; over the half chord it is smooth from end to end. The rows stand `(2R + w)/sections` apart in offset,
//! all in index space. A plain section looks the same from both sides, so only half of the rows are stored,
//! named by their *depth*: how far into the kernel the slab goes from the nearer end. A slab wider than the
//! kernel cuts nothing more at depth `2R` than at any larger one, so that is where its rows end. A normalised
//! section is not symmetric (`hierarchy.rs`) and has all its rows.

use crate::SectionDesc;
use crate::kernel::half_chord;
use slabsplat_core::{Cancelled, FrameHandle, Lookup, Normalization};

/// How finely a [`SectionTable`] is sampled, and how it is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TableDesc {
    /// Rows over all offsets at which slab and kernel meet; the paper takes 128.
    pub sections: u32,
    /// Samples from the middle of a section to its edge.
    pub radial_samples: u32,
    /// How an offset between two rows is read.
    pub lookup: Lookup,
}

/// Sampled sections of one kernel by slabs of one width.
#[derive(Clone, Debug, PartialEq)]
pub struct SectionTable {
    rows: RowMap,
    lookup: Lookup,
    /// Values in a row: samples 0 to `radial_samples`, and the last once more, so that interpolation
    /// never looks past the end.
    row_len: usize,
    samples_per_index: f32,
    /// Slab width in index units, and distance between rows.
    width: f64,
    row_spacing: f64,
    weights: Vec<f32>,
}

/// Where along the rows of a table an offset lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RowMap {
    /// The kernel's radius in index units.
    pub radius: f32,
    /// Rows per index unit of depth.
    pub rows_per_index: f32,
    /// The last row, with the fraction at which the kernel ends.
    pub last_row: f32,
    /// Whether the depth is measured from the nearer end, or always from the front.
    pub mirrored: bool,
}

impl SectionTable {
    /// Samples the sections of `desc`; some `sections × radial_samples` exact integrals.
    pub fn new(desc: &SectionDesc<'_>, table: TableDesc) -> Self {
        Self::for_frame(desc, table, &FrameHandle::new()).expect("nobody cancels the frame")
    }

    /// The same for a frame: of normalised sections, and at the most that settings ask for, they take
    /// seconds.
    ///
    /// # Errors
    /// If that is cancelled.
    pub fn for_frame(
        desc: &SectionDesc<'_>,
        table: TableDesc,
        frame: &FrameHandle,
    ) -> Result<Self, Cancelled> {
        let radius = desc.kernel.radius();
        let mirrored = desc.normalization == Normalization::None || desc.width <= desc.base_width;
        // A plain slab wider than the kernel cuts just what one as wide as it does.
        let width = if mirrored { desc.width.min(2.0 * radius / desc.kappa) } else { desc.width };
        let desc = &SectionDesc { width, ..*desc };
        let row_spacing = row_spacing(desc, table);
        let deepest = if mirrored {
            radius + 0.5 * desc.width_in_index()
        } else {
            2.0 * radius + desc.width_in_index()
        };
        let n_intervals = (deepest / row_spacing - 1e-9).ceil();
        // The offset of row 0: the slab's back face just touches the kernel.
        let first_front = -radius - desc.width_in_index();
        let mut weights = Vec::new();
        for row_idx in 0..=n_intervals as usize {
            let front = first_front + row_idx as f64 * row_spacing;
            // A single row may take tens of milliseconds.
            let weight = |rho| frame.check().map(|()| desc.weight(rho, front));
            weights.extend(sample_row(table.radial_samples, radius, weight)?);
        }
        Ok(Self {
            rows: RowMap {
                radius: radius as f32,
                rows_per_index: (1.0 / row_spacing) as f32,
                last_row: (deepest / row_spacing) as f32,
                mirrored,
            },
            lookup: table.lookup,
            row_len: row_len(table.radial_samples),
            samples_per_index: (f64::from(table.radial_samples) / radius) as f32,
            width: desc.width_in_index(),
            row_spacing,
            weights,
        })
    }

    /// The weight, at distance `rho`, of the section between the faces `front` and `back`, which cut the
    /// ray that many index units behind its point nearest to the voxel.
    #[inline]
    pub fn sample(&self, rho: f32, front: f32, back: f32) -> f32 {
        let position = self.samples_per_index * half_chord_f32(self.rows.radius, rho);
        self.sample_at(position, front, back)
    }

    /// As [`sample`](Self::sample), at `position` samples from the start of a row.
    #[inline]
    pub fn sample_at(&self, position: f32, front: f32, back: f32) -> f32 {
        let (row_idx, t) = self.row_at(front, back);
        let near = lerp_radial(self.row(row_idx), position);
        if t == 0.0 {
            return near;
        }
        near + t * (lerp_radial(self.row(row_idx + 1), position) - near)
    }

    /// Values in a row.
    pub fn row_len(&self) -> usize {
        self.row_len
    }

    /// Number of rows stored.
    pub fn n_rows(&self) -> usize {
        self.weights.len() / self.row_len
    }

    /// All rows, one after the other.
    pub fn weights(&self) -> &[f32] {
        &self.weights
    }

    /// All rows, each by itself.
    pub(crate) fn all_rows(&self) -> Vec<&[f32]> {
        self.weights.chunks_exact(self.row_len).collect()
    }

    /// Where the faces of a row's slab cut the ray: index units behind its point nearest to the voxel.
    pub(crate) fn faces_of_row(&self, row_idx: usize) -> [f64; 2] {
        let back = row_idx as f64 * self.row_spacing - f64::from(self.rows.radius);
        [back - self.width, back]
    }

    /// Samples in a row per index unit of half chord.
    pub fn samples_per_index(&self) -> f32 {
        self.samples_per_index
    }

    /// Which row an offset reads.
    pub fn rows(&self) -> RowMap {
        self.rows
    }

    /// How an offset between two rows is read.
    pub fn lookup(&self) -> Lookup {
        self.lookup
    }

    /// The row at or below the section between two faces, and how far it is to the next one, 0 … 1. Where
    /// that is 0 there need not be a next one.
    #[inline(always)]
    pub fn row_at(&self, front: f32, back: f32) -> (usize, f32) {
        let position = self.rows.position(front, back);
        match self.lookup {
            Lookup::Nearest => ((position + 0.5) as usize, 0.0),
            Lookup::Linear => {
                let row_idx = position as usize;
                (row_idx, position - row_idx as f32)
            }
        }
    }

    #[inline]
    fn row(&self, row_idx: usize) -> &[f32] {
        &self.weights[row_idx * self.row_len..][..self.row_len]
    }
}

impl RowMap {
    /// Rows from the first, with a fraction.
    #[inline(always)]
    fn position(self, front: f32, back: f32) -> f32 {
        let from_front = back + self.radius;
        let depth = if self.mirrored { from_front.min(self.radius - front) } else { from_front };
        (depth * self.rows_per_index).clamp(0.0, self.last_row)
    }
}

fn half_chord_f32(radius: f32, rho: f32) -> f32 {
    (radius * radius - rho * rho).max(0.0).sqrt()
}

/// Interpolates a row of a table at `position` samples from its start, 0 … 4096: the half chord times the
/// table's samples per index unit.
#[inline]
pub fn lerp_radial(row: &[f32], position: f32) -> f32 {
    // Adding 1½·2²³ rounds to whole numbers and leaves them in the low bits: the same as a cast and
    // back, without the casts' checks, which cost as much as the rest. At a tie either neighbour
    // serves, as t is then 0 or 1.
    const MAGIC: f32 = 12_582_912.0;
    let rounded = (position - 0.5) + MAGIC;
    let idx = rounded.to_bits().wrapping_sub(MAGIC.to_bits()) as usize;
    let t = position - (rounded - MAGIC);
    row[idx] + t * (row[idx + 1] - row[idx])
}

/// Distance between rows in index space: the paper's, but never coarser than it is for a slab as wide as
/// the kernel, or thick slabs would be read from ever fewer rows. Rows that are interpolated are
/// never further apart than for the thinnest of slabs, nor than a quarter of a slab, as far as there can
/// be that many: with the paper's, slabs as wide as the kernel miss by four times as much as thin ones.
fn row_spacing(desc: &SectionDesc<'_>, table: TableDesc) -> f64 {
    let kernel_extent = 2.0 * desc.kernel.radius();
    let width = desc.width_in_index().min(kernel_extent);
    let sections = f64::from(table.sections);
    match table.lookup {
        Lookup::Nearest => (kernel_extent + width) / sections,
        Lookup::Linear => {
            (kernel_extent / sections).min((0.25 * width).max(kernel_extent / MAX_ROWS))
        }
    }
}

/// Rows of a table, unless more are asked for: 4 MiB.
const MAX_ROWS: f64 = 4096.0;

pub(crate) fn row_len(radial_samples: u32) -> usize {
    radial_samples as usize + 2
}

/// Samples `weight_at` distances from `radius` down to 0, at equal steps of the half chord, and adds the
/// guard.
pub(crate) fn sample_row<E>(
    radial_samples: u32,
    radius: f64,
    weight_at: impl Fn(f64) -> Result<f64, E>,
) -> Result<Vec<f32>, E> {
    let step = radius / f64::from(radial_samples);
    let exact: Vec<f64> = (0..=radial_samples)
        .map(|sample| weight_at(half_chord(radius, f64::from(sample) * step)))
        .collect::<Result<_, E>>()?;
    let mut row: Vec<f32> = fitted(&exact).map(|weight| weight as f32).collect();
    row.push(exact[exact.len() - 1] as f32);
    Ok(row)
}

/// Values at the same points whose interpolation is right on average, where that of `exact` lies to one
/// side of a curve: a twelfth of the second difference lower. Many kernels overlap in a pixel, so that
/// errors of one sign would add up, and these cancel.
fn fitted(exact: &[f64]) -> impl Iterator<Item = f64> + '_ {
    let last = exact.len() - 1;
    exact.iter().enumerate().map(move |(idx, &here)| {
        if idx == 0 || idx == last {
            return here;
        }
        here - (exact[idx - 1] - 2.0 * here + exact[idx + 1]) / 12.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Gaussian, KERNEL_NAMES, Kernel, kernel_named};
    use std::sync::atomic::{AtomicUsize, Ordering};

    const PAPER: TableDesc =
        TableDesc { sections: 128, radial_samples: 256, lookup: Lookup::Nearest };
    const DEFAULT: TableDesc = TableDesc { lookup: Lookup::Linear, ..PAPER };

    fn desc<'a>(name: &str, width: f64, normalization: Normalization) -> SectionDesc<'a> {
        let kernel = Box::leak(Box::new(kernel_named(name).unwrap()));
        SectionDesc { kernel: &**kernel, width, kappa: 1.0, normalization, base_width: 0.5 }
    }

    /// Largest and mean error over a lattice of offsets and distances that hits no sample.
    fn errors(desc: &SectionDesc<'_>, table: TableDesc) -> (f64, f64) {
        let sampled = SectionTable::new(desc, table);
        let (radius, width) = (desc.kernel.radius(), desc.width_in_index());
        let (n_offsets, n_radii) = (701, 211);
        let (mut worst, mut sum) = (0.0_f64, 0.0);
        for o in 0..n_offsets {
            let front = -radius - width
                + (f64::from(o) + 0.3) / f64::from(n_offsets) * (2.0 * radius + width);
            for r in 0..n_radii {
                let rho = (f64::from(r) + 0.4) / f64::from(n_radii) * radius;
                let read = sampled.sample(rho as f32, front as f32, (front + width) as f32);
                let error = (f64::from(read) - desc.weight(rho, front)).abs();
                worst = worst.max(error);
                sum += error;
            }
        }
        (worst, sum / f64::from(n_offsets * n_radii))
    }

    /// The measured error of the table against the exact integral, per section.
    #[test]
    fn section_table_error_is_small() {
        for &name in KERNEL_NAMES {
            for width in [0.25, 0.5, 1.0, 2.0, 5.0, 100.0] {
                let desc = desc(name, width, Normalization::None);
                let (worst, mean) = errors(&desc, DEFAULT);
                println!("{name} w={width}: linear {worst:.1e} (mean {mean:.1e})");
                assert!(worst < 3e-4 && mean < 3e-5, "{name} w={width}: {worst} {mean}");
                let (worst, mean) = errors(&desc, PAPER);
                println!("{name} w={width}: nearest {worst:.1e} (mean {mean:.1e})");
                assert!(worst < 2e-2 && mean < 2e-3, "{name} w={width}: {worst} {mean}");
            }
        }
    }

    #[test]
    fn section_table_error_is_small_when_normalized() {
        for normalization in [Normalization::Paper, Normalization::Product] {
            for width in [0.75, 1.0, 2.0, 3.0, 16.0] {
                let (worst, mean) = errors(&desc("gaussian", width, normalization), DEFAULT);
                println!("{normalization} w={width}: {worst:.1e} (mean {mean:.1e})");
                assert!(worst < 3e-4 && mean < 3e-5, "{normalization} w={width}: {worst} {mean}");
            }
        }
    }

    #[test]
    fn section_table_doubled_resolution_quarters_the_error() {
        let desc = desc("gaussian", 1.0, Normalization::None);
        let (_, coarse) = errors(&desc, DEFAULT);
        let twice = TableDesc { sections: 256, radial_samples: 512, ..DEFAULT };
        let (_, fine) = errors(&desc, twice);
        assert!(fine < 0.35 * coarse, "{coarse} {fine}");
    }

    /// §3.2: "symmetry allows the reuse of sections for part of the kernel width".
    #[test]
    fn section_table_stores_half_if_symmetric() {
        let plain = SectionTable::new(&desc("gaussian", 1.0, Normalization::None), PAPER);
        assert_eq!(plain.n_rows(), 65);
        let normalized = SectionTable::new(&desc("gaussian", 1.0, Normalization::Product), PAPER);
        assert_eq!(normalized.n_rows(), 129);
        assert_eq!(plain.sample(0.4, -1.2, -0.2), plain.sample(0.4, 0.2, 1.2));
    }

    #[test]
    fn section_table_rows_are_sections_between_their_faces() {
        let desc = SectionDesc { kappa: 0.8, ..desc("crawfis-max", 0.7, Normalization::None) };
        let table = SectionTable::new(&desc, DEFAULT);
        let rows = table.all_rows();
        assert_eq!((rows.len(), table.row_len()), (table.n_rows(), 258));
        assert_eq!(rows.concat(), table.weights());
        for (row_idx, row) in rows.into_iter().enumerate() {
            let [front, back] = table.faces_of_row(row_idx);
            assert!((back - front - desc.width_in_index()).abs() < 1e-12, "{row_idx}");
            for rho in [0.0, 0.4, 1.1, 1.5] {
                let half_chord = half_chord(desc.kernel.radius(), rho) as f32;
                let read = lerp_radial(row, half_chord * table.samples_per_index());
                let error = (f64::from(read) - desc.weight(rho, front)).abs();
                assert!(error < 1e-4, "{row_idx} {rho}: {error}");
            }
        }
    }

    #[test]
    fn section_table_reads_the_nearest_row_or_two() {
        let desc = desc("gaussian", 1.0, Normalization::None);
        for (lookup, near, far) in
            [(Lookup::Nearest, (9, 0.0), (10, 0.0)), (Lookup::Linear, (9, 0.25), (9, 0.75))]
        {
            let table = SectionTable::new(&desc, TableDesc { lookup, ..PAPER });
            let at = |rows: f64| {
                let [front, back] = [0, 1].map(|face| {
                    table.faces_of_row(9)[face] + rows / f64::from(table.rows().rows_per_index)
                });
                let (row_idx, t) = table.row_at(front as f32, back as f32);
                (row_idx, (64.0 * t).round() / 64.0)
            };
            assert_eq!((at(0.25), at(0.75)), (near, far), "{lookup}");
        }
    }

    /// Never further apart than the paper's of the thinnest slabs, nor than a quarter of a slab.
    #[test]
    fn section_table_rows_are_close() {
        let rows = |width: f64, table: TableDesc| {
            SectionTable::new(&desc("gaussian", width, Normalization::None), table).n_rows()
        };
        let coarse = TableDesc { radial_samples: 2, ..DEFAULT };
        assert_eq!(rows(4.0, coarse), 129, "4/128 apart over a depth of 2 + 4/2");
        assert_eq!(rows(1.0, coarse), 81, "4/128 apart over a depth of 2 + 1/2");
        assert_eq!(rows(0.04, coarse), 203, "0.04/4 apart over a depth of 2 + 0.04/2");
        assert_eq!(rows(1e-12, coarse), 2049, "4/4096 apart over a depth of 2");
        let nearest = TableDesc { lookup: Lookup::Nearest, ..coarse };
        assert_eq!(rows(1e-12, nearest), 65, "half of the paper's");
        assert_eq!(rows(9.0, nearest), 65, "half of the paper's");
        let smaller = desc("crawfis-max", 1e-12, Normalization::None);
        assert_eq!(SectionTable::new(&smaller, coarse).n_rows(), 2049, "a 4096th of its extent");
    }

    /// A polygon through them has the parabola's area.
    #[test]
    fn fitted_values_are_right_on_average() {
        let parabola: Vec<f64> = (0..6).map(|x: i32| f64::from(3 * x * x - 5 * x)).collect();
        let fitted: Vec<f64> = fitted(&parabola).collect();
        assert_eq!([fitted[0], fitted[5]], [parabola[0], parabola[5]], "the ends stay");
        let integral = |x: f64| x * x * x - 2.5 * x * x;
        for (x, pair) in fitted.windows(2).enumerate().take(4).skip(1) {
            let x = x as f64;
            let area = 0.5 * (pair[0] + pair[1]);
            assert!((area - (integral(x + 1.0) - integral(x))).abs() < 1e-12, "{x}: {area}");
        }
    }

    #[test]
    fn lerp_radial_draws_lines_between_samples() {
        let row = [0.0, 1.0, 5.0, 3.0, 3.0];
        for (position, expected) in
            [(0.0, 0.0), (0.5, 0.5), (1.0, 1.0), (1.25, 2.0), (1.75, 4.0), (2.5, 4.0), (3.0, 3.0)]
        {
            assert_eq!(lerp_radial(&row, position), expected, "{position}");
        }
    }

    /// A slab of 10¹² steps cuts what one of 4 does, and one no wider than the base is plain.
    #[test]
    fn section_table_of_extreme_widths() {
        let wide = SectionTable::new(&desc("gaussian", 1e12, Normalization::None), DEFAULT);
        assert!(wide.n_rows() <= 130);
        let half = wide.sample(0.5, 0.0, 1e12);
        let exact = desc("gaussian", 9.0, Normalization::None).weight(0.5, 0.0);
        assert!((f64::from(half) - exact).abs() < 1e-4, "{half} {exact}");
        let based =
            SectionDesc { base_width: 1e9, ..desc("gaussian", 1e9, Normalization::Product) };
        assert!(SectionTable::new(&based, DEFAULT).n_rows() <= 130);
    }

    /// Also where a slab is thinner than the paper's rows are apart.
    #[test]
    fn section_table_of_thin_slabs() {
        let (worst, _) = errors(&desc("gaussian", 0.04, Normalization::None), DEFAULT);
        assert!(worst < 1.2e-5, "{worst}");
    }

    /// A kernel that cancels a frame when it is asked for its so-manieth integral.
    #[derive(Debug)]
    struct Cancelling {
        frame: FrameHandle,
        at_integral: usize,
        n_integrals: AtomicUsize,
    }

    impl Kernel for Cancelling {
        fn name(&self) -> &str {
            "cancelling"
        }

        fn radius(&self) -> f64 {
            Gaussian.radius()
        }

        fn value(&self, r: f64) -> f64 {
            Gaussian.value(r)
        }

        fn line_integral(&self, rho: f64, a: f64, b: f64) -> f64 {
            if self.n_integrals.fetch_add(1, Ordering::Relaxed) == self.at_integral {
                self.frame.cancel();
            }
            Gaussian.line_integral(rho, a, b)
        }
    }

    /// Not a row later: after the very sample at which it is cancelled.
    #[test]
    fn section_table_stops_when_cancelled() {
        for normalization in [Normalization::None, Normalization::Paper] {
            for at_integral in [0, 1, 70, 7000] {
                let kernel = Cancelling {
                    frame: FrameHandle::new(),
                    at_integral,
                    n_integrals: AtomicUsize::new(0),
                };
                let desc = SectionDesc { kernel: &kernel, ..desc("gaussian", 4.0, normalization) };
                let made = SectionTable::for_frame(&desc, DEFAULT, &kernel.frame);
                assert_eq!(made, Err(Cancelled));
                // Of one sample: the section, and those of the hierarchy over eight of half a step.
                let most_of_sample = 1 + 1 + 8;
                let n_integrals = kernel.n_integrals.into_inner();
                assert!(n_integrals <= at_integral + most_of_sample, "{n_integrals}");
            }
        }
    }

    #[test]
    fn section_table_is_zero_where_nothing_is_cut() {
        let table = SectionTable::new(&desc("gaussian", 1.0, Normalization::None), DEFAULT);
        for (rho, front) in [(0.0, 2.0), (0.0, -3.0), (0.0, 50.0), (2.0, -0.5), (9.0, -0.5)] {
            assert_eq!(table.sample(rho, front, front + 1.0), 0.0, "{rho} {front}");
        }
    }
}
