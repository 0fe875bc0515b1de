//! Where files are: on disk, or in memory, for who has no disk (a page in a browser) or needs none (an
//! archive, a network).
//!
//! Readers ask a [`Store`] and nobody else, so that each of them reads from both.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, Cursor, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use crate::{
    IoError, LoadedMesh, LoadedVolume, RawDesc, VolumeListing, VolumeOptions, mesh, volume,
};

/// Files in memory by their names, as a folder has them.
///
/// One is enough for most formats. Of those in several files a header names the others, and is looked for
/// beside itself:
///
/// ```
/// use slabsplat_io::FilesInMemory;
///
/// let header = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\ndata file: a.raw\n";
/// let files = FilesInMemory::from_iter([("a.nhdr", header.as_bytes()), ("a.raw", &[7; 8])]);
/// let loaded = files.read_volume("a.nhdr")?;
/// assert_eq!(loaded.volume.grid().dims(), [2, 2, 2]);
/// # Ok::<(), slabsplat_io::IoError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct FilesInMemory<'b> {
    by_path: BTreeMap<PathBuf, &'b [u8]>,
}

impl<'b, P: Into<PathBuf>> FromIterator<(P, &'b [u8])> for FilesInMemory<'b> {
    fn from_iter<T: IntoIterator<Item = (P, &'b [u8])>>(files: T) -> Self {
        Self { by_path: files.into_iter().map(|(path, bytes)| (path.into(), bytes)).collect() }
    }
}

impl FilesInMemory<'_> {
    /// As [`read_volume`](crate::read_volume).
    ///
    /// # Errors
    /// As there.
    pub fn read_volume(&self, path: impl AsRef<Path>) -> Result<LoadedVolume, IoError> {
        self.read_volume_with(path, &VolumeOptions::default())
    }

    /// As [`read_volume_with`](crate::read_volume_with). A folder is what all paths in it begin with.
    ///
    /// # Errors
    /// As there.
    pub fn read_volume_with(
        &self,
        path: impl AsRef<Path>,
        options: &VolumeOptions,
    ) -> Result<LoadedVolume, IoError> {
        volume::read_from(Store::Memory(self), path.as_ref(), options)
    }

    /// As [`list_volume`](crate::list_volume).
    ///
    /// # Errors
    /// As there.
    pub fn list_volume(
        &self,
        path: impl AsRef<Path>,
        options: &VolumeOptions,
    ) -> Result<VolumeListing, IoError> {
        volume::list_from(Store::Memory(self), path.as_ref(), options)
    }

    /// As [`read_raw`](crate::read_raw).
    ///
    /// # Errors
    /// As there.
    pub fn read_raw(
        &self,
        path: impl AsRef<Path>,
        desc: &RawDesc,
    ) -> Result<LoadedVolume, IoError> {
        let options = VolumeOptions::default();
        volume::read_raw_from(Store::Memory(self), path.as_ref(), desc, &options)
    }

    /// As [`read_mesh`](crate::read_mesh).
    ///
    /// # Errors
    /// As there.
    pub fn read_mesh(&self, path: impl AsRef<Path>) -> Result<LoadedMesh, IoError> {
        mesh::read_from(Store::Memory(self), path.as_ref())
    }
}

/// Where a reader finds files.
#[derive(Clone, Copy)]
pub(crate) enum Store<'b> {
    Disk,
    Memory(&'b FilesInMemory<'b>),
}

