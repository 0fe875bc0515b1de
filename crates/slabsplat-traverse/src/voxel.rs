//! What is stored of a relevant voxel between frames: where it is in its brick, and which way its surface
//! faces.

use crate::BRICK_SIDE;

/// One relevant voxel (§4), in 8 bytes: with [`Brick`](crate::Brick) it knows its coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct VoxelRecord {
    /// The voxel's slot in its brick, x fastest: three bits each of x, y and z.
    pub slot: u16,
    /// `−∇v/|∇v|` in world space, times [`NORMAL_STEPS`]; zero where the gradient is zero.
    pub normal: [i16; 3],
}

const _: () = assert!(size_of::<VoxelRecord>() == 8, "a relevant voxel takes 8 bytes");

/// A component of a normal is stored in steps of this part of 1, so a normal is off by at most 2.7·10⁻⁵.
pub const NORMAL_STEPS: f32 = 32767.0;

impl VoxelRecord {
    /// The voxel's coordinates from its brick's first voxel, 0 … 7 each.
    #[inline]
    pub fn coords_in_brick(self) -> [usize; 3] {
        let slot = usize::from(self.slot);
        [slot % BRICK_SIDE, slot / BRICK_SIDE % BRICK_SIDE, slot / (BRICK_SIDE * BRICK_SIDE)]
    }

    /// The same with another normal, x, y and z in world space, of length 1 or 0.
    #[inline]
    #[must_use]
    pub fn with_normal(self, normal: [f64; 3]) -> Self {
        let steps = |component: f64| (component * f64::from(NORMAL_STEPS)).round() as i16;
        Self { normal: normal.map(steps), ..self }
    }

    /// `−∇v/|∇v|` in world space, or zero.
    ///
    /// The length is 1 to within 10⁻⁶. What rounding did to it is taken back by one step of Newton's for
    /// `1/√x` from 1: a highlight as sharp as (n·h)¹⁰⁰ would show it.
    #[inline]
    pub fn normal_in_world(self) -> [f32; 3] {
        let [x, y, z] = self.normal.map(|steps| f32::from(steps) * (1.0 / NORMAL_STEPS));
        let to_length_1 = 1.5 - 0.5 * (x * x + y * y + z * z);
        [x * to_length_1, y * to_length_1, z * to_length_1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn voxel_record_knows_its_slot() {
        let record = VoxelRecord { slot: 0o731, ..VoxelRecord::default() };
        assert_eq!(record.coords_in_brick(), [1, 3, 7]);
    }

    #[test]
    fn voxel_record_normal_has_length_1() {
        let check = |normal: [i16; 3], length: f32| {
            let record = VoxelRecord { slot: 0, normal };
            let [x, y, z] = record.normal_in_world();
            assert!(((x * x + y * y + z * z).sqrt() - length).abs() < 1e-6, "{normal:?}");
        };
        check([0; 3], 0.0);
        check([32767, 0, 0], 1.0);
        check([18919, -18918, 18917], 1.0);
        check([-23171, 0, 23169], 1.0);
        let record = VoxelRecord::default().with_normal([0.6, 0.0, -0.8]);
        let expected = [0.6, 0.0, -0.8];
        let is_near = |(a, b): (f32, f64)| (f64::from(a) - b).abs() < 3e-5;
        assert!(record.normal_in_world().into_iter().zip(expected).all(is_near), "{record:?}");
    }
}
