//! Surface normals from central differences (model §6), a row of a brick at a time.
//!
//! ```text
//! for each of 8 voxels along x
//!     d  = differences along x, y and z     0.5·(after − before), one-sided at borders and beside NaN
//!     g  = −A⁻ᵀ d, divided by a power of two near its length
//!     n  = g/|g|, or 0 if g is 0 or not finite
//! ```
//!
//! 1. There are no branches on voxels: where a neighbour is missing (which is NaN, for types that have it),
//!    the voxel itself stands in for it, and the difference counts whole instead of half.
//! 2. Samples are read as they are; of a slope only the sign counts, and an intercept does not.
//! 3. Samples of 8 and 16 bits take 32-bit floats, in which their differences are exact. All others, and
//!    sheared grids, in which parts of `A⁻ᵀ d` cancel, take 64 bits up to the division, after which 32 do:
//!    normals are stored to 2.7·10⁻⁵.
//! 4. The division keeps squares of faint or steep gradients from leaving the range of 32-bit floats.
//!
//! The price: all 8 voxels are computed where some are asked for.

use crate::NORMAL_STEPS;
use crate::bricks::BRICK_SIDE;
use crate::order::Ordered;
use slabsplat_core::glam::DMat3;
use slabsplat_core::{Sample, Volume};
use std::array::from_fn;
use std::ops::{Add, Mul, Sub};

/// The normals of a row, component by component, in [`NORMAL_STEPS`].
pub(crate) type RowNormals = [[i16; BRICK_SIDE]; 3];

/// Finds normals, in arithmetic of type `F`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Normals<'a, T, F> {
    samples: &'a [T],
    dims: [usize; 3],
    /// `−A⁻ᵀ`, divided by so much that sums of its products cannot overflow; row by row.
    matrix: [[F; 3]; 3],
}

/// Whether 32 bits are enough for normals of `volume`.
pub(crate) fn is_narrow(volume: &Volume) -> bool {
    let m = volume.grid().world_from_index().matrix3;
    let skew = m.determinant().abs() / (m.x_axis.length() * m.y_axis.length() * m.z_axis.length());
    volume.sample_type().size_bytes() <= 2 && MIN_SKEW < skew
}

/// Volume of the parallelepiped of normalised columns below which errors of 10⁻⁷ could grow to 10⁻⁶.
const MIN_SKEW: f64 = 0.1;

impl<'a, T: Ordered, F: Real> Normals<'a, T, F> {
    /// The normals of `volume`, whose samples are `samples`.
    pub(crate) fn new(volume: &Volume, samples: &'a [T]) -> Self {
        let world_gradient_from_index = volume.grid().index_from_world().matrix3.transpose();
        let m: DMat3 = world_gradient_from_index * -volume.scaling().slope.signum();
        let largest = m.to_cols_array().into_iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        let matrix = [0, 1, 2].map(|row| (m.row(row) / (32.0 * largest)).to_array().map(F::of));
        Self { samples, dims: volume.grid().dims(), matrix }
    }

    /// The normals of the 8 voxels from `coords` along x. Where the grid ends before, the rest is
    /// anything.
    #[inline]
    pub(crate) fn of_row(&self, [x, y, z]: [usize; 3]) -> RowNormals {
        let [n_x, n_y, n_z] = self.dims;
        let start = (z * n_y + y) * n_x + x;
        let here = self.row(start);
        let differences = [
            self.along_x(&here, x, start),
            self.along(&here, start, n_x, [0 < y, y + 1 < n_y]),
            self.along(&here, start, n_x * n_y, [0 < z, z + 1 < n_z]),
        ];
        quantised(&self.matrix, &differences)
    }

    #[inline]
    fn along_x(&self, here: &[T; BRICK_SIDE], x: usize, start: usize) -> [F; BRICK_SIDE] {
        if 0 < x && x + BRICK_SIDE < self.dims[0] {
            let [before, after] = [self.row(start - 1), self.row(start + 1)];
            differences(&before, here, &after, &[F::of(0.5); BRICK_SIDE])
        } else {
            let ([before, after], factors) = self.neighbors_along_x(x, start);
            differences(&before, here, &after, &factors)
        }
    }

    /// Along y or z, in which all eight have neighbours or none.
    #[inline]
    fn along(
        &self,
        here: &[T; BRICK_SIDE],
        start: usize,
        stride: usize,
        [has_before, has_after]: [bool; 2],
    ) -> [F; BRICK_SIDE] {
        let missing = || here.map(T::missing_neighbor);
        let before = if has_before { self.row(start - stride) } else { missing() };
        let after = if has_after { self.row(start + stride) } else { missing() };
        let factor = F::of(if has_before && has_after { 0.5 } else { 1.0 });
        differences(&before, here, &after, &[factor; BRICK_SIDE])
    }

