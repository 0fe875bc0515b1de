//! Bytes become samples, in their own type and without a second copy where volumes have that type.

use std::collections::TryReserveError;
use std::io::{self, Read};
use std::sync::Arc;

use slabsplat_core::{Sample, SampleType, Samples, with_samples};

use super::spill::Spill;
use super::stored::{Narrowed, StoredType, half, integer, reserve};

/// The order of a number's bytes in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[expect(clippy::exhaustive_enums, reason = "bytes have two orders")]
pub enum Endian {
    /// Least significant byte first.
    Little,
    /// Most significant byte first.
    Big,
}

impl Endian {
    /// This machine's.
    pub const NATIVE: Self = if cfg!(target_endian = "big") { Self::Big } else { Self::Little };
}

/// Samples on their way in. Those of a volume's own types are stored as they come, and turned to this
/// machine's byte order at the end, in place; others are converted a chunk at a time.
pub(super) struct SampleBuffer {
    stored: StoredType,
    endian: Endian,
    target: Target,
    spilling: Option<Spilling>,
}

/// Where samples go that are in memory no longer than it takes.
struct Spilling {
    to: Arc<Spill>,
    n_spilled: usize,
}

enum Target {
    Same(Samples),
    Half(Vec<f32>),
    Wide(Narrowed),
}

/// Fewer came than were asked for.
pub(super) enum ReadFailure {
    /// The data end after so many bytes.
    TooShort(u64),
    /// The system, or the unpacking, failed.
    Io(io::Error),
}

/// Memory grows by at least so much.
const CHUNK_BYTES: usize = 1 << 20;

/// Samples that are in memory before they are spilled.
const N_SPILLED_AT_ONCE: usize = 1 << 18;

/// Items that are converted at a time.
const N_AT_ONCE: usize = 1 << 13;

impl SampleBuffer {
    pub(super) fn new(stored: impl Into<StoredType>, endian: Endian) -> Self {
        let stored = stored.into();
        Self { stored, endian, target: Target::empty(stored), spilling: None }
    }

    /// The same that writes samples there, and holds some of them alone.
    pub(super) fn spilling(self, to: Option<Arc<Spill>>) -> Self {
        Self { spilling: to.map(|to| Spilling { to, n_spilled: 0 }), ..self }
    }

    /// Takes `n_samples` more from `reader`. With `is_backed`, so many bytes are known to be there.
    pub(super) fn append(
        &mut self,
        reader: &mut impl Read,
        n_samples: usize,
        is_backed: bool,
    ) -> Result<(), ReadFailure> {
        if self.spilling.is_none() {
            return self.append_here(reader, n_samples, is_backed);
        }
        for first in (0..n_samples).step_by(N_SPILLED_AT_ONCE) {
            let n_now = N_SPILLED_AT_ONCE.min(n_samples - first);
            self.append_here(reader, n_now, true).map_err(|failure| match failure {
                ReadFailure::TooShort(n_found) => {
                    ReadFailure::TooShort((first * self.stored.size_bytes()) as u64 + n_found)
                }
                other @ ReadFailure::Io(_) => other,
            })?;
            self.spill().map_err(ReadFailure::Io)?;
        }
        Ok(())
    }

    fn append_here(
        &mut self,
        reader: &mut impl Read,
        n_samples: usize,
        is_backed: bool,
    ) -> Result<(), ReadFailure> {
        match &mut self.target {
            Target::Same(samples) => {
                with_samples!(samples, |s| append(s, reader, n_samples, is_backed))
            }
            Target::Half(_) | Target::Wide(_) => self.convert(reader, n_samples, is_backed),
        }
    }

    fn convert(
        &mut self,
        reader: &mut impl Read,
        n_samples: usize,
        is_backed: bool,
    ) -> Result<(), ReadFailure> {
        let item_bytes = self.stored.size_bytes();
        let mut chunk = vec![0; item_bytes * N_AT_ONCE.min(n_samples)];
        let mut n_done = 0;
        while n_done < n_samples {
            let n_left = n_samples - n_done;
            let bytes = &mut chunk[..item_bytes * n_left.min(N_AT_ONCE)];
            let n_read = read_full(reader, bytes).map_err(ReadFailure::Io)?;
            if n_read < bytes.len() {
                return Err(ReadFailure::TooShort((n_done * item_bytes + n_read) as u64));
            }
            let n_expected = if is_backed { n_left } else { 0 };
            self.push_items(bytes, self.endian, n_expected)
                .map_err(|_| ReadFailure::Io(io::ErrorKind::OutOfMemory.into()))?;
            n_done += bytes.len() / item_bytes;
        }
        Ok(())
    }

