//! A ball with a soft edge: the gradient is radial everywhere, so that shading is easily judged.

use slabsplat_core::Samples;

use super::{sampled, smoothstep, to_byte};

/// The radius at which the value is one half, in sides of the volume.
const RADIUS: f64 = 0.375;

/// Width of the edge in voxel steps: wide enough that central differences resolve it.
const EDGE: f64 = 4.0;

pub(super) fn samples(size: usize) -> Samples {
    let radius = RADIUS * size as f64;
    let value_at = |r: f64| to_byte(smoothstep(0.5 + (radius - r) / EDGE));
    Samples::U8(sampled(size, |place| value_at(place.length())))
}

#[cfg(test)]
mod tests {
    use crate::builtin_volume;
    use slabsplat_core::glam::DVec3;

    #[test]
    fn sphere_falls_with_the_radius_alone() {
        let volume = builtin_volume("sphere", None).unwrap();
        let grid = volume.grid();
        let radius_of = |voxel_idx| {
            let coords = DVec3::from_array(grid.voxel_coords(voxel_idx).map(|c| c as f64));
            grid.world_from_index().transform_point3(coords).length()
        };
        for voxel_idx in 0..grid.n_voxels() {
            let value = volume.value(voxel_idx);
            match radius_of(voxel_idx) {
                r if r < 22.0 => assert_eq!(value, 255.0),
                r if 26.0 < r => assert_eq!(value, 0.0),
                r => assert!((value - 127.5) * (24.0 - r) >= -0.5, "{value} at {r}"),
            }
        }
    }
}
