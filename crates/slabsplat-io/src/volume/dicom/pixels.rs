//! The bytes of frames, from wherever they are and however they are packed, and as samples.

use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use flate2::read::DeflateDecoder;
use slabsplat_core::{SampleType, Samples};

use super::super::Endian;
use super::super::buffer::{ReadFailure, SampleBuffer};
use super::super::formats::Input;
use super::super::parallel;
use super::super::stream::MAX_GZIP_RATIO;
use super::super::window::not_in_boxes;
use super::frame::{Colors, Frame, Layout};
use super::line::Slice;
use super::scan::{Series, SliceFile};
use super::stack::Stack;
use super::syntax::Packing;
use super::unpack::unpack;
use super::ybr;
use crate::IoError;
use crate::store::Store;

/// Deflate makes no more of a byte; a JPEG has two bits for 64 pixels at least, and a run of 128 bytes takes
/// two.
pub(super) const MAX_RATIO: u64 = MAX_GZIP_RATIO;

/// Reads the samples of a stack, a slice after the other: of each pixel those of a channel, or all.
pub(super) fn read(
    input: &Input<'_>,
    series: &Series,
    stack: &Stack,
    to_float: bool,
    channel: Option<usize>,
) -> Result<Samples, IoError> {
    let store = input.store;
    if input.spill.is_some() && !are_packed_alone(series) {
        return Err(not_in_boxes(input.path, "a DICOM file of many frames that is deflated"));
    }
    let sample_type = if to_float { SampleType::F32 } else { sample_type(&series.layout) };
    let mut buffer = input.buffer(sample_type, Endian::NATIVE);
    let n_read = channel.map_or(series.layout.n_channels, |_| 1);
    let n_slice_bytes = (series.layout.n_pixels() * n_read * sample_type.size_bytes()) as u64;
    let meter = input.meter(n_slice_bytes.saturating_mul(stack.slices.len() as u64));
    let reader = || FrameReader { store, series, channel, to_float, cached: None };
    let stored: Option<Vec<usize>> = stack.slices.iter().map(Slice::stored).collect();
    if let Some(stored) = stored.filter(|_| are_packed_alone(series)) {
        let n_workers = parallel::n_workers(stored.len());
        let mut workers: Vec<FrameReader<'_>> = (0..n_workers).map(|_| reader()).collect();
        let unpack =
            |frames: &mut FrameReader<'_>, &idx: &usize| frames.samples(&stack.frames[idx]);
        parallel::in_order(&mut workers, &stored, unpack, |&idx, samples| {
            let path = &series.files[stack.frames[idx].file_idx].path;
            meter.advance(samples.len() as u64)?;
            append(path, &mut buffer, sample_type, &samples)
        })?;
        return Ok(buffer.finish(&mut Vec::new()));
    }
    let mut frames = reader();
    let mut last: Option<(usize, Vec<u8>)> = None;
    let mut next: Option<(usize, Vec<u8>)> = None;
    for slice in &stack.slices {
        let (idx, share) = match *slice {
            Slice::Frame(idx) => (idx, None),
            Slice::Between(idx, share) => (idx, Some(share)),
        };
        if next.as_ref().is_some_and(|(next_idx, _)| *next_idx == idx) {
            last = next.take();
        }
        let samples = match last.take() {
            Some((last_idx, samples)) if last_idx == idx => samples,
            _ => frames.samples(&stack.frames[idx])?,
        };
        meter.advance(n_slice_bytes)?;
        let path = &series.files[stack.frames[idx].file_idx].path;
        match share {
            None => append(path, &mut buffer, sample_type, &samples)?,
            Some(share) => {
                if next.as_ref().is_none_or(|(next_idx, _)| *next_idx != idx + 1) {
                    next = Some((idx + 1, frames.samples(&stack.frames[idx + 1])?));
                }
                let above = next.as_ref().map_or(&[][..], |(_, samples)| samples);
                let between = between(sample_type, &samples, above, share);
                append(path, &mut buffer, sample_type, &between)?;
            }
        }
        last = Some((idx, samples));
    }
    Ok(buffer.finish(&mut Vec::new()))
}

