//! What can go wrong with a file. Every message is one line that says what, where and what to do; nothing
//! that a file holds can end the line or command a terminal: all of it passes through `printable` here.

use std::io;
use std::path::{Path, PathBuf};
use thiserror::Error;

use crate::PictureFormat;
use crate::memory::{MemoryNeeds, in_units};
use crate::printable::{printable, shown, shown_path};
use slabsplat_core::{GridError, LabelError, VolumeError};

/// Why a file could not be read or written, or a built-in volume not made.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum IoError {
    /// The operating system did not let us read.
    #[error("cannot read {}: {source}", shown_path(path))]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// Who hears how far reading is had it stopped
    /// ([`ProgressCallback::stopping`](crate::ProgressCallback::stopping)).
    #[error("reading was given up")]
    Cancelled,
    /// The operating system did not let us write; nothing is left behind.
    #[error("cannot write {}: {source}", shown_path(path))]
    Write {
        /// The file that was to be.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The picture is none that its format has.
    #[error("cannot encode the picture: {source}")]
    Encode {
        /// What the encoder says.
        source: io::Error,
    },
    /// The file is in none of the formats that can be read.
    #[error(
        "{} is not a volume file that can be read: expected {known}; 3D Slicer, ITK-SNAP or ImageJ convert \
         many others",
        shown_path(path)
    )]
    UnknownFormat {
        /// The file.
        path: PathBuf,
        /// The formats that can be read, with their extensions.
        known: String,
    },
    /// The folder is none that is a volume.
    #[error(
        "{} is a folder that holds no volume of many files, but {held}: name one of them",
        shown_path(path)
    )]
    UnknownFolder {
        /// The folder.
        path: PathBuf,
        /// How many files of which names are in it.
        held: String,
    },
    /// The file does not hold as many series, channels, times or levels as are asked for.
    #[error("{}: there is no {part} {asked}: there is {}", shown_path(path), printable(there))]
    NoSuchPart {
        /// The file.
        path: PathBuf,
        /// Of what there are too few.
        part: &'static str,
        /// What is asked for.
        asked: usize,
        /// What there is.
        there: String,
    },
    /// A header names a file that is not beside it.
    #[error(
        "{}: it names a file outside of its folder, {name:?}: move that, or allow it (allow_external)",
        shown_path(path)
    )]
    External {
        /// The header's file.
        path: PathBuf,
        /// What it names.
        name: String,
    },
    /// The file is a mesh in none of the formats that can be read.
    #[error(
        "{} is not a mesh file that can be read: expected PLY (.ply), STL (.stl) or OBJ (.obj)",
        shown_path(path)
    )]
    UnknownMesh {
        /// The file.
        path: PathBuf,
    },
    /// The file breaks the rules of its format.
    #[error("{}: {}", shown_path(path), printable(what))]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Which rule, and what to do.
        what: String,
    },
    /// The file is sound, but uses a part of its format that is not read here.
    #[error("{}: {}", shown_path(path), printable(what))]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// Which part, and what to do.
        what: String,
    },
    /// The file is only read whole, and a box of its voxels was asked for.
    #[error(
        "{}: {what} cannot be read box by box: slabsplat convert makes .raw, .nii or .zarr of it",
        shown_path(path)
    )]
    NotInBoxes {
        /// The file.
        path: PathBuf,
        /// What it is.
        what: String,
    },
    /// There is no room to unpack a volume on a disk, so that boxes of it could be read.
    #[error(
        "{}: to read it box by box takes {} of scratch, and {} are there for it in {}: choose another folder",
        shown_path(path),
        in_units(*needed_bytes),
        in_units(*room_bytes),
        shown_path(folder)
    )]
    NoScratch {
        /// The volume.
        path: PathBuf,
        /// Where it was to be unpacked.
        folder: PathBuf,
        /// What it takes.
        needed_bytes: u64,
        /// What is free there, or permitted.
        room_bytes: u64,
    },
    /// The operating system did not let us unpack a volume on a disk; nothing is left behind.
    #[error(
        "{}: it cannot be unpacked into {}: {source}: choose another folder",
        shown_path(path),
        shown_path(folder)
    )]
    Scratch {
        /// The volume.
        path: PathBuf,
        /// Where it was to be unpacked.
        folder: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// What another process of this computer unpacked of a volume cannot be opened here.
    #[error(
        "{}: what another process has unpacked of it cannot be opened: {source}: slabsplat convert makes a \
         file that all can read",
        shown_path(path)
    )]
    SharedScratch {
        /// The volume.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The data are shorter (or, in a plain raw file, longer) than the header promises.
    #[error("{}: needs {needed} bytes of data, has {found}: {hint}", shown_path(path))]
    WrongLength {
        /// The file that holds the data.
        path: PathBuf,
        /// Bytes that the header asks for.
        needed: u64,
        /// Bytes that there are.
        found: u64,
        /// What to do.
        hint: &'static str,
    },
    /// There is no room for what a scene shows.
    #[error(
        "the volumes need {} of memory, and {} are free: {needs}",
        in_units(needs.total_bytes()),
        in_units(*free_bytes)
    )]
    OutOfMemory {
        /// What each of them needs.
        needs: MemoryNeeds,
        /// What is free.
        free_bytes: u64,
    },
    /// The grid that the file describes cannot be used.
    #[error("{}: {source}", shown_path(path))]
    Grid {
        /// The file.
        path: PathBuf,
        /// Why not.
        source: GridError,
    },
    /// The samples that the file holds cannot be used.
    #[error("{}: {source}", shown_path(path))]
    Volume {
        /// The file.
        path: PathBuf,
        /// Why not.
        source: VolumeError,
    },
    /// The values of the volume are no labels.
    #[error("{}: {source}", shown_path(path))]
    Labels {
        /// The file.
        path: PathBuf,
        /// Why not.
        source: LabelError,
    },
    /// There is no such built-in volume.
    #[error("there is no built-in volume {name:?}: choose one of {}", crate::BUILTIN_NAMES.join(", "))]
    UnknownBuiltin {
        /// The name asked for.
        name: String,
    },
    /// A built-in volume cannot be made in that size.
    #[error("a built-in volume has {min} to {max} voxels a side, not {size}")]
    BadBuiltinSize {
        /// The size asked for.
        size: usize,
        /// Smallest size.
        min: usize,
        /// Largest size.
        max: usize,
    },
    /// There is no such transfer function.
    #[error("there is no preset {name:?}: choose one of {}", crate::PRESET_NAMES.join(", "))]
    UnknownPreset {
        /// The name asked for.
        name: String,
    },
    /// There is no such colour map.
    #[error("there is no colour map {name:?}: choose one of {}", crate::COLORMAP_NAMES.join(", "))]
    UnknownColormap {
        /// The name asked for.
        name: String,
    },
    /// A scene file says something that cannot be.
    #[error("{}{}: {}", shown_path(path), line_suffix(*line), printable(what))]
    Scene {
        /// The file.
        path: PathBuf,
        /// The line, counted from 1, where one can be named.
        line: Option<usize>,
        /// What is wrong, and what to do.
        what: String,
    },
    /// A scene cannot be a scene file.
    #[error("cannot write the scene {}: {}", shown_path(path), printable(what))]
    SceneText {
        /// The file that was to be.
        path: PathBuf,
        /// Why not.
        what: String,
    },
    /// A scene file names the files that labels are in.
    #[error("the labels of layer {layer_idx} come from no file that a scene file could name")]
    LabelsWithoutFile {
        /// Which layer, counted from 0.
        layer_idx: usize,
    },
    /// The name of a volume that is to be written does not tell its format.
    #[error(
        "cannot tell the format of {}: name the volume .nrrd, .nii, .nii.gz, .mha, .npy, .raw or .zarr",
        shown_path(path)
    )]
    UnknownOutput {
        /// The file that was to be.
        path: PathBuf,
    },
    /// The name of a picture does not tell its format, or one whose feature is off.
    #[error("{}", unknown_picture(path))]
    UnknownPicture {
        /// The file that was to be.
        path: PathBuf,
    },
}