impl<'b> Store<'b> {
    pub(crate) fn open(self, path: &Path) -> Result<StoredFile<'b>, IoError> {
        let opened = match self {
            Self::Disk => open_file(path).map(StoredFile::Disk),
            Self::Memory(files) => {
                files.get(path).map(|bytes| StoredFile::Memory(Cursor::new(bytes)))
            }
        };
        opened.map_err(IoError::read(path))
    }

    /// The whole content of a file.
    pub(crate) fn read(self, path: &Path) -> Result<Vec<u8>, IoError> {
        let bytes = match self {
            Self::Disk => fs::read(path),
            Self::Memory(files) => files.get(path).map(<[u8]>::to_vec),
        };
        bytes.map_err(IoError::read(path))
    }

    pub(crate) fn has(self, path: &Path) -> bool {
        match self {
            Self::Disk => path.is_file(),
            Self::Memory(files) => files.get(path).is_ok(),
        }
    }

    pub(crate) fn is_folder(self, path: &Path) -> bool {
        match self {
            Self::Disk => on_disk(path).is_dir(),
            Self::Memory(files) => {
                files.get(path).is_err() && files.by_path.keys().any(|file| file.starts_with(path))
            }
        }
    }

    /// The files directly in a folder, by their names in order.
    pub(crate) fn files_in(self, folder: &Path) -> Result<Vec<PathBuf>, IoError> {
        let (files, _) = self.entries_in(folder)?;
        Ok(files)
    }

    /// The files directly in a folder, and the folders directly in it, by their names in order.
    pub(crate) fn entries_in(self, folder: &Path) -> Result<(Vec<PathBuf>, Vec<PathBuf>), IoError> {
        match self {
            Self::Disk => disk_entries(folder).map_err(IoError::read(folder)),
            Self::Memory(files) => Ok(files.entries_in(folder)),
        }
    }
}

/// A file that can be read from any place: a pipe would wait for who writes it, and cannot go back.
fn open_file(path: &Path) -> io::Result<File> {
    let metadata = fs::metadata(path)?;
    if metadata.is_dir() {
        return Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a folder, not a file"));
    }
    if !metadata.is_file() {
        return Err(io::Error::other(
            "it is a pipe or a device: save what it gives as a file, or pipe it into -",
        ));
    }
    File::open(path)
}

/// The folder of a file that is named without one has an empty path, which no system knows.
fn on_disk(folder: &Path) -> &Path {
    if folder.as_os_str().is_empty() { Path::new(".") } else { folder }
}

fn disk_entries(folder: &Path) -> io::Result<(Vec<PathBuf>, Vec<PathBuf>)> {
    let (mut files, mut folders) = (Vec::new(), Vec::new());
    for entry in fs::read_dir(on_disk(folder))? {
        let path = folder.join(entry?.file_name());
        if path.is_dir() {
            folders.push(path);
        } else if path.is_file() {
            files.push(path);
        }
    }
    files.sort_unstable();
    folders.sort_unstable();
    Ok((files, folders))
}

impl<'b> FilesInMemory<'b> {
    fn entries_in(&self, folder: &Path) -> (Vec<PathBuf>, Vec<PathBuf>) {
        let (mut files, mut folders) = (Vec::new(), Vec::new());
        for path in self.by_path.keys() {
            let Ok(below) = path.strip_prefix(folder) else { continue };
            let mut components = below.components();
            let Some(first) = components.next() else { continue };
            let entry = folder.join(first);
            if components.next().is_none() {
                files.push(entry);
            } else if folders.last() != Some(&entry) {
                folders.push(entry);
            }
        }
        (files, folders)
    }

    fn get(&self, path: &Path) -> io::Result<&'b [u8]> {
        let bytes = self.by_path.get(path).copied();
        bytes.ok_or_else(|| {
            io::Error::new(io::ErrorKind::NotFound, "there is no such file in memory")
        })
    }
}

/// An open file.
pub(crate) enum StoredFile<'b> {
    Disk(File),
    Memory(Cursor<&'b [u8]>),
}

impl StoredFile<'_> {
    pub(crate) fn n_bytes(&self) -> io::Result<u64> {
        match self {
            Self::Disk(file) => file.metadata().map(|metadata| metadata.len()),
            Self::Memory(cursor) => Ok(cursor.get_ref().len() as u64),
        }
    }
}

impl Read for StoredFile<'_> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        match self {
            Self::Disk(file) => file.read(bytes),
            Self::Memory(cursor) => cursor.read(bytes),
        }
    }
}