    /// Appends what has to be converted, of `n_expected` items that are to come.
    fn push_items(
        &mut self,
        bytes: &[u8],
        endian: Endian,
        n_expected: usize,
    ) -> Result<(), TryReserveError> {
        let stored = self.stored;
        let items = bytes.chunks_exact(stored.size_bytes());
        match &mut self.target {
            Target::Same(_) => Ok(()),
            Target::Half(samples) => {
                reserve(samples, items.len(), n_expected)?;
                samples.extend(items.map(|item| half(item, endian)));
                Ok(())
            }
            Target::Wide(narrowed) => {
                narrowed.append(items.map(|item| integer(item, stored, endian)), n_expected)
            }
        }
    }

    /// Appends the next number of a text; `None` if `token` is none, or not of the type.
    pub(super) fn push_text(&mut self, token: &str) -> Option<()> {
        match &mut self.target {
            Target::Same(samples) => with_samples!(samples, |s| s.push(token.parse().ok()?)),
            Target::Half(samples) => samples.push(token.parse().ok()?),
            Target::Wide(narrowed) => {
                let number = match self.stored {
                    StoredType::U64 => i128::from(token.parse::<u64>().ok()?),
                    _ => i128::from(token.parse::<i64>().ok()?),
                };
                narrowed.append(std::iter::once(number), 0).ok()?;
            }
        }
        self.spill_if_many();
        Some(())
    }

    /// Appends a sample by its bytes, in this machine's order.
    pub(super) fn push_bytes(&mut self, bytes: &[u8]) -> Result<(), TryReserveError> {
        match &mut self.target {
            Target::Same(samples) => {
                with_samples!(samples, |s| s.push(bytemuck::pod_read_unaligned(bytes)));
            }
            Target::Half(_) | Target::Wide(_) => self.push_items(bytes, Endian::NATIVE, 0)?,
        }
        self.spill_if_many();
        Ok(())
    }

    /// What fails is remembered by the spill, whoever reads on.
    fn spill_if_many(&mut self) {
        if self.spilling.is_some() && N_SPILLED_AT_ONCE <= self.target.len() {
            let _ = self.spill();
        }
    }

    /// Writes what is here, if it is to be written, and forgets it.
    fn spill(&mut self) -> io::Result<()> {
        let Some(Spilling { to, n_spilled }) = &mut self.spilling else { return Ok(()) };
        let target = std::mem::replace(&mut self.target, Target::empty(self.stored));
        let (first, n_samples) = (*n_spilled as u64, target.len());
        match target {
            Target::Wide(narrowed) => to.write_integers(first, narrowed, self.stored)?,
            _ => to.write(first, &target.finish(self.stored, self.endian, &mut Vec::new()))?,
        }
        *n_spilled += n_samples;
        Ok(())
    }

    /// Bytes of a sample in the file.
    pub(super) fn sample_bytes(&self) -> usize {
        self.stored.size_bytes()
    }

    pub(super) fn len(&self) -> usize {
        self.spilling.as_ref().map_or(0, |spilling| spilling.n_spilled) + self.target.len()
    }

    /// The samples, and a warning if they are of another type than in the file; one alone, a zero, if they
    /// are spilled.
    pub(super) fn finish(mut self, warnings: &mut Vec<String>) -> Samples {
        // What fails here is remembered, too.
        let _ = self.spill();
        match self.spilling {
            None => self.target.finish(self.stored, self.endian, warnings),
            Some(Spilling { to, n_spilled }) => {
                to.end(n_spilled as u64);
                one_zero(self.stored)
            }
        }
    }
}

impl Target {
    fn empty(stored: StoredType) -> Self {
        match stored {
            StoredType::Sample(sample_type) => Self::Same(no_samples(sample_type)),
            StoredType::F16 => Self::Half(Vec::new()),
            StoredType::I64 | StoredType::U64 => Self::Wide(Narrowed::new(Vec::new())),
        }
    }

    fn len(&self) -> usize {
        match self {
            Self::Same(samples) => samples.len(),
            Self::Half(samples) => samples.len(),
            Self::Wide(narrowed) => narrowed.len(),
        }
    }

    fn finish(self, stored: StoredType, endian: Endian, warnings: &mut Vec<String>) -> Samples {
        match self {
            Self::Same(mut samples) => {
                if endian != Endian::NATIVE {
                    with_samples!(&mut samples, |s| swap_bytes(s));
                }
                samples
            }
            Self::Half(samples) => Samples::F32(samples),
            Self::Wide(narrowed) => narrowed.finish(stored, warnings),
        }
    }
}

/// What stands for samples that are spilled.
pub(super) fn one_zero(stored: StoredType) -> Samples {
    let mut samples = no_samples(stored.widest());
    with_samples!(&mut samples, |s| s.resize(1, bytemuck::Zeroable::zeroed()));
    samples
}

fn no_samples(sample_type: SampleType) -> Samples {
    match sample_type {
        SampleType::U8 => Samples::U8(Vec::new()),
        SampleType::I8 => Samples::I8(Vec::new()),
        SampleType::U16 => Samples::U16(Vec::new()),
        SampleType::I16 => Samples::I16(Vec::new()),
        SampleType::U32 => Samples::U32(Vec::new()),
        SampleType::I32 => Samples::I32(Vec::new()),
        SampleType::F32 => Samples::F32(Vec::new()),
        SampleType::F64 => Samples::F64(Vec::new()),
    }
}

