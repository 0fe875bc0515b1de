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
mod tests;
