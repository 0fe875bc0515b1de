//! Volumes that are packed, or that are only read from front to back for another reason, as files of their
//! own from which boxes are read.
//!
//! Such a volume is read once, from front to back and never whole into memory, and its samples are written
//! into a scratch file as they come (`spill`). How large that gets is known before the first byte is written.
//! The file has no name: it is unlinked as soon as it is created (`tempfile`), so that it is gone when the
//! last handle is, by whatever the program ends: an error, a signal, a kill. Other processes of the computer
//! share it by its descriptor (`handle`).

mod handle;
mod unpacked;

use std::fmt;
use std::fs::File;
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::formats::{self, Found, Input, Reader};
use super::spill::{Spill, SpillFailure};
use super::window::not_in_boxes;
use super::{LoadedVolume, OpacitySource, VolumeOptions, read_by};
use crate::IoError;
use crate::store::Store;
use unpacked::Unpacked;

/// Where volumes are unpacked that cannot be read box by box as they are, and how large that may get.
///
/// By default that is the system's folder for temporary files, up to what is free there. Where that folder
/// lies in memory, as `/tmp` of some systems does, another one should be said.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct ScratchDesc {
    /// The folder; `None` is the system's ([`std::env::temp_dir`]).
    pub folder: Option<PathBuf>,
    /// Bytes that one volume may take there, at most; `None` is what is free.
    pub most_bytes: Option<u64>,
    hear: Option<ScratchCallback>,
    origin: Origin,
}

/// Where scratch files come from.
#[derive(Clone, Debug, Default)]
enum Origin {
    /// They are made.
    #[default]
    Unpacked,
    /// Nowhere: there are none.
    Refused,
    /// Another process has made one.
    Handle(Arc<[u8]>),
}

/// What a volume takes in a folder of scratch, for as long as its boxes are read.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct ScratchUse {
    /// The volume.
    pub path: PathBuf,
    /// The folder. The file in it has no name.
    pub folder: PathBuf,
    /// Bytes of all samples.
    pub n_bytes: u64,
    /// Whether the folder lies in memory, as far as the system tells: then nothing is gained by it.
    pub is_in_memory: bool,
}

#[derive(Clone)]
struct ScratchCallback(Arc<dyn Fn(&ScratchUse) + Send + Sync>);

impl fmt::Debug for ScratchCallback {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("ScratchCallback")
    }
}

impl ScratchDesc {
    /// Unpacks into this folder.
    #[must_use]
    pub fn folder(self, folder: impl Into<PathBuf>) -> Self {
        Self { folder: Some(folder.into()), ..self }
    }

    /// Unpacks no volume that takes more bytes.
    #[must_use]
    pub fn most_bytes(self, most_bytes: u64) -> Self {
        Self { most_bytes: Some(most_bytes), ..self }
    }

    /// Unpacks nothing: what would have to be is refused.
    #[must_use]
    pub fn refused(self) -> Self {
        Self { origin: Origin::Refused, ..self }
    }

    /// Unpacks nothing, but reads what another process of this computer has unpacked of the same volume, by
    /// what [`VolumeBoxes::scratch_handle`](crate::VolumeBoxes::scratch_handle) says there.
    #[must_use]
    pub fn shared(self, handle: &[u8]) -> Self {
        Self { origin: Origin::Handle(handle.into()), ..self }
    }

    /// Tells `hear` of each volume, before it is unpacked.
    #[must_use]
    pub fn on_use(self, hear: impl Fn(&ScratchUse) + Send + Sync + 'static) -> Self {
        Self { hear: Some(ScratchCallback(Arc::new(hear))), ..self }
    }

    pub(crate) fn is_refused(&self) -> bool {
        matches!(self.origin, Origin::Refused)
    }

    fn in_folder(&self) -> PathBuf {
        self.folder.clone().unwrap_or_else(std::env::temp_dir)
    }

    fn use_of(&self, path: &Path, n_bytes: u64) -> ScratchUse {
        let folder = self.in_folder();
        let is_in_memory = is_in_memory(&folder);
        ScratchUse { path: path.to_owned(), folder, n_bytes, is_in_memory }
    }

    /// An empty file for so many bytes of a volume, if there is room for them.
    fn file_for(&self, path: &Path, n_bytes: u64) -> Result<(File, ScratchUse), IoError> {
        let folder = self.in_folder();
        let failed = |source| {
            let (path, folder) = (path.to_owned(), folder.clone());
            IoError::Scratch { path, folder, source }
        };
        let free_bytes = free_bytes(&folder).map_err(failed)?;
        let room_bytes = free_bytes.min(self.most_bytes.unwrap_or(u64::MAX));
        if room_bytes < n_bytes {
            let (path, needed_bytes) = (path.to_owned(), n_bytes);
            return Err(IoError::NoScratch { path, folder, needed_bytes, room_bytes });
        }
        let file = tempfile::tempfile_in(&folder).map_err(failed)?;
        Ok((file, self.use_of(path, n_bytes)))
    }
}

/// A volume in a scratch file.
#[derive(Debug)]
pub(crate) struct Scratch {
    spill: Arc<Spill>,
    options: VolumeOptions,
    unpacked: Unpacked,
    /// One voxel, with all that is known of the volume.
    first: LoadedVolume,
    of: ScratchUse,
}

