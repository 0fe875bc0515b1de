//! Some of a volume's voxels alone, so that a volume need never be in memory whole.
//!
//! A plain file is read at the rows that a box has, from wherever they are; of a store of chunks those are
//! unpacked that the box meets (`zarr`). Memory grows with the box, and the file is checked to be as long as
//! the whole volume needs before that. What is only read from front to back goes through a file that is not
//! packed first (`scratch`).

use std::io;
use std::ops::Range;
use std::path::Path;

use slabsplat_core::{Grid, GridError, Samples};

use super::Endian;
use super::buffer::ReadFailure;
use super::choices::VolumeChoices;
use super::formats::Input;
use super::placed::{Axis, PlacedSamples, Source};
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
    /// If the volume has no such voxels, or if all are asked for and are more than a volume may have.
    pub(super) fn window(&self, grid: &Grid) -> Result<(Option<Window>, Grid), IoError> {
        let Some(voxels) = &self.options.voxels else {
            if grid.is_large() && self.spill.is_none() {
                let source = GridError::TooLarge(grid.dims());
                return Err(IoError::Grid { path: self.path.to_owned(), source });
            }
            return Ok((None, *grid));
        };
        let window = Window::of(self.path, grid, voxels)?;
        Ok((Some(window), grid.cropped(voxels)))
    }

    /// Refuses boxes of what cannot be read in boxes.
    ///
    /// # Errors
    /// If a box is asked for; `why` says what the file is.
    pub(super) fn refuse_window(&self, why: &str) -> Result<(), IoError> {
        if self.options.voxels.is_none() { Ok(()) } else { Err(not_in_boxes(self.path, why)) }
    }
}

/// That a file is only read whole; `what` says what it is.
pub(super) fn not_in_boxes(path: &Path, what: &str) -> IoError {
    IoError::NotInBoxes { path: path.to_owned(), what: what.to_owned() }
}

impl Window {
    /// A box of a volume on that grid.
    ///
    /// # Errors
    /// If the volume has no such voxels.
    pub(super) fn of(
        path: &Path,
        grid: &Grid,
        voxels: &[Range<usize>; 3],
    ) -> Result<Self, IoError> {
        let dims = grid.dims();
        if voxels.iter().zip(dims).any(|(range, n)| range.is_empty() || n < range.end) {
            let what = format!("there are no voxels {voxels:?} among {dims:?}");
            return Err(IoError::malformed(path, what));
        }
        Ok(Self { dims, voxels: voxels.clone() })
    }

    /// Voxels of the box.
    pub(super) fn n_voxels(&self) -> usize {
        self.voxels.iter().map(Range::len).product()
    }

    /// Voxels of the volume.
    pub(super) fn n_of_whole(&self) -> usize {
        self.dims.iter().product()
    }

    /// What the box keeps of an axis of the volume, x, y or z, as an axis of an array.
    pub(super) fn axis(&self, axis: usize) -> Axis {
        let stride = self.voxels[..axis].iter().map(Range::len).product();
        Axis { len: self.dims[axis], kept: self.voxels[axis].clone(), stride }
    }

    /// Keeps of an array, whose axes are those of the whole volume and maybe others, no more than the box.
    ///
    /// # Errors
    /// If it has to be looked at whole, which says what it is.
    pub(super) fn keep(
        &self,
        axes: &mut [Axis],
        choices: &VolumeChoices,
        stored: StoredType,
    ) -> Result<(), &'static str> {
        if let StoredType::I64 | StoredType::U64 = stored {
            return Err("an array of 64-bit integers");
        }
        // All values of a voxel lie next to each other.
        let n_values = choices.n_read();
        let mut stride = n_values;
        let strides = self.dims.map(|n| {
            let before = stride;
            stride *= n;
            before
        });
        for axis in axes {
            let of_volume = (0..3).find(|&of| {
                1 < axis.kept.len()
                    && strides[of] == axis.stride
                    && self.dims[of] == axis.kept.len()
            });
            let Some(of_volume) = of_volume else { continue };
            let Axis { kept, stride, .. } = self.axis(of_volume);
            let first = axis.kept.start;
            let (len, kept) = (axis.len, first + kept.start..first + kept.end);
            *axis = Axis { len, kept, stride: n_values * stride };
        }
        Ok(())
    }

    /// The samples of the box, of so many values a voxel, from a stream that is about to come to the volume's
    /// first voxel.
    ///
    /// # Errors
    /// If the stream is too short, packed, or of integers of 64 bits, which become what they are by looking
    /// at all of them.
    pub(super) fn read(
        &self,
        path: &Path,
        stream: &mut DataStream<'_>,
        (stored, n_values): (StoredType, usize),
        endian: Endian,
    ) -> Result<Samples, IoError> {
        if !stream.is_plain() {
            return Err(not_in_boxes(path, "a packed file"));
        }
        if let StoredType::I64 | StoredType::U64 = stored {
            return Err(not_in_boxes(path, "a file of 64-bit integers"));
        }
        let n_all = self.dims.iter().fold(n_values as u64, |n, len| n.saturating_mul(*len as u64));
        stream.check_left(n_all.saturating_mul(stored.size_bytes() as u64))?;
        self.place(path, stream, (stored, n_values), endian)
    }

    /// The same from what is as long as it needs to be, of so many values a voxel.
    pub(super) fn place(
        &self,
        path: &Path,
        source: &mut impl Source,
        (stored, n_values): (StoredType, usize),
        endian: Endian,
    ) -> Result<Samples, IoError> {
        let of_voxels = [0, 1, 2].map(|axis| self.axis(axis));
        let of_voxels = of_voxels.map(|axis| Axis { stride: n_values * axis.stride, ..axis });
        let [x, y, z] = of_voxels;
        let axes = [Axis::whole(n_values, 1), x, y, z];
        let samples = PlacedSamples::new(stored, endian, n_values * self.n_voxels());
        let placed = samples.and_then(|mut samples| {
            samples.place(source, &axes, 0)?;
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
