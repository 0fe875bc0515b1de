//! Reads the samples from the file or files that hold them.

use std::path::Path;

use slabsplat_core::{SampleType, Samples};

use super::ascii;
use super::buffer::{Endian, SampleBuffer};
use super::data_files::DataFiles;
use super::stream::DataStream;
use crate::IoError;
use crate::store::Store;

/// How the samples are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Raw,
    /// By gzip or zlib.
    Packed,
    Text,
}

/// How the samples lie in their files.
pub(super) struct Layout {
    pub(super) n_samples: usize,
    pub(super) sample_type: SampleType,
    pub(super) encoding: Encoding,
    pub(super) endian: Endian,
    /// Lines to pass over first.
    pub(super) line_skip: u64,
    /// Bytes to pass over then; unpacked ones, if they are packed. −1: the data are at the end.
    pub(super) byte_skip: i64,
}

/// Reads the samples of files that hold equal shares of them; `path` is that of the header.
pub(super) fn read(
    store: Store<'_>,
    path: &Path,
    layout: &Layout,
    files: &DataFiles,
    warnings: &mut Vec<String>,
) -> Result<Samples, IoError> {
    if layout.byte_skip < 0 && layout.encoding != Encoding::Raw {
        let what = "a byte skip below 0 is only for the raw encoding";
        return Err(IoError::malformed(path, what));
    }
    // The number of files was checked against the sizes of the axes.
    let n_samples_each = layout.n_samples / files.len();
    let mut buffer = SampleBuffer::new(layout.sample_type);
    for file_idx in 0..files.len() {
        let (path, offset) = files.get(file_idx);
        let stream = DataStream::open(store, &path, offset)?;
        read_file(stream, &path, layout, n_samples_each, &mut buffer, warnings)?;
    }
    Ok(buffer.finish(match layout.encoding {
        Encoding::Raw | Encoding::Packed => layout.endian,
        Encoding::Text => Endian::NATIVE,
    }))
}

fn read_file(
    mut stream: DataStream<'_>,
    path: &Path,
    layout: &Layout,
    n_samples: usize,
    buffer: &mut SampleBuffer,
    warnings: &mut Vec<String>,
) -> Result<(), IoError> {
    let sample_bytes = layout.sample_type.size_bytes();
    stream.skip_lines(layout.line_skip)?;
    if layout.encoding == Encoding::Packed {
        stream = stream.unpacked();
    }
    stream.skip(byte_skip(&stream, layout.byte_skip, n_samples as u64 * sample_bytes as u64))?;
    match layout.encoding {
        Encoding::Raw | Encoding::Packed => stream.fill(buffer, n_samples, sample_bytes)?,
        Encoding::Text => return ascii::read(path, stream, buffer, n_samples),
    }
    // With data counted from the end, whatever comes after them was meant to be there.
    if 0 <= layout.byte_skip && stream.has_more()? {
        warnings.push(format!("{} holds more data than were needed", path.display()));
    }
    Ok(())
}

/// The bytes to pass over: −1 puts the data at the very end of the file, −2 one byte earlier.
fn byte_skip(stream: &DataStream<'_>, byte_skip: i64, needed: u64) -> u64 {
    match u64::try_from(byte_skip) {
        Ok(n_bytes) => n_bytes,
        Err(_) => {
            let n_after = (byte_skip + 1).unsigned_abs();
            stream.n_left_at_most().saturating_sub(needed.saturating_add(n_after))
        }
    }
}
