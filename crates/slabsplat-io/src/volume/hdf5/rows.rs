//! The bytes of a data set as they would be without chunks, some rows at once.

use std::io::{self, Cursor, Read};

use hdf5_pure::Dataset;

use super::super::placed::Source;
use super::refusals::as_io_error;

/// Bytes that are unpacked at once, unless one layer of chunks or one row has more.
const WINDOW_BYTES: u64 = 8 << 20;

/// A data set, as far as it was read.
pub(super) struct Rows {
    dataset: Dataset,
    n_rows: u64,
    row_bytes: u64,
    /// Rows that are read together: whole layers of chunks, so that none is unpacked twice.
    n_at_once: u64,
    next_row: u64,
    window: Cursor<Vec<u8>>,
}

impl Rows {
    pub(super) fn of(dataset: Dataset, shape: &[usize], item_bytes: u64) -> Self {
        let (n_rows, row) = shape.split_first().map_or((1, shape), |(n, row)| (*n as u64, row));
        let row_bytes = row.iter().fold(item_bytes, |n, len| n.saturating_mul(*len as u64));
        let chunk = dataset.chunk_shape().ok().flatten();
        let n_in_chunk = chunk.and_then(|shape| shape.first().copied()).unwrap_or(1).max(1);
        let n_at_once = (WINDOW_BYTES / row_bytes.max(1)).max(1);
        let n_at_once = n_at_once.checked_next_multiple_of(n_in_chunk).unwrap_or(u64::MAX);
        let window = Cursor::new(Vec::new());
        Self { dataset, n_rows, row_bytes, n_at_once, next_row: 0, window }
    }

    fn n_left_in_window(&self) -> u64 {
        (self.window.get_ref().len() as u64).saturating_sub(self.window.position())
    }

    fn fill(&mut self) -> io::Result<()> {
        let n_rows = self.n_at_once.min(self.n_rows - self.next_row);
        let bytes = self.dataset.read_raw_rows(self.next_row, n_rows);
        let bytes = bytes.map_err(|error| as_io_error(&self.dataset, &error))?;
        self.next_row += n_rows;
        self.window = Cursor::new(bytes);
        Ok(())
    }
}

impl Read for Rows {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        if self.n_left_in_window() == 0 && self.next_row < self.n_rows {
            self.fill()?;
        }
        self.window.read(bytes)
    }
}

impl Source for Rows {
    /// Rows that nobody wants are not unpacked.
    fn pass_over(&mut self, n_bytes: u64) -> io::Result<()> {
        let in_window = self.n_left_in_window();
        if n_bytes <= in_window {
            self.window.set_position(self.window.position() + n_bytes);
            return Ok(());
        }
        let n_left = n_bytes - in_window;
        let n_rows = (n_left / self.row_bytes.max(1)).min(self.n_rows - self.next_row);
        self.window = Cursor::new(Vec::new());
        self.next_row += n_rows;
        io::copy(&mut self.take(n_left - n_rows * self.row_bytes), &mut io::sink()).map(drop)
    }
}
