//! Files in a ZIP archive, stored or deflated: what NumPy's `.npz` and zipped Zarr need of it.
//!
//! Format: APPNOTE 6.3 <https://pkware.cachefly.net/webdocs/casestudies/APPNOTE.TXT>, §4.3, ZIP64 too. The
//! crate `zip` writes, encrypts and knows a dozen packings; reading two of them is this file. Not read:
//! encrypted archives, archives in several parts.

use std::collections::BTreeMap;
use std::io::{self, BufReader, Read, Seek, SeekFrom, Take};
use std::path::{Path, PathBuf};

use flate2::Crc;
use flate2::read::DeflateDecoder;

use super::placed::Source;
use super::stream::MAX_GZIP_RATIO;
use crate::IoError;
use crate::printable::printable;
use crate::store::{Store, StoredFile};

/// The names in an archive, and where their bytes are.
pub(super) struct ZipFile<'b> {
    store: Store<'b>,
    path: PathBuf,
    entries: Vec<Entry>,
    /// Where the entry of a name is among them, the first of its name.
    by_name: BTreeMap<String, usize>,
}

/// A file in an archive, on the word of the archive's directory.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub(super) name: String,
    method: u16,
    is_encrypted: bool,
    crc: u32,
    n_packed: u64,
    n_bytes: u64,
    header_at: u64,
}

/// The bytes of a file in an archive, unpacked.
pub(super) struct EntryReader<'b> {
    reader: Unpacker<'b>,
    crc: Crc,
    expected: u32,
    n_left: u64,
}

enum Unpacker<'b> {
    Stored(Packed<'b>),
    Deflated(Box<DeflateDecoder<Packed<'b>>>),
}

type Packed<'b> = Take<BufReader<StoredFile<'b>>>;

/// The directory's end, with the longest comment after it.
const MAX_END_BYTES: u64 = 22 + 65_535;

const STORED: u16 = 0;
const DEFLATED: u16 = 8;

/// Whether the file begins as an archive with files in it does.
pub(super) fn is_zip(start: &[u8]) -> bool {
    start.starts_with(b"PK\x03\x04")
}

impl<'b> ZipFile<'b> {
    pub(super) fn open(store: Store<'b>, path: &Path) -> Result<Self, IoError> {
        let mut file = store.open(path)?;
        let n_bytes = file.n_bytes().map_err(IoError::read(path))?;
        let directory = directory(&mut file, n_bytes).map_err(IoError::read(path))?;
        let cut_off = || IoError::malformed(path, "not a whole ZIP archive: it has no directory");
        let entries = entries(&directory.ok_or_else(cut_off)?).ok_or_else(|| {
            IoError::malformed(path, "the directory of the ZIP archive is broken")
        })?;
        let names = entries.iter().enumerate().rev();
        let by_name = names.map(|(idx, entry)| (entry.name.clone(), idx)).collect();
        Ok(Self { store, path: path.to_owned(), entries, by_name })
    }

    pub(super) fn entries(&self) -> &[Entry] {
        &self.entries
    }

    pub(super) fn get(&self, name: &str) -> Option<&Entry> {
        self.by_name.get(name).map(|&idx| &self.entries[idx])
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    pub(super) fn reader(&self, entry: &Entry) -> Result<EntryReader<'b>, IoError> {
        let packed = self.packed(entry)?;
        let n_most = entry.n_packed.saturating_mul(MAX_GZIP_RATIO);
        let (reader, n_left) = match entry.method {
            STORED => (Unpacker::Stored(packed), entry.n_packed.min(entry.n_bytes)),
            DEFLATED => {
                let decoder = Box::new(DeflateDecoder::new(packed));
                (Unpacker::Deflated(decoder), n_most.min(entry.n_bytes))
            }
            other => {
                let what = format!(
                    "{} is packed by method {other} of ZIP: pack the archive with deflate",
                    entry.name
                );
                return Err(IoError::unsupported(self.path.as_path(), what));
            }
        };
        Ok(EntryReader { reader, crc: Crc::new(), expected: entry.crc, n_left })
    }

    /// Where the bytes of a stored file are in the archive; `None` of one that is packed.
    pub(super) fn stored_range(&self, entry: &Entry) -> Result<Option<(u64, u64)>, IoError> {
        if entry.method != STORED {
            return Ok(None);
        }
        let mut packed = self.packed(entry)?;
        let at = packed.get_mut().stream_position().map_err(IoError::read(&self.path))?;
        Ok(Some((at, entry.n_packed)))
    }

    fn packed(&self, entry: &Entry) -> Result<Packed<'b>, IoError> {
        let malformed = |what: &str| {
            IoError::malformed(self.path.as_path(), format!("{} in the archive {what}", entry.name))
        };
        if entry.is_encrypted {
            let what = format!("{} in the archive is encrypted: unpack it", entry.name);
            return Err(IoError::unsupported(self.path.as_path(), what));
        }
        let file = self.store.open(&self.path)?;
        let n_bytes = file.n_bytes().map_err(IoError::read(&self.path))?;
        let mut file = BufReader::new(file);
        let mut header = [0; 30];
        file.seek(SeekFrom::Start(entry.header_at))
            .and_then(|_| file.read_exact(&mut header))
            .map_err(|_| malformed("is not where the directory says"))?;
        if !header.starts_with(b"PK\x03\x04") {
            return Err(malformed("is not where the directory says"));
        }
        let n_names = i64::from(u16_at(&header, 26)) + i64::from(u16_at(&header, 28));
        file.seek_relative(n_names).map_err(IoError::read(&self.path))?;
        let data_at = entry.header_at + 30 + n_names.unsigned_abs();
        if n_bytes.saturating_sub(data_at) < entry.n_packed {
            return Err(malformed("is longer than the archive"));
        }
        Ok(file.take(entry.n_packed))
    }
}

