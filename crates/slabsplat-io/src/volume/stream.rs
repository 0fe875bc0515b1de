//! Bytes from files, plain or packed by gzip, zlib or bzip2. Knows how many there can be before it is asked
//! for them.

use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use bzip2::bufread::MultiBzDecoder;
use flate2::bufread::{MultiGzDecoder, ZlibDecoder};

use super::buffer::{ReadFailure, SampleBuffer};
use super::placed::Source;
use crate::IoError;
use crate::progress::ReadMeter;
use crate::store::{Store, StoredFile};

/// Deflate cannot pack better than this: 258 bytes in two bits.
pub(super) const MAX_GZIP_RATIO: u64 = 1032;

/// Nor bzip2 than this: a block of 45.9 million zeros in some forty bytes.
const MAX_BZIP2_RATIO: u64 = 1 << 21;

/// Voxels of several values are read by so much.
const CHUNK_BYTES: usize = 1 << 16;

/// No more is read at once.
const MAX_AT_ONCE_BYTES: usize = 4 << 20;

/// Enough of a file to tell what it is: a NIfTI-2 header.
pub(super) const N_FIRST_BYTES: usize = 540;

/// A file that is being read from front to back.
pub(super) struct DataStream<'p> {
    path: &'p Path,
    reader: Reader<'p>,
    /// No more bytes than this can come.
    n_left_at_most: u64,
    /// What counts the bytes that came.
    meter: Option<&'p ReadMeter>,
}

