//! How other processes of a computer open a scratch file, which has no name.
//!
//! Linux has a path for each open file of a process, `/proc/PID/fd/N`, which its user may open. So the file
//! is shared without a name that somebody would have to remove, and a process that has opened it does not
//! depend on the one that made it. A handle is that path as numbers, which file is there, and what is known
//! of the volume, in JSON.

use std::fs::File;
use std::io;

use serde::{Deserialize, Serialize};
use slabsplat_core::glam::DAffine3;
use slabsplat_core::{Acquisition, Grid, Modality, Orientation, SampleType, Scaling};

use super::super::{VolumeChoices, VolumeFormat};
use super::unpacked::Unpacked;

#[derive(Deserialize, Serialize)]
struct Handle {
    file: OpenFile,
    n_bytes: u64,
    dims: [usize; 3],
    /// Column by column.
    world_from_index: [f64; 12],
    /// Slope and intercept.
    scaling: [f64; 2],
    /// As they are in the file, and what they become, by their positions in `SampleType::ALL`.
    samples: [usize; 2],
    /// By its position in `VolumeFormat::ALL`.
    format: usize,
    modality: Option<Modality>,
    orientation: Orientation,
    is_metric: bool,
    choices: VolumeChoices,
    warnings: Vec<String>,
}

/// A file that a process has open.
#[derive(Deserialize, Serialize)]
struct OpenFile {
    process: u32,
    descriptor: i32,
    /// Its device, and its number there: those of another file are another's.
    identity: [u64; 2],
}

/// Of so many bytes of samples in an open file.
///
/// # Errors
/// If the system does not tell which file it is.
pub(super) fn of(file: &File, unpacked: &Unpacked, n_bytes: u64) -> io::Result<Vec<u8>> {
    let Unpacked { grid, scaling, acquisition, .. } = unpacked;
    let handle = Handle {
        file: OpenFile::of(file)?,
        n_bytes,
        dims: grid.dims(),
        world_from_index: grid.world_from_index().to_cols_array(),
        scaling: [scaling.slope, scaling.intercept],
        samples: [unpacked.spilled, unpacked.narrowed].map(|of| position(SampleType::ALL, &of)),
        format: position(VolumeFormat::ALL, &unpacked.format),
        modality: acquisition.modality,
        orientation: acquisition.orientation,
        is_metric: acquisition.is_metric,
        choices: unpacked.choices.clone(),
        warnings: unpacked.warnings.clone(),
    };
    Ok(serde_json::to_vec(&handle)?)
}

fn position<T: PartialEq>(all: &[T], of: &T) -> usize {
    all.iter().position(|other| other == of).expect("all are listed")
}

/// The file, what it holds, and bytes of that.
///
/// # Errors
/// If the process has no such file, or the handle is none.
pub(super) fn open(handle: &[u8]) -> io::Result<(File, Unpacked, u64)> {
    let handle: Handle = serde_json::from_slice(handle)?;
    let unpacked = handle.unpacked().ok_or(io::ErrorKind::InvalidData)?;
    let file = handle.file.open()?;
    if file.metadata()?.len() < unpacked.n_bytes() {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }
    Ok((file, unpacked, handle.n_bytes))
}

impl Handle {
    fn unpacked(&self) -> Option<Unpacked> {
        let place = DAffine3::from_cols_array(&self.world_from_index);
        let [spilled, narrowed] = self.samples.map(|idx| SampleType::ALL.get(idx).copied());
        let [slope, intercept] = self.scaling;
        let mut acquisition = Acquisition::UNKNOWN.orientation(self.orientation);
        acquisition.modality = self.modality;
        acquisition.is_metric = self.is_metric;
        Some(Unpacked {
            grid: Grid::new_large(self.dims, place).ok()?,
            scaling: Scaling { slope, intercept },
            spilled: spilled?,
            narrowed: narrowed?,
            format: *VolumeFormat::ALL.get(self.format)?,
            acquisition,
            choices: self.choices.clone(),
            warnings: self.warnings.clone(),
        })
    }
}

#[cfg(target_os = "linux")]
impl OpenFile {
    fn of(file: &File) -> io::Result<Self> {
        use std::os::fd::AsRawFd;
        let (process, descriptor) = (std::process::id(), file.as_raw_fd());
        Ok(Self { process, descriptor, identity: identity(file)? })
    }

    fn open(&self) -> io::Result<File> {
        let file = File::open(format!("/proc/{}/fd/{}", self.process, self.descriptor))?;
        // Where processes do not see each other, as in containers of their own, the number is another's.
        let is_it = identity(&file)? == self.identity;
        if is_it { Ok(file) } else { Err(io::ErrorKind::NotFound.into()) }
    }
}

#[cfg(target_os = "linux")]
fn identity(file: &File) -> io::Result<[u64; 2]> {
    use std::os::unix::fs::MetadataExt;
    let metadata = file.metadata()?;
    Ok([metadata.dev(), metadata.ino()])
}

#[cfg(not(target_os = "linux"))]
impl OpenFile {
    fn of(_: &File) -> io::Result<Self> {
        Ok(Self { process: 0, descriptor: 0, identity: [0; 2] })
    }

    fn open(&self) -> io::Result<File> {
        Err(io::ErrorKind::Unsupported.into())
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests;
