//! Reads the samples from the file or files that hold them.

use std::path::Path;

use slabsplat_core::Samples;

use super::ascii;
use super::buffer::{Endian, SampleBuffer};
use super::data_files::DataFiles;
use super::formats::Input;
use super::stored::StoredType;
use super::stream::DataStream;
use super::window::{Window, not_in_boxes};
use crate::IoError;
use crate::printable::shown_path;
use crate::progress::ReadMeter;
use crate::store::Store;

/// How the samples are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Raw,
    /// By gzip or zlib.
    Packed,
    /// By bzip2.
    PackedByBzip2,
    Text,
    /// Two digits a byte.
    Hex,
}

/// Which of the samples in the files are those of the volume.
#[derive(Clone, Copy, Debug)]
pub(super) struct Share {
    /// Values of one voxel, that follow each other.
    pub(super) n_channels: usize,
    pub(super) channel: usize,
    /// Volumes that follow each other.
    pub(super) n_volumes: usize,
    pub(super) volume: usize,
}

/// How the samples lie in their files.
pub(super) struct Layout {
    /// What is read of the volume, if not all.
    pub(super) window: Option<Window>,
    /// Of the volume.
    pub(super) n_samples: usize,
    pub(super) share: Share,
    pub(super) stored: StoredType,
    pub(super) encoding: Encoding,
    pub(super) endian: Endian,
    /// Lines to pass over first.
    pub(super) line_skip: u64,
    /// Bytes to pass over then; unpacked ones, if they are packed. −1: the data are at the end.
    pub(super) byte_skip: i64,
}

/// Reads the samples of files that hold equal shares of them; `input` is the header.
pub(super) fn read(
    input: &Input<'_>,
    layout: &Layout,
    files: &DataFiles,
    warnings: &mut Vec<String>,
) -> Result<Samples, IoError> {
    let &Input { store, path, .. } = input;
    if layout.byte_skip < -1 {
        let what = "a byte skip is -1, which is from the end, or not below 0";
        return Err(IoError::malformed(path, what));
    }
    let sample_bytes = layout.stored.size_bytes() as u64;
    files.check_backed(path, (layout.n_samples as u64).saturating_mul(sample_bytes))?;
    let Share { n_channels, n_volumes, volume, .. } = layout.share;
    let n_volume = (layout.n_samples as u64).saturating_mul(n_channels as u64);
    // The number of files was checked against the sizes of the axes.
    let n_each = n_volume.saturating_mul(n_volumes as u64) / files.len() as u64;
    let first = n_volume.saturating_mul(volume as u64);
    let end = first.saturating_add(n_volume);
    let endian = match layout.encoding {
        Encoding::Raw | Encoding::Packed | Encoding::PackedByBzip2 => layout.endian,
        Encoding::Text | Encoding::Hex => Endian::NATIVE,
    };
    if let Some(window) = &layout.window {
        return read_window(input, layout, files, window);
    }
    let mut buffer = input.buffer(layout.stored, endian);
    let mut file_idx = first.checked_div(n_each).unwrap_or(0);
    let mut at = first;
    // What comes before the volume in its first file has to be unpacked, too.
    let n_counted = end.saturating_sub(file_idx.saturating_mul(n_each));
    let meter = input.meter(n_counted.saturating_mul(layout.meter_bytes()));
    while at < end && file_idx < files.len() as u64 {
        let start = file_idx.saturating_mul(n_each);
        let n_here = end.min(start.saturating_add(n_each)) - at;
        let (path, offset) = files.get(file_idx as usize);
        let file = File {
            store,
            path: &path,
            offset,
            n_all: n_each,
            n_before: at - start,
            n_here,
            meter: &meter,
        };
        read_file(&file, layout, &mut buffer, warnings)?;
        at += n_here;
        file_idx += 1;
    }
    Ok(buffer.finish(warnings))
}