fn append(
    path: &Path,
    buffer: &mut SampleBuffer,
    sample_type: SampleType,
    samples: &[u8],
) -> Result<(), IoError> {
    let n_samples = samples.len() / sample_type.size_bytes();
    buffer.append(&mut &samples[..], n_samples, true).map_err(|failure| match failure {
        ReadFailure::TooShort(_) => IoError::malformed(path, "a slice is shorter than it says"),
        ReadFailure::Io(source) => IoError::Read { path: path.to_owned(), source },
    })
}

/// Whether no file is packed as a whole that holds several slices: each thread would unpack all of it.
fn are_packed_alone(series: &Series) -> bool {
    let is_deflated = series.files.iter().any(|file| file.syntax.is_deflated);
    !is_deflated || series.files.len() == series.frames.len()
}

/// The type that holds all values of a layout.
pub(super) fn sample_type(layout: &Layout) -> SampleType {
    match (layout.bits_allocated, layout.is_signed) {
        (64, _) => SampleType::F64,
        (32, _) if layout.is_float => SampleType::F32,
        (8, false) => SampleType::U8,
        (8, true) => SampleType::I8,
        (16, false) => SampleType::U16,
        (16, true) => SampleType::I16,
        (_, false) => SampleType::U32,
        (_, true) => SampleType::I32,
    }
}

/// Samples of this machine's byte order, so far between two slices.
fn between(sample_type: SampleType, below: &[u8], above: &[u8], share: f64) -> Vec<u8> {
    macro_rules! mixed {
        ($type:ty, $finish:expr) => {{
            let read = |bytes: &[u8]| {
                <$type>::from_ne_bytes(bytes.try_into().expect("chunks have this size"))
            };
            let pairs =
                below.chunks_exact(size_of::<$type>()).zip(above.chunks_exact(size_of::<$type>()));
            pairs
                .flat_map(|(below, above)| {
                    let (below, above) = (f64::from(read(below)), f64::from(read(above)));
                    let value: f64 = $finish(below + share * (above - below));
                    (value as $type).to_ne_bytes()
                })
                .collect()
        }};
    }
    match sample_type {
        SampleType::U8 => mixed!(u8, f64::round),
        SampleType::I8 => mixed!(i8, f64::round),
        SampleType::U16 => mixed!(u16, f64::round),
        SampleType::I16 => mixed!(i16, f64::round),
        SampleType::U32 => mixed!(u32, f64::round),
        SampleType::I32 => mixed!(i32, f64::round),
        SampleType::F32 => mixed!(f32, f64::from),
        SampleType::F64 => mixed!(f64, f64::from),
    }
}

/// What was read of a file to find frames in it.
enum Cached {
    /// All pixels of a file that is packed as a whole.
    Pixels(usize, Vec<u8>),
    /// Where fragments are, and how long; the first is a table of frames.
    Fragments(usize, Vec<(u64, u32)>),
}

struct FrameReader<'a> {
    store: Store<'a>,
    series: &'a Series,
    /// The value of each pixel that is read, if not all are.
    channel: Option<usize>,
    to_float: bool,
    cached: Option<Cached>,
}

