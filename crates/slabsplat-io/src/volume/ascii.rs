//! Samples written as text, with blanks, line ends or commas between.

use std::io::{BufRead, BufReader};
use std::path::Path;

use super::buffer::SampleBuffer;
use super::stream::DataStream;
use crate::IoError;

/// No number needs more digits: a 64-bit float written out in full has 1077.
const MAX_TOKEN_BYTES: usize = 2048;

/// Appends `n_samples` numbers. What comes after them is not looked at.
pub(super) fn read(
    path: &Path,
    stream: DataStream<'_>,
    buffer: &mut SampleBuffer,
    n_samples: usize,
) -> Result<(), IoError> {
    let n_after = buffer.len() + n_samples;
    let mut tokens = Tokens { path, reader: BufReader::new(stream), token: Vec::new() };
    while buffer.len() < n_after {
        let Some(token) = tokens.next()? else {
            let n_found = buffer.len() + n_samples - n_after;
            let what = format!("needs {n_samples} numbers, has {n_found}: the file is cut off");
            return Err(IoError::malformed(path, what));
        };
        if buffer.push_text(token).is_none() {
            let what = format!("{token:?} is not a number of the type that the header gives");
            return Err(IoError::malformed(path, what));
        }
    }
    Ok(())
}

struct Tokens<'p, R> {
    path: &'p Path,
    reader: R,
    token: Vec<u8>,
}

impl<R: BufRead> Tokens<'_, R> {
    /// The next run of bytes without blanks or commas.
    fn next(&mut self) -> Result<Option<&str>, IoError> {
        self.token.clear();
        loop {
            let bytes = self.reader.fill_buf().map_err(IoError::read(self.path))?;
            if bytes.is_empty() {
                break;
            }
            let is_blank = |b: &u8| b.is_ascii_whitespace() || *b == b',';
            let n_token = bytes.iter().position(is_blank).unwrap_or(bytes.len());
            let ends_here = n_token < bytes.len();
            self.token.extend(&bytes[..n_token]);
            self.reader.consume(n_token + usize::from(ends_here));
            if MAX_TOKEN_BYTES < self.token.len() {
                return Err(IoError::malformed(self.path, "the data are not numbers in text"));
            }
            if ends_here && !self.token.is_empty() {
                break;
            }
        }
        let not_text = |_| IoError::malformed(self.path, "the data are not numbers in text");
        let token = str::from_utf8(&self.token).map_err(not_text)?;
        Ok((!token.is_empty()).then_some(token))
    }
}