/// Reads a box of a volume that lies in one file as it is.
fn read_window(
    input: &Input<'_>,
    layout: &Layout,
    files: &DataFiles,
    window: &Window,
) -> Result<Samples, IoError> {
    let Share { n_channels, n_volumes, volume, .. } = layout.share;
    if files.len() != 1 || n_channels != 1 || layout.encoding != Encoding::Raw {
        return Err(not_in_boxes(
            input.path,
            "a volume that is packed, of several files or colours",
        ));
    }
    let (path, offset) = files.get(0);
    let mut stream = DataStream::open(input.store, &path, offset)?;
    stream.skip_lines(layout.line_skip)?;
    let n_bytes = (layout.n_samples as u64).saturating_mul(layout.stored.size_bytes() as u64);
    let n_all = n_bytes.saturating_mul(n_volumes as u64);
    let byte_skip = u64::try_from(layout.byte_skip);
    stream.jump(byte_skip.unwrap_or_else(|_| stream.n_left_at_most().saturating_sub(n_all)))?;
    stream.check_left(n_all)?;
    stream.jump(n_bytes.saturating_mul(volume as u64))?;
    // Of colours all values are read of a voxel.
    let n_values = layout.n_samples / window.n_of_whole().max(1);
    window.read(&path, &mut stream, (layout.stored, n_values), layout.endian)
}

/// A file, and which of its samples are read.
struct File<'p> {
    store: Store<'p>,
    path: &'p Path,
    offset: u64,
    n_all: u64,
    n_before: u64,
    n_here: u64,
    meter: &'p ReadMeter,
}

impl Layout {
    /// What a sample counts for in the progress of reading: its bytes, and as a text the fewest there are.
    fn meter_bytes(&self) -> u64 {
        match self.encoding {
            Encoding::Text => 2,
            Encoding::Hex => 2 * self.stored.size_bytes() as u64,
            Encoding::Raw | Encoding::Packed | Encoding::PackedByBzip2 => {
                self.stored.size_bytes() as u64
            }
        }
    }
}

impl<'p> File<'p> {
    /// The stream of data, unpacked if they are packed.
    fn open(&self, layout: &Layout) -> Result<DataStream<'p>, IoError> {
        let mut stream = DataStream::open(self.store, self.path, self.offset)?;
        stream.skip_lines(layout.line_skip)?;
        Ok(match layout.encoding {
            Encoding::Packed => stream.unpacked(),
            Encoding::PackedByBzip2 => stream.unpacked_by_bzip2(),
            Encoding::Raw | Encoding::Text | Encoding::Hex => stream,
        })
    }
}

fn read_file(
    file: &File<'_>,
    layout: &Layout,
    buffer: &mut SampleBuffer,
    warnings: &mut Vec<String>,
) -> Result<(), IoError> {
    let path = file.path;
    let sample_bytes = layout.stored.size_bytes() as u64;
    let Share { n_channels, channel, .. } = layout.share;
    let n_samples = (file.n_here / n_channels as u64) as usize;
    let mut stream = file.open(layout)?;
    let needed = file.n_all.saturating_mul(sample_bytes);
    let byte_skip = match u64::try_from(layout.byte_skip) {
        Ok(n_bytes) => n_bytes,
        Err(_) if stream.is_plain() => stream.n_left_at_most().saturating_sub(needed),
        // How much is packed is known only when it is unpacked.
        Err(_) => file.open(layout)?.count()?.saturating_sub(needed),
    };
    stream.skip(byte_skip)?;
    stream.metered(file.meter);
    if let Encoding::Text | Encoding::Hex = layout.encoding {
        let picked = ascii::Picked { n_before: file.n_before, n_samples, n_channels, channel };
        return match layout.encoding {
            Encoding::Hex => ascii::read_hex(path, stream, buffer, &picked, layout.endian),
            _ => ascii::read(path, stream, buffer, &picked),
        };
    }
    stream.skip(file.n_before.saturating_mul(sample_bytes))?;
    stream.fill_channel(buffer, n_samples, sample_bytes as usize, [n_channels, channel])?;
    // With data counted from the end, whatever comes after them was meant to be there.
    let is_all = file.n_before.saturating_add(file.n_here) == file.n_all;
    if is_all && 0 <= layout.byte_skip && stream.has_more()? {
        warnings.push(format!("{} holds more data than were needed", shown_path(path)));
    }
    Ok(())
}
