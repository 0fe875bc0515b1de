//! What of HDF5 is not read, in words, with what helps.

use std::io;
use std::path::Path;

use hdf5_pure::{ChunkIndex, Dataset, Error, FormatError};

use super::super::formats::Input;
use crate::IoError;
use crate::printable::shown;

/// What makes a file of any data set that is read.
const REMEDY: &str = "save it by Python: numpy.save(\"OUT.npy\", h5py.File(\"IN\")[\"NAME\"][()])";

/// Why a data set's samples could not be read.
pub(super) fn refused(path: &Path, error: &io::Error) -> IoError {
    match error.kind() {
        io::ErrorKind::Unsupported => IoError::unsupported(path, error.to_string()),
        _ => IoError::malformed(path, error.to_string()),
    }
}

/// Why a file, or what it says of a data set, could not be read.
pub(super) fn broken(input: &Input<'_>, error: &Error) -> IoError {
    match unread(error) {
        Some(what) => IoError::unsupported(input.path, what),
        None => IoError::malformed(input.path, format!("not a sound HDF5 file: {error}")),
    }
}

/// The same for those who only know of input and output.
pub(super) fn as_io_error(dataset: &Dataset, error: &Error) -> io::Error {
    let has_trees = matches!(dataset.chunk_index(), Ok(Some(ChunkIndex::BTreeV2)));
    let trees = has_trees
        .then(|| with_remedy("its chunks are listed in the form of HDF5 1.10 (several axes grow)"));
    match trees.or_else(|| unread(error)) {
        Some(what) => io::Error::new(io::ErrorKind::Unsupported, what),
        None => io::Error::other(shown(&error.to_string())),
    }
}

/// `None` if the file is broken, as far as one can see.
fn unread(error: &Error) -> Option<String> {
    let Error::Format(error) = error else { return None };
    Some(match error {
        FormatError::InvalidLayoutVersion(5) => with_remedy("it is in the form of HDF5 2.0"),
        FormatError::UnsupportedFilter(filter) => {
            with_remedy(&format!("its chunks are packed by {}", name_of(*filter)))
        }
        FormatError::UnsupportedVirtualLayout => with_remedy("it is put together from others"),
        FormatError::UnsupportedExternalStorage => with_remedy("its samples are in another file"),
        _ => return None,
    })
}

fn with_remedy(what: &str) -> String {
    format!("{what}, which is not read: {REMEDY}")
}

/// By the numbers that the HDF Group gives to filters.
fn name_of(filter: u16) -> String {
    let name = match filter {
        4 => "szip",
        5 => "n-bit",
        307 => "bzip2",
        32001 => "Blosc",
        32004 => "LZ4",
        32008 => "bitshuffle",
        32013 => "ZFP",
        32015 => "Zstandard",
        32026 => "Blosc2",
        other => return format!("the filter {other}"),
    };
    name.to_owned()
}
