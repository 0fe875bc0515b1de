//! Some of a volume's voxels alone, so that a volume need never be in memory whole.
//!
//! A plain file is read at the rows that a box has, from wherever they are; of a store of chunks those are
//! unpacked that the box meets (`zarr`). Memory grows with the box, and the file is checked to be as long as
//! the whole volume needs before that.

use std::io;
use std::ops::Range;
use std::path::Path;

use slabsplat_core::{Grid, Samples};

use super::Endian;
use super::buffer::ReadFailure;
use super::formats::Input;
use super::placed::{Axis, PlacedSamples};
use super::stored::StoredType;
use super::stream::DataStream;
use crate::IoError;

/// A box of voxels, of a volume that has it.
#[derive(Clone, Debug)]
pub(super) struct Window {
    dims: [usize; 3],
    pub(super) voxels: [Range<usize>; 3],
}

impl Input<'_> {
    /// The box that is asked for of a volume of that grid, and the grid of what is read.
    ///
    /// # Errors
    /// If the volume has no such voxels.
    pub(super) fn window(&self, grid: &Grid) -> Result<(Option<Window>, Grid), IoError> {
        let Some(voxels) = &self.options.voxels else { return Ok((None, *grid)) };
        let dims = grid.dims();
        if voxels.iter().zip(dims).any(|(range, n)| range.is_empty() || n < range.end) {
            let what = format!("there are no voxels {voxels:?} among {dims:?}");
            return Err(IoError::malformed(self.path, what));
        }
        Ok((Some(Window { dims, voxels: voxels.clone() }), grid.cropped(voxels)))
    }

    /// Refuses boxes of what cannot be read in boxes.
    ///
    /// # Errors
    /// If a box is asked for; `why` says what the file is.
    pub(super) fn refuse_window(&self, why: &str) -> Result<(), IoError> {
        if self.options.voxels.is_none() { Ok(()) } else { Err(not_in_boxes(self.path, why)) }
    }
}

/// That a file is only read whole.
pub(super) fn not_in_boxes(path: &Path, why: &str) -> IoError {
    let what = format!(
        "{why} cannot be read box by box: slabsplat convert makes .raw, .nii or .zarr of it"
    );
    IoError::unsupported(path, what)
}

impl Window {
    /// Voxels of the box.
    pub(super) fn n_voxels(&self) -> usize {
        self.voxels.iter().map(Range::len).product()
    }

    /// What the box keeps of an axis of the volume, x, y or z, as an axis of an array.
    pub(super) fn axis(&self, axis: usize) -> Axis {
        let stride = self.voxels[..axis].iter().map(Range::len).product();
        Axis { len: self.dims[axis], kept: self.voxels[axis].clone(), stride }
    }

    /// The samples of the box from a stream that is about to come to the volume's first voxel.
    ///
    /// # Errors
    /// If the stream is too short, packed, or of integers of 64 bits, which become what they are by looking
    /// at all of them.
    pub(super) fn read(
        &self,
        path: &Path,
        stream: &mut DataStream<'_>,
        stored: StoredType,
        endian: Endian,
    ) -> Result<Samples, IoError> {
        if !stream.is_plain() {
            return Err(not_in_boxes(path, "a packed file"));
        }
        if let StoredType::I64 | StoredType::U64 = stored {
            return Err(not_in_boxes(path, "a file of 64-bit integers"));
        }
        let n_all = self.dims.iter().fold(1, |n: u64, len| n.saturating_mul(*len as u64));
        stream.check_left(n_all.saturating_mul(stored.size_bytes() as u64))?;
        let axes = [0, 1, 2].map(|axis| self.axis(axis));
        let samples = PlacedSamples::new(stored, endian, self.n_voxels());
        let placed = samples.and_then(|mut samples| {
            samples.place(stream, &axes, 0)?;
            Ok(samples.finish(&mut Vec::new()))
        });
        placed.map_err(|failure| {
            let source = match failure {
                ReadFailure::TooShort(_) => io::ErrorKind::UnexpectedEof.into(),
                ReadFailure::Io(source) => source,
            };
            IoError::Read { path: path.to_owned(), source }
        })
    }
}