impl FrameReader<'_> {
    /// The samples of a frame, in this machine's byte order.
    fn samples(&mut self, frame: &Frame) -> Result<Vec<u8>, IoError> {
        let layout = self.series.layout;
        let file = &self.series.files[frame.file_idx];
        let mut bytes = self.stored(file, frame)?;
        // Pixels of 8 bits may be written as words, but those of one byte order are the same either way.
        let is_packed = file.syntax.packing != Packing::None;
        let stored = if is_packed { Endian::Little } else { file.syntax.endian };
        if stored == Endian::Big {
            let pixel_bytes = layout.bits_allocated as usize / 8;
            bytes.chunks_exact_mut(pixel_bytes).for_each(<[u8]>::reverse);
        }
        if layout.colors == Colors::Ybr {
            ybr::to_rgb(&layout, &mut bytes);
        }
        let bytes = match self.channel {
            Some(channel) => one_channel(&layout, bytes, channel),
            None => all_channels(&layout, bytes),
        };
        Ok(match layout.bits_allocated {
            64 => from_le(&bytes, f64::from_le_bytes, f64::to_ne_bytes),
            32 if layout.is_float => from_le(&bytes, f32::from_le_bytes, f32::to_ne_bytes),
            _ => self.integers(&layout, &bytes, frame),
        })
    }

    fn integers(&self, layout: &Layout, bytes: &[u8], frame: &Frame) -> Vec<u8> {
        let pixel_bytes = layout.bits_allocated as usize / 8;
        let unused = 31 - layout.high_bit;
        let value = |pixel: &[u8]| {
            let mut word = [0; 4];
            word[..pixel_bytes].copy_from_slice(pixel);
            // What lies above and below the bits that are used is shifted out.
            let word = u32::from_le_bytes(word) << unused;
            let below = 32 - layout.bits_stored;
            if layout.is_signed {
                i64::from(word as i32 >> below)
            } else {
                i64::from(word >> below)
            }
        };
        let values = bytes.chunks_exact(pixel_bytes).map(value);
        if self.to_float {
            let scaled = values.map(|v| (v as f64 * frame.slope + frame.intercept) as f32);
            return scaled.flat_map(f32::to_ne_bytes).collect();
        }
        match layout.bits_allocated {
            8 => values.map(|v| v as u8).collect(),
            16 => values.flat_map(|v| (v as u16).to_ne_bytes()).collect(),
            _ => values.flat_map(|v| (v as u32).to_ne_bytes()).collect(),
        }
    }

    /// The bytes of a frame, unpacked.
    fn stored(&mut self, file: &SliceFile, frame: &Frame) -> Result<Vec<u8>, IoError> {
        if file.syntax.is_deflated {
            return self.of_deflated(file, frame);
        }
        match (file.syntax.packing, file.pixels.n_bytes) {
            (Packing::None, Some(_)) => self.plain(file, frame),
            (Packing::None, None) => {
                Err(IoError::malformed(&file.path, "its pixels are in fragments, but not packed"))
            }
            (packing, None) => {
                let packed = self.packed(file, frame)?;
                unpack(&file.path, &self.series.layout, packing, &packed)
            }
            (_, Some(_)) => Err(IoError::malformed(
                &file.path,
                "its pixels should be in fragments, as packed ones are",
            )),
        }
    }

    fn plain(&self, file: &SliceFile, frame: &Frame) -> Result<Vec<u8>, IoError> {
        let path = &file.path;
        let mut reader = self.store.open(path)?;
        let n_bytes = self.series.layout.frame_bytes();
        let offset =
            (frame.frame_idx as u64).saturating_mul(n_bytes).saturating_add(file.pixels.offset);
        let found = reader.n_bytes().map_err(IoError::read(path))?.saturating_sub(offset);
        let in_element =
            file.pixels.n_bytes.map_or(0, u64::from).saturating_add(file.pixels.offset);
        let found = found.min(in_element.saturating_sub(offset));
        if found < n_bytes {
            return Err(too_short(path, n_bytes, found));
        }
        reader.seek(SeekFrom::Start(offset)).map_err(IoError::read(path))?;
        let mut bytes = vec![0; n_bytes as usize];
        reader.read_exact(&mut bytes).map_err(IoError::read(path))?;
        Ok(bytes)
    }

    fn of_deflated(&mut self, file: &SliceFile, frame: &Frame) -> Result<Vec<u8>, IoError> {
        let n_bytes = self.series.layout.frame_bytes() as usize;
        let is_cached =
            matches!(&self.cached, Some(Cached::Pixels(idx, _)) if *idx == frame.file_idx);
        if !is_cached {
            let pixels = inflated(self.store, file)?;
            self.cached = Some(Cached::Pixels(frame.file_idx, pixels));
        }
        let Some(Cached::Pixels(_, pixels)) = &self.cached else { return Ok(Vec::new()) };
        let start = frame.frame_idx.saturating_mul(n_bytes);
        let bytes = pixels.get(start..start.saturating_add(n_bytes));
        bytes.map(<[u8]>::to_vec).ok_or_else(|| {
            let found = pixels.len().saturating_sub(start) as u64;
            too_short(&file.path, n_bytes as u64, found)
        })
    }

    /// The fragments of a frame, joined.
    fn packed(&mut self, file: &SliceFile, frame: &Frame) -> Result<Vec<u8>, IoError> {
        let path = &file.path;
        let is_cached =
            matches!(&self.cached, Some(Cached::Fragments(idx, _)) if *idx == frame.file_idx);
        if !is_cached {
            let fragments = fragments(self.store, file)?;
            self.cached = Some(Cached::Fragments(frame.file_idx, fragments));
        }
        let Some(Cached::Fragments(_, fragments)) = &self.cached else { return Ok(Vec::new()) };
        let mut reader = self.store.open(path)?;
        let n_frames = self.series.frames.iter().filter(|f| f.file_idx == frame.file_idx).count();
        let table = fragments.first().copied().unwrap_or((0, 0));
        let fragments = fragments.get(1..).unwrap_or_default();
        let of_frame = if fragments.len() == n_frames {
            fragments.get(frame.frame_idx..frame.frame_idx + 1)
        } else if n_frames == 1 {
            Some(fragments)
        } else {
            let starts = offsets(&mut reader, table).map_err(IoError::read(path))?;
            by_offsets(fragments, &starts, frame.frame_idx)
        };
        let of_frame = of_frame.filter(|fragments| !fragments.is_empty()).ok_or_else(|| {
            let what = format!("the pixels of frame {} cannot be found", frame.frame_idx);
            IoError::malformed(path, what)
        })?;
        let mut packed = Vec::new();
        for &(offset, n_bytes) in of_frame {
            reader.seek(SeekFrom::Start(offset)).map_err(IoError::read(path))?;
            let fragment = reader.by_ref().take(u64::from(n_bytes));
            let mut fragment = BufReader::new(fragment);
            fragment.read_to_end(&mut packed).map_err(IoError::read(path))?;
        }
        Ok(packed)
    }
}