impl Seek for StoredFile<'_> {
    fn seek(&mut self, position: SeekFrom) -> io::Result<u64> {
        match self {
            Self::Disk(file) => file.seek(position),
            Self::Memory(cursor) => cursor.seek(position),
        }
    }
}

/// Writes files into a folder and reads the first as a volume: from there, and from memory, which must come
/// to the same.
#[cfg(test)]
pub(crate) fn read_from_both(files: &[(&str, &[u8])]) -> Result<LoadedVolume, String> {
    let dir = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        fs::write(dir.path().join(name), bytes).unwrap();
    }
    let folder = dir.path().join("");
    let without_folder = |text: String| text.replace(&*folder.to_string_lossy(), "");
    let from_disk = crate::read_volume(folder.join(files[0].0));
    let in_memory = FilesInMemory::from_iter(files.iter().copied());
    let from_memory = in_memory.read_volume(files[0].0);
    let default = VolumeOptions::default();
    let listed = crate::list_volume(folder.join(files[0].0), &default);
    let listed_in_memory = in_memory.list_volume(files[0].0, &default);
    assert_eq!(listed.ok(), listed_in_memory.ok());
    match (&from_disk, &from_memory) {
        (Ok(disk), Ok(memory)) => {
            assert_eq!(disk.volume.samples(), memory.volume.samples());
            assert_eq!(disk.volume.grid(), memory.volume.grid());
            assert_eq!(disk.format, memory.format);
            let warnings = disk.warnings.iter().cloned().map(without_folder);
            assert!(warnings.eq(memory.warnings.iter().cloned()), "{:?}", memory.warnings);
        }
        // What the system says of a file that is not there is its own affair.
        (Err(IoError::Read { .. }), Err(IoError::Read { .. })) => {}
        (Err(disk), Err(memory)) => {
            assert_eq!(without_folder(disk.to_string()), memory.to_string());
        }
        _ => panic!("from disk: {from_disk:?}, from memory: {from_memory:?}"),
    }
    from_disk.map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Endian, read_mesh, read_raw};
    use slabsplat_core::SampleType;

    #[test]
    fn memory_holds_raw_samples_and_meshes() {
        let desc = RawDesc {
            dims: [2, 1, 1],
            sample_type: SampleType::U16,
            endian: Endian::Big,
            spacing: [1.0; 3],
            header_bytes: 1,
        };
        let raw = [9, 1, 0, 2, 0];
        let obj = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
        let files = FilesInMemory::from_iter([("a.raw", &raw[..]), ("a.obj", obj)]);
        let dir = tempfile::tempdir().unwrap();
        for (name, bytes) in [("a.raw", &raw[..]), ("a.obj", obj)] {
            fs::write(dir.path().join(name), bytes).unwrap();
        }
        let volume = files.read_raw("a.raw", &desc).unwrap().volume;
        let on_disk = read_raw(dir.path().join("a.raw"), &desc).unwrap().volume;
        assert_eq!(volume.samples(), on_disk.samples());
        let mesh = files.read_mesh("a.obj").unwrap().mesh;
        assert_eq!(mesh, read_mesh(dir.path().join("a.obj")).unwrap().mesh);
    }

    #[test]
    fn disk_has_a_folder_of_files_that_are_named_without_one() {
        let empty = Path::new("");
        assert!(Store::Disk.is_folder(empty));
        // Cargo runs tests in the folder of the package.
        assert!(Store::Disk.files_in(empty).unwrap().contains(&PathBuf::from("Cargo.toml")));
    }

    #[test]
    fn memory_lacks_files_as_a_folder_does() {
        let files = FilesInMemory::default();
        let error = files.read_volume("a.nrrd").unwrap_err().to_string();
        assert_eq!(error, "cannot read a.nrrd: there is no such file in memory");
        assert!(files.read_mesh("a.ply").is_err());
    }
}
