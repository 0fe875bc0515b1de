//! VTK's images: XML (`.vti`), and the legacy format (`.vtk`, STRUCTURED_POINTS).
//!
//! Format: <https://docs.vtk.org/en/latest/vtk_file_formats/index.html>. Read: text, base64 and raw data,
//! inline or appended, plain or packed by zlib or LZ4; any extent, origin, spacing and direction; arrays
//! of points and of cells, of which one is chosen by name. VTK does not say what its axes are in a body, so
//! that they are taken as they are. Not read: other data sets, LZMA, images whose pieces are in files of
//! their own (`.pvti`). The crate `vtkio` is not used: it returns a data set with all of its arrays.
//!
//! Reading order: `image` (where points are, which array is read); `tags`, `base64`, `blocks`, `text` (bytes
//! of arrays); `xml`, `legacy` with `lines` (a format each).

mod base64;
mod blocks;
mod image;
mod tags;
mod text;

mod legacy;
mod lines;
mod xml;

use std::io::{self, BufReader, Seek, SeekFrom};

use slabsplat_core::Scaling;

use super::buffer::ReadFailure;
use super::colors::Voxels;
use super::formats::{Input, Reader, VolumeListing};
use super::placed::{Axis, Metered, PlacedSamples, Source};
use super::stored::StoredType;
use super::{Endian, LoadedVolume, VolumeFormat};
use crate::IoError;
use crate::progress::ReadMeter;
use crate::store::StoredFile;
use image::{ArrayDesc, Chosen, Geometry};

/// Both kinds.
pub(super) struct Vtk;

impl Reader for Vtk {
    fn listed(&self) -> &'static str {
        "VTK images (.vti, .vtk)"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["vti", "vtk"]
    }

    fn is_begun_by(&self, start: &[u8]) -> bool {
        legacy::is_begun_by(start) || xml::is_begun_by(start)
    }

    fn names_arrays(&self) -> bool {
        true
    }

    fn read(&self, input: &Input<'_>) -> Result<LoadedVolume, IoError> {
        match legacy::is_begun_by(&input.start()?) {
            true => legacy::read(input),
            false => xml::read(input),
        }
    }

    fn list(&self, input: &Input<'_>) -> Result<VolumeListing, IoError> {
        match legacy::is_begun_by(&input.start()?) {
            true => legacy::list(input),
            false => xml::list(input),
        }
    }
}

impl Input<'_> {
    fn start(&self) -> Result<Vec<u8>, IoError> {
        super::stream::first_bytes(self.store, self.path)
    }

    /// The file from some byte on, and how many bytes that are.
    fn open_at(&self, at: u64) -> Result<(BufReader<StoredFile<'_>>, u64), IoError> {
        let mut file = self.store.open(self.path)?;
        let n_bytes = file.n_bytes().map_err(IoError::read(self.path))?;
        file.seek(SeekFrom::Start(at)).map_err(IoError::read(self.path))?;
        Ok((BufReader::with_capacity(1 << 16, file), n_bytes.saturating_sub(at)))
    }

    /// What the system says, or what is wrong with the data.
    fn failed(&self, error: io::Error) -> IoError {
        match error.kind() {
            io::ErrorKind::InvalidData => IoError::malformed(self.path, error.to_string()),
            io::ErrorKind::UnexpectedEof => {
                IoError::malformed(self.path, "the file is cut off, or its header lies")
            }
            _ => IoError::Read { path: self.path.to_owned(), source: error },
        }
    }
}

impl Source for BufReader<StoredFile<'_>> {
    fn pass_over(&mut self, n_bytes: u64) -> io::Result<()> {
        self.seek_relative(i64::try_from(n_bytes).unwrap_or(i64::MAX))
    }
}

impl<R: io::Read> Source for base64::Base64<R> {}
impl<R: io::Read> Source for blocks::Blocks<R> {}
impl<R: io::BufRead> Source for text::NumbersInText<R> {}

/// An array of an image, while its samples come.
struct Filling<'a> {
    input: &'a Input<'a>,
    stored: StoredType,
    n_components: usize,
    /// Of its values.
    values: Axis,
    dims: [usize; 3],
    samples: PlacedSamples,
    meter: ReadMeter,
}

impl<'a> Filling<'a> {
    fn new(
        input: &'a Input<'a>,
        geometry: &Geometry,
        array: &ArrayDesc,
        chosen: &Chosen,
        endian: Endian,
    ) -> Result<Self, IoError> {
        let grid = geometry.grid(input, array.is_of_cells)?;
        let n_samples = grid.n_voxels().saturating_mul(chosen.choices.n_read());
        let samples = input.room(chosen.stored, endian, n_samples);
        let samples = samples.map_err(|_| input.failed(io::ErrorKind::OutOfMemory.into()))?;
        let n_components = array.n_components.max(1);
        Ok(Self {
            input,
            stored: chosen.stored,
            n_components,
            values: chosen.choices.axis_of_values(),
            dims: grid.dims(),
            samples,
            meter: input.meter(n_bytes(grid.dims(), n_components, chosen.stored)),
        })
    }

    /// Takes a part of the image, of so many samples along each axis, from `first` on.
    fn place(
        &mut self,
        source: &mut impl Source,
        dims: [usize; 3],
        first: [usize; 3],
    ) -> Result<(), IoError> {
        let [nx, ny, _] = self.dims;
        let each = self.values.kept.len();
        let axes = [
            self.values.clone(),
            Axis::whole(dims[0], each),
            Axis::whole(dims[1], each * nx),
            Axis::whole(dims[2], each * nx * ny),
        ];
        let first = each * ((first[2] * ny + first[1]) * nx + first[0]);
        let needed = n_bytes(dims, self.n_components, self.stored);
        let mut source = Metered { source, meter: &self.meter };
        self.samples.place(&mut source, &axes, first).map_err(|failure| match failure {
            ReadFailure::TooShort(found) => self.input.too_short(needed, found),
            ReadFailure::Io(error) => self.input.failed(error),
        })
    }

    fn finish(
        self,
        geometry: &Geometry,
        chosen: Chosen,
        is_of_cells: bool,
        mut warnings: Vec<String>,
    ) -> Result<LoadedVolume, IoError> {
        let grid = geometry.grid(self.input, is_of_cells)?;
        let samples = self.samples.finish(&mut warnings);
        let choices = chosen.choices;
        let voxels = Voxels { grid, samples, scaling: Scaling::IDENTITY, choices };
        voxels.load(self.input, VolumeFormat::Vtk, warnings)
    }
}

/// Bytes of an array, all components of it.
fn n_bytes(dims: [usize; 3], n_components: usize, stored: StoredType) -> u64 {
    let n_items = dims.into_iter().fold(n_components as u64, |n, d| n.saturating_mul(d as u64));
    n_items.saturating_mul(stored.size_bytes() as u64)
}

#[cfg(test)]
mod tests;