/// What to do about a picture's name.
fn unknown_picture(path: &Path) -> String {
    let (name, endings) = (shown_path(path), PictureFormat::endings());
    match PictureFormat::missing_feature(path) {
        Some(feature) => format!(
            "{name}: it takes the feature `{feature}`, which is off here; without it, name it {endings}"
        ),
        None => format!("cannot tell the format of {name}: name it {endings}"),
    }
}

fn line_suffix(line: Option<usize>) -> String {
    line.map(|line| format!(":{line}")).unwrap_or_default()
}

impl IoError {
    pub(crate) fn read(path: impl Into<PathBuf>) -> impl FnOnce(io::Error) -> Self {
        let path = path.into();
        |source| Self::Read { path, source }
    }

    pub(crate) fn write(path: impl Into<PathBuf>) -> impl FnOnce(io::Error) -> Self {
        let path = path.into();
        |source| Self::Write { path, source }
    }

    pub(crate) fn malformed(path: impl Into<PathBuf>, what: impl Into<String>) -> Self {
        Self::Malformed { path: path.into(), what: shown(&what.into()) }
    }

    pub(crate) fn unsupported(path: impl Into<PathBuf>, what: impl Into<String>) -> Self {
        Self::Unsupported { path: path.into(), what: shown(&what.into()) }
    }
}