fn append<T: Sample>(
    samples: &mut Vec<T>,
    reader: &mut impl Read,
    n_samples: usize,
    is_backed: bool,
) -> Result<(), ReadFailure> {
    let out_of_memory = || ReadFailure::Io(io::ErrorKind::OutOfMemory.into());
    let n_before = samples.len();
    let n_after = n_before + n_samples;
    while samples.len() < n_after {
        let n_read = samples.len();
        // What has come doubles the room at most, so that a lying header costs little, and room
        // never exceeds what is needed, so that an honest one costs nothing.
        let step = if is_backed { n_samples } else { n_read.max(CHUNK_BYTES / size_of::<T>()) };
        let step = step.min(n_after - n_read);
        if n_read == 0 {
            // Zeroed by the system, page by page: a gigabyte need not be written twice.
            *samples = bytemuck::try_zeroed_vec(step).map_err(|_| out_of_memory())?;
        } else {
            samples.try_reserve_exact(step).map_err(|_| out_of_memory())?;
            samples.resize(n_read + step, T::zeroed());
        }
        let bytes = bytemuck::cast_slice_mut(&mut samples[n_read..]);
        let n_bytes = read_full(reader, bytes).map_err(ReadFailure::Io)?;
        if n_bytes < bytes.len() {
            let before = (n_read - n_before) * size_of::<T>();
            return Err(ReadFailure::TooShort((before + n_bytes) as u64));
        }
    }
    Ok(())
}

/// Fills `bytes` as far as the reader has any; a packed stream that breaks off counts as its end.
fn read_full(reader: &mut impl Read, bytes: &mut [u8]) -> io::Result<usize> {
    let mut n_read = 0;
    while n_read < bytes.len() {
        match reader.read(&mut bytes[n_read..]) {
            Ok(0) => break,
            Ok(n) => n_read += n,
            Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
            Err(e) if e.kind() == io::ErrorKind::UnexpectedEof => break,
            Err(e) => return Err(e),
        }
    }
    Ok(n_read)
}

fn swap_bytes<T: Sample>(samples: &mut [T]) {
    let bytes: &mut [u8] = bytemuck::cast_slice_mut(samples);
    for sample in bytes.chunks_exact_mut(size_of::<T>()) {
        sample.reverse();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(
        bytes: &[u8],
        stored: impl Into<StoredType>,
        n: usize,
        endian: Endian,
    ) -> Result<Samples, u64> {
        let mut buffer = SampleBuffer::new(stored, endian);
        match buffer.append(&mut &bytes[..], n, false) {
            Ok(()) => Ok(buffer.finish(&mut Vec::new())),
            Err(ReadFailure::TooShort(n)) => Err(n),
            Err(ReadFailure::Io(e)) => panic!("{e}"),
        }
    }

    #[test]
    fn buffer_reads_either_byte_order() {
        let bytes = [1, 2, 3, 4];
        let read16 = |endian| read(&bytes, SampleType::U16, 2, endian);
        assert_eq!(read16(Endian::Little), Ok(Samples::U16(vec![0x0201, 0x0403])));
        assert_eq!(read16(Endian::Big), Ok(Samples::U16(vec![0x0102, 0x0304])));
        let float = 2.5_f64.to_be_bytes();
        assert_eq!(read(&float, SampleType::F64, 1, Endian::Big), Ok(Samples::F64(vec![2.5])));
    }

    /// More of them than are converted at a time, and a wide one among the last.
    #[test]
    fn buffer_converts_as_it_reads() {
        let numbers: Vec<i64> =
            (0..20_000).map(|n| if n == 19_000 { -1 << 40 } else { n }).collect();
        let expected = Samples::F64(numbers.iter().map(|&n| n as f64).collect());
        let bytes: Vec<u8> = numbers.iter().flat_map(|n| n.to_be_bytes()).collect();
        assert_eq!(read(&bytes, StoredType::I64, 20_000, Endian::Big), Ok(expected));
        let narrow = Samples::I32((0..19_000).collect());
        assert_eq!(read(&bytes, StoredType::I64, 19_000, Endian::Big), Ok(narrow));
        assert_eq!(read(&bytes[1..], StoredType::U64, 20_000, Endian::Big), Err(159_999));
        let halves = [0x00, 0x3c, 0x00, 0xc0];
        let expected = Samples::F32(vec![1.0, -2.0]);
        assert_eq!(read(&halves, StoredType::F16, 2, Endian::Little), Ok(expected));
    }

    #[test]
    fn buffer_tells_how_much_there_was() {
        assert_eq!(read(&[0; 7], SampleType::I32, 2, Endian::Little), Err(7));
        assert_eq!(
            read(&[0; 3_000_000], SampleType::U8, usize::MAX / 4, Endian::Big),
            Err(3_000_000)
        );
    }
}
