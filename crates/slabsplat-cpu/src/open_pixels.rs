//! Which pixels of a tile may still change: early splat elimination (Mueller, Shareef, Huang & Crawfis,
//! "High-Quality Splatting on Rectilinear Grids with Efficient Culling of Occluded Voxels", IEEE
//! TVCG 5(2), 1999), a run of pixels for every row.
//!
//! A pixel is closed once it is as opaque as the plan's cut-off: what lies behind it is not drawn. A row's
//! open pixels are kept as one run, from the first open pixel to the last. That is less than the
//! paper's occlusion map could tell, but looking after it costs next to nothing, and runs of footprints
//! are cut to it without a test in the inner loop.

use std::ops::Range;

/// The open run of every row of a tile.
#[derive(Clone, Debug)]
pub(crate) struct OpenPixels {
    columns: Vec<Range<usize>>,
    /// Rows outside of which nothing is open.
    rows: Range<usize>,
}

impl OpenPixels {
    /// All of the first `n_columns` in the first `n_rows`, the part of a tile that is inside the image.
    pub(crate) fn all([n_columns, n_rows]: [usize; 2]) -> Self {
        Self { columns: vec![0..n_columns; n_rows], rows: 0..n_rows }
    }

    /// Whether no pixel can change any more.
    pub(crate) fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Rows outside of which nothing is open.
    #[inline]
    pub(crate) fn rows(&self) -> Range<usize> {
        self.rows.clone()
    }

    /// The open run of a row.
    #[inline]
    pub(crate) fn columns(&self, row: usize) -> Range<usize> {
        self.columns[row].clone()
    }

    /// Whether a pixel of the rectangle may be open.
    #[inline]
    pub(crate) fn meets(&self, columns: &Range<usize>, rows: Range<usize>) -> bool {
        let open = |run: &Range<usize>| run.start.max(columns.start) < run.end.min(columns.end);
        !rows.is_empty() && self.columns[rows].iter().any(open)
    }

    /// Closes the pixels at both ends of each run that are at least as opaque as `cutoff`.
    pub(crate) fn close(&mut self, pixels: &[[f32; 4]], side: usize, cutoff: f32) {
        for row in self.rows() {
            let is_closed = |column: usize| cutoff <= pixels[row * side + column][3];
            let run = &mut self.columns[row];
            while run.start < run.end && is_closed(run.start) {
                run.start += 1;
            }
            while run.start < run.end && is_closed(run.end - 1) {
                run.end -= 1;
            }
        }
        while !self.rows.is_empty() && self.columns[self.rows.start].is_empty() {
            self.rows.start += 1;
        }
        while !self.rows.is_empty() && self.columns[self.rows.end - 1].is_empty() {
            self.rows.end -= 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn open_pixels_close_from_both_ends() {
        let side = 4;
        let mut open = OpenPixels::all([4, 2]);
        let mut pixels = vec![[0.0; 4]; 8];
        let mut fill = |open: &mut OpenPixels, places: &[usize]| {
            places.iter().for_each(|&place| pixels[place][3] = 0.95);
            open.close(&pixels, side, 0.9);
        };
        fill(&mut open, &[0, 2]);
        assert_eq!(open.columns(0), 1..4, "a closed pixel between open ones stays in the run");
        fill(&mut open, &[3, 4]);
        assert_eq!((open.columns(0), open.columns(1)), (1..2, 1..4));
        assert!(
            open.meets(&(0..2), 0..1) && !open.meets(&(2..4), 0..1) && open.meets(&(2..4), 0..2)
        );
        fill(&mut open, &[1]);
        assert_eq!(open.rows(), 1..2);
        fill(&mut open, &[5, 6, 7]);
        assert!(open.is_empty());
    }
}