    /// Eight samples, whether they are of one row or not; fewer at the end of the volume.
    #[inline]
    fn row(&self, start: usize) -> [T; BRICK_SIDE] {
        match self.samples[start..].first_chunk() {
            Some(samples) => *samples,
            None => self.row_at_end(start),
        }
    }

    #[cold]
    fn row_at_end(&self, start: usize) -> [T; BRICK_SIDE] {
        let last = self.samples.len() - 1;
        from_fn(|offset| self.samples[last.min(start + offset)])
    }

    #[cold]
    fn neighbors_along_x(&self, x: usize, start: usize) -> ([[T; BRICK_SIDE]; 2], [F; BRICK_SIDE]) {
        let last = self.dims[0] - 1;
        let x_at = |offset: usize| last.min(x + offset);
        let sample_at = |x_there: usize| self.samples[start - x + x_there];
        let before = |x: usize| match x {
            0 => sample_at(0).missing_neighbor(),
            _ => sample_at(x - 1),
        };
        let after = |x: usize| match x {
            _ if x == last => sample_at(last).missing_neighbor(),
            _ => sample_at(x + 1),
        };
        let factor = |x: usize| F::of(if 0 < x && x < last { 0.5 } else { 1.0 });
        let neighbors =
            [from_fn(|offset| before(x_at(offset))), from_fn(|offset| after(x_at(offset)))];
        (neighbors, from_fn(|offset| factor(x_at(offset))))
    }
}

/// `factors` are 0.5 where both neighbours are there.
#[inline]
#[expect(clippy::eq_op, reason = "a sample that differs from itself is NaN, whatever its type")]
fn differences<T: Sample, F: Real>(
    before: &[T; BRICK_SIDE],
    here: &[T; BRICK_SIDE],
    after: &[T; BRICK_SIDE],
    factors: &[F; BRICK_SIDE],
) -> [F; BRICK_SIDE] {
    let mut differences = [F::of(0.0); BRICK_SIDE];
    for x in 0..BRICK_SIDE {
        let (no_before, no_after) = (before[x] != before[x], after[x] != after[x]);
        // Where both are missing the difference is 0, even if the voxel itself is infinite.
        let stand_in = if no_before & no_after { T::zeroed() } else { here[x] };
        let before = if no_before { stand_in } else { before[x] };
        let after = if no_after { stand_in } else { after[x] };
        let factor = if no_before | no_after { F::of(1.0) } else { factors[x] };
        differences[x] = (F::of_sample(after) - F::of_sample(before)) * factor;
    }
    differences
}

#[inline]
fn quantised<F: Real>(matrix: &[[F; 3]; 3], d: &[[F; BRICK_SIDE]; 3]) -> RowNormals {
    let mut scaled = [[0.0_f32; BRICK_SIDE]; 3];
    for x in 0..BRICK_SIDE {
        let along = |row: &[F; 3]| row[0] * d[0][x] + row[1] * d[1][x] + row[2] * d[2][x];
        let [a, b, c] = F::scaled([along(&matrix[0]), along(&matrix[1]), along(&matrix[2])]);
        (scaled[0][x], scaled[1][x], scaled[2][x]) = (a, b, c);
    }
    let mut normals = [[0; BRICK_SIDE]; 3];
    for x in 0..BRICK_SIDE {
        let [a, b, c] = [scaled[0][x], scaled[1][x], scaled[2][x]];
        let squared = a * a + b * b + c * c;
        let steps = if 0.0 < squared { NORMAL_STEPS / squared.sqrt() } else { 0.0 };
        normals[0][x] = rounded(a * steps);
        normals[1][x] = rounded(b * steps);
        normals[2][x] = rounded(c * steps);
    }
    normals
}

/// The nearest integer to a number of a size of at most 2¹⁵. Adding 1.5·2²³ leaves it in the low bits of the
/// sum; `round` would be a call into libm, for want of an instruction among the x86-64 that we can
/// count on.
#[inline]
fn rounded(number: f32) -> i16 {
    (number + 12_582_912.0).to_bits() as i16
}

/// The arithmetic of gradients: 32-bit or 64-bit floats.
pub(crate) trait Real:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self>
{
    fn of(number: f64) -> Self;

    fn of_sample<T: Sample>(sample: T) -> Self;

    /// The vector divided by a power of two near the sum of its components' sizes, so that they are at
    /// most 2; zero if it is zero or not finite.
    fn scaled(vector: [Self; 3]) -> [f32; 3];
}

