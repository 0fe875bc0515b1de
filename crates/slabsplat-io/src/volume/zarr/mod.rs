//! OME-Zarr: an array in chunks, each a file of its own, in a folder or in a ZIP archive.
//!
//! Formats: <https://ngff.openmicroscopy.org> (0.4 on Zarr 2, 0.5 on Zarr 3) and
//! <https://zarr-specs.readthedocs.io>.
//! Read: levels with scales and translations, lengths in any unit, channels and times, a Zarr array alone;
//! chunks packed by gzip, zlib, Zstandard and Blosc (BloscLZ, LZ4, zlib, Zstandard; shuffled bytes and bits),
//! CRC32C, transposed axes, shards. The crate `zarrs` is not used: it brings 190 crates, C libraries among
//! them, needs a newer compiler, and takes memory on the word of the metadata. Not read: other codecs and
//! filters, chunks of unequal sizes, plates of many images.
//!
//! Chunks are unpacked as a stream, straight to where their samples belong.
//!
//! Reading order: `tree` (files by keys), `meta` (what an array is like), `image` (which array, and where its
//! voxels are); `codecs`, `blosc` (bytes of a chunk), `chunk_cache`, `chunks` (which of them, and
//! where to).

mod blosc;
mod chunk_cache;
mod chunks;
mod codecs;
mod image;
mod meta;
mod tree;

use std::path::{Path, PathBuf};

use slabsplat_core::Scaling;

use super::colors::Voxels;
use super::formats::{Input, Reader, VolumeListing};
use super::window::not_in_boxes;
use super::zip::is_zip;
use super::{LoadedVolume, VolumeFormat};
use crate::IoError;
use crate::store::Store;
pub(crate) use chunk_cache::ChunkCache;
use image::Image;
use tree::{Tree, is_zip_of_zarr};

/// A folder, or a ZIP archive.
pub(super) struct Zarr;

impl Reader for Zarr {
    fn listed(&self) -> &'static str {
        "OME-Zarr (.zarr, .zip)"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["zarr", "ozx"]
    }

    fn is_begun_by(&self, start: &[u8]) -> bool {
        is_zip(start)
    }

    fn is_other(&self, store: Store<'_>, path: &Path) -> bool {
        !is_mark(path) && !is_zip_of_zarr(store, path)
    }

    fn is_named(&self, _store: Store<'_>, path: &Path) -> bool {
        is_mark(path)
    }

    fn header_of(&self, _store: Store<'_>, path: &Path) -> Result<PathBuf, IoError> {
        // Of a file that marks a folder, the folder.
        Ok(path.parent().unwrap_or(Path::new("")).to_owned())
    }

    fn is_folder(&self, store: Store<'_>, folder: &Path, _files: &[PathBuf]) -> bool {
        tree::MARKS.iter().any(|mark| store.has(&folder.join(mark)))
    }

    fn names_arrays(&self) -> bool {
        true
    }

    fn reads_boxes(&self) -> bool {
        true
    }

    fn read(&self, input: &Input<'_>) -> Result<LoadedVolume, IoError> {
        let tree = Tree::open(input)?;
        let mut image = Image::find(input, &tree)?;
        let (window, grid) = input.window(&image.grid(input)?)?;
        if let Some(window) = &window {
            image.keep(window).map_err(|why| not_in_boxes(input.path, why))?;
        }
        let n_samples = grid.n_voxels().saturating_mul(image.choices.n_read());
        let mut warnings = image.warnings.clone();
        let samples = chunks::read(input, &tree, &image, n_samples, &mut warnings)?;
        let choices = image.choices;
        let voxels = Voxels { grid, samples, scaling: Scaling::IDENTITY, choices };
        voxels.load(input, VolumeFormat::Zarr, warnings)
    }

    fn list(&self, input: &Input<'_>) -> Result<VolumeListing, IoError> {
        let image = Image::find(input, &Tree::open(input)?)?;
        Ok(VolumeListing {
            format: VolumeFormat::Zarr,
            dims: image.dims,
            sample_type: image.array.stored.widest(),
            choices: image.choices,
        })
    }
}

/// Whether the file is one that a Zarr's folder has.
fn is_mark(path: &Path) -> bool {
    path.file_name().is_some_and(|name| tree::MARKS.iter().any(|mark| name == *mark))
}

/// Whether an archive holds a Zarr.
pub(super) fn is_in_zip(store: Store<'_>, path: &Path) -> bool {
    is_zip_of_zarr(store, path)
}

#[cfg(test)]
mod blosc_tests;
#[cfg(test)]
mod tests;
