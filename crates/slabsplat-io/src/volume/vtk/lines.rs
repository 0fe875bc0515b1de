//! A legacy file line by line, with numbers between the lines.

use std::io::{self, BufRead, BufReader, Read, Seek};

use super::super::formats::Input;
use super::text::next_token;
use crate::IoError;
use crate::store::StoredFile;

/// A file that is read line by line.
pub(super) struct Lines<'a> {
    pub(super) input: &'a Input<'a>,
    pub(super) reader: BufReader<StoredFile<'a>>,
    pub(super) n_bytes: u64,
}

const MAX_LINE_BYTES: u64 = 1 << 16;

impl Lines<'_> {
    /// The next line that is not blank, without blanks around it.
    pub(super) fn next(&mut self) -> Result<Option<String>, IoError> {
        while let Some(line) = self.next_raw()? {
            if !line.trim().is_empty() {
                return Ok(Some(line.trim().to_owned()));
            }
        }
        Ok(None)
    }

    pub(super) fn next_raw(&mut self) -> Result<Option<String>, IoError> {
        let mut bytes = Vec::new();
        let n_read = (&mut self.reader).take(MAX_LINE_BYTES).read_until(b'\n', &mut bytes);
        let n_read = n_read.map_err(IoError::read(self.input.path))? as u64;
        if n_read == MAX_LINE_BYTES && !bytes.ends_with(b"\n") {
            return Err(self.malformed("a line of the header is longer than 64 KiB"));
        }
        Ok((0 < n_read).then(|| String::from_utf8_lossy(&bytes).into_owned()))
    }

    pub(super) fn at(&mut self) -> Result<u64, IoError> {
        self.reader.stream_position().map_err(IoError::read(self.input.path))
    }

    pub(super) fn numbers<T: std::str::FromStr + Copy + Default, const N: usize>(
        &self,
        keyword: &str,
        words: &[&str],
    ) -> Result<[T; N], IoError> {
        let mut numbers = [T::default(); N];
        for (idx, number) in numbers.iter_mut().enumerate() {
            let parsed = words.get(idx).and_then(|word| word.parse().ok());
            *number = parsed
                .ok_or_else(|| self.malformed(&format!("{keyword} should have {N} numbers")))?;
        }
        Ok(numbers)
    }

    /// After `SCALARS` may be the name of a table.
    pub(super) fn pass_over_table_name(&mut self) -> Result<(), IoError> {
        let start = self.at()?;
        let mut keyword = [0; 12];
        let path = self.input.path;
        let n_read = (&mut self.reader).take(12).read(&mut keyword).map_err(IoError::read(path))?;
        if n_read == 12 && keyword.eq_ignore_ascii_case(b"LOOKUP_TABLE") {
            return self.next_raw().map(drop);
        }
        let back = io::SeekFrom::Start(start);
        self.reader.seek(back).map(drop).map_err(IoError::read(path))
    }

    /// Names of components and the like, up to a blank line.
    pub(super) fn pass_over_metadata(&mut self) -> Result<(), IoError> {
        while let Some(line) = self.next_raw()? {
            if line.trim().is_empty() {
                break;
            }
        }
        Ok(())
    }

    pub(super) fn pass_over_bytes(&mut self, n_bytes: u64) -> Result<(), IoError> {
        let n_left = self.n_bytes.saturating_sub(self.at()?);
        if n_left < n_bytes {
            return Err(self.input.too_short(n_bytes, n_left));
        }
        let n_bytes = i64::try_from(n_bytes).unwrap_or(i64::MAX);
        self.reader.seek_relative(n_bytes).map_err(IoError::read(self.input.path))
    }

    pub(super) fn pass_over_tokens(&mut self, n_tokens: u64) -> Result<(), IoError> {
        let mut token = Vec::new();
        for n_found in 0..n_tokens {
            if !next_token(&mut self.reader, &mut token).map_err(|e| self.input.failed(e))? {
                let what = format!("needs {n_tokens} numbers, has {n_found}: the file is cut off");
                return Err(self.malformed(&what));
            }
        }
        Ok(())
    }

    pub(super) fn malformed(&self, what: &str) -> IoError {
        IoError::malformed(self.input.path, what)
    }
}
