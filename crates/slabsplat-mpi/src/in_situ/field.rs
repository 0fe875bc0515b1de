//! Arrays of a simulation, as it has them in memory.

use super::VoxelBox;
use slabsplat::{Grid, Sample, Samples, Scaling, Volume};
use std::ops::Range;
use thiserror::Error;

/// Values of a field on a box of voxels, which may be more than the rank's own: ghosts are then taken from
/// there. Nothing is copied before a picture is drawn.
#[derive(Clone, Debug)]
pub struct Field<'a> {
    values: Values<'a>,
    held: VoxelBox,
    /// Elements from one voxel to the next along x, y and z.
    strides: [usize; 3],
}

/// The array itself, in the simulation's type.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum Values<'a> {
    /// 8 bits, unsigned.
    U8(&'a [u8]),
    /// 16 bits, unsigned.
    U16(&'a [u16]),
    /// 32 bits, floating point.
    F32(&'a [f32]),
    /// 64 bits, floating point.
    F64(&'a [f64]),
}

/// Why an array is no field.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum FieldError {
    /// It is too short for its box and strides.
    #[error("an array of {n_values} values is too short: a box of {dims:?} voxels takes {needed}")]
    TooShort {
        /// What it has.
        n_values: usize,
        /// Voxels of the box.
        dims: [usize; 3],
        /// What it takes.
        needed: usize,
    },
    /// The rank has not all of its own box.
    #[error("an array with the voxels {held:?} has not all of the rank's own, {own:?}")]
    NotOwn {
        /// What it has.
        held: VoxelBox,
        /// What it should.
        own: VoxelBox,
    },
    /// The box is too large to be drawn in one piece.
    #[error("a box of {0:?} voxels is too large: 4294967295 are the most")]
    TooLarge([usize; 3]),
}

impl<'a> Field<'a> {
    /// Values of the voxels `held`, x fastest, without gaps.
    ///
    /// # Errors
    /// If there are too few.
    pub fn packed(values: Values<'a>, held: VoxelBox) -> Result<Self, FieldError> {
        let [nx, ny, _] = held.each_ref().map(Range::len);
        Self::strided(values, held, [1, nx, nx * ny])
    }

    /// The same with so many elements from one voxel to the next along x, y and z.
    ///
    /// # Errors
    /// If there are too few.
    pub fn strided(
        values: Values<'a>,
        held: VoxelBox,
        strides: [usize; 3],
    ) -> Result<Self, FieldError> {
        let dims = held.each_ref().map(Range::len);
        let last = dims.iter().zip(strides).try_fold(0_usize, |sum, (n, stride)| {
            sum.checked_add(n.saturating_sub(1).checked_mul(stride)?)
        });
        let is_empty = dims.contains(&0);
        let needed = if is_empty { 0 } else { last.map_or(usize::MAX, |last| last + 1) };
        let n_values = values.len();
        if n_values < needed {
            return Err(FieldError::TooShort { n_values, dims, needed });
        }
        Ok(Self { values, held, strides })
    }

    /// Its voxels.
    pub fn held(&self) -> &VoxelBox {
        &self.held
    }

    /// Whether it has all of a rank's own, which may be none.
    pub(super) fn check_holds(&self, own: &VoxelBox, grid: &Grid) -> Result<(), FieldError> {
        let is_empty = own.iter().any(Range::is_empty);
        let fits = self.held.iter().zip(grid.dims()).all(|(held, n)| held.end <= n);
        if fits && (is_empty || holds(&self.held, own)) {
            return Ok(());
        }
        Err(FieldError::NotOwn { held: self.held.clone(), own: own.clone() })
    }

    /// The values of some of its voxels, in their type, x fastest.
    pub(super) fn part(&self, voxels: &VoxelBox) -> Samples {
        match self.values {
            Values::U8(values) => self.copied(values, voxels).into(),
            Values::U16(values) => self.copied(values, voxels).into(),
            Values::F32(values) => self.copied(values, voxels).into(),
            Values::F64(values) => self.copied(values, voxels).into(),
        }
    }

    fn copied<T: Sample>(&self, values: &[T], voxels: &VoxelBox) -> Vec<T> {
        let mut copy = Vec::with_capacity(voxels.iter().map(Range::len).product());
        let from = |axis: usize, at: usize| (at - self.held[axis].start) * self.strides[axis];
        for k in voxels[2].clone() {
            for j in voxels[1].clone() {
                let row = from(2, k) + from(1, j);
                copy.extend(voxels[0].clone().map(|i| values[row + from(0, i)]));
            }
        }
        copy
    }

    /// A volume of its type, full of zeros.
    pub(super) fn blank(&self, grid: Grid) -> Result<Volume, FieldError> {
        let n_voxels = grid.n_voxels();
        let samples: Samples = match self.values {
            Values::U8(_) => vec![0_u8; n_voxels].into(),
            Values::U16(_) => vec![0_u16; n_voxels].into(),
            Values::F32(_) => vec![0.0_f32; n_voxels].into(),
            Values::F64(_) => vec![0.0_f64; n_voxels].into(),
        };
        volume(grid, samples)
    }
}

impl Values<'_> {
    fn len(&self) -> usize {
        match self {
            Self::U8(values) => values.len(),
            Self::U16(values) => values.len(),
            Self::F32(values) => values.len(),
            Self::F64(values) => values.len(),
        }
    }
}

/// Values are what they are.
pub(super) fn volume(grid: Grid, samples: Samples) -> Result<Volume, FieldError> {
    let dims = grid.dims();
    Volume::new(grid, samples, Scaling::IDENTITY).map_err(|_| FieldError::TooLarge(dims))
}

/// Whether a box has all voxels of another one.
pub(super) fn holds(of: &VoxelBox, other: &VoxelBox) -> bool {
    of.iter().zip(other).all(|(of, other)| of.start <= other.start && other.end <= of.end)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn field_is_read_by_strides() {
        let values: Vec<f32> = (0_u8..60).map(f32::from).collect();
        // z fastest, as arrays of C are.
        let field = Field::strided(Values::F32(&values), [2..5, 0..4, 7..12], [20, 5, 1]).unwrap();
        let part = field.part(&[3..5, 1..2, 8..10]);
        assert_eq!(part, vec![26.0_f32, 46.0, 27.0, 47.0].into());
        let packed = Field::packed(Values::F32(&values), [0..3, 0..4, 0..5]).unwrap();
        assert_eq!(packed.part(&[1..3, 3..4, 4..5]), vec![58.0_f32, 59.0].into());
        let short = Field::packed(Values::F32(&values), [0..3, 0..4, 0..6]);
        assert!(matches!(short, Err(FieldError::TooShort { needed: 72, .. })), "{short:?}");
        let huge = Field::strided(Values::F32(&values), [0..3, 0..4, 0..5], [usize::MAX, 1, 1]);
        assert!(huge.is_err());
    }
}
