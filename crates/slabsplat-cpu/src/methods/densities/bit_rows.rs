//! Voxels of a volume, a bit each, and all within reach of them.
//!
//! ```text
//! for each row of voxels:
//!     for the rows of steps that go equally far along it, at once:
//!         join the rows of voxels that they lead to
//!         row |= what was joined, moved by each of the steps along it, by doubling
//! ```

use super::reach::Row;
use rayon::prelude::*;
use slabsplat_core::FrameHandle;
use std::ops::RangeInclusive;

/// Some of the voxels, row by row along the first axis.
pub(super) struct BitRows {
    dims: [usize; 3],
    /// Words in a row.
    n_words: usize,
    bits: Vec<u64>,
}

const BITS: usize = u64::BITS as usize;

impl BitRows {
    /// Those of which `is_meant`, given their indices in memory; any, if the frame is cancelled.
    pub(super) fn of(
        dims: [usize; 3],
        frame: &FrameHandle,
        is_meant: impl Fn(usize) -> bool + Sync,
    ) -> Self {
        let mut all = Self::none(dims);
        let n_words = all.n_words;
        let rows = all.bits.par_chunks_mut(n_words).enumerate();
        rows.filter(|_| !frame.is_cancelled()).for_each(|(row, words)| {
            for x in 0..dims[0] {
                words[x / BITS] |= u64::from(is_meant(row * dims[0] + x)) << (x % BITS);
            }
        });
        all
    }

    fn none(dims: [usize; 3]) -> Self {
        let n_words = dims[0].div_ceil(BITS);
        Self { dims, n_words, bits: vec![0; n_words * dims[1] * dims[2]] }
    }

    pub(super) fn holds(&self, voxel_idx: usize) -> bool {
        let (row, x) = (voxel_idx / self.dims[0], voxel_idx % self.dims[0]);
        self.bits[row * self.n_words + x / BITS] >> (x % BITS) & 1 == 1
    }

    /// The voxels that are one of some steps away from any of these; any, if the frame is cancelled.
    pub(super) fn spread(&self, steps: &[Row], frame: &FrameHandle) -> Self {
        let mut all = Self::none(self.dims);
        let rows = all.bits.par_chunks_mut(self.n_words).enumerate();
        rows.filter(|_| !frame.is_cancelled()).for_each_init(Vec::new, |joined, (row, words)| {
            for alike in steps.chunk_by(|a, b| a.x == b.x) {
                joined.clear();
                joined.resize(self.n_words + alike[0].x.clone().count().div_ceil(BITS), 0);
                for source in alike.iter().filter_map(|steps| self.row(row, steps)) {
                    or(joined, source);
                }
                if joined.iter().any(|word| *word != 0) {
                    move_by_each(joined, alike[0].x.clone());
                    or(words, joined);
                }
            }
        });
        all
    }

    /// The row that steps lead to.
    fn row(&self, row: usize, steps: &Row) -> Option<&[u64]> {
        let [_, n_y, n_z] = self.dims;
        let y = (row % n_y).checked_add_signed(steps.y).filter(|y| *y < n_y)?;
        let z = (row / n_y).checked_add_signed(steps.z).filter(|z| *z < n_z)?;
        Some(&self.bits[(z * n_y + y) * self.n_words..][..self.n_words])
    }
}

fn or(words: &mut [u64], others: &[u64]) {
    words.iter_mut().zip(others).for_each(|(word, other)| *word |= other);
}

/// Sets the bits from which any step leads to one that was set; there is room for all steps behind the last.
fn move_by_each(words: &mut [u64], steps: RangeInclusive<isize>) {
    let n_steps = steps.clone().count();
    move_down(words, (*steps.start()).max(0) as usize, |_, moved| moved);
    move_up(words, (-*steps.start()).max(0) as usize);
    let mut n_done = 1;
    while n_done < n_steps {
        let by = n_done.min(n_steps - n_done);
        move_down(words, by, |word, moved| word | moved);
        n_done += by;
    }
}

/// Combines every word with what lies `by` bits behind it.
fn move_down(words: &mut [u64], by: usize, combined: impl Fn(u64, u64) -> u64) {
    let (n_words, n_bits) = (by / BITS, by % BITS);
    for idx in 0..words.len() {
        let at = |idx: usize| words.get(idx + n_words).copied().unwrap_or(0);
        // In two moves, as a word cannot be moved by all of its bits.
        let moved = at(idx) >> n_bits | at(idx + 1) << 1 << (BITS - 1 - n_bits);
        words[idx] = combined(words[idx], moved);
    }
}

fn move_up(words: &mut [u64], by: usize) {
    let (n_words, n_bits) = (by / BITS, by % BITS);
    for idx in (0..words.len()).rev() {
        let at = |before: usize| idx.checked_sub(before).map_or(0, |idx| words[idx]);
        words[idx] = at(n_words) << n_bits | at(n_words + 1) >> 1 >> (BITS - 1 - n_bits);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_seeds::for_each_seed;

    #[test]
    fn bit_rows_spread_by_every_step() {
        for_each_seed(1, |mut rng| {
            for _ in 0..30 {
                let frame = FrameHandle::new();
                let dims = [rng.usize(1..200), rng.usize(1..6), rng.usize(1..6)];
                let n_voxels = dims.iter().product();
                let is_set: Vec<bool> = (0..n_voxels).map(|_| rng.u8(..40) == 0).collect();
                let row = |_| {
                    let first = rng.i64(-150..150) as isize;
                    let [y, z] = [0; 2].map(|_| rng.i64(-3..4) as isize);
                    Row { x: first..=first + rng.i64(0..90) as isize, y, z }
                };
                let mut steps: Vec<Row> = (0..5).map(row).collect();
                // Of one extent and another position.
                steps.extend([Row { y: 1, ..steps[4].clone() }]);
                let spread = BitRows::of(dims, &frame, |idx| is_set[idx]).spread(&steps, &frame);
                for idx in 0..n_voxels {
                    let [x, y, z] =
                        [idx % dims[0], idx / dims[0] % dims[1], idx / dims[0] / dims[1]];
                    let leads_to_one = |steps: &Row| {
                        steps.x.clone().any(|step| {
                            let at = |axis: usize, idx: usize, step: isize| {
                                idx.checked_add_signed(step).filter(|idx| *idx < dims[axis])
                            };
                            let [Some(x), Some(y), Some(z)] =
                                [at(0, x, step), at(1, y, steps.y), at(2, z, steps.z)]
                            else {
                                return false;
                            };
                            is_set[(z * dims[1] + y) * dims[0] + x]
                        })
                    };
                    assert_eq!(spread.holds(idx), steps.iter().any(leads_to_one), "{idx} {dims:?}");
                }
            }
        });
    }
}
