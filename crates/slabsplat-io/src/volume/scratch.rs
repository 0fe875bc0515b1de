//! Volumes that are packed, or that are only read from front to back for another reason, as files of their
//! own from which boxes are read.
//!
//! Such a volume is read once, from front to back and never whole into memory, and its samples are written
//! into a scratch file as they come (`spill`). How large that gets is known before the first byte is written.
//! The file has no name: it is unlinked as soon as it is created (`tempfile`), so that it is gone when the
//! last handle is, by whatever the program ends: an error, a signal, a kill.

use std::fmt;
use std::fs::File;
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use slabsplat_core::SampleType;

use super::colors::Voxels;
use super::formats::{self, Found, Input, Reader};
use super::spill::{Spill, SpillFailure};
use super::window::{Window, not_in_boxes};
use super::{Endian, LoadedVolume, OpacitySource, VolumeOptions, assemble, read_by};
use crate::IoError;
use crate::store::Store;

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
    is_refused: bool,
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
        Self { is_refused: true, ..self }
    }

    /// Tells `hear` of each volume, before it is unpacked.
    #[must_use]
    pub fn on_use(self, hear: impl Fn(&ScratchUse) + Send + Sync + 'static) -> Self {
        Self { hear: Some(ScratchCallback(Arc::new(hear))), ..self }
    }

    pub(crate) fn is_refused(&self) -> bool {
        self.is_refused
    }

    /// An empty file for so many bytes of a volume, if there is room for them.
    fn file_for(&self, path: &Path, n_bytes: u64) -> Result<(File, ScratchUse), IoError> {
        let folder = self.folder.clone().unwrap_or_else(std::env::temp_dir);
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
        let is_in_memory = is_in_memory(&folder);
        Ok((file, ScratchUse { path: path.to_owned(), folder, n_bytes, is_in_memory }))
    }
}

/// A volume in a scratch file.
#[derive(Debug)]
pub(crate) struct Scratch {
    spill: Arc<Spill>,
    options: VolumeOptions,
    /// The type of samples in the file.
    spilled: SampleType,
    /// One voxel, with all that is known of the volume.
    first: LoadedVolume,
    of: ScratchUse,
}

impl Scratch {
    /// Reads a volume of a file into a scratch file.
    ///
    /// # Errors
    /// If it cannot be read, or not without having it in memory whole, or there is no room for it.
    pub(crate) fn unpack(
        path: &Path,
        options: &VolumeOptions,
        desc: &ScratchDesc,
    ) -> Result<Self, IoError> {
        let Found { reader, path, options } = formats::find(Store::Disk, path, options)?;
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
        let first = read_by(reader, input);
        match spill.failure() {
            Some(SpillFailure::Order(what)) => return Err(not_in_boxes(input.path, what)),
            Some(SpillFailure::Write(source)) => {
                let ScratchUse { path, folder, .. } = of;
                return Err(IoError::Scratch { path, folder, source });
            }
            None => {}
        }
        let mut first = first?;
        let spilled = first.volume.sample_type();
        if let Some((stored, integers)) = spill.integers() {
            first.warnings.push(integers.said_of(stored));
            let volume = &first.volume;
            let sample = integers.narrowed(volume.samples().clone());
            first.volume = assemble(input.path, *volume.grid(), sample, volume.scaling())?;
        }
        let scratch = Self { spill, options: input.options.clone(), spilled, first, of };
        scratch.complete()?;
        Ok(scratch)
    }

    /// That all samples came; those that no part of the file has are zero.
    fn complete(&self) -> Result<(), IoError> {
        let n_voxels = self.first.volume.grid().uncropped().n_voxels() as u64;
        let n_samples = n_voxels.saturating_mul(self.first.choices.n_read() as u64);
        let n_came = self.spill.n_in_order().unwrap_or(n_samples);
        if n_came != n_samples {
            let what = format!("it has {n_came} samples for {n_voxels} voxels");
            return Err(IoError::malformed(&self.of.path, what));
        }
        let n_bytes = n_samples * self.spilled.size_bytes() as u64;
        self.spill.set_len(n_bytes).map_err(|source| {
            let (path, folder) = (self.of.path.clone(), self.of.folder.clone());
            IoError::Scratch { path, folder, source }
        })
    }

    /// One voxel of the volume, with all that its file says.
    pub(crate) fn first(&self) -> &LoadedVolume {
        &self.first
    }

    pub(crate) fn of(&self) -> &ScratchUse {
        &self.of
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
        let (path, first) = (&self.of.path, &self.first.volume);
        let whole = first.grid().uncropped();
        let window = Window::of(path, &whole, voxels)?;
        let values = (self.spilled.into(), self.first.choices.n_read());
        let samples =
            self.spill.with_reader(|reader| window.place(path, reader, values, Endian::NATIVE))?;
        let samples = match self.spill.integers() {
            Some((_, integers)) => integers.narrowed(samples),
            None => samples,
        };
        let (grid, scaling) = (whole.cropped(voxels), first.scaling());
        let choices = self.first.choices.clone();
        let options =
            VolumeOptions { voxels: Some(voxels.clone()), opacity_from, ..self.options.clone() };
        let input = Input { store: Store::Disk, path, options: &options, spill: None };
        let read = Voxels { grid, samples, scaling, choices };
        let LoadedVolume { volume, colors, .. } =
            read.load(&input, self.first.format, Vec::new())?;
        Ok(LoadedVolume { volume, colors, warnings: Vec::new(), ..self.first.clone() })
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
