//! The files of a Zarr by their keys: in a folder, or in a ZIP archive, where a folder may be around them.

use std::io::{self, BufReader, Cursor, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use serde_json::Value;

use super::super::formats::Input;
use super::super::placed::Source;
use super::super::zip::ZipFile;
use crate::IoError;
use crate::store::{Store, StoredFile};

/// Files that only a Zarr has.
pub(super) const MARKS: &[&str] = &["zarr.json", ".zattrs", ".zgroup", ".zarray", ".zmetadata"];

/// No metadata that anybody writes are longer.
const MAX_JSON_BYTES: u64 = 16 << 20;

/// Of a file that is unpacked into memory whole.
const MAX_UNPACKED_BYTES: u64 = 1 << 30;

pub(super) enum Tree<'b> {
    Folder { store: Store<'b>, root: PathBuf },
    Zip { store: Store<'b>, zip: ZipFile<'b>, prefix: String },
}

/// A part of a file, or what was unpacked of one.
pub(super) enum Part<'b> {
    File { reader: BufReader<StoredFile<'b>>, start: u64, n_bytes: u64, at: u64 },
    Memory(Cursor<Vec<u8>>),
}

impl<'b> Tree<'b> {
    pub(super) fn open(input: &Input<'b>) -> Result<Self, IoError> {
        let (store, path) = (input.store, input.path);
        if store.is_folder(path) {
            return Ok(Self::Folder { store, root: path.to_owned() });
        }
        let zip = ZipFile::open(store, path)?;
        let prefix = prefix(&zip).ok_or_else(|| {
            IoError::unsupported(
                path,
                "the ZIP archive holds no Zarr: unpack it, and open what is in it",
            )
        })?;
        Ok(Self::Zip { store, zip, prefix })
    }

    /// The metadata at a key, if there are any.
    pub(super) fn json(&self, key: &str) -> Result<Option<Value>, IoError> {
        let Some(part) = self.part(key)? else { return Ok(None) };
        let mut text = Vec::new();
        let path = self.path_of(key);
        part.take(MAX_JSON_BYTES).read_to_end(&mut text).map_err(IoError::read(&path))?;
        match serde_json::from_slice(&text) {
            Ok(object @ Value::Object(_)) => Ok(Some(object)),
            Ok(_) => Err(IoError::malformed(path, "the metadata are no JSON object")),
            Err(error) => {
                Err(IoError::malformed(path, format!("the metadata are no JSON: {error}")))
            }
        }
    }

    /// The file at a key, if there is one.
    pub(super) fn part(&self, key: &str) -> Result<Option<Part<'b>>, IoError> {
        match self {
            Self::Folder { store, root } => {
                let path = root.join(key);
                if !store.has(&path) {
                    return Ok(None);
                }
                let file = store.open(&path)?;
                let n_bytes = file.n_bytes().map_err(IoError::read(&path))?;
                Ok(Some(Part::File { reader: BufReader::new(file), start: 0, n_bytes, at: 0 }))
            }
            Self::Zip { store, zip, prefix } => {
                let Some(entry) = zip.get(&format!("{prefix}{key}")) else { return Ok(None) };
                if let Some((start, n_bytes)) = zip.stored_range(entry)? {
                    let file = store.open(zip.path())?;
                    let mut reader = BufReader::new(file);
                    let sought = reader.seek(SeekFrom::Start(start));
                    sought.map_err(IoError::read(zip.path()))?;
                    return Ok(Some(Part::File { reader, start, n_bytes, at: 0 }));
                }
                let mut bytes = Vec::new();
                let mut reader = zip.reader(entry)?;
                if MAX_UNPACKED_BYTES < reader.n_left_at_most() {
                    let what =
                        format!("{key} in the archive is longer than 1 GiB: unpack the archive");
                    return Err(IoError::unsupported(zip.path(), what));
                }
                reader.read_to_end(&mut bytes).map_err(IoError::read(zip.path()))?;
                Ok(Some(Part::Memory(Cursor::new(bytes))))
            }
        }
    }

    pub(super) fn has(&self, key: &str) -> bool {
        match self {
            Self::Folder { store, root } => store.has(&root.join(key)),
            Self::Zip { zip, prefix, .. } => zip.get(&format!("{prefix}{key}")).is_some(),
        }
    }

    /// For messages.
    pub(super) fn path_of(&self, key: &str) -> PathBuf {
        match self {
            Self::Folder { root, .. } => root.join(key),
            Self::Zip { zip, .. } => zip.path().to_owned(),
        }
    }
}

/// Whether an archive has the metadata of a Zarr in it.
pub(super) fn is_zip_of_zarr(store: Store<'_>, path: &Path) -> bool {
    ZipFile::open(store, path).ok().and_then(|zip| prefix(&zip)).is_some()
}

/// What is before the key of the metadata that are highest up.
fn prefix(zip: &ZipFile<'_>) -> Option<String> {
    let names = zip.entries().iter().map(|entry| entry.name.as_str());
    let prefixes = names.filter_map(|name| {
        let (folder, file) =
            name.rsplit_once('/').map_or(("", name), |(f, n)| (&name[..f.len() + 1], n));
        MARKS.contains(&file).then_some(folder)
    });
    prefixes.min_by_key(|prefix| prefix.len()).map(str::to_owned)
}

/// A key below another, if it does not lead out of it.
pub(super) fn joined(key: &str, below: &str) -> Option<String> {
    let below = below.trim_matches('/');
    let is_sane = |part: &str| {
        !["", ".", ".."].contains(&part)
            && !part.contains(|c: char| c.is_control() || "\\:".contains(c))
    };
    if !below.is_empty() && !below.split('/').all(is_sane) {
        return None;
    }
    Some(match (key.is_empty(), below.is_empty()) {
        (true, _) => below.to_owned(),
        (false, true) => key.to_owned(),
        (false, false) => format!("{key}/{below}"),
    })
}

impl Part<'_> {
    pub(super) fn n_bytes(&self) -> u64 {
        match self {
            Self::File { n_bytes, .. } => *n_bytes,
            Self::Memory(cursor) => cursor.get_ref().len() as u64,
        }
    }

    /// Whether it is read where it lies, so that to open it again takes no memory.
    pub(super) fn is_file(&self) -> bool {
        matches!(self, Self::File { .. })
    }

    /// Goes to a byte.
    pub(super) fn go_to(&mut self, to: u64) -> io::Result<()> {
        match self {
            Self::File { reader, start, at, .. } => {
                reader.seek(SeekFrom::Start(start.saturating_add(to)))?;
                *at = to;
            }
            Self::Memory(cursor) => cursor.set_position(to),
        }
        Ok(())
    }
}

impl Read for Part<'_> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        match self {
            Self::File { reader, n_bytes, at, .. } => {
                let n_left = usize::try_from(n_bytes.saturating_sub(*at)).unwrap_or(usize::MAX);
                let n_wanted = bytes.len().min(n_left);
                let n_read = reader.read(&mut bytes[..n_wanted])?;
                *at += n_read as u64;
                Ok(n_read)
            }
            Self::Memory(cursor) => cursor.read(bytes),
        }
    }
}

impl Source for Part<'_> {}
