//! The paper's binary cube (figures 2 and 6): 255 in the inner 16 of 28 voxels a side, 0 around.

use slabsplat_core::Samples;

/// At other sizes the margin of 6 voxels in 28 is kept in proportion, the same on both sides.
pub(super) fn samples(size: usize) -> Samples {
    let margin = (size * 6 + 14) / 28;
    let inside = margin..size - margin;
    let mut samples = vec![0_u8; size.pow(3)];
    for k in inside.clone() {
        for j in inside.clone() {
            let row = (k * size + j) * size;
            samples[row + inside.start..row + inside.end].fill(255);
        }
    }
    Samples::U8(samples)
}

#[cfg(test)]
mod tests {
    use crate::builtin_volume;

    #[test]
    fn cube_is_the_papers() {
        let volume = builtin_volume("cube", None).unwrap();
        for voxel_idx in 0..volume.grid().n_voxels() {
            let is_inside =
                volume.grid().voxel_coords(voxel_idx).iter().all(|c| (6..22).contains(c));
            assert_eq!(volume.value(voxel_idx), if is_inside { 255.0 } else { 0.0 });
        }
    }

    #[test]
    fn cube_keeps_its_proportion() {
        for (size, side) in [(4_usize, 2_u32), (7, 3), (14, 8), (56, 32), (100, 58)] {
            let volume = builtin_volume("cube", Some(size)).unwrap();
            let n_set = (0..volume.grid().n_voxels()).filter(|&v| 0.0 < volume.value(v)).count();
            assert_eq!(n_set, (side as usize).pow(3), "size {size}");
        }
    }
}