impl Scratch {
    /// Reads a volume of a file into a scratch file, or opens the one that another process has made of it.
    ///
    /// # Errors
    /// If it cannot be read, or not without having it in memory whole, or there is no room for it; if what
    /// another process made is not there.
    pub(crate) fn open(
        path: &Path,
        options: &VolumeOptions,
        desc: &ScratchDesc,
    ) -> Result<Self, IoError> {
        let Found { reader, path, options } = formats::find(Store::Disk, path, options)?;
        if let Origin::Handle(handle) = &desc.origin {
            let (file, unpacked, n_bytes) = handle::open(handle)
                .map_err(|source| IoError::SharedScratch { path: path.clone(), source })?;
            return Self::of(Spill::new(file), &options, unpacked, desc.use_of(&path, n_bytes));
        }
        let mut input = Input { store: Store::Disk, path: &path, options: &options, spill: None };
        let listing = reader.list(&input)?;
        options.check(&path, &listing.choices)?;
        let (file, of) = desc.file_for(&path, listing.bytes())?;
        if let Some(ScratchCallback(hear)) = &desc.hear {
            hear(&of);
        }
        input.spill = Some(Spill::new(file));
        Self::filled(reader, &input, of)
    }

    /// Reads all of a volume into a file.
    fn filled(reader: &dyn Reader, input: &Input<'_>, of: ScratchUse) -> Result<Self, IoError> {
        let spill = input.spill.clone().expect("there is somewhere to write to");
        let read = read_by(reader, input);
        let failed = |source| {
            let (path, folder) = (of.path.clone(), of.folder.clone());
            IoError::Scratch { path, folder, source }
        };
        match spill.failure() {
            Some(SpillFailure::Order(what)) => return Err(not_in_boxes(input.path, what)),
            Some(SpillFailure::Write(source)) => return Err(failed(source)),
            None => {}
        }
        let unpacked = Unpacked::of(read?, &spill);
        let n_samples = unpacked.n_samples();
        let n_came = spill.n_in_order().unwrap_or(n_samples);
        if n_came != n_samples {
            let what = format!("it has {n_came} samples for {} voxels", unpacked.grid.n_voxels());
            return Err(IoError::malformed(&of.path, what));
        }
        // Those that no part of the file has are zero.
        spill.set_len(unpacked.n_bytes()).map_err(failed)?;
        Self::of(spill, input.options, unpacked, of)
    }

    /// A volume whose samples are all in the file.
    fn of(
        spill: Arc<Spill>,
        options: &VolumeOptions,
        unpacked: Unpacked,
        of: ScratchUse,
    ) -> Result<Self, IoError> {
        let path = of.path.as_path();
        let one = [0..1, 0..1, 0..1];
        let mut first = unpacked.read((&spill, path), &one, options, options.opacity_from)?;
        first.warnings.clone_from(&unpacked.warnings);
        Ok(Self { spill, options: options.clone(), unpacked, first, of })
    }

    /// One voxel of the volume, with all that its file says.
    pub(crate) fn first(&self) -> &LoadedVolume {
        &self.first
    }

    pub(crate) fn of_folder(&self) -> &ScratchUse {
        &self.of
    }

    /// What other processes of this computer open the same file by, as long as this one has it.
    ///
    /// # Errors
    /// If the system does not tell which file it is.
    pub(crate) fn handle(&self) -> Result<Vec<u8>, IoError> {
        let handle = self.spill.with_file(|file| handle::of(file, &self.unpacked, self.of.n_bytes));
        handle.map_err(|source| IoError::SharedScratch { path: self.of.path.clone(), source })
    }

    /// A box of the volume; of one of colours opacity is made of that.
    ///
    /// # Errors
    /// If there are no such voxels, or they cannot be read any more.
    pub(crate) fn read(
        &self,
        voxels: &[Range<usize>; 3],
        opacity_from: Option<OpacitySource>,
    ) -> Result<LoadedVolume, IoError> {
        let file = (&*self.spill, self.of.path.as_path());
        self.unpacked.read(file, voxels, &self.options, opacity_from)
    }
}

/// What is free for this user where a folder is; all that there can be where the system does not tell.
#[cfg(unix)]
fn free_bytes(folder: &Path) -> io::Result<u64> {
    let disk = rustix::fs::statvfs(folder)?;
    Ok(disk.f_bavail.saturating_mul(disk.f_frsize))
}

#[cfg(not(unix))]
fn free_bytes(_: &Path) -> io::Result<u64> {
    Ok(u64::MAX)
}

/// Whether a folder lies in memory, of which Linux tells.
#[cfg(target_os = "linux")]
fn is_in_memory(folder: &Path) -> bool {
    // Of statfs(2): tmpfs and ramfs.
    const OF_MEMORY: [u32; 2] = [0x0102_1994, 0x8584_58f6];
    rustix::fs::statfs(folder).is_ok_and(|disk| OF_MEMORY.contains(&(disk.f_type as u32)))
}

#[cfg(not(target_os = "linux"))]
fn is_in_memory(_: &Path) -> bool {
    false
}

#[cfg(test)]
mod tests;