impl Real for f32 {
    #[inline]
    fn of(number: f64) -> Self {
        number as Self
    }

    #[inline]
    fn of_sample<T: Sample>(sample: T) -> Self {
        sample.to_f64() as Self
    }

    #[inline]
    fn scaled(vector: [Self; 3]) -> [f32; 3] {
        const EXPONENT: u32 = 0x7f80_0000;
        let size = vector[0].abs() + vector[1].abs() + vector[2].abs();
        let factor = Self::from_bits((254_u32 << 23).wrapping_sub(size.to_bits() & EXPONENT));
        let factor = if size < Self::INFINITY { factor } else { 0.0 };
        [vector[0] * factor, vector[1] * factor, vector[2] * factor]
    }
}

impl Real for f64 {
    #[inline]
    fn of(number: f64) -> Self {
        number
    }

    #[inline]
    fn of_sample<T: Sample>(sample: T) -> Self {
        sample.to_f64()
    }

    #[inline]
    fn scaled(vector: [Self; 3]) -> [f32; 3] {
        const EXPONENT: u64 = 0x7ff0_0000_0000_0000;
        let size = vector[0].abs() + vector[1].abs() + vector[2].abs();
        let factor = Self::from_bits((2046_u64 << 52).wrapping_sub(size.to_bits() & EXPONENT));
        let component =
            |number: Self| if size < Self::INFINITY { (number * factor) as f32 } else { 0.0 };
        [component(vector[0]), component(vector[1]), component(vector[2])]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::VoxelRecord;
    use crate::naive_normals::naive_normal;
    use crate::tests::random_volume;
    use slabsplat_core::glam::{DAffine3, DVec3};
    use slabsplat_core::{Grid, Samples, Scaling, with_samples};
    use slabsplat_seeds::for_each_seed;

    /// The normal of every voxel, by way of rows.
    fn normals(volume: &Volume) -> Vec<DVec3> {
        let grid = volume.grid();
        let normal = |voxel_idx: usize| {
            let [x, y, z] = grid.voxel_coords(voxel_idx);
            let row_at = [x - x % BRICK_SIDE, y, z];
            let row = with_samples!(volume.samples(), |s| if is_narrow(volume) {
                Normals::<_, f32>::new(volume, s).of_row(row_at)
            } else {
                Normals::<_, f64>::new(volume, s).of_row(row_at)
            });
            let normal = row.map(|component| component[x % BRICK_SIDE]);
            DVec3::from(VoxelRecord { slot: 0, normal }.normal_in_world().map(f64::from))
        };
        (0..grid.n_voxels()).map(normal).collect()
    }

    /// Half a step in each component.
    const MAX_ERROR: f64 = 2.7e-5;

    #[test]
    fn normals_are_those_of_the_definition() {
        for_each_seed(1, |mut rng| {
            for _ in 0..100 {
                let volume = random_volume(&mut rng);
                for (voxel_idx, normal) in normals(&volume).into_iter().enumerate() {
                    // A voxel without a value has no normal either, and is never asked.
                    if volume.value(voxel_idx).is_nan() {
                        continue;
                    }
                    let expected = naive_normal(&volume, voxel_idx);
                    let difference = normal.distance(expected);
                    assert!(difference < MAX_ERROR, "{normal} {expected} {voxel_idx} {volume:?}");
                }
            }
        });
    }

    #[test]
    fn is_narrow_where_32_bits_are_enough() {
        let sheared = |by: f64| DMat3::from_cols(DVec3::X, DVec3::new(by, 1.0, 0.0), DVec3::Z);
        let check = |samples: Samples, matrix: DMat3, expected: bool| {
            let grid = Grid::new([1; 3], DAffine3::from_mat3(matrix)).unwrap();
            let volume = Volume::new(grid, samples, Scaling::IDENTITY).unwrap();
            assert_eq!(is_narrow(&volume), expected, "{:?} {matrix}", volume.sample_type());
        };
        check(vec![1_u8].into(), DMat3::IDENTITY, true);
        check(vec![1_i16].into(), sheared(3.0), true);
        check(vec![1_u16].into(), DMat3::from_diagonal(DVec3::new(1e-9, 1.0, -1e9)), true);
        check(vec![1_u16].into(), DMat3::from_diagonal(DVec3::new(1e-3, 1e-3, 1e-3)), true);
        check(vec![1_i8].into(), sheared(30.0), false);
        for wide in
            [vec![1_u32].into(), vec![1_i32].into(), vec![1.0_f32].into(), vec![1.0_f64].into()]
        {
            check(wide, DMat3::IDENTITY, false);
        }
    }

    /// Differences in the last digits, which 32-bit floats do not have.
    #[test]
    fn normal_of_wide_samples_keeps_their_digits() {
        let grid = Grid::with_spacing([3; 3], [1.0; 3]).unwrap();
        let step = |idx: usize| {
            let [x, y, z] = grid.voxel_coords(idx);
            (x + 2 * y + 2 * z) as u32
        };
        let large: Vec<u32> = (0..27).map(|idx| 4_000_000_000 + step(idx)).collect();
        let fine: Vec<f64> = (0..27).map(|idx| 1e12 + f64::from(step(idx))).collect();
        for samples in [Samples::U32(large), Samples::F64(fine)] {
            let volume = Volume::new(grid, samples, Scaling::IDENTITY).unwrap();
            let expected = DVec3::new(-1.0, -2.0, -2.0) / 3.0;
            assert!(normals(&volume)[13].distance(expected) < MAX_ERROR, "{volume:?}");
        }
    }

    #[test]
    fn normal_where_two_components_sum_to_the_third() {
        let grid = Grid::with_spacing([3; 3], [1.0; 3]).unwrap();
        for gradient in [[1, 1, 2], [1, 2, 1], [2, 1, 1]] {
            let value = |idx: usize| {
                let [x, y, z] = grid.voxel_coords(idx).map(|c| c as u8);
                gradient[0] * x + gradient[1] * y + gradient[2] * z
            };
            let narrow: Vec<u8> = (0..27).map(value).collect();
            let wide: Vec<f64> = narrow.iter().map(|&sample| sample.into()).collect();
            let expected = -DVec3::from(gradient.map(f64::from)).normalize();
            for samples in [Samples::U8(narrow), Samples::F64(wide)] {
                let volume = Volume::new(grid, samples, Scaling::IDENTITY).unwrap();
                assert!(normals(&volume)[13].distance(expected) < MAX_ERROR, "{volume:?}");
            }
        }
    }

    #[test]
    fn normal_is_one_sided_beside_nan() {
        let row = |samples: Vec<f32>| {
            let grid = Grid::with_spacing([samples.len(), 1, 1], [1.0; 3]).unwrap();
            let volume = Volume::new(grid, Samples::F32(samples), Scaling::IDENTITY).unwrap();
            normals(&volume)[1]
        };
        let check = |samples, expected: DVec3| assert!(row(samples).distance(expected) < 1e-6);
        check(vec![f32::NAN, 1.0, 3.0], -DVec3::X);
        check(vec![9.0, 1.0, f32::NAN], DVec3::X);
        check(vec![f32::NAN, 1.0, f32::NAN], DVec3::ZERO);
        check(vec![4.0, 1.0, 4.0], DVec3::ZERO);
        check(vec![0.0, 1.0, f32::INFINITY], DVec3::ZERO);
        check(vec![f32::NEG_INFINITY, 1.0, f32::INFINITY], DVec3::ZERO);
        check(vec![0.0, 0.0, 1e-38], -DVec3::X);
        check(vec![0.0, 0.0, f32::from_bits(1)], -DVec3::X);
        check(vec![-3e38, 0.0, 3e38], -DVec3::X);
    }

    /// Steps as unequal, and columns as close to one plane, as a grid allows.
    #[test]
    fn normal_on_extreme_grids() {
        let check = |matrix: DMat3| {
            let grid = Grid::new([3; 3], DAffine3::from_mat3(matrix)).unwrap();
            for gradient in [[1, 0, 0], [0, 1, 0], [0, 0, 1], [3, 2, 1]] {
                let value = |idx: usize| {
                    let coords = grid.voxel_coords(idx);
                    (0..3).map(|axis| coords[axis] as u8 * gradient[axis]).sum::<u8>()
                };
                let samples: Vec<u8> = (0..27).map(value).collect();
                let volume = Volume::new(grid, samples.into(), Scaling::IDENTITY).unwrap();
                let (normal, expected) = (normals(&volume)[13], naive_normal(&volume, 13));
                assert!(normal.distance(expected) < MAX_ERROR, "{normal} {expected} {matrix}");
            }
        };
        check(DMat3::from_diagonal(DVec3::new(1e-11, 1.0, 1e11)));
        check(DMat3::from_diagonal(DVec3::new(-1e11, 1e-11, 1e11)));
        let sheared = |by: f64| DMat3::from_cols(DVec3::X, DVec3::new(1.0, by, 0.0), DVec3::Z);
        check(sheared(1e-5));
        check(sheared(0.2));
    }
}
