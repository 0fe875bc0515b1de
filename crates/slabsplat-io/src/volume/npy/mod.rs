//! NumPy's arrays: one in a file (`.npy`), or some in an archive (`.npz`), each with a name.
//!
//! Format: <https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html>. The last axis is x, the
//! one before it y, then z, as `array[z, y, x]` has it, whichever axis is the fastest in the file. The crate
//! `npyz` is not used: it returns items in the order of the file, and what is left to do beside it, axes and
//! archives, is most of this. Not read: records, objects, text, complex numbers, floats of more than 64 bits.
//!
//! Reading order: `header` (the text at the front), `archive` (which of several arrays).

mod archive;
mod header;

use std::io::Read;
use std::path::Path;

use slabsplat_core::glam::DAffine3;
use slabsplat_core::{Grid, Scaling};

use super::array_axes::VolumeAxes;
use super::buffer::ReadFailure;
use super::choices::VolumeChoices;
use super::colors::Voxels;
use super::formats::{Input, Reader, VolumeListing};
use super::placed::Source;
use super::stream::DataStream;
use super::window::not_in_boxes;
use super::{LoadedVolume, VolumeFormat, zarr, zip};
use crate::IoError;
use crate::printable::shown_path;
use crate::store::Store;
use header::{Header, HeaderError};

/// One array.
pub(super) struct Npy;

/// Arrays in an archive.
pub(super) struct Npz;

impl Reader for Npy {
    fn listed(&self) -> &'static str {
        "NumPy (.npy)"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["npy"]
    }

    fn is_begun_by(&self, start: &[u8]) -> bool {
        start.starts_with(header::MAGIC)
    }

    fn reads_boxes(&self) -> bool {
        true
    }

    fn read(&self, input: &Input<'_>) -> Result<LoadedVolume, IoError> {
        let mut stream = DataStream::open_unpacked(input.store, input.path)?;
        if !stream.is_plain() {
            input.refuse_window("a packed file")?;
        }
        let n_left = stream.n_left_at_most();
        let array = Array::open(input, &mut stream)?;
        let meter = input.meter(array.n_bytes());
        stream.metered(&meter);
        let mut loaded = array.read(input, &mut stream, n_left)?;
        if stream.has_more()? {
            loaded
                .warnings
                .push(format!("{} holds more data than were needed", shown_path(input.path)));
        }
        Ok(loaded)
    }

    fn list(&self, input: &Input<'_>) -> Result<VolumeListing, IoError> {
        let mut stream = DataStream::open_unpacked(input.store, input.path)?;
        Ok(Array::open(input, &mut stream)?.listing())
    }
}

impl Reader for Npz {
    fn listed(&self) -> &'static str {
        "NumPy archives (.npz)"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["npz"]
    }

    fn is_begun_by(&self, start: &[u8]) -> bool {
        zip::is_zip(start)
    }

    fn is_other(&self, store: Store<'_>, path: &Path) -> bool {
        zarr::is_in_zip(store, path)
    }

    fn names_arrays(&self) -> bool {
        true
    }

    fn read(&self, input: &Input<'_>) -> Result<LoadedVolume, IoError> {
        archive::read(input)
    }

    fn list(&self, input: &Input<'_>) -> Result<VolumeListing, IoError> {
        archive::list(input)
    }
}

/// An array whose header has been read.
struct Array {
    header: Header,
    axes: VolumeAxes,
}

impl Array {
    fn open(input: &Input<'_>, reader: &mut impl Read) -> Result<Self, IoError> {
        let header = Header::read(reader).map_err(IoError::read(input.path))?;
        let header = header.map_err(|error| error.in_file(input))?;
        let axes = VolumeAxes::of(input, &header.shape, header.stored)?;
        Ok(Self { header, axes })
    }

    /// Of all items.
    fn n_bytes(&self) -> u64 {
        let item_bytes = self.header.stored.size_bytes() as u64;
        self.axes.n_items().and_then(|n| n.checked_mul(item_bytes)).unwrap_or(u64::MAX)
    }

    fn listing(self) -> VolumeListing {
        VolumeListing {
            format: VolumeFormat::Npy,
            dims: self.axes.dims,
            sample_type: self.header.stored.widest(),
            choices: self.axes.choices,
        }
    }

    /// Reads the items, of whose file `n_left` bytes at most were left before the header.
    fn read(
        self,
        input: &Input<'_>,
        source: &mut impl Source,
        n_left: u64,
    ) -> Result<LoadedVolume, IoError> {
        let needed = self.n_bytes();
        let Self { header, axes } = self;
        let grid = Grid::new_large(axes.dims, DAffine3::IDENTITY)
            .map_err(|source| IoError::Grid { path: input.path.to_owned(), source })?;
        let found = n_left.saturating_sub(header.n_bytes);
        let failed = |failure| match failure {
            ReadFailure::TooShort(found) => input.too_short(needed, found),
            ReadFailure::Io(source) => IoError::Read { path: input.path.to_owned(), source },
        };
        if found < needed {
            return Err(input.too_short(needed, found));
        }
        let mut in_file = axes.axes;
        let (window, grid) = input.window(&grid)?;
        if let Some(window) = &window {
            let kept = window.keep(&mut in_file, &axes.choices, header.stored);
            kept.map_err(|what| not_in_boxes(input.path, what))?;
        }
        let n_samples = grid.n_voxels().saturating_mul(axes.choices.n_read());
        let samples = input.room(header.stored, header.endian, n_samples);
        let mut samples = samples.map_err(failed)?;
        if header.is_fortran {
            in_file.reverse();
        }
        samples.place(source, &in_file, 0).map_err(failed)?;
        let mut warnings = vec![super::units::NO_SIZE.to_owned()];
        let samples = samples.finish(&mut warnings);
        let voxels = Voxels { grid, samples, scaling: Scaling::IDENTITY, choices: axes.choices };
        voxels.load(input, VolumeFormat::Npy, warnings)
    }
}

impl HeaderError {
    fn in_file(self, input: &Input<'_>) -> IoError {
        match self {
            Self::Malformed(what) => IoError::malformed(input.path, what),
            Self::Unsupported(what) => IoError::unsupported(input.path, what),
        }
    }
}

impl Input<'_> {
    pub(super) fn too_short(&self, needed: u64, found: u64) -> IoError {
        let hint = "the file is cut off, or its header lies";
        IoError::WrongLength { path: self.path.to_owned(), needed, found, hint }
    }
}

/// Arrays in an archive, as choices.
fn choices_with(series: super::choices::Choice, axes: VolumeChoices) -> VolumeChoices {
    VolumeChoices { series, ..axes }
}

#[cfg(test)]
mod tests;
