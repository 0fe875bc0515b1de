//! Bytes become samples, in their own type and without a second copy.

use std::io::{self, Read};

use slabsplat_core::{Sample, SampleType, Samples, with_samples};

/// The order of a number's bytes in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
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

/// Samples on their way in. They are stored as they come, and turned to this machine's byte order
/// at the end, in place.
pub(super) struct SampleBuffer {
    samples: Samples,
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

impl SampleBuffer {
    pub(super) fn new(sample_type: SampleType) -> Self {
        let samples = match sample_type {
            SampleType::U8 => Samples::U8(Vec::new()),
            SampleType::I8 => Samples::I8(Vec::new()),
            SampleType::U16 => Samples::U16(Vec::new()),
            SampleType::I16 => Samples::I16(Vec::new()),
            SampleType::U32 => Samples::U32(Vec::new()),
            SampleType::I32 => Samples::I32(Vec::new()),
            SampleType::F32 => Samples::F32(Vec::new()),
            SampleType::F64 => Samples::F64(Vec::new()),
        };
        Self { samples }
    }

    /// Takes `n_samples` more from `reader`. With `is_backed`, so many bytes are known to be there.
    pub(super) fn append(
        &mut self,
        reader: &mut impl Read,
        n_samples: usize,
        is_backed: bool,
    ) -> Result<(), ReadFailure> {
        with_samples!(&mut self.samples, |s| append(s, reader, n_samples, is_backed))
    }

    /// Appends the next number of a text; `None` if `token` is none, or not of the type.
    pub(super) fn push_text(&mut self, token: &str) -> Option<()> {
        with_samples!(&mut self.samples, |s| s.push(token.parse().ok()?));
        Some(())
    }

    /// Appends a sample by its bytes, in this machine's order.
    pub(super) fn push_bytes(&mut self, bytes: &[u8]) {
        with_samples!(&mut self.samples, |s| s.push(bytemuck::pod_read_unaligned(bytes)));
    }

    pub(super) fn sample_bytes(&self) -> usize {
        self.samples.sample_type().size_bytes()
    }

    pub(super) fn len(&self) -> usize {
        self.samples.len()
    }

    pub(super) fn finish(mut self, stored: Endian) -> Samples {
        if stored != Endian::NATIVE {
            with_samples!(&mut self.samples, |s| swap_bytes(s));
        }
        self.samples
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

    fn read(bytes: &[u8], t: SampleType, n: usize, endian: Endian) -> Result<Samples, u64> {
        let mut buffer = SampleBuffer::new(t);
        match buffer.append(&mut &bytes[..], n, false) {
            Ok(()) => Ok(buffer.finish(endian)),
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

    #[test]
    fn buffer_tells_how_much_there_was() {
        assert_eq!(read(&[0; 7], SampleType::I32, 2, Endian::Little), Err(7));
        assert_eq!(
            read(&[0; 3_000_000], SampleType::U8, usize::MAX / 4, Endian::Big),
            Err(3_000_000)
        );
    }
}
