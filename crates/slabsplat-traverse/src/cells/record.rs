//! What is retained of a cell: 64 bits.
//!
//! | bits | | in steps of |
//! | --- | --- | --- |
//! | 0 … 11 | extinction | 1/4095 of its brick's largest |
//! | 12 … 35 | red, green, blue | 1/255 |
//! | 36 … 59 | mean normal, x, y and z | 1/127, from −1 on |
//! | 60 … 63 | the share that has no normal | 1/15 |
//!
//! Numbers are rounded down after a **dither** is added, which differs from cell to cell. A pixel sees a mean
//! of ten cells and more, of which each is off by another part of a step: rounded to the nearest, all cells
//! of an even region would be off by the same.

/// A cell in 8 bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CellRecord(u64);

/// A cell: means of its voxels, weighted with their extinctions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CellValues {
    /// Extinction per voxel step: the sum of its voxels', over the voxels along an edge.
    pub extinction: f32,
    /// Red, green and blue before light, 0 … 1.
    pub color: [f32; 3],
    /// The mean of normals; shorter than 1 as they point elsewhere.
    pub normal: [f32; 3],
    /// The share of voxels without a normal.
    pub undirected: f32,
}

const EXTINCTION_BITS: u32 = 12;
const EXTINCTION_STEPS: f32 = 4095.0;
const COLOR_STEPS: f32 = 255.0;
const NORMAL_STEPS: f32 = 127.0;
const UNDIRECTED_STEPS: f32 = 15.0;

/// Where the normal's x is, and what has no direction.
const NORMAL_AT: u32 = EXTINCTION_BITS + 3 * 8;
const UNDIRECTED_AT: u32 = NORMAL_AT + 3 * 8;

/// What is added before rounding down, 0 … 1, for one of up to three numbers of a cell.
pub(super) fn dither(slot: usize, which: usize) -> f32 {
    (slot as f32 * DITHER_STEPS[which % 3]).fract()
}

/// `A^−k` for the `A` that solves `A⁴ = A + 1`: the numbers of a sequence that fills a cube evenly, and any
/// line or square in it (M. Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018,
/// <https://extremelearning.com.au/unreasonable-effectiveness-of-quasirandom-sequences/>).
const DITHER_STEPS: [f32; 3] = [0.819_172_5, 0.671_043_6, 0.549_700_5];

impl CellRecord {
    /// A cell in that slot of a brick whose largest extinction is `largest`.
    pub(super) fn new(values: &CellValues, slot: usize, largest: f32) -> Self {
        let CellValues { extinction, color, normal, undirected } = *values;
        let rounded = |number: f32, most: f32, which: usize| {
            (number + dither(slot, which)).clamp(0.0, most) as u64
        };
        let steps = rounded(extinction / largest * EXTINCTION_STEPS, EXTINCTION_STEPS, 0);
        // What is there at all is not lost.
        let mut bits = steps.max(1)
            | rounded(undirected * UNDIRECTED_STEPS, UNDIRECTED_STEPS, 1) << UNDIRECTED_AT;
        for (channel, number) in (0..).zip(color) {
            bits |= rounded(number * COLOR_STEPS, COLOR_STEPS, channel)
                << (EXTINCTION_BITS + 8 * channel as u32);
        }
        for (axis, number) in (0..).zip(normal) {
            let from_least = (number + 1.0) * NORMAL_STEPS;
            bits |= rounded(from_least, 2.0 * NORMAL_STEPS, axis) << (NORMAL_AT + 8 * axis as u32);
        }
        Self(bits)
    }

    /// What it was made of, but for rounding.
    #[inline(always)]
    pub fn values(self, largest: f32) -> CellValues {
        // By way of 32 bits, of which processors make eight numbers at once.
        let byte = |at: u32| ((self.0 >> at) as u32 & 0xff) as f32;
        let extinction = (self.0 as u32 & ((1 << EXTINCTION_BITS) - 1)) as f32;
        CellValues {
            extinction: extinction * (largest / EXTINCTION_STEPS),
            color: [0, 8, 16].map(|at| byte(EXTINCTION_BITS + at) * (1.0 / COLOR_STEPS)),
            normal: [0, 8, 16].map(|at| byte(NORMAL_AT + at) * (1.0 / NORMAL_STEPS) - 1.0),
            undirected: (self.0 >> UNDIRECTED_AT) as u32 as f32 * (1.0 / UNDIRECTED_STEPS),
        }
    }
}

const _: () = assert!(size_of::<CellRecord>() == 8, "a cell takes 8 bytes");

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_seeds::for_each_seed;

    const fn steps_of() -> [f32; 8] {
        let [c, n] = [1.0 / COLOR_STEPS, 1.0 / NORMAL_STEPS];
        [1.0 / EXTINCTION_STEPS, c, c, c, n, n, n, 1.0 / UNDIRECTED_STEPS]
    }

    fn numbers(values: &CellValues) -> [f32; 8] {
        let CellValues { extinction, color: [r, g, b], normal: [x, y, z], undirected } = *values;
        [extinction, r, g, b, x, y, z, undirected]
    }

    #[test]
    fn cell_record_is_off_by_a_step_and_its_mean_by_less() {
        for_each_seed(1, |mut rng| {
            let values = CellValues {
                extinction: rng.f32(),
                color: [0; 3].map(|_| rng.f32()),
                normal: [0; 3].map(|_| 1.15 * (rng.f32() - 0.5)),
                undirected: rng.f32(),
            };
            let mut means = [0.0; 8];
            for slot in 0..512 {
                let off = numbers(&CellRecord::new(&values, slot, 1.0).values(1.0));
                let off: Vec<f32> = off.iter().zip(numbers(&values)).map(|(a, b)| a - b).collect();
                for ((mean, off), step) in means.iter_mut().zip(off).zip(steps_of()) {
                    assert!(off.abs() < 1.01 * step, "{off} of {step}");
                    *mean += off / 512.0;
                }
            }
            for (mean, step) in means.iter().zip(steps_of()) {
                assert!(mean.abs() < 0.02 * step, "{mean} of {step}");
            }
        });
    }

    #[test]
    fn cell_record_has_the_ends_of_ranges_exactly() {
        for slot in [0, 1, 7, 100, 511] {
            let ends = CellValues {
                extinction: 3.0,
                color: [0.0, 1.0, 0.0],
                normal: [-1.0, 0.0, 1.0],
                undirected: 1.0,
            };
            let read = CellRecord::new(&ends, slot, 3.0).values(3.0);
            let (read_numbers, expected) = (numbers(&read), numbers(&ends));
            let off = read_numbers.iter().zip(expected).map(|(a, b)| (a - b).abs());
            assert!(off.fold(0.0, f32::max) < 1e-6, "{read:?}");
            let faint = CellValues { extinction: 1e-9, ..CellValues::default() };
            assert!(0.0 < CellRecord::new(&faint, slot, 3.0).values(3.0).extinction);
        }
    }
}