impl EntryReader<'_> {
    /// No more bytes than this can come.
    pub(super) fn n_left_at_most(&self) -> u64 {
        self.n_left
    }

    /// Passes over the rest, and compares the sum over all bytes with the archive's.
    pub(super) fn ends_soundly(mut self) -> io::Result<bool> {
        io::copy(&mut self, &mut io::sink())?;
        Ok(self.crc.sum() == self.expected)
    }
}

impl Read for EntryReader<'_> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let n_wanted = usize::try_from(self.n_left).unwrap_or(usize::MAX).min(bytes.len());
        let bytes = &mut bytes[..n_wanted];
        let n_read = match &mut self.reader {
            Unpacker::Stored(reader) => reader.read(bytes)?,
            Unpacker::Deflated(reader) => reader.read(bytes)?,
        };
        self.crc.update(&bytes[..n_read]);
        self.n_left -= n_read as u64;
        Ok(n_read)
    }
}

impl Source for EntryReader<'_> {}

/// The bytes of the archive's directory; `None` if there is none.
fn directory(file: &mut StoredFile<'_>, n_bytes: u64) -> io::Result<Option<Vec<u8>>> {
    let mut end = Vec::new();
    file.seek(SeekFrom::Start(n_bytes.saturating_sub(MAX_END_BYTES + 20)))?;
    file.by_ref().take(MAX_END_BYTES + 20).read_to_end(&mut end)?;
    let last_to_first = (0..end.len().saturating_sub(21)).rev();
    let Some(at) = last_to_first.clone().find(|&at| end[at..].starts_with(b"PK\x05\x06")) else {
        return Ok(None);
    };
    let mut n_directory = u64::from(u32_at(&end, at + 12));
    let mut directory_at = u64::from(u32_at(&end, at + 16));
    // Before it, in large archives, what says where the same in 64 bits is.
    if let Some(locator) = at.checked_sub(20)
        && end[locator..].starts_with(b"PK\x06\x07")
    {
        let mut record = [0; 56];
        file.seek(SeekFrom::Start(u64_at(&end, locator + 8)))?;
        if file.read_exact(&mut record).is_err() || !record.starts_with(b"PK\x06\x06") {
            return Ok(None);
        }
        n_directory = u64_at(&record, 40);
        directory_at = u64_at(&record, 48);
    }
    if n_bytes.saturating_sub(directory_at) < n_directory {
        return Ok(None);
    }
    let mut directory = Vec::new();
    file.seek(SeekFrom::Start(directory_at))?;
    file.take(n_directory).read_to_end(&mut directory)?;
    Ok(Some(directory))
}