pub(super) fn too_short(path: &Path, needed: u64, found: u64) -> IoError {
    let hint = "the file is cut off, or its header lies";
    IoError::WrongLength { path: path.to_owned(), needed, found, hint }
}

/// All pixels of a file that is packed as a whole.
fn inflated(store: Store<'_>, file: &SliceFile) -> Result<Vec<u8>, IoError> {
    let path = &file.path;
    let mut reader = store.open(path)?;
    let most = reader.n_bytes().map_err(IoError::read(path))?.saturating_mul(MAX_RATIO);
    reader.seek(SeekFrom::Start(file.syntax.deflated_from)).map_err(IoError::read(path))?;
    let mut reader = DeflateDecoder::new(BufReader::new(reader));
    let skipped = reader.by_ref().take(file.pixels.offset);
    std::io::copy(&mut { skipped }, &mut std::io::sink()).map_err(IoError::read(path))?;
    let n_bytes = file.pixels.n_bytes.map_or(0, u64::from).min(most);
    let mut pixels = Vec::new();
    reader.take(n_bytes).read_to_end(&mut pixels).map_err(IoError::read(path))?;
    Ok(pixels)
}

/// Where the fragments of a file's pixels are.
fn fragments(store: Store<'_>, file: &SliceFile) -> Result<Vec<(u64, u32)>, IoError> {
    let path = &file.path;
    let mut reader = store.open(path)?;
    let n_bytes = reader.n_bytes().map_err(IoError::read(path))?;
    let mut offset = file.pixels.offset;
    let mut fragments = Vec::new();
    loop {
        let mut item = [0; 8];
        reader.seek(SeekFrom::Start(offset)).map_err(IoError::read(path))?;
        if n_bytes < offset.saturating_add(8) {
            break;
        }
        reader.read_exact(&mut item).map_err(IoError::read(path))?;
        let [a, b, c, d, length @ ..] = item;
        if [a, b, c, d] != [0xfe, 0xff, 0x00, 0xe0] {
            break;
        }
        let length = u32::from_le_bytes(length);
        let start = offset + 8;
        offset = start + u64::from(length);
        if n_bytes < offset {
            return Err(too_short(path, u64::from(length), n_bytes - start));
        }
        fragments.push((start, length));
    }
    Ok(fragments)
}

