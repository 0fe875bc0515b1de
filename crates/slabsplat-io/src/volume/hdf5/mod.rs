//! HDF5: data sets by their paths, also those of NetCDF-4, MATLAB 7.3 and Imaris, which are HDF5 files.
//!
//! Format: <https://support.hdfgroup.org/documentation/hdf5/latest/_f_m_t3.html>. Read by the crate
//! `hdf5-pure`, if the feature `hdf5` is there; without it an error says how to get it. That crate is all
//! Rust, takes `flate2` and `byteorder` and nothing else, and is held against the C library by its own tests.
//! `hdf5-reader` brings ten crates and maps files by unsafe code; `hdf5-metno` binds the C library, which
//! needs a C compiler and has been broken by crafted files again and again.
//!
//! Reading order: `arrays` (which data set, and what its numbers are), `rows` (its bytes), `refusals` (what
//! is not read, and what to do then).

#[cfg(feature = "hdf5")]
mod arrays;
#[cfg(feature = "hdf5")]
mod refusals;
#[cfg(feature = "hdf5")]
mod rows;

use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use super::LoadedVolume;
use super::formats::{Input, Reader, VolumeListing, not_begun};
use crate::IoError;
use crate::store::{Store, StoredFile};

/// What a file begins with, or what is behind a block of another program's.
const MAGIC: [u8; 8] = *b"\x89HDF\r\n\x1a\n";

/// The least block in front, which MATLAB has; others are twice as long, or twice that, and so on.
const USER_BLOCK_BYTES: usize = 512;

/// No program puts more in front.
const MAX_USER_BLOCK_BYTES: usize = 1 << 30;

/// The format.
pub(super) struct Hdf5;

impl Reader for Hdf5 {
    fn listed(&self) -> &'static str {
        "HDF5 (.h5, .hdf5, .nc, .mat, .ims)"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["h5", "hdf5", "nc", "mat", "ims"]
    }

    fn is_begun_by(&self, start: &[u8]) -> bool {
        let behind = start.get(USER_BLOCK_BYTES..).unwrap_or_default();
        start.starts_with(&MAGIC) || behind.starts_with(&MAGIC)
    }

    /// Of a file with a longer block in front, which the name alone says.
    fn header_of(&self, store: Store<'_>, path: &Path) -> Result<PathBuf, IoError> {
        let has_block = has_user_block(store.open(path)?).map_err(IoError::read(path))?;
        has_block.then(|| path.to_owned()).ok_or_else(|| not_begun(self.listed(), path))
    }

    fn names_arrays(&self) -> bool {
        true
    }

    #[cfg(feature = "hdf5")]
    fn read(&self, input: &Input<'_>) -> Result<LoadedVolume, IoError> {
        arrays::Array::open(input)?.read(input)
    }

    #[cfg(feature = "hdf5")]
    fn list(&self, input: &Input<'_>) -> Result<VolumeListing, IoError> {
        Ok(arrays::Array::open(input)?.listing())
    }

    #[cfg(not(feature = "hdf5"))]
    fn read(&self, input: &Input<'_>) -> Result<LoadedVolume, IoError> {
        Err(not_built(input))
    }

    #[cfg(not(feature = "hdf5"))]
    fn list(&self, input: &Input<'_>) -> Result<VolumeListing, IoError> {
        Err(not_built(input))
    }
}

fn has_user_block(mut file: StoredFile<'_>) -> io::Result<bool> {
    let n_bytes = file.n_bytes()?;
    let mut block_bytes = USER_BLOCK_BYTES;
    while block_bytes <= MAX_USER_BLOCK_BYTES && (block_bytes + MAGIC.len()) as u64 <= n_bytes {
        let mut start = [0; MAGIC.len()];
        file.seek(SeekFrom::Start(block_bytes as u64))?;
        file.read_exact(&mut start)?;
        if start == MAGIC {
            return Ok(true);
        }
        block_bytes *= 2;
    }
    Ok(false)
}

#[cfg(not(feature = "hdf5"))]
fn not_built(input: &Input<'_>) -> IoError {
    let what = "HDF5 was left out of this build: build it with the feature hdf5 (cargo install slabsplat-cli \
                --features hdf5), or save the data set as .npy";
    IoError::unsupported(input.path, what)
}

#[cfg(test)]
mod tests;
