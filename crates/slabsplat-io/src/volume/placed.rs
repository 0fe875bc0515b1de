//! Samples that come in another order than the volume's, or among others: each is put where it belongs as it
//! comes, so that nothing but the volume is ever in memory whole.
//!
//! ```text
//! for every axis, slowest first: pass over what is not kept, and go on with the axis inside
//!     of the fastest axis: read a run, put its samples `stride` apart
//! ```

use std::io::{self, Read};
use std::ops::Range;
use std::sync::Arc;

use slabsplat_core::{Sample, SampleType, Samples, with_samples};

use super::Endian;
use super::buffer::{ReadFailure, one_zero};
use super::spill::Spill;
use super::stored::{Narrowed, StoredType, half, integer};
use crate::progress::ReadMeter;

/// One axis of an array as it is stored.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Axis {
    /// Items along it.
    pub(super) len: usize,
    /// Those that belong to the volume.
    pub(super) kept: Range<usize>,
    /// How far apart in the volume neighbours are; 0 if one alone is kept.
    pub(super) stride: usize,
}

/// A volume's samples, while they come.
pub(super) struct PlacedSamples {
    stored: StoredType,
    endian: Endian,
    target: Target,
    /// Bytes that have come, and bytes passed over.
    n_read: u64,
}

enum Target {
    Same(Samples),
    Half(Vec<f32>),
    Wide(Narrowed),
    /// They are in memory no longer than it takes to write them there.
    Spilled(Arc<Spill>),
}

/// Bytes that are read at once where they cannot go to their place directly.
const CHUNK_BYTES: usize = 1 << 18;

/// Bytes that can be passed over.
pub(super) trait Source: Read {
    /// Passes over so many, or to the end.
    fn pass_over(&mut self, n_bytes: u64) -> io::Result<()> {
        let mut passed = [0; 1 << 13];
        let mut n_left = n_bytes;
        while 0 < n_left {
            let n_now = passed.len().min(usize::try_from(n_left).unwrap_or(usize::MAX));
            match self.read(&mut passed[..n_now]) {
                Ok(0) => break,
                Ok(n) => n_left -= n as u64,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }
}

impl Source for &[u8] {}

impl<R: Source + ?Sized> Source for &mut R {
    fn pass_over(&mut self, n_bytes: u64) -> io::Result<()> {
        (**self).pass_over(n_bytes)
    }
}

impl<R: Source + ?Sized> Source for Box<R> {
    fn pass_over(&mut self, n_bytes: u64) -> io::Result<()> {
        (**self).pass_over(n_bytes)
    }
}

/// A source whose bytes are counted.
pub(super) struct Metered<'m, S> {
    pub(super) source: S,
    pub(super) meter: &'m ReadMeter,
}

/// No more is read at once.
const MAX_AT_ONCE_BYTES: usize = 4 << 20;

impl<S: Read> Read for Metered<'_, S> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let n_most = bytes.len().min(MAX_AT_ONCE_BYTES);
        let n_read = self.source.read(&mut bytes[..n_most])?;
        self.meter.advance(n_read as u64)?;
        Ok(n_read)
    }
}

impl<S: Source> Source for Metered<'_, S> {
    fn pass_over(&mut self, n_bytes: u64) -> io::Result<()> {
        self.source.pass_over(n_bytes)?;
        Ok(self.meter.advance(n_bytes)?)
    }
}

impl Axis {
    /// All of an axis.
    pub(super) fn whole(len: usize, stride: usize) -> Self {
        Self { len, kept: 0..len, stride }
    }

    /// One item of an axis.
    pub(super) fn one(len: usize, at: usize) -> Self {
        Self { len, kept: at..at + 1, stride: 0 }
    }
}

impl PlacedSamples {
    /// Room for `n_voxels`, all of them zero. The caller knows that a file backs them.
    pub(super) fn new(
        stored: StoredType,
        endian: Endian,
        n_voxels: usize,
    ) -> Result<Self, ReadFailure> {
        let target = match stored {
            StoredType::Sample(SampleType::U8) => Target::Same(Samples::U8(zeros(n_voxels)?)),
            StoredType::Sample(SampleType::I8) => Target::Same(Samples::I8(zeros(n_voxels)?)),
            StoredType::Sample(SampleType::U16) => Target::Same(Samples::U16(zeros(n_voxels)?)),
            StoredType::Sample(SampleType::I16) => Target::Same(Samples::I16(zeros(n_voxels)?)),
            StoredType::Sample(SampleType::U32) => Target::Same(Samples::U32(zeros(n_voxels)?)),
            StoredType::Sample(SampleType::I32) => Target::Same(Samples::I32(zeros(n_voxels)?)),
            StoredType::Sample(SampleType::F32) => Target::Same(Samples::F32(zeros(n_voxels)?)),
            StoredType::Sample(SampleType::F64) => Target::Same(Samples::F64(zeros(n_voxels)?)),
            StoredType::F16 => Target::Half(zeros(n_voxels)?),
            StoredType::I64 | StoredType::U64 => Target::Wide(Narrowed::new(zeros(n_voxels)?)),
        };
        Ok(Self { stored, endian, target, n_read: 0 })
    }

