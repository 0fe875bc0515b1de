//! A sheet of densities over one tile and its border, and the loop that adds sections to it.
//!
//! ```text
//! for each row of the ellipse ρ ≤ ρ_max that is summed:
//!     find the run of pixels inside; for each:
//!         ρ² = along·Y² + across·(X + lean·Y)²
//!         H = weight(ρ², …)
//!         length += H, weighted value += H·value
//! ```

use super::summed::{SHEET_SIDE, Summed};
use crate::footprints::raster::PixelShape;
use std::ops::Range;

/// What a pixel of a sheet sums.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Sum {
    /// `ΣH`: the length of the ray in the slab, in `unit`s, as far as it is within the grid.
    pub(super) length: f32,
    /// `ΣH·v`, values scaled.
    pub(super) weighted: f32,
}

/// The sums of a tile and of the pixels beside it.
#[derive(Debug)]
pub(super) struct Sheet {
    sums: Box<[[Sum; SHEET_SIDE]; SHEET_SIDE]>,
    /// Rows that may hold something.
    rows: Range<usize>,
}

impl Default for Sheet {
    fn default() -> Self {
        Self { sums: Box::new([[Sum::default(); SHEET_SIDE]; SHEET_SIDE]), rows: 0..0 }
    }
}

/// A section that is about to be splatted.
#[derive(Clone, Copy, Debug)]
pub(super) struct Section {
    /// Its centre, in pixels from the sheet's upper left corner.
    pub(super) center: [f32; 2],
    /// The kernel's radius in index units.
    pub(super) radius: f32,
    /// Where it ends, in index units from the centre: at the radius, or before it.
    pub(super) rho_max: f32,
    /// The voxel's value, scaled.
    pub(super) value: f32,
}

/// A pixel of a section.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// In index units squared.
    pub(super) rho_squared: f32,
    /// Pixels to the right of the centre, and below it.
    pub(super) offset: [f32; 2],
}

impl Sheet {
    pub(super) const BYTES: usize = size_of::<[[Sum; SHEET_SIDE]; SHEET_SIDE]>();

    pub(super) fn clear(&mut self) {
        self.sums[self.rows.clone()].fill([Sum::default(); SHEET_SIDE]);
        self.rows = 0..0;
    }

    /// Whether nothing was splatted.
    pub(super) fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// The sums of a pixel, in the sheet's columns and rows.
    #[inline]
    pub(super) fn at(&self, [column, row]: [usize; 2]) -> Sum {
        self.sums[row][column]
    }

    /// Adds a section where the sheet is summed. Returns whether that is anywhere.
    #[inline(always)]
    pub(super) fn add(
        &mut self,
        summed: &Summed,
        shape: &PixelShape,
        section: &Section,
        weight: impl Fn(Place) -> f32,
    ) -> bool {
        let Section { center: [cx, cy], radius, rho_max, value } = *section;
        // In index units squared, not in halves of the kernel's radius squared.
        let per_radius = 0.5 * radius * radius;
        let (across, lean, along) =
            (shape.across * per_radius, shape.lean, shape.along * per_radius);
        let half_height = shape.half_extent[1] * rho_max;
        let mut is_open = false;
        for row in pixels_between(cy - half_height, cy + half_height, summed.rows()) {
            let dy = row as f32 + 0.5 - cy;
            let along_squared = along * dy * dy;
            let half_width_squared = (rho_max * rho_max - along_squared) / across;
            if half_width_squared <= 0.0 {
                continue;
            }
            let (middle, half_width) = (cx - lean * dy, half_width_squared.sqrt());
            let run = pixels_between(middle - half_width, middle + half_width, summed.run(row));
            if run.is_empty() {
                continue;
            }
            is_open = true;
            self.touch(row);
            let first_dx = run.start as f32 + 0.5;
            let sums = &mut self.sums[row][run];
            for (column, sum) in sums.iter_mut().enumerate() {
                let x = first_dx + column as f32;
                let from_middle = x - middle;
                let rho_squared = along_squared + across * from_middle * from_middle;
                // A cubic may dip below 0 beside the edge; a density must stay a mean.
                let weight = weight(Place { rho_squared, offset: [x - cx, dy] }).max(0.0);
                sum.length += weight;
                sum.weighted += weight * value;
            }
        }
        is_open
    }

    #[inline]
    fn touch(&mut self, row: usize) {
        self.rows = if self.rows.is_empty() {
            row..row + 1
        } else {
            self.rows.start.min(row)..self.rows.end.max(row + 1)
        };
    }
}

/// The pixels of `within` that have their centres between two coordinates.
#[inline]
fn pixels_between(min: f32, max: f32, within: Range<usize>) -> Range<usize> {
    let [start, end] = [within.start, within.end].map(|pixel| pixel as f32);
    let first = ceil((min - 0.5).clamp(start, end));
    let end = (max + 0.5).clamp(start, end) as i32 as usize;
    first..end.max(first)
}

/// Rounds up what is neither negative nor large, without the call that `f32::ceil` is where the baseline
/// instruction set lacks it.
#[inline]
fn ceil(value: f32) -> usize {
    let down = value as i32;
    down as usize + usize::from((down as f32) < value)
}
