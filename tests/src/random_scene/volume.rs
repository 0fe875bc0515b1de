//! Volumes at random: a wave, noise on it, and in floats some voxels that are no numbers.

use super::{between, random_direction};
use fastrand::Rng;
use slabsplat_core::glam::DVec3;
use slabsplat_core::{Grid, Samples, Scaling, Volume};

/// A volume on `grid`, and the range in which its finite values lie.
pub(super) fn random_volume(rng: &mut Rng, grid: Grid) -> (Volume, [f64; 2]) {
    let fractions = random_fractions(rng, &grid);
    let (samples, scaling) = match rng.u32(..3) {
        0 => {
            let samples = fractions.iter().map(|f| (255.0 * f) as u8).collect();
            (Samples::U8(samples), Scaling::IDENTITY)
        }
        1 => {
            let samples = fractions.iter().map(|f| (3000.0 * f - 1000.0) as i16).collect();
            let slope = if rng.bool() { 0.5 } else { -0.25 };
            (Samples::I16(samples), Scaling { slope, intercept: -100.0 })
        }
        _ => {
            let samples = fractions.iter().map(|&f| spoiled(rng, f as f32)).collect();
            (Samples::F32(samples), Scaling { slope: 2.0, intercept: 0.5 })
        }
    };
    let volume = Volume::new(grid, samples, scaling).expect("one sample a voxel");
    let values = (0..grid.n_voxels()).map(|i| volume.value(i)).filter(|v| v.is_finite());
    let range =
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], v| [lo.min(v), hi.max(v)]);
    (volume, range)
}

/// A number from 0 to 1 for every voxel.
fn random_fractions(rng: &mut Rng, grid: &Grid) -> Vec<f64> {
    let wave = random_direction(rng) * between(rng, 0.3, 1.2);
    let noise = [0.0, 0.1, 0.5][rng.usize(..3)];
    let fraction = |voxel_idx: usize| {
        let coords = DVec3::from_array(grid.voxel_coords(voxel_idx).map(|c| c as f64));
        let smooth = 0.5 + 0.5 * (wave.dot(coords) + 0.1 * coords.length_squared()).sin();
        (1.0 - noise) * smooth + noise * rng.f64()
    };
    (0..grid.n_voxels()).map(fraction).collect()
}

fn spoiled(rng: &mut Rng, fraction: f32) -> f32 {
    match rng.u32(..60) {
        0 | 1 => f32::NAN,
        2 => f32::INFINITY,
        3 => f32::NEG_INFINITY,
        _ => fraction,
    }
}
