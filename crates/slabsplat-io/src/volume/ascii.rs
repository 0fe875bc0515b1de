//! Samples written as text, with blanks, line ends or commas between.

use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

use super::buffer::{Endian, SampleBuffer};
use super::stream::DataStream;
use crate::IoError;

/// No number needs more digits: a 64-bit float written out in full has 1077.
const MAX_TOKEN_BYTES: usize = 2048;

/// Which numbers are read.
pub(super) struct Picked {
    /// Numbers that are passed over first.
    pub(super) n_before: u64,
    /// Numbers that are read then.
    pub(super) n_samples: usize,
    /// Every so many of those that come.
    pub(super) n_channels: usize,
    pub(super) channel: usize,
}

/// Appends numbers. What comes after them is not looked at.
pub(super) fn read(
    path: &Path,
    stream: DataStream<'_>,
    buffer: &mut SampleBuffer,
    picked: &Picked,
) -> Result<(), IoError> {
    let &Picked { n_before, n_samples, n_channels, channel } = picked;
    let n_after = buffer.len() + n_samples;
    let mut tokens = Tokens { path, reader: BufReader::new(stream), token: Vec::new() };
    let mut n_seen: u64 = 0;
    while buffer.len() < n_after {
        let Some(token) = tokens.next()? else {
            let n_found = buffer.len() + n_samples - n_after;
            let what = format!("needs {n_samples} numbers, has {n_found}: the file is cut off");
            return Err(IoError::malformed(path, what));
        };
        n_seen += 1;
        let is_picked =
            n_before < n_seen && (n_seen - 1 - n_before) % n_channels as u64 == channel as u64;
        if !is_picked {
            continue;
        }
        if buffer.push_text(token).is_none() {
            let what = format!("{token:?} is not a number of the type that the header gives");
            return Err(IoError::malformed(path, what));
        }
    }
    Ok(())
}

/// Appends samples whose bytes are written as two digits each, with blanks anywhere.
pub(super) fn read_hex(
    path: &Path,
    stream: DataStream<'_>,
    buffer: &mut SampleBuffer,
    picked: &Picked,
    endian: Endian,
) -> Result<(), IoError> {
    let &Picked { n_before, n_samples, n_channels, channel } = picked;
    let n_left_at_most = stream.n_left_at_most() / 2;
    let sample_bytes = buffer.sample_bytes();
    let voxel_bytes = n_channels.saturating_mul(sample_bytes);
    let n_all = (n_samples as u64).saturating_mul(voxel_bytes as u64);
    if n_left_at_most < n_all {
        let what = format!("needs {n_all} bytes as digits, has room for {n_left_at_most}");
        return Err(IoError::malformed(path, what));
    }
    let mut digits = HexBytes { reader: BufReader::new(stream) };
    let n_skipped = n_before.saturating_mul(sample_bytes as u64);
    io::copy(&mut digits.by_ref().take(n_skipped), &mut io::sink()).map_err(IoError::read(path))?;
    let mut voxel = vec![0; voxel_bytes];
    for _ in 0..n_samples {
        digits.read_exact(&mut voxel).map_err(|error| match error.kind() {
            io::ErrorKind::UnexpectedEof | io::ErrorKind::InvalidData => IoError::malformed(
                path,
                "the data are not as many hexadecimal digits as are needed",
            ),
            _ => IoError::Read { path: path.to_owned(), source: error },
        })?;
        let sample = &mut voxel[channel * sample_bytes..][..sample_bytes];
        if endian != Endian::NATIVE {
            sample.reverse();
        }
        buffer.push_bytes(sample).map_err(|_| IoError::Read {
            path: path.to_owned(),
            source: io::ErrorKind::OutOfMemory.into(),
        })?;
    }
    Ok(())
}

/// Pairs of hexadecimal digits as bytes.
struct HexBytes<R> {
    reader: R,
}

impl<R: BufRead> Read for HexBytes<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        for (n_read, out) in bytes.iter_mut().enumerate() {
            let Some(high) = self.digit()? else { return Ok(n_read) };
            let low = self.digit()?.ok_or(io::ErrorKind::UnexpectedEof)?;
            *out = 16 * high + low;
        }
        Ok(bytes.len())
    }
}

impl<R: BufRead> HexBytes<R> {
    fn digit(&mut self) -> io::Result<Option<u8>> {
        let mut byte = [0];
        loop {
            if self.reader.read(&mut byte)? == 0 {
                return Ok(None);
            }
            if !byte[0].is_ascii_whitespace() {
                let digit = char::from(byte[0]).to_digit(16);
                return digit
                    .map(|digit| Some(digit as u8))
                    .ok_or(io::ErrorKind::InvalidData.into());
            }
        }
    }
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