/// What a directory lists; `None` if it breaks off.
fn entries(mut directory: &[u8]) -> Option<Vec<Entry>> {
    let mut entries = Vec::new();
    while directory.starts_with(b"PK\x01\x02") {
        let header = directory.get(..46)?;
        let [n_name, n_extra, n_comment] = [28, 30, 32].map(|at| usize::from(u16_at(header, at)));
        let name = directory.get(46..46 + n_name)?;
        let extra = directory.get(46 + n_name..46 + n_name + n_extra)?;
        let mut wide = wide_fields(extra);
        let mut number = |at: usize| match u32_at(header, at) {
            u32::MAX => wide.next(),
            number => Some(u64::from(number)),
        };
        // In this order they are in 64 bits, those that need it.
        let (n_bytes, n_packed) = (number(24)?, number(20)?);
        let header_at = number(42)?;
        entries.push(Entry {
            name: printable(&String::from_utf8_lossy(name)),
            method: u16_at(header, 10),
            is_encrypted: u16_at(header, 8) & 1 == 1,
            crc: u32_at(header, 16),
            n_packed,
            n_bytes,
            header_at,
        });
        directory = directory.get(46 + n_name + n_extra + n_comment..)?;
    }
    Some(entries)
}

/// The numbers of the field that has those too large for 32 bits.
fn wide_fields(mut extra: &[u8]) -> impl Iterator<Item = u64> {
    let mut numbers: &[u8] = &[];
    while let Some(header) = extra.get(..4) {
        let n_bytes = usize::from(u16_at(header, 2));
        let Some(field) = extra.get(4..4 + n_bytes) else { break };
        if u16_at(header, 0) == 1 {
            numbers = field;
        }
        extra = &extra[4 + n_bytes..];
    }
    numbers.chunks_exact(8).map(|bytes| u64_at(bytes, 0))
}

fn u16_at(bytes: &[u8], at: usize) -> u16 {
    u16::from_le_bytes([bytes[at], bytes[at + 1]])
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from(u16_at(bytes, at)) | u32::from(u16_at(bytes, at + 2)) << 16
}

fn u64_at(bytes: &[u8], at: usize) -> u64 {
    u64::from(u32_at(bytes, at)) | u64::from(u32_at(bytes, at + 4)) << 32
}

#[cfg(test)]
pub(crate) mod written {
    //! Archives for tests.

    use std::io::Write;

    /// An archive of some files; `packs` says which are deflated.
    pub(crate) fn zip(files: &[(&str, &[u8])], packs: bool) -> Vec<u8> {
        let mut archive = Vec::new();
        let mut directory = Vec::new();
        for (name, bytes) in files {
            let mut crc = flate2::Crc::new();
            crc.update(bytes);
            let packed = if packs { deflated(bytes) } else { bytes.to_vec() };
            let mut fields = vec![20, 0, 0, 0, if packs { 8 } else { 0 }, 0, 0, 0, 0, 0];
            fields.extend(crc.sum().to_le_bytes());
            fields.extend((packed.len() as u32).to_le_bytes());
            fields.extend((bytes.len() as u32).to_le_bytes());
            fields.extend((name.len() as u16).to_le_bytes());
            fields.extend([0, 0]);
            let header_at = archive.len() as u32;
            archive.extend([&b"PK\x03\x04"[..], &fields, name.as_bytes(), &packed].concat());
            directory.extend([&b"PK\x01\x02\x14\x00"[..], &fields, &[0; 10]].concat());
            directory.extend(header_at.to_le_bytes());
            directory.extend(name.as_bytes());
        }
        let directory_at = archive.len() as u32;
        let n_files = (files.len() as u16).to_le_bytes();
        archive.extend(&directory);
        archive.extend([&b"PK\x05\x06\0\0\0\0"[..], &n_files, &n_files].concat());
        archive.extend((directory.len() as u32).to_le_bytes());
        archive.extend(directory_at.to_le_bytes());
        archive.extend([0, 0]);
        archive
    }

