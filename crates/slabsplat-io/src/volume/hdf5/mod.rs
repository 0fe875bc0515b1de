//! HDF5: data sets by their paths, also those of NetCDF-4, MATLAB 7.3 and Imaris, which are HDF5 files.
//!
//! Format: <https://support.hdfgroup.org/documentation/hdf5/latest/_f_m_t3.html>. Read by the crate
//! `hdf5-pure`, if the feature `hdf5` is there; without it an error says how to get it. That crate is all
//! Rust, takes `flate2` and `byteorder` and nothing else, and is held against the C library by its own tests.
//! `hdf5-reader` brings ten crates and maps files by unsafe code; `hdf5-metno` binds the C library, which
//! needs a C compiler and has been broken by crafted files again and again.
//!
//! Reading order: `arrays` (which data set, and what its numbers are), `rows` (its bytes).

#[cfg(feature = "hdf5")]
mod arrays;
#[cfg(feature = "hdf5")]
mod rows;

use super::LoadedVolume;
use super::formats::{Input, Reader, VolumeListing};
use crate::IoError;

/// What a file begins with, or what is behind a block of another program's.
const MAGIC: &[u8] = b"\x89HDF\r\n\x1a\n";

/// The block that MATLAB puts in front.
const USER_BLOCK_BYTES: usize = 512;

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
        start.starts_with(MAGIC) || behind.starts_with(MAGIC)
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

#[cfg(not(feature = "hdf5"))]
fn not_built(input: &Input<'_>) -> IoError {
    let what = "HDF5 was left out of this build: build it with the feature hdf5 (cargo install slabsplat-cli \
                --features hdf5), or save the data set as .npy";
    IoError::unsupported(input.path, what)
}

#[cfg(test)]
mod tests;