/// Where frames begin, from the first fragment on.
fn offsets(
    reader: &mut (impl Read + Seek),
    (start, n_bytes): (u64, u32),
) -> std::io::Result<Vec<u64>> {
    reader.seek(SeekFrom::Start(start))?;
    let mut bytes = Vec::new();
    reader.take(u64::from(n_bytes)).read_to_end(&mut bytes)?;
    let word =
        |bytes: &[u8]| u64::from(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]));
    Ok(bytes.chunks_exact(4).map(word).collect())
}

/// The fragments from the offset of a frame up to that of the next.
fn by_offsets<'f>(
    fragments: &'f [(u64, u32)],
    starts: &[u64],
    frame_idx: usize,
) -> Option<&'f [(u64, u32)]> {
    let first = fragments.first()?.0 - 8;
    let at = |frame_idx: usize| {
        let start = first.checked_add(*starts.get(frame_idx)?)?.checked_add(8)?;
        fragments.iter().position(|&(offset, _)| offset == start)
    };
    let end = if frame_idx + 1 < starts.len() { at(frame_idx + 1)? } else { fragments.len() };
    fragments.get(at(frame_idx)?..end)
}

fn from_le<T, const N: usize>(
    bytes: &[u8],
    from: impl Fn([u8; N]) -> T,
    to: impl Fn(T) -> [u8; N],
) -> Vec<u8> {
    let value = |chunk: &[u8]| to(from(chunk.try_into().expect("chunks have this size")));
    bytes.chunks_exact(N).flat_map(value).collect()
}

/// The values of all channels, pixel by pixel.
fn all_channels(layout: &Layout, bytes: Vec<u8>) -> Vec<u8> {
    if !layout.is_planar || layout.n_channels == 1 {
        return bytes;
    }
    let value_bytes = layout.bits_allocated as usize / 8;
    let plane_bytes = layout.n_pixels() * value_bytes;
    let pixels = (0..plane_bytes).step_by(value_bytes);
    let values =
        pixels.flat_map(|at| (0..layout.n_channels).map(move |channel| channel * plane_bytes + at));
    values.flat_map(|at| &bytes[at..at + value_bytes]).copied().collect()
}

/// The values of one channel.
fn one_channel(layout: &Layout, bytes: Vec<u8>, channel: usize) -> Vec<u8> {
    if layout.n_channels == 1 {
        return bytes;
    }
    let value_bytes = layout.bits_allocated as usize / 8;
    if layout.is_planar {
        let n_bytes = layout.n_pixels() * value_bytes;
        return bytes[channel * n_bytes..][..n_bytes].to_vec();
    }
    let pixels = bytes.chunks_exact(value_bytes * layout.n_channels);
    pixels.flat_map(|pixel| pixel[channel * value_bytes..][..value_bytes].to_vec()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slices_between_are_mixed() {
        let bytes = |values: [i16; 2]| values.map(i16::to_ne_bytes).concat();
        let mixed = between(SampleType::I16, &bytes([-100, 7]), &bytes([100, 8]), 0.75);
        assert_eq!(mixed, bytes([50, 8]));
        assert_eq!(between(SampleType::U8, &[0, 200], &[255, 0], 0.5), [128, 100]);
    }

    #[test]
    fn frames_are_found_by_their_offsets() {
        let fragments = [(108, 10), (126, 4), (138, 6)];
        assert_eq!(by_offsets(&fragments, &[0, 30], 0), Some(&fragments[..2]));
        assert_eq!(by_offsets(&fragments, &[0, 30], 1), Some(&fragments[2..]));
        assert_eq!(by_offsets(&fragments, &[0, 31], 1), None);
        assert_eq!(by_offsets(&fragments, &[], 0), None);
    }
}