    /// The same that writes them there.
    pub(super) fn spilled(stored: StoredType, endian: Endian, to: Arc<Spill>) -> Self {
        Self { stored, endian, target: Target::Spilled(to), n_read: 0 }
    }

    /// Puts an array, of which `axes` are the axes with the fastest first, with its first kept item at the
    /// voxel `first`.
    pub(super) fn place(
        &mut self,
        source: &mut impl Source,
        axes: &[Axis],
        first: usize,
    ) -> Result<(), ReadFailure> {
        let axes = joined(axes);
        self.place_axes(source, &axes, first)
    }

    /// Puts one number, as it would be stored, into voxels `stride` apart.
    pub(super) fn fill(&mut self, item: &[u8], first: usize, stride: usize, n: usize) {
        for idx in 0..n {
            // Nothing is filled that is spilled.
            let _ = self.put(item, 1, 0, first + idx * stride, 1);
        }
    }

    pub(super) fn finish(self, warnings: &mut Vec<String>) -> Samples {
        match self.target {
            Target::Same(samples) => samples,
            Target::Half(samples) => Samples::F32(samples),
            Target::Wide(narrowed) => narrowed.finish(self.stored, warnings),
            Target::Spilled(_) => one_zero(self.stored),
        }
    }

    fn place_axes(
        &mut self,
        source: &mut impl Source,
        axes: &[Axis],
        first: usize,
    ) -> Result<(), ReadFailure> {
        match axes {
            [] => self.place_run(source, &Axis::whole(1, 1), 1, 0, first),
            [run] => self.place_run(source, run, 1, 0, first),
            // Channels, say, of which one is taken.
            [one, run] if one.kept.len() == 1 => {
                self.place_run(source, run, one.len, one.kept.start, first)
            }
            [inner @ .., axis] => {
                let n_inside = inner.iter().map(|axis| axis.len as u64).product::<u64>();
                self.pass_over(source, n_inside * axis.kept.start as u64)?;
                for idx in 0..axis.kept.len() {
                    self.place_axes(source, inner, first + idx * axis.stride)?;
                }
                self.pass_over(source, n_inside * (axis.len - axis.kept.end) as u64)
            }
        }
    }

    /// A run of groups of `n_each` items, of which the one at `pick` is taken.
    fn place_run(
        &mut self,
        source: &mut impl Source,
        run: &Axis,
        n_each: usize,
        pick: usize,
        first: usize,
    ) -> Result<(), ReadFailure> {
        self.pass_over(source, (run.kept.start * n_each) as u64)?;
        if n_each == 1 && run.stride == 1 && matches!(self.target, Target::Same(_)) {
            self.read_into_place(source, first, run.kept.len())?;
        } else {
            self.read_in_chunks(source, run, n_each, pick, first)?;
        }
        self.pass_over(source, ((run.len - run.kept.end) * n_each) as u64)
    }

    fn read_into_place(
        &mut self,
        source: &mut impl Source,
        first: usize,
        n_items: usize,
    ) -> Result<(), ReadFailure> {
        let Target::Same(samples) = &mut self.target else { return Ok(()) };
        let swaps = self.endian != Endian::NATIVE;
        let n_read = &mut self.n_read;
        with_samples!(samples, |s| {
            let samples = &mut s[first..first + n_items];
            let sample_bytes = size_of_val(samples) / n_items.max(1);
            let bytes = bytemuck::cast_slice_mut(samples);
            read_all(source, bytes, n_read)?;
            if swaps && 1 < sample_bytes {
                bytes.chunks_exact_mut(sample_bytes).for_each(<[u8]>::reverse);
            }
        });
        Ok(())
    }

    fn read_in_chunks(
        &mut self,
        source: &mut impl Source,
        run: &Axis,
        n_each: usize,
        pick: usize,
        first: usize,
    ) -> Result<(), ReadFailure> {
        let item_bytes = self.stored.size_bytes();
        let is_far_apart = CHUNK_BYTES < n_each.saturating_mul(item_bytes);
        // Groups too long for a chunk are passed over but for the one item.
        let (n_group, pick_in_group) = if is_far_apart { (1, 0) } else { (n_each, pick) };
        let group_bytes = n_group * item_bytes;
        let n_at_once = if is_far_apart { 1 } else { CHUNK_BYTES / group_bytes };
        let mut chunk = vec![0; group_bytes * n_at_once.min(run.kept.len())];
        let mut n_done = 0;
        while n_done < run.kept.len() {
            let n_now = n_at_once.min(run.kept.len() - n_done);
            let bytes = &mut chunk[..n_now * group_bytes];
            if is_far_apart {
                self.pass_over(source, pick as u64)?;
            }
            read_all(source, bytes, &mut self.n_read)?;
            if is_far_apart {
                self.pass_over(source, (n_each - pick - 1) as u64)?;
            }
            let first = first + n_done * run.stride;
            self.put(bytes, n_group, pick_in_group, first, run.stride).map_err(ReadFailure::Io)?;
            n_done += n_now;
        }
        Ok(())
    }

