//! Which pixels of a tile may still change, and which are therefore summed: those, and their neighbours.

use std::ops::Range;

/// The run of open pixels on every row of a tile, as in `open_pixels`, and the runs that are summed for them.
#[derive(Clone, Debug, Default)]
pub(super) struct Open {
    /// Columns of the tile, from the first open pixel to the last.
    open: Vec<Range<usize>>,
    /// Columns of the sheet, which has a border: row `y` of the tile is row `y + 1` here.
    summed: Vec<Range<usize>>,
    /// Rows of the sheet outside of which nothing is summed.
    rows: Range<usize>,
}

impl Open {
    /// Opens all of the first `n_columns` in the first `n_rows`, the part of a tile that is inside the image.
    pub(super) fn open_all(&mut self, [n_columns, n_rows]: [usize; 2]) {
        self.open.clear();
        self.open.resize(n_rows, 0..n_columns);
        self.summed.resize(n_rows + 2, 0..0);
        self.follow();
    }

    /// Whether no pixel can change any more.
    pub(super) fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// The open run of a row of the tile.
    pub(super) fn open(&self, row: usize) -> Range<usize> {
        self.open[row].clone()
    }

    /// Rows of the tile.
    pub(super) fn n_rows(&self) -> usize {
        self.open.len()
    }

    /// Rows of the sheet that are summed.
    #[inline]
    pub(super) fn summed_rows(&self) -> Range<usize> {
        self.rows.clone()
    }

    /// The run of a row of the sheet that is summed.
    #[inline]
    pub(super) fn summed(&self, row: usize) -> Range<usize> {
        self.summed[row].clone()
    }

    /// Closes the pixels at both ends of each run for which `is_closed` holds.
    pub(super) fn close(&mut self, is_closed: impl Fn([usize; 2]) -> bool) {
        for (row, run) in self.open.iter_mut().enumerate() {
            while run.start < run.end && is_closed([run.start, row]) {
                run.start += 1;
            }
            while run.start < run.end && is_closed([run.end - 1, row]) {
                run.end -= 1;
            }
        }
        self.follow();
    }

    /// Makes the summed runs those of the open ones.
    fn follow(&mut self) {
        self.summed.fill(0..0);
        for (row, run) in self.open.iter().enumerate().filter(|(_, run)| !run.is_empty()) {
            // One more on either side, and the run itself above and below; a column of the tile is one further
            // right in the sheet.
            join(&mut self.summed[row + 1], run.start..run.end + 2);
            join(&mut self.summed[row], run.start + 1..run.end + 1);
            join(&mut self.summed[row + 2], run.start + 1..run.end + 1);
        }
        let is_summed = |run: &Range<usize>| !run.is_empty();
        let first = self.summed.iter().position(is_summed);
        let last = self.summed.iter().rposition(is_summed);
        self.rows = first.zip(last).map_or(0..0, |(first, last)| first..last + 1);
    }
}

fn join(run: &mut Range<usize>, other: Range<usize>) {
    *run = if run.start < run.end {
        run.start.min(other.start)..run.end.max(other.end)
    } else {
        other
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn open_sums_neighbours() {
        let mut open = Open::default();
        open.open_all([9, 5]);
        open.open_all([4, 2]);
        assert_eq!((open.summed_rows(), open.summed(0), open.summed(1)), (0..4, 1..5, 0..6));
        open.close(|[column, row]| row == 1 || column != 2);
        assert_eq!((open.open(0), open.open(1).is_empty()), (2..3, true));
        assert_eq!(open.summed_rows(), 0..3);
        assert_eq!([0, 1, 2].map(|row| open.summed(row)), [3..4, 2..5, 3..4]);
        open.close(|_| true);
        assert!(open.is_empty());
    }
}
