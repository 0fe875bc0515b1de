//! Classification and Blinn–Phong shading (SPEC §6), once a voxel and frame.
//!
//! What comes out is what a sheet sums (SPEC §3): the voxel's colour and opacity in the form that the
//! compositing wants, so that splatting is the same four multiply-adds for all three.

use crate::VoxelRecord;
use rayon::prelude::*;
use slabsplat_core::glam::DVec3;
use slabsplat_core::{Compositing, Light, Phong, Shading, TransferFunction, Volume};

/// Everything that a voxel's colour depends on, but for the voxel.
#[derive(Clone, Copy, Debug)]
pub struct ShadeDesc<'a> {
    /// Values to opacity and colour.
    pub transfer: &'a TransferFunction,
    /// Colour to shaded colour.
    pub shading: &'a Shading,
    /// The viewing direction, of length 1; the viewer is at `−forward`.
    pub forward: DVec3,
    /// What a sheet sums.
    pub compositing: Compositing,
}

/// Opacity from which `extinction` is cut off: its logarithm would be infinite at 1.
const MAX_OPACITY: f64 = 1.0 - 1e-6;

/// Writes red, green, blue and opacity of `records` into `colors`, as the compositing sums them:
/// `(c, α)` for `separate`, `(αc, α)` for `associated`, `(μc, μ)` with `μ = −ln(1 − α)` for
/// `extinction`.
pub fn shade(
    desc: &ShadeDesc<'_>,
    volume: &Volume,
    records: &[VoxelRecord],
    colors: &mut Vec<[f32; 4]>,
) {
    let lamp = match desc.shading {
        Shading::None => None,
        Shading::Phong(phong) => Some(Lamp::new(*phong, desc.forward)),
    };
    records
        .par_iter()
        .with_min_len(1 << 12)
        .map(|record| {
            let value = volume.value(record.voxel_idx as usize);
            let base = DVec3::from_array(desc.transfer.color(value));
            let color = lamp.map_or(base, |lamp| lamp.light_up(base, record.normal_in_world));
            splat_color(desc.compositing, color, desc.transfer.opacity(value))
        })
        .collect_into_vec(colors);
}

fn splat_color(compositing: Compositing, color: DVec3, opacity: f64) -> [f32; 4] {
    let weighted = |weight: f64| (color * weight).extend(weight);
    let summed = match compositing {
        Compositing::Separate => color.extend(opacity),
        Compositing::Associated => weighted(opacity),
        Compositing::Extinction => weighted(-(-opacity.min(MAX_OPACITY)).ln_1p()),
    };
    summed.as_vec4().to_array()
}

/// A light and a viewer, both infinitely far away.
#[derive(Clone, Copy, Debug)]
struct Lamp {
    phong: Phong,
    to_light: DVec3,
    /// `h = (l + v)/|l + v|`; zero if the light shines straight at the viewer.
    halfway: DVec3,
}

impl Lamp {
    fn new(phong: Phong, forward: DVec3) -> Self {
        let to_light = match phong.light {
            Light::Headlight => -forward,
            Light::Direction(direction) => direction,
        };
        Self { phong, to_light, halfway: (to_light - forward).normalize_or_zero() }
    }

    /// `c·(k_a + k_d·n·l) + k_s·(n·h)^s`, clamped.
    fn light_up(&self, color: DVec3, normal: [f32; 3]) -> DVec3 {
        let Phong { ambient, diffuse, specular, shininess, two_sided, .. } = self.phong;
        let normal = DVec3::from_array(normal.map(f64::from));
        if normal == DVec3::ZERO {
            return (color * ambient).min(DVec3::ONE);
        }
        let facing = |direction: DVec3| {
            let product = normal.dot(direction);
            if two_sided { product.abs() } else { product.max(0.0) }
        };
        let n_l = facing(self.to_light);
        let highlight =
            if 0.0 < n_l { specular * facing(self.halfway).powf(shininess) } else { 0.0 };
        (color * (ambient + diffuse * n_l) + highlight).clamp(DVec3::ZERO, DVec3::ONE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::{Grid, Scaling};

    fn lit(phong: Phong, normal: DVec3) -> DVec3 {
        let lamp = Lamp::new(phong, -DVec3::Z);
        lamp.light_up(DVec3::new(1.0, 0.5, 0.0), normal.as_vec3().to_array())
    }

    #[test]
    fn shade_phong_terms() {
        let phong =
            Phong { ambient: 0.1, diffuse: 0.6, specular: 0.3, shininess: 8.0, ..Phong::default() };
        let close = |a: DVec3, b: [f64; 3]| assert!(a.abs_diff_eq(DVec3::from(b), 1e-6), "{a}");
        close(lit(phong, DVec3::Z), [1.0, 0.65, 0.3]);
        close(lit(phong, -DVec3::Z), [1.0, 0.65, 0.3]);
        close(lit(phong, DVec3::ZERO), [0.1, 0.05, 0.0]);
        let one_sided = Phong { two_sided: false, ..phong };
        close(lit(one_sided, -DVec3::Z), [0.1, 0.05, 0.0]);
        let slanted = DVec3::new(0.6, 0.0, 0.8);
        let highlight = 0.3 * 0.8_f64.powi(8);
        close(lit(phong, slanted), [0.58 + highlight, 0.29 + highlight, highlight]);
        let from_right = Phong { light: Light::towards(DVec3::X).unwrap(), ..one_sided };
        let halfway = (1.4_f64 / 2.0_f64.sqrt()).powi(8) * 0.3;
        close(lit(from_right, slanted), [0.46 + halfway, 0.23 + halfway, halfway]);
        close(lit(from_right, DVec3::Z), [0.1, 0.05, 0.0]);
    }

    #[test]
    fn shade_sums_what_the_compositing_wants() {
        let grid = Grid::with_spacing([1, 1, 1], [1.0; 3]).unwrap();
        let volume = Volume::new(grid, vec![7_u8].into(), Scaling::IDENTITY).unwrap();
        let color = [0.2, 0.4, 0.8];
        let check = |opacity: f64, compositing, expected: [f64; 4]| {
            let transfer =
                TransferFunction::new(vec![(0.0, [opacity])], vec![(0.0, color)]).unwrap();
            let desc = ShadeDesc {
                transfer: &transfer,
                shading: &Shading::None,
                forward: DVec3::Z,
                compositing,
            };
            let records = [VoxelRecord { voxel_idx: 0, normal_in_world: [0.0; 3] }];
            let mut colors = Vec::new();
            shade(&desc, &volume, &records, &mut colors);
            for (actual, expected) in colors[0].iter().zip(expected) {
                assert!((f64::from(*actual) - expected).abs() < 1e-6, "{colors:?}");
            }
        };
        check(0.5, Compositing::Separate, [0.2, 0.4, 0.8, 0.5]);
        check(0.5, Compositing::Associated, [0.1, 0.2, 0.4, 0.5]);
        let mu = std::f64::consts::LN_2;
        check(0.5, Compositing::Extinction, [0.2 * mu, 0.4 * mu, 0.8 * mu, mu]);
        let most = -(1e-6_f64).ln();
        check(1.0, Compositing::Extinction, [0.2 * most, 0.4 * most, 0.8 * most, most]);
    }
}
