//! Blinn–Phong: how much light eight normals send to the viewer.

use crate::{NORMAL_STEPS, VoxelRecord};
use slabsplat_core::glam::DVec3;
use slabsplat_core::{Light, Phong};

/// A light and a viewer, both infinitely far away.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lamp {
    ambient: f32,
    diffuse: f32,
    specular: f32,
    shininess: Power,
    two_sided: bool,
    to_light: [f32; 3],
    /// `h = (l + v)/|l + v|`; zero if the light shines straight at the viewer.
    halfway: [f32; 3],
}

/// What a voxel's colour `c` becomes: `c·scattered + mirrored`, at most 1.
pub(crate) struct Light8 {
    pub(crate) scattered: [f32; 8],
    pub(crate) mirrored: [f32; 8],
}

/// An exponent. Highlights mostly have small whole ones, which take a few multiplications for all eight
/// instead of a call of `powf` each.
#[derive(Clone, Copy, Debug)]
enum Power {
    Whole(u32),
    Real(f32),
}

/// Every squaring doubles the relative error, which begins as 10⁻⁷.
const MAX_WHOLE_POWER: f64 = 256.0;

impl Lamp {
    /// `forward` is the viewing direction.
    pub(crate) fn new(phong: &Phong, forward: DVec3) -> Self {
        let to_light = match phong.light {
            Light::Headlight => -forward,
            Light::Direction(direction) => direction,
        };
        let shininess = phong.shininess;
        let is_whole = shininess.fract() == 0.0 && shininess <= MAX_WHOLE_POWER;
        Self {
            ambient: phong.ambient as f32,
            diffuse: phong.diffuse as f32,
            specular: phong.specular as f32,
            shininess: if is_whole {
                Power::Whole(shininess as u32)
            } else {
                Power::Real(shininess as f32)
            },
            two_sided: phong.two_sided,
            to_light: to_light.as_vec3().to_array(),
            halfway: (to_light - forward).normalize_or_zero().as_vec3().to_array(),
        }
    }

    /// The light on the first eight of `records`; of no meaning beyond their end. A normal of zero gets the
    /// ambient term alone, as its products are zero.
    #[inline]
    pub(crate) fn on(&self, records: &[VoxelRecord]) -> Light8 {
        let mut normals = [[0.0; 8]; 3];
        for (x, record) in records.iter().take(8).enumerate() {
            for (components, steps) in normals.iter_mut().zip(record.normal) {
                components[x] = f32::from(steps) * (1.0 / NORMAL_STEPS);
            }
        }
        let n_l = self.facing(&normals, self.to_light);
        let highlights = self.shininess.of(self.facing(&normals, self.halfway));
        let highlight = |x: usize| if 0.0 < n_l[x] { highlights[x] } else { 0.0 };
        Light8 {
            scattered: n_l.map(|n_l| self.ambient + self.diffuse * n_l),
            mirrored: std::array::from_fn(|x| self.specular * highlight(x)),
        }
    }

    /// Products of normals and a direction, 0 … 1.
    #[inline]
    fn facing(&self, [x, y, z]: &[[f32; 8]; 3], direction: [f32; 3]) -> [f32; 8] {
        std::array::from_fn(|i| {
            let [x, y, z] = [x[i], y[i], z[i]];
            // Normals are kept to some 10⁻⁵; as in `VoxelRecord::normal_in_world`.
            let to_length_1 = 1.5 - 0.5 * (x * x + y * y + z * z);
            let product = (x * direction[0] + y * direction[1] + z * direction[2]) * to_length_1;
            let product = if self.two_sided { product.abs() } else { product };
            let product = if 0.0 < product { product } else { 0.0 };
            if product < 1.0 { product } else { 1.0 }
        })
    }
}

impl Power {
    #[inline]
    fn of(self, bases: [f32; 8]) -> [f32; 8] {
        let mut left = match self {
            Self::Whole(exponent) => exponent,
            Self::Real(exponent) => return bases.map(|base| base.powf(exponent)),
        };
        let (mut squares, mut result) = (bases, [1.0; 8]);
        while left != 0 {
            if left & 1 == 1 {
                result = std::array::from_fn(|i| result[i] * squares[i]);
            }
            squares = squares.map(|square| square * square);
            left >>= 1;
        }
        result
    }
}