enum Reader<'p> {
    Plain(BufReader<StoredFile<'p>>),
    Gzip(Box<MultiGzDecoder<BufReader<StoredFile<'p>>>>),
    Zlib(Box<ZlibDecoder<BufReader<StoredFile<'p>>>>),
    Bzip2(Box<MultiBzDecoder<BufReader<StoredFile<'p>>>>),
}

impl<'p> DataStream<'p> {
    /// The bytes of the file as they are, from `offset`.
    pub(super) fn open(store: Store<'p>, path: &'p Path, offset: u64) -> Result<Self, IoError> {
        let mut file = store.open(path)?;
        let n_bytes = file.n_bytes().map_err(IoError::read(path))?;
        file.seek(SeekFrom::Start(offset)).map_err(IoError::read(path))?;
        let n_left_at_most = n_bytes.saturating_sub(offset);
        let reader = Reader::Plain(BufReader::new(file));
        Ok(Self { path, reader, n_left_at_most, meter: None })
    }

    /// From here on `meter` counts the bytes that come, and those that are passed over.
    pub(super) fn metered(&mut self, meter: &'p ReadMeter) {
        self.meter = Some(meter);
    }

    /// The file's content: unpacked if it begins as a gzip file does.
    pub(super) fn open_unpacked(store: Store<'p>, path: &'p Path) -> Result<Self, IoError> {
        let mut stream = Self::open(store, path, 0)?;
        let start = stream.peek()?;
        let is_gzip = start.starts_with(&[0x1f, 0x8b]);
        Ok(if is_gzip { stream.unpacked() } else { stream })
    }

    fn peek(&mut self) -> Result<&[u8], IoError> {
        let buffer = match &mut self.reader {
            Reader::Plain(reader) => reader.fill_buf(),
            Reader::Gzip(_) | Reader::Zlib(_) | Reader::Bzip2(_) => Ok(&[][..]),
        };
        buffer.map_err(IoError::read(self.path))
    }

    /// What follows, unpacked by zlib if it begins as that does, else by gzip.
    pub(super) fn unpacked(mut self) -> Self {
        let is_zlib = matches!(self.peek(), Ok([0x78, flags, ..]) if is_zlib_header(*flags));
        let Reader::Plain(reader) = self.reader else {
            return self;
        };
        let reader = if is_zlib {
            Reader::Zlib(Box::new(ZlibDecoder::new(reader)))
        } else {
            Reader::Gzip(Box::new(MultiGzDecoder::new(reader)))
        };
        let n_left_at_most = self.n_left_at_most.saturating_mul(MAX_GZIP_RATIO);
        Self { reader, n_left_at_most, ..self }
    }

    /// What follows, unpacked by bzip2.
    pub(super) fn unpacked_by_bzip2(self) -> Self {
        let Reader::Plain(reader) = self.reader else {
            return self;
        };
        let reader = Reader::Bzip2(Box::new(MultiBzDecoder::new(reader)));
        let n_left_at_most = self.n_left_at_most.saturating_mul(MAX_BZIP2_RATIO);
        Self { reader, n_left_at_most, ..self }
    }

    pub(super) fn n_left_at_most(&self) -> u64 {
        self.n_left_at_most
    }

    /// Whether the bytes left are known, not only bounded.
    pub(super) fn is_plain(&self) -> bool {
        matches!(self.reader, Reader::Plain(_))
    }

    /// Passes over `n_bytes`, or to the end if there are fewer.
    pub(super) fn skip(&mut self, n_bytes: u64) -> Result<(), IoError> {
        let path = self.path;
        let n_bytes = n_bytes.min(self.n_left_at_most);
        let skipped = io::copy(&mut self.by_ref().take(n_bytes), &mut io::sink());
        skipped.map(drop).map_err(IoError::read(path))
    }

    /// Passes over `n_bytes` without reading them, if the file is plain, or to the end if there are fewer.
    pub(super) fn jump(&mut self, n_bytes: u64) -> Result<(), IoError> {
        let path = self.path;
        self.pass_over(n_bytes).map_err(IoError::read(path))
    }

    /// Passes over `n_lines` lines, or to the end if there are fewer.
    pub(super) fn skip_lines(&mut self, n_lines: u64) -> Result<(), IoError> {
        let path = self.path;
        let mut n_seen = 0;
        let mut byte = [0];
        while n_seen < n_lines && self.read(&mut byte).map_err(IoError::read(path))? == 1 {
            n_seen += u64::from(byte[0] == b'\n');
        }
        Ok(())
    }

    /// Moves `n_samples` into `buffer`.
    pub(super) fn fill(
        &mut self,
        buffer: &mut SampleBuffer,
        n_samples: usize,
        sample_bytes: usize,
    ) -> Result<(), IoError> {
        let needed = n_samples as u64 * sample_bytes as u64;
        let found = self.n_left_at_most;
        if found < needed {
            return Err(self.too_short(needed, found));
        }
        let is_plain = self.is_plain();
        buffer.append(self, n_samples, is_plain).map_err(|failure| match failure {
            ReadFailure::TooShort(found) => too_short(self.path, needed, found),
            ReadFailure::Io(source) => IoError::Read { path: self.path.to_owned(), source },
        })
    }

    /// Moves `n_samples` into `buffer`: of each voxel, which has so many, the one of `channel`.
    pub(super) fn fill_channel(
        &mut self,
        buffer: &mut SampleBuffer,
        n_samples: usize,
        sample_bytes: usize,
        [n_channels, channel]: [usize; 2],
    ) -> Result<(), IoError> {
        if n_channels == 1 {
            return self.fill(buffer, n_samples, sample_bytes);
        }
        let voxel_bytes = n_channels.saturating_mul(sample_bytes);
        let needed = (n_samples as u64).saturating_mul(voxel_bytes as u64);
        let found = self.n_left_at_most;
        if found < needed {
            return Err(self.too_short(needed, found));
        }
        let path = self.path;
        let is_plain = self.is_plain();
        // As many voxels at a time as are some pages of memory; one alone is backed by what is left.
        let n_at_once = (CHUNK_BYTES / voxel_bytes).max(1);
        let mut channel_reader = OneChannel {
            reader: self.by_ref(),
            voxels: vec![0; n_at_once * voxel_bytes],
            samples: Vec::new(),
            n_taken: 0,
            bytes: [voxel_bytes, sample_bytes, channel * sample_bytes],
        };
        buffer.append(&mut channel_reader, n_samples, is_plain).map_err(|failure| match failure {
            ReadFailure::TooShort(found) => {
                too_short(path, needed, found.saturating_mul(n_channels as u64))
            }
            ReadFailure::Io(source) => IoError::Read { path: path.to_owned(), source },
        })
    }

    /// That so many bytes may come.
    pub(super) fn check_left(&self, needed: u64) -> Result<(), IoError> {
        let found = self.n_left_at_most;
        if found < needed { Err(self.too_short(needed, found)) } else { Ok(()) }
    }

    /// How many bytes are left, by reading them all.
    pub(super) fn count(mut self) -> Result<u64, IoError> {
        let path = self.path;
        io::copy(&mut self, &mut io::sink()).map_err(IoError::read(path))
    }

    fn too_short(&self, needed: u64, found: u64) -> IoError {
        if self.is_plain() {
            return too_short(self.path, needed, found);
        }
        let what = format!(
            "needs {needed} bytes of data, but is too short to unpack to more than {found}: the \
             file is cut off, or its header lies"
        );
        IoError::malformed(self.path, what)
    }

    /// Whether anything is left. Of a packed file this also checks the sum at its end.
    pub(super) fn has_more(&mut self) -> Result<bool, IoError> {
        let path = self.path;
        let n_read = self.read(&mut [0]).map_err(IoError::read(path))?;
        Ok(0 < n_read)
    }
}

impl Read for DataStream<'_> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        // Whole volumes are asked for at once; between parts of them is told how far they are.
        let n_most = bytes.len().min(MAX_AT_ONCE_BYTES);
        let bytes = &mut bytes[..n_most];
        let n_read = match &mut self.reader {
            Reader::Plain(reader) => reader.read(bytes)?,
            Reader::Gzip(reader) => reader.read(bytes)?,
            Reader::Zlib(reader) => reader.read(bytes)?,
            Reader::Bzip2(reader) => reader.read(bytes)?,
        };
        self.n_left_at_most = self.n_left_at_most.saturating_sub(n_read as u64);
        if let Some(meter) = self.meter {
            meter.advance(n_read as u64)?;
        }
        Ok(n_read)
    }
}

/// The bytes of one value of each voxel.
struct OneChannel<R> {
    reader: R,
    voxels: Vec<u8>,
    samples: Vec<u8>,
    n_taken: usize,
    /// Of a voxel, of a value, and before the value in the voxel.
    bytes: [usize; 3],
}

impl<R: Read> Read for OneChannel<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        if self.n_taken == self.samples.len() {
            self.refill()?;
        }
        let left = &self.samples[self.n_taken..];
        let n_read = left.len().min(bytes.len());
        bytes[..n_read].copy_from_slice(&left[..n_read]);
        self.n_taken += n_read;
        Ok(n_read)
    }
}

