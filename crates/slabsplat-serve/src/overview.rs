//! A volume made small, for a viewer to steer by.

use axum::body::Bytes;
use slabsplat::glam::{DAffine3, DVec3};
use slabsplat::{Grid, Sample, Scaling, Volume, with_samples};
use std::fmt::Write;

/// Voxels a side of the smaller volume, at most.
const MAX_SIDE: usize = 64;

/// The volume with the means of blocks of voxels as its own, as an NRRD file, raw and attached. What is not
/// finite has no part in a mean.
pub(crate) fn overview_of(volume: &Volume) -> Bytes {
    let blocks = Blocks::of(volume.grid());
    let values = with_samples!(volume.samples(), |it| blocks.means(it, volume.scaling()));
    let mut bytes = blocks.header(volume.grid()).into_bytes();
    bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    bytes.into()
}

/// How voxels of a grid are joined.
#[derive(Clone, Copy)]
struct Blocks {
    /// Voxels of the grid along each axis.
    dims: [usize; 3],
    /// Those of a block.
    sides: [usize; 3],
    /// Blocks along each axis.
    counts: [usize; 3],
}

impl Blocks {
    fn of(grid: &Grid) -> Self {
        let dims = grid.dims();
        let sides = dims.map(|dim| dim.div_ceil(MAX_SIDE));
        let counts = [0, 1, 2].map(|axis| dims[axis].div_ceil(sides[axis]));
        Self { dims, sides, counts }
    }

    fn means<T: Sample>(self, samples: &[T], scaling: Scaling) -> Vec<f32> {
        let [nx, ny, _] = self.dims;
        let [mx, my, mz] = self.counts;
        let mut sums = vec![(0.0, 0_u32); mx * my * mz];
        for (row_idx, row) in samples.chunks_exact(nx).enumerate() {
            let (j, k) = (row_idx % ny / self.sides[1], row_idx / ny / self.sides[2]);
            let first = mx * (j + my * k);
            for (block, sum) in row.chunks(self.sides[0]).zip(&mut sums[first..first + mx]) {
                for value in block.iter().map(|sample| scaling.apply(sample.to_f64())) {
                    if value.is_finite() {
                        *sum = (sum.0 + value, sum.1 + 1);
                    }
                }
            }
        }
        sums.into_iter().map(|(sum, n)| (sum / f64::from(n)) as f32).collect()
    }

    /// The middle of a block is where it is in the world.
    fn header(self, grid: &Grid) -> String {
        let side = DVec3::from_array(self.sides.map(|side| side as f64));
        let index_from_block =
            DAffine3 { translation: 0.5 * (side - 1.0), ..DAffine3::from_scale(side) };
        let world_from_block = grid.world_from_index() * index_from_block;
        let vector = |v: DVec3| format!("({},{},{})", v.x + 0.0, v.y + 0.0, v.z + 0.0);
        let [nx, ny, nz] = self.counts;
        let matrix = world_from_block.matrix3;
        let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(vector);
        let origin = vector(world_from_block.translation);
        let mut header = String::from("NRRD0005\ntype: float\ndimension: 3\n");
        let written = write!(
            header,
            "space: right-anterior-superior\nsizes: {nx} {ny} {nz}\nspace directions: {x} {y} {z}\n\
             kinds: domain domain domain\nendian: little\nencoding: raw\nspace origin: {origin}\n\n"
        );
        written.expect("a text grows as it has to");
        header
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat::io::FilesInMemory;
    use slabsplat::{Samples, glam::DMat3};

    #[test]
    fn overview_is_where_the_volume_is() {
        let matrix = DMat3::from_cols(2.0 * DVec3::X, DVec3::new(0.5, -1.0, 0.0), 3.0 * DVec3::Z);
        let place = DAffine3::from_mat3_translation(matrix, DVec3::new(-7.0, 0.25, 1e3));
        let grid = Grid::new([130, 5, 64], place).unwrap();
        let value = |[i, j, k]: [usize; 3]| (i + 1000 * j) as f32 + 0.5 * k as f32;
        let volume = Volume::from_fn(grid, value);
        let bytes = overview_of(&volume);
        let files = FilesInMemory::from_iter([("a.nrrd", &bytes[..])]);
        let small = files.read_volume("a.nrrd").unwrap().volume;
        assert_eq!(small.grid().dims(), [44, 5, 64]);
        let at = small.grid().world_from_index().transform_point3(DVec3::new(2.0, 3.0, 4.0));
        let expected = place.transform_point3(DVec3::new(7.0, 3.0, 4.0));
        assert!(at.distance(expected) < 1e-9, "{at} {expected}");
        assert_eq!(small.value(small.grid().voxel_idx([2, 3, 4])), f64::from(value([7, 3, 4])));
        // The last block has one voxel.
        assert_eq!(small.value(43), f64::from(value([129, 0, 0])));
    }

    #[test]
    fn overview_leaves_out_what_is_not_finite() {
        let grid = Grid::with_spacing([128, 1, 1], [1.0; 3]).unwrap();
        let mut samples = vec![4.0_f32; 128];
        (samples[1], samples[2], samples[3]) = (f32::NAN, f32::INFINITY, f32::NAN);
        let scaling = Scaling { slope: 2.0, intercept: 1.0 };
        let volume = Volume::new(grid, Samples::F32(samples), scaling).unwrap();
        let bytes = overview_of(&volume);
        let values: Vec<f32> = bytes[bytes.len() - 4 * 64..]
            .as_chunks::<4>()
            .0
            .iter()
            .map(|bytes| f32::from_le_bytes(*bytes))
            .collect();
        assert!(values[0] == 9.0 && values[1].is_nan() && values[2] == 9.0);
    }
}