    fn deflated(bytes: &[u8]) -> Vec<u8> {
        let level = flate2::Compression::fast();
        let mut encoder = flate2::write::DeflateEncoder::new(Vec::new(), level);
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    }
}

#[cfg(test)]
mod tests {
    use super::written::zip;
    use super::*;
    use crate::FilesInMemory;

    fn read(archive: &[u8], name: &str) -> Result<(Vec<u8>, bool), String> {
        let files = FilesInMemory::from_iter([("a.zip", archive)]);
        let zip = ZipFile::open(Store::Memory(&files), Path::new("a.zip"));
        let zip = zip.map_err(|e| e.to_string())?;
        let entry = zip.get(name).ok_or("no such file")?;
        let mut reader = zip.reader(entry).map_err(|e| e.to_string())?;
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes).map_err(|e| e.to_string())?;
        Ok((bytes, reader.ends_soundly().map_err(|e| e.to_string())?))
    }

    #[test]
    fn zip_reads_stored_and_deflated() {
        let long = vec![7; 100_000];
        let files = [("a", &b"first"[..]), ("b/c.npy", &long)];
        for packs in [false, true] {
            let archive = zip(&files, packs);
            assert!(is_zip(&archive));
            for (name, bytes) in files {
                assert_eq!(read(&archive, name), Ok((bytes.to_vec(), true)));
            }
            let with_comment = [archive, b"a comment".to_vec()].concat();
            assert_eq!(read(&with_comment, "a").unwrap().0, b"first");
        }
    }

    #[test]
    fn zip_refuses_what_is_broken() {
        let archive = zip(&[("a", b"first")], false);
        let broken = |at: usize, byte: u8| {
            let mut broken = archive.clone();
            broken[at] = byte;
            read(&broken, "a")
        };
        assert_eq!(broken(31, b'F'), Ok((b"First".to_vec(), false)));
        assert!(broken(1, 0).unwrap_err().contains("not where the directory says"));
        let in_directory = archive.len() - 22 - 47;
        assert!(broken(in_directory + 8, 1).unwrap_err().contains("encrypted"));
        assert!(broken(in_directory + 10, 12).unwrap_err().contains("method 12"));
        assert!(broken(in_directory + 23, 12).unwrap_err().contains("longer than the archive"));
        let cut_off = read(&archive[..archive.len() - 1], "a").unwrap_err();
        assert!(cut_off.contains("no directory"), "{cut_off}");
    }

    /// Sizes in 64 bits, as archives beyond 4 GiB have them, and Python for streams.
    #[test]
    fn zip_reads_wide_fields() {
        let mut archive = zip(&[("a", b"first")], false);
        let directory_at = archive.len() - 22 - 47;
        let wide = [1, 0, 24, 0].into_iter();
        let wide = wide.chain([5_u64, 5, 0].into_iter().flat_map(u64::to_le_bytes));
        for at in [20, 24, 42] {
            archive[directory_at + at..][..4].fill(0xff);
        }
        archive[directory_at + 30] = 28;
        let end = archive.len() - 22;
        archive.splice(end..end, wide);
        let at = archive.len() - 22 + 12;
        archive[at] += 28;
        assert_eq!(read(&archive, "a"), Ok((b"first".to_vec(), true)));
    }
}