    /// Puts one item of each group of `n_each` into the volume.
    fn put(
        &mut self,
        bytes: &[u8],
        n_each: usize,
        pick: usize,
        first: usize,
        stride: usize,
    ) -> io::Result<()> {
        let (stored, endian) = (self.stored, self.endian);
        let item_bytes = stored.size_bytes();
        let groups = bytes.chunks_exact(n_each * item_bytes);
        let items = groups.map(|group| &group[pick * item_bytes..][..item_bytes]);
        match &mut self.target {
            Target::Same(samples) => {
                with_samples!(samples, |s| put_same(&mut s[first..], stride, items, endian));
            }
            Target::Half(samples) => {
                for (idx, item) in items.enumerate() {
                    samples[first + idx * stride] = half(item, endian);
                }
            }
            Target::Wide(narrowed) => {
                narrowed.put(first, stride, items.map(|item| integer(item, stored, endian)));
            }
            Target::Spilled(spill) => {
                if 1 < stride {
                    return Err(spill.refuse("an array whose rows do not lie along x"));
                }
                let here = Self::new(stored, endian, items.len());
                let mut here = here.map_err(|_| io::Error::from(io::ErrorKind::OutOfMemory))?;
                here.put(bytes, n_each, pick, 0, 1)?;
                match here.target {
                    Target::Wide(narrowed) => {
                        spill.write_integers(first as u64, narrowed, stored)?;
                    }
                    _ => spill.write(first as u64, &here.finish(&mut Vec::new()))?,
                }
            }
        }
        Ok(())
    }

    fn pass_over(&mut self, source: &mut impl Source, n_items: u64) -> Result<(), ReadFailure> {
        if n_items == 0 {
            return Ok(());
        }
        let n_bytes = n_items.saturating_mul(self.stored.size_bytes() as u64);
        self.n_read = self.n_read.saturating_add(n_bytes);
        source.pass_over(n_bytes).map_err(ReadFailure::Io)
    }
}

fn zeros<T: Sample>(n_voxels: usize) -> Result<Vec<T>, ReadFailure> {
    // Zeroed by the system, page by page: what is never written is never taken.
    bytemuck::try_zeroed_vec(n_voxels)
        .map_err(|()| ReadFailure::Io(io::ErrorKind::OutOfMemory.into()))
}

fn put_same<'b, T: Sample>(
    samples: &mut [T],
    stride: usize,
    items: impl Iterator<Item = &'b [u8]>,
    endian: Endian,
) {
    for (idx, item) in items.enumerate() {
        let sample = &mut samples[idx * stride];
        let bytes = bytemuck::bytes_of_mut(sample);
        bytes.copy_from_slice(item);
        if endian != Endian::NATIVE {
            bytes.reverse();
        }
    }
}

/// Fills `bytes`; a packed stream that breaks off counts as its end.
fn read_all(source: &mut impl Read, bytes: &mut [u8], n_read: &mut u64) -> Result<(), ReadFailure> {
    let mut n_filled = 0;
    while n_filled < bytes.len() {
        match source.read(&mut bytes[n_filled..]) {
            Ok(0) => return Err(ReadFailure::TooShort(*n_read)),
            Ok(n) => {
                n_filled += n;
                *n_read += n as u64;
            }
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
                return Err(ReadFailure::TooShort(*n_read));
            }
            Err(error) => return Err(ReadFailure::Io(error)),
        }
    }
    Ok(())
}

/// The same array with as few axes as say it: an axis that continues where the one before ends is one with
/// it.
fn joined(axes: &[Axis]) -> Vec<Axis> {
    let mut joined: Vec<Axis> = Vec::new();
    for axis in axes.iter().filter(|axis| axis.len != 1) {
        match joined.last_mut() {
            Some(last) if last.kept == (0..last.len) && last.stride * last.len == axis.stride => {
                let n = last.len;
                last.len *= axis.len;
                last.kept = axis.kept.start * n..axis.kept.end * n;
            }
            _ => joined.push(axis.clone()),
        }
    }
    joined
}

#[cfg(test)]
mod tests;
