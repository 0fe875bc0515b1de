//! The least and the largest value of every brick: where an iso-range can have voxels at all.
//!
//! The paper sorts all voxels by value and finds an iso-range by binary search (§4). That takes 4 bytes a
//! voxel, 4 GiB for 1024³, and lists voxels in an order in which neighbours in the list are far apart in
//! memory. Here a brick whose values miss an iso-range is skipped, and so is one for whose values a change
//! of ranges changes nothing; only the others are looked at. That takes two samples a brick, 1/256 of the
//! volume, and one pass over it instead of a sort.

use crate::order::Ordered;
use crate::{BRICK_SIDE, BrickGrid};
use rayon::prelude::*;
use slabsplat_core::{
    Cancelled, FrameHandle, IsoRange, Sample, Samples, Scaling, Volume, with_samples,
};

/// What values every brick of a volume holds.
#[derive(Clone, Debug, PartialEq)]
pub struct BrickRanges {
    /// The least and the largest sample of each brick, by its number; the other way round where all are NaN.
    ends: Samples,
    scaling: Scaling,
}

impl BrickRanges {
    /// Looks through `volume`, in parallel.
    pub fn new(volume: &Volume) -> Self {
        Self::for_frame(volume, &FrameHandle::new()).expect("nobody cancels the frame")
    }

    /// The same for a frame.
    ///
    /// # Errors
    /// If that is cancelled.
    pub fn for_frame(volume: &Volume, frame: &FrameHandle) -> Result<Self, Cancelled> {
        let bricks = BrickGrid::new(volume.grid());
        let ends = with_samples!(volume.samples(), |s| ends(s, &bricks, frame).into());
        frame.check()?;
        Ok(Self { ends, scaling: volume.scaling() })
    }

    /// The least and the largest value in the brick; `hi < lo` if all its voxels are NaN.
    #[inline]
    pub fn of_brick(&self, brick_idx: usize) -> IsoRange {
        let [least, most] = with_samples!(&self.ends, |s| {
            [2 * brick_idx, 2 * brick_idx + 1].map(|idx| s[idx].to_f64())
        });
        if most < least {
            return IsoRange { lo: f64::INFINITY, hi: f64::NEG_INFINITY };
        }
        // Scaling keeps the order, or turns it.
        let [a, b] = [least, most].map(|sample| self.scaling.apply(sample));
        IsoRange { lo: a.min(b), hi: a.max(b) }
    }

    /// How many bricks there are.
    pub fn n_bricks(&self) -> usize {
        self.ends.len() / 2
    }

    /// Bytes held.
    pub fn resident_bytes(&self) -> usize {
        self.ends.len() * self.ends.sample_type().size_bytes()
    }
}

/// A row of bricks a task: its voxels are 64 runs of memory.
fn ends<T: Ordered>(samples: &[T], bricks: &BrickGrid, frame: &FrameHandle) -> Vec<T> {
    let nothing = [T::MOST, T::LEAST];
    let mut ends = vec![nothing; bricks.n_bricks()];
    ends.par_chunks_mut(bricks.n_along()[0]).enumerate().for_each_init(
        || Extremes::new(bricks.dims()[0]),
        |extremes, (row, ends)| {
            if !frame.is_cancelled() {
                extremes.gather(samples, bricks, row);
                ends.iter_mut().zip(extremes.of_bricks()).for_each(|(ends, found)| *ends = found);
            }
        },
    );
    ends.into_flattened()
}

/// The extremes of a row of bricks, column of voxels by column. Columns first, because the minimum of
/// two rows is what vector units are made for; the minimum within a brick's 8 columns is then 1/64 of the
/// work.
struct Extremes<T> {
    least: Vec<T>,
    most: Vec<T>,
}

impl<T: Ordered> Extremes<T> {
    fn new(n_x: usize) -> Self {
        Self { least: vec![T::MOST; n_x], most: vec![T::LEAST; n_x] }
    }

    fn gather(&mut self, samples: &[T], bricks: &BrickGrid, row: usize) {
        self.least.fill(T::MOST);
        self.most.fill(T::LEAST);
        let [n_x, n_y, n_z] = bricks.dims();
        let n_along_y = bricks.n_along()[1];
        let [y, z] = [row % n_along_y, row / n_along_y].map(|coord| coord * BRICK_SIDE);
        for z in z..n_z.min(z + BRICK_SIDE) {
            let rows = &samples[(z * n_y + y) * n_x..][..BRICK_SIDE.min(n_y - y) * n_x];
            for row in rows.chunks_exact(n_x) {
                fold(&mut self.least, &mut self.most, row);
            }
        }
    }

    fn of_bricks(&self) -> impl Iterator<Item = [T; 2]> {
        self.least.chunks(BRICK_SIDE).zip(self.most.chunks(BRICK_SIDE)).map(|(least, most)| {
            let lo = least.iter().fold(T::MOST, |a, &b| if b < a { b } else { a });
            let hi = most.iter().fold(T::LEAST, |a, &b| if a < b { b } else { a });
            [lo, hi]
        })
    }
}

/// A NaN compares as false, so that it never replaces a number.
#[inline]
fn fold<T: Ordered>(least: &mut [T], most: &mut [T], row: &[T]) {
    for ((lo, hi), &sample) in least.iter_mut().zip(most).zip(row) {
        *lo = if sample < *lo { sample } else { *lo };
        *hi = if *hi < sample { sample } else { *hi };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::random_volume;
    use slabsplat_core::Grid;
    use slabsplat_seeds::for_each_seed;

    #[test]
    fn brick_ranges_are_those_of_their_voxels() {
        for_each_seed(1, |mut rng| {
            for _ in 0..60 {
                let volume = random_volume(&mut rng);
                let bricks = BrickGrid::new(volume.grid());
                let mut expected = vec![(f64::INFINITY, f64::NEG_INFINITY); bricks.n_bricks()];
                for voxel_idx in 0..volume.grid().n_voxels() {
                    let at = volume.grid().voxel_coords(voxel_idx).map(|c| c / BRICK_SIDE);
                    let [n_x, n_y, _] = bricks.n_along();
                    let (lo, hi) = &mut expected[(at[2] * n_y + at[1]) * n_x + at[0]];
                    let value = volume.value(voxel_idx);
                    (*lo, *hi) = (lo.min(value), hi.max(value));
                }
                let ranges = BrickRanges::new(&volume);
                for (brick_idx, &(lo, hi)) in expected.iter().enumerate() {
                    assert_eq!(
                        ranges.of_brick(brick_idx),
                        IsoRange { lo, hi },
                        "{:?}",
                        volume.grid()
                    );
                }
            }
        });
    }

    #[test]
    fn brick_ranges_take_two_samples_a_brick() {
        let grid = Grid::with_spacing([17, 8, 50], [1.0; 3]).unwrap();
        let volume = Volume::new(grid, vec![1_u8; 17 * 8 * 50].into(), Scaling::IDENTITY).unwrap();
        let ranges = BrickRanges::new(&volume);
        assert_eq!(ranges.n_bricks(), 3 * 7);
        assert_eq!(ranges.resident_bytes(), 2 * 3 * 7);
    }
}
