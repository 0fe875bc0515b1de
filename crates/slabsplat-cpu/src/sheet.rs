//! A sheet over one tile: the sums of SPEC §3.

use std::ops::Range;

/// Four sums a pixel, and the rectangle in which any of them may differ from 0.
#[derive(Debug, Default)]
pub(crate) struct Sheet {
    side: usize,
    sums: Vec<[f32; 4]>,
    columns: Range<usize>,
    rows: Range<usize>,
}

impl Sheet {
    /// Makes the sheet that of a tile of `side` pixels; it is empty then, as it is after
    /// [`drain`](Self::drain).
    pub(crate) fn resize(&mut self, side: usize) {
        if self.side != side {
            *self = Self { side, sums: vec![[0.0; 4]; side * side], ..Self::default() };
        }
    }

    /// A run of pixels, to be added to.
    #[inline]
    pub(crate) fn run(&mut self, row: usize, columns: Range<usize>) -> &mut [[f32; 4]] {
        if self.rows.is_empty() {
            self.rows = row..row + 1;
            self.columns = columns.clone();
        } else {
            self.rows = self.rows.start.min(row)..self.rows.end.max(row + 1);
            self.columns = self.columns.start.min(columns.start)..self.columns.end.max(columns.end);
        }
        let start = row * self.side;
        &mut self.sums[start + columns.start..start + columns.end]
    }

    /// Hands out every pixel that may hold something, with its place in the tile, and empties it.
    pub(crate) fn drain(&mut self, mut take: impl FnMut(usize, [f32; 4])) {
        for row in self.rows.clone() {
            for pixel_idx in
                row * self.side + self.columns.start..row * self.side + self.columns.end
            {
                take(pixel_idx, std::mem::take(&mut self.sums[pixel_idx]));
            }
        }
        (self.rows, self.columns) = (0..0, 0..0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sheet_drains_what_was_added() {
        let mut sheet = Sheet::default();
        sheet.resize(4);
        sheet.run(1, 2..4)[1] = [1.0; 4];
        sheet.run(3, 0..1)[0] = [2.0; 4];
        let mut taken = Vec::new();
        sheet.drain(|pixel_idx, sums| taken.push((pixel_idx, sums[0])));
        taken.retain(|&(_, sum)| sum != 0.0);
        assert_eq!(taken, [(7, 1.0), (12, 2.0)]);
        sheet.drain(|_, _| panic!("the sheet is empty"));
    }
}
