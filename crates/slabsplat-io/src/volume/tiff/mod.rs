//! TIFF: a page a slice, as microscopes write it; BigTIFF, OME-TIFF and what ImageJ writes, too.
//!
//! The `tiff` crate reads pages, in every packing that it knows. What they mean is decided here: which pages
//! are the slices of one channel at one time, and how large voxels are, in millimetres. Pages
//! are not turned over: y grows downwards, as their rows do. Not read: other colours than RGB, palettes,
//! samples of less than 8 bits. Pages of an OME-TIFF may be in several files beside each other.
//!
//! Reading order: `pages` (what a file holds), `stack` (which pages are slices, and where), `ome`, `imagej`.

mod imagej;
mod ome;
mod pages;
mod stack;

use slabsplat_core::{Grid, Scaling};

use super::buffer::{Endian, ReadFailure};
use super::colors::Voxels;
use super::formats::{Input, Reader, VolumeListing};
use super::{LoadedVolume, VolumeFormat, parallel};
use crate::IoError;
use ome::Page;
pub(super) use pages::Pages;
use stack::Stack;

/// The format.
pub(super) struct Tiff;

impl Reader for Tiff {
    fn listed(&self) -> &'static str {
        "TIFF (.tif, .tiff)"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["tif", "tiff"]
    }

    fn is_begun_by(&self, start: &[u8]) -> bool {
        is_tiff(start)
    }

    fn read(&self, input: &Input<'_>) -> Result<LoadedVolume, IoError> {
        read(input)
    }

    fn list(&self, input: &Input<'_>) -> Result<VolumeListing, IoError> {
        let pages = Pages::open(input.store, input.path)?;
        let stack = Stack::find(input, &pages, &mut Vec::new())?;
        Ok(VolumeListing {
            format: VolumeFormat::Tiff,
            dims: stack.dims(&pages),
            sample_type: pages.stored.widest(),
            choices: stack.choices,
        })
    }
}

fn is_tiff(start: &[u8]) -> bool {
    [b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"].iter().any(|magic| start.starts_with(*magic))
}

fn read(input: &Input<'_>) -> Result<LoadedVolume, IoError> {
    let &Input { store, path, .. } = input;
    let pages = Pages::open(store, path)?;
    let mut warnings = Vec::new();
    let stack = Stack::find(input, &pages, &mut warnings)?;
    let grid = Grid::with_spacing(stack.dims(&pages), stack.spacing)
        .map_err(|source| IoError::Grid { path: path.to_owned(), source })?;
    let mut buffer = input.buffer(pages.stored, Endian::NATIVE);
    let n_values = grid.n_voxels().saturating_mul(stack.choices.n_read());
    let meter = input.meter(n_values as u64 * pages.stored.size_bytes() as u64);
    // Pixels of one value have their channels in pages of their own.
    let keep = |page: &mut Vec<u8>| {
        if 1 < pages.n_values {
            stack.choices.keep_read(page, pages.stored.size_bytes());
        }
    };
    let mut take = |page: &[u8]| {
        let n_samples = page.len() / pages.stored.size_bytes();
        buffer.append(&mut { page }, n_samples, true).map_err(|failure| match failure {
            ReadFailure::TooShort(_) => IoError::malformed(path, "a page is shorter than it says"),
            ReadFailure::Io(source) => IoError::Read { path: path.to_owned(), source },
        })?;
        meter.advance(page.len() as u64).map_err(IoError::from)
    };
    if stack.slices.iter().all(|page| page.file.is_none()) {
        let n_workers = parallel::n_workers(stack.slices.len());
        let workers = (0..n_workers).map(|_| Ok((pages.again(store)?, Vec::new())));
        let mut workers = workers.collect::<Result<Vec<(Pages<'_>, Vec<u8>)>, IoError>>()?;
        let unpack = |(pages, page): &mut (Pages<'_>, Vec<u8>), slice: &Page| {
            pages.read_into(slice.page_idx, page)?;
            keep(page);
            Ok(std::mem::take(page))
        };
        parallel::in_order(&mut workers, &stack.slices, unpack, |_, page| take(&page))?;
    } else {
        let mut own = pages.again(store)?;
        let mut others = Others { input, last: None };
        let mut page = Vec::new();
        for Page { file, page_idx } in &stack.slices {
            match file {
                None => own.read_into(*page_idx, &mut page)?,
                Some(name) => others.read_into(name, *page_idx, &pages, &mut page)?,
            }
            keep(&mut page);
            take(&page)?;
        }
    }
    let samples = buffer.finish(&mut warnings);
    let voxels = Voxels { grid, samples, scaling: Scaling::IDENTITY, choices: stack.choices };
    voxels.load(input, VolumeFormat::Tiff, warnings)
}

/// Files that the pages of an OME-TIFF are in beside the one that was opened, one at a time.
struct Others<'a> {
    input: &'a Input<'a>,
    last: Option<(String, Pages<'a>)>,
}

impl Others<'_> {
    fn read_into(
        &mut self,
        name: &str,
        page_idx: usize,
        own: &Pages<'_>,
        page: &mut Vec<u8>,
    ) -> Result<(), IoError> {
        if self.last.as_ref().is_none_or(|(last, _)| last != name) {
            self.last = None;
            let pages = Pages::open(self.input.store, &self.input.beside(name)?)?;
            if !pages.are_like(own) {
                let what = "its pages are of another size or type than those of the other files";
                return Err(pages.unsupported(what));
            }
            self.last = Some((name.to_owned(), pages));
        }
        let Some((_, pages)) = &mut self.last else { return Ok(()) };
        if pages.len() <= page_idx {
            let what = format!("the file has no page {page_idx}, which OME-XML says to be a slice");
            return Err(pages.malformed(what));
        }
        pages.read_into(page_idx, page)
    }
}

#[cfg(test)]
mod tests;
