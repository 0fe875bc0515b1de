//! TIFF: a page a slice, as microscopes write it; BigTIFF, OME-TIFF and what ImageJ writes, too.
//!
//! The `tiff` crate reads pages, in every packing that it knows. What they mean is decided here: which pages
//! are the slices of the first channel at the first time, and how large voxels are, in millimetres. Pages
//! are not turned over: y grows downwards, as their rows do. Not read: colours, palettes, samples of less
//! than 8 bits, of 64 bits unless floats, or of 16-bit floats; OME-TIFFs whose pages are in several files.
//!
//! Reading order: `pages` (what a file holds), `stack` (which pages are slices, and where), `ome`, `imagej`.

mod imagej;
mod ome;
mod pages;
mod stack;

use std::path::Path;

use slabsplat_core::{Grid, SampleType, Scaling};

use super::buffer::{Endian, ReadFailure, SampleBuffer};
use super::{LoadedVolume, VolumeFormat, assemble};
use crate::IoError;
use crate::store::Store;
use pages::Pages;
use stack::Stack;

/// Whether the file begins as TIFF and BigTIFF do.
pub(super) fn is_tiff(start: &[u8]) -> bool {
    [b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"].iter().any(|magic| start.starts_with(*magic))
}

pub(super) fn read(store: Store<'_>, path: &Path) -> Result<LoadedVolume, IoError> {
    let mut pages = Pages::open(store, path)?;
    let mut warnings = Vec::new();
    let stack = Stack::find(&pages, &mut warnings)?;
    let grid = Grid::with_spacing(stack.dims(&pages), stack.spacing)
        .map_err(|source| IoError::Grid { path: path.to_owned(), source })?;
    let mut buffer = SampleBuffer::new(pages.sample_type);
    let mut page = Vec::new();
    for &page_idx in &stack.slices {
        pages.read_into(page_idx, &mut page)?;
        let n_samples = page.len() / pages.sample_type.size_bytes();
        buffer.append(&mut page.as_slice(), n_samples, true).map_err(|failure| match failure {
            ReadFailure::TooShort(_) => IoError::malformed(path, "a page is shorter than it says"),
            ReadFailure::Io(source) => IoError::Read { path: path.to_owned(), source },
        })?;
    }
    let volume = assemble(path, grid, buffer.finish(Endian::NATIVE), Scaling::IDENTITY)?;
    Ok(LoadedVolume { volume, format: VolumeFormat::Tiff, warnings })
}

/// What the pages' headers say of the volume's size.
pub(super) fn dims_and_type(
    store: Store<'_>,
    path: &Path,
) -> Result<([usize; 3], SampleType), IoError> {
    let pages = Pages::open(store, path)?;
    let stack = Stack::find(&pages, &mut Vec::new())?;
    Ok((stack.dims(&pages), pages.sample_type))
}

#[cfg(test)]
mod tests;
