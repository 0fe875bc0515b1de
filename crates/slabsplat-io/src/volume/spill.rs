//! Samples on their way into a file instead of into memory: of a volume that is only read from front to back,
//! boxes are read from there afterwards (`scratch`).
//!
//! What readers collect samples in (`buffer`, `placed`) writes them here as they come, in this machine's byte
//! order, some at a time. What fails is remembered: a reader knows of no file but the one that it reads, and
//! would say that this one is broken.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use slabsplat_core::{Samples, with_samples};

use super::Endian;
use super::buffer::{ReadFailure, SampleBuffer};
use super::formats::Input;
use super::placed::{PlacedSamples, Source};
use super::stored::{Narrowed, StoredType, WideRange};

/// A file that takes the samples of a volume.
#[derive(Debug)]
pub(super) struct Spill(Mutex<Spilled>);

#[derive(Debug)]
struct Spilled {
    file: File,
    failure: Option<SpillFailure>,
    /// How many samples came one after the other, if they came so.
    n_in_order: Option<u64>,
    /// What integers of 64 bits are to become, which are numbers of 64 bits here.
    integers: Option<(StoredType, WideRange)>,
}

/// Why the file has not all samples.
#[derive(Debug)]
pub(super) enum SpillFailure {
    /// The system did not let us write.
    Write(io::Error),
    /// They do not come in an order in which they could be written; what they are.
    Order(&'static str),
}

impl Input<'_> {
    /// What takes the samples of a volume one after the other.
    pub(super) fn buffer(&self, stored: impl Into<StoredType>, endian: Endian) -> SampleBuffer {
        SampleBuffer::new(stored, endian).spilling(self.spill.clone())
    }

    /// What takes so many samples of a volume in any order, as [`PlacedSamples::new`].
    pub(super) fn room(
        &self,
        stored: StoredType,
        endian: Endian,
        n_voxels: usize,
    ) -> Result<PlacedSamples, ReadFailure> {
        match &self.spill {
            None => PlacedSamples::new(stored, endian, n_voxels),
            Some(spill) => Ok(PlacedSamples::spilled(stored, endian, spill.clone())),
        }
    }
}

impl Spill {
    pub(super) fn new(file: File) -> Arc<Self> {
        Arc::new(Self(Mutex::new(Spilled {
            file,
            failure: None,
            n_in_order: None,
            integers: None,
        })))
    }

    fn lock(&self) -> MutexGuard<'_, Spilled> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Writes samples from the `first`th of the volume on.
    pub(super) fn write(&self, first: u64, samples: &Samples) -> io::Result<()> {
        let mut spilled = self.lock();
        let at = first.saturating_mul(samples.sample_type().size_bytes() as u64);
        let bytes: &[u8] = with_samples!(samples, |s| bytemuck::cast_slice(s));
        let file = &mut spilled.file;
        let written = file.seek(SeekFrom::Start(at)).and_then(|_| file.write_all(bytes));
        written.map_err(|error| spilled.fail(SpillFailure::Write(error)))
    }

    /// The same of integers of 64 bits, of which only the last one tells what they become.
    pub(super) fn write_integers(
        &self,
        first: u64,
        numbers: Narrowed,
        stored: StoredType,
    ) -> io::Result<()> {
        let mut so_far = self.integers().map_or_else(WideRange::default, |(_, range)| range);
        let numbers = Samples::F64(numbers.widened(&mut so_far));
        self.lock().integers = Some((stored, so_far));
        self.write(first, &numbers)
    }

    /// What integers of 64 bits became of those that came, if they are that.
    pub(super) fn integers(&self) -> Option<(StoredType, WideRange)> {
        self.lock().integers
    }

    /// That samples cannot be written as they come.
    pub(super) fn refuse(&self, what: &'static str) -> io::Error {
        self.lock().fail(SpillFailure::Order(what))
    }

    /// So many samples came one after the other, and no more do.
    pub(super) fn end(&self, n_samples: u64) {
        self.lock().n_in_order = Some(n_samples);
    }

    pub(super) fn n_in_order(&self) -> Option<u64> {
        self.lock().n_in_order
    }

    /// What failed, if anything did.
    pub(super) fn failure(&self) -> Option<SpillFailure> {
        self.lock().failure.take()
    }

    /// Makes the file so long: what was not written is zero, as it is in memory.
    pub(super) fn set_len(&self, n_bytes: u64) -> io::Result<()> {
        self.lock().file.set_len(n_bytes)
    }

    /// Has `look` look at the file itself.
    pub(super) fn with_file<T>(&self, look: impl FnOnce(&File) -> T) -> T {
        look(&self.lock().file)
    }

    /// Has `read` read the file, from its first byte on.
    pub(super) fn with_reader<T>(&self, read: impl FnOnce(&mut SpillReader<'_>) -> T) -> T {
        read(&mut SpillReader { file: &self.lock().file, at: 0 })
    }
}

impl Spilled {
    /// What a reader of another file is told.
    fn fail(&mut self, failure: SpillFailure) -> io::Error {
        self.failure.get_or_insert(failure);
        io::Error::other("scratch failed")
    }
}

/// Reads the file where it is asked to: rows of a box are far apart, so that to read ahead were in vain.
pub(super) struct SpillReader<'f> {
    file: &'f File,
    at: u64,
}

impl Read for SpillReader<'_> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        self.file.seek(SeekFrom::Start(self.at))?;
        let n_read = self.file.read(bytes)?;
        self.at += n_read as u64;
        Ok(n_read)
    }
}

impl Source for SpillReader<'_> {
    fn pass_over(&mut self, n_bytes: u64) -> io::Result<()> {
        self.at = self.at.saturating_add(n_bytes);
        Ok(())
    }
}
