//! The bytes of a data set as they would be without chunks, some rows at once.

use std::collections::VecDeque;
use std::io::{self, Cursor, Read};

use hdf5_pure::Dataset;

use super::super::parallel;
use super::super::placed::Source;
use super::refusals::as_io_error;

/// Bytes that are unpacked at once by a thread, unless one layer of chunks or one row has more.
const WINDOW_BYTES: u64 = 8 << 20;

/// All threads together unpack at most such a share of the data set at once.
const MAX_SHARE: u64 = 4;

/// A data set, as far as it was read.
pub(super) struct Rows {
    dataset: Dataset,
    n_rows: u64,
    row_bytes: u64,
    /// Rows that are read together: whole layers of chunks, so that none is unpacked twice.
    n_at_once: u64,
    next_row: u64,
    n_workers: usize,
    windows: VecDeque<Cursor<Vec<u8>>>,
}

impl Rows {
    pub(super) fn of(dataset: Dataset, shape: &[usize], item_bytes: u64) -> Self {
        let (n_rows, row) = shape.split_first().map_or((1, shape), |(n, row)| (*n as u64, row));
        let row_bytes = row.iter().fold(item_bytes, |n, len| n.saturating_mul(*len as u64));
        let chunk = dataset.chunk_shape().ok().flatten();
        let is_packed = chunk.is_some();
        let n_in_chunk = chunk.and_then(|shape| shape.first().copied()).unwrap_or(1).max(1);
        let n_at_once = (WINDOW_BYTES / row_bytes.max(1)).max(1);
        let n_at_once = n_at_once.checked_next_multiple_of(n_in_chunk).unwrap_or(u64::MAX);
        // What is not packed takes no longer than to read it.
        let n_most = if is_packed { n_rows / n_at_once.saturating_mul(MAX_SHARE) } else { 1 };
        let n_workers = rayon::current_num_threads().min(n_most as usize).max(1);
        let windows = VecDeque::new();
        Self { dataset, n_rows, row_bytes, n_at_once, next_row: 0, n_workers, windows }
    }

    /// What is unpacked and not read yet, next.
    fn window(&mut self) -> Option<&mut Cursor<Vec<u8>>> {
        while self.windows.front().is_some_and(|window| n_left(window) == 0) {
            self.windows.pop_front();
        }
        self.windows.front_mut()
    }

    fn unpack(&mut self) -> io::Result<()> {
        let Self { dataset, n_rows, n_at_once, next_row, n_workers, windows, .. } = self;
        let starts = (0..*n_workers as u64).map(|idx| *next_row + idx.saturating_mul(*n_at_once));
        let starts: Vec<u64> = starts.take_while(|start| start < n_rows).collect();
        let read = |(): &mut (), start: &u64| {
            let bytes = dataset.read_raw_rows(*start, (*n_at_once).min(*n_rows - start));
            bytes.map_err(|error| as_io_error(dataset, &error))
        };
        parallel::in_order(&mut vec![(); starts.len()], &starts, read, |start, bytes| {
            *next_row = start.saturating_add(*n_at_once).min(*n_rows);
            windows.push_back(Cursor::new(bytes));
            Ok(())
        })
    }
}

fn n_left(window: &Cursor<Vec<u8>>) -> u64 {
    (window.get_ref().len() as u64).saturating_sub(window.position())
}

impl Read for Rows {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        if self.window().is_none() && self.next_row < self.n_rows {
            self.unpack()?;
        }
        self.window().map_or(Ok(0), |window| window.read(bytes))
    }
}

impl Source for Rows {
    /// Rows that nobody wants are not unpacked.
    fn pass_over(&mut self, n_bytes: u64) -> io::Result<()> {
        let mut n_bytes = n_bytes;
        while let Some(window) = self.window() {
            let n_passed = n_bytes.min(n_left(window));
            window.set_position(window.position() + n_passed);
            n_bytes -= n_passed;
            if n_bytes == 0 {
                return Ok(());
            }
        }
        let n_rows = (n_bytes / self.row_bytes.max(1)).min(self.n_rows - self.next_row);
        self.next_row += n_rows;
        io::copy(&mut self.take(n_bytes - n_rows * self.row_bytes), &mut io::sink()).map(drop)
    }
}