impl<R: Read> OneChannel<R> {
    fn refill(&mut self) -> io::Result<()> {
        let [voxel_bytes, sample_bytes, before] = self.bytes;
        let mut n_read = 0;
        while n_read < self.voxels.len() {
            match self.reader.read(&mut self.voxels[n_read..]) {
                Ok(0) => break,
                Ok(n) => n_read += n,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        self.samples.clear();
        self.n_taken = 0;
        for voxel in self.voxels[..n_read].chunks_exact(voxel_bytes) {
            self.samples.extend_from_slice(&voxel[before..before + sample_bytes]);
        }
        Ok(())
    }
}

impl Source for DataStream<'_> {
    fn pass_over(&mut self, n_bytes: u64) -> io::Result<()> {
        let n_bytes = n_bytes.min(self.n_left_at_most);
        match &mut self.reader {
            Reader::Plain(reader) => {
                reader.seek_relative(i64::try_from(n_bytes).unwrap_or(i64::MAX))?;
                self.n_left_at_most -= n_bytes;
                if let Some(meter) = self.meter {
                    meter.advance(n_bytes)?;
                }
                Ok(())
            }
            Reader::Gzip(_) | Reader::Zlib(_) | Reader::Bzip2(_) => {
                io::copy(&mut self.by_ref().take(n_bytes), &mut io::sink()).map(drop)
            }
        }
    }
}

/// Whether a byte may come second in a zlib stream that begins with 0x78 (RFC 1950 §2.2).
fn is_zlib_header(flags: u8) -> bool {
    (0x7800 + u16::from(flags)).is_multiple_of(31)
}

fn too_short(path: &Path, needed: u64, found: u64) -> IoError {
    IoError::WrongLength {
        path: path.to_owned(),
        needed,
        found,
        hint: "the file is cut off, or its header lies",
    }
}

/// The first bytes of the file, unpacked if it is a gzip file; fewer than 540 if it is shorter.
pub(super) fn first_bytes(store: Store<'_>, path: &Path) -> Result<Vec<u8>, IoError> {
    let mut bytes = Vec::with_capacity(N_FIRST_BYTES);
    let stream = DataStream::open_unpacked(store, path)?;
    match stream.take(N_FIRST_BYTES as u64).read_to_end(&mut bytes) {
        // A gzip file that breaks off here is reported by whoever reads it to the end.
        Err(e) if e.kind() != io::ErrorKind::UnexpectedEof => {
            Err(IoError::Read { path: path.to_owned(), source: e })
        }
        _ => Ok(bytes),
    }
}

/// The file's extension in lower case, looking through a `.gz`; empty if there is none.
pub(super) fn plain_extension(path: &Path) -> String {
    let lower = |p: &Path| p.extension().map(|e| e.to_string_lossy().to_lowercase());
    match lower(path).unwrap_or_default() {
        gz if gz == "gz" => lower(&path.with_extension("")).unwrap_or_default(),
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::super::buffer::Endian;
    use super::*;
    use slabsplat_core::SampleType;
    use std::io::Write;

    fn gzip(bytes: &[u8]) -> Vec<u8> {
        let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    }

    #[test]
    fn stream_unpacks_several_members() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.gz");
        std::fs::write(&path, [gzip(b"abc"), gzip(b"def")].concat()).unwrap();
        assert_eq!(first_bytes(Store::Disk, &path).unwrap(), b"abcdef");
        let mut stream = DataStream::open_unpacked(Store::Disk, &path).unwrap();
        stream.skip(2).unwrap();
        let mut buffer = SampleBuffer::new(SampleType::U8, Endian::NATIVE);
        stream.fill(&mut buffer, 4, 1).unwrap();
        assert!(!stream.has_more().unwrap());
    }

    #[test]
    fn stream_refuses_what_cannot_be() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.gz");
        std::fs::write(&path, gzip(&[0; 1000])).unwrap();
        let mut buffer = SampleBuffer::new(SampleType::U8, Endian::NATIVE);
        let mut fill =
            |n| DataStream::open_unpacked(Store::Disk, &path).unwrap().fill(&mut buffer, n, 1);
        let err = fill(1 << 30).unwrap_err().to_string();
        assert!(err.contains("too short to unpack"), "{err}");
        let err = fill(1001).unwrap_err().to_string();
        assert!(err.contains("needs 1001 bytes of data, has 1000"), "{err}");
        let err =
            DataStream::open(Store::Disk, &path, 5).unwrap().fill(&mut buffer, 99, 1).unwrap_err();
        assert!(err.to_string().contains("needs 99 bytes"), "{err}");
    }

    #[test]
    fn stream_notices_a_wrong_checksum() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.gz");
        let mut bytes = gzip(&[7; 100]);
        let at = bytes.len() - 6;
        bytes[at] ^= 1;
        std::fs::write(&path, bytes).unwrap();
        let mut stream = DataStream::open_unpacked(Store::Disk, &path).unwrap();
        stream.skip(100).unwrap();
        assert!(stream.has_more().is_err());
    }

    #[test]
    fn extension_looks_through_gz() {
        for (name, expected) in
            [("a.nii.gz", "nii"), ("A.NII.GZ", "nii"), ("a.hdr", "hdr"), ("a.gz", ""), ("a", "")]
        {
            assert_eq!(plain_extension(Path::new(name)), expected);
        }
    }
}
