//! What tests share: random volumes of every type and awkward size, and random iso-ranges.

use slabsplat_core::glam::{DAffine3, DMat3, DVec3};
use slabsplat_core::{Grid, IsoRange, Samples, Scaling, Volume};

/// A volume of any sample type whose values are mostly in −100 … 200, smooth along x in parts, so that
/// bricks differ. Floats may be NaN or infinite.
pub(crate) fn random_volume(rng: &mut fastrand::Rng) -> Volume {
    let dims = [0; 3].map(|_| if rng.u8(0..3) == 0 { rng.usize(1..4) } else { rng.usize(1..28) });
    let mut column = || DVec3::new(rng.f64() - 0.5, rng.f64() - 0.5, rng.f64() - 0.5);
    let matrix = DMat3::from_cols(column(), column(), column());
    let grid = Grid::new(dims, DAffine3::from_mat3(matrix))
        .unwrap_or_else(|_| Grid::with_spacing(dims, [1.0, 1.5, 0.7]).unwrap());
    let samples = random_samples(rng, grid.n_voxels());
    let scaling = match rng.u8(0..3) {
        0 => Scaling::IDENTITY,
        1 => Scaling { slope: -0.7, intercept: 30.0 },
        _ => Scaling { slope: 1.3, intercept: -20.0 },
    };
    Volume::new(grid, samples, scaling).unwrap()
}

fn random_samples(rng: &mut fastrand::Rng, n: usize) -> Samples {
    let (levels, is_wild) = ([2, 20, 120][rng.usize(0..3)], rng.bool());
    let mut number = {
        let mut base = 0;
        let mut rng = rng.fork();
        move || {
            if rng.u8(0..20) == 0 {
                base = rng.i32(0..100);
            }
            base + rng.i32(0..levels) % 120
        }
    };
    let mut wild = rng.fork();
    let mut float = {
        let mut number_of = rng.fork();
        move || match if is_wild { wild.u8(0..60) } else { 9 } {
            0 => f64::NAN,
            1 => f64::INFINITY,
            2 => f64::NEG_INFINITY,
            3 => -0.0,
            4 => 0.0,
            5 => 1e-38,
            _ => f64::from(number_of.i32(0..levels)) * 0.1,
        }
    };
    match rng.u8(0..8) {
        0 => (0..n).map(|_| number() as u8).collect::<Vec<_>>().into(),
        1 => (0..n).map(|_| (number() - 100) as i8).collect::<Vec<_>>().into(),
        2 => (0..n).map(|_| number() as u16).collect::<Vec<_>>().into(),
        3 => (0..n).map(|_| (number() - 50) as i16).collect::<Vec<_>>().into(),
        4 => (0..n).map(|_| number() as u32).collect::<Vec<_>>().into(),
        5 => (0..n).map(|_| number() - 50).collect::<Vec<_>>().into(),
        6 => (0..n).map(|_| float() as f32).collect::<Vec<_>>().into(),
        _ => (0..n).map(|_| float()).collect::<Vec<_>>().into(),
    }
}

/// Up to three disjoint ranges, often with ends at values of the volume.
pub(crate) fn random_ranges(rng: &mut fastrand::Rng, volume: &Volume) -> Vec<IsoRange> {
    let n_voxels = volume.grid().n_voxels();
    let mut end = |_| match rng.u8(0..8) {
        0 => f64::NEG_INFINITY,
        1 => f64::INFINITY,
        2 | 3 => rng.f64() * 200.0 - 60.0,
        _ => volume.value(rng.usize(0..n_voxels)),
    };
    let mut ends: Vec<f64> = (0..6).map(&mut end).filter(|end| !end.is_nan()).collect();
    ends.sort_by(f64::total_cmp);
    ends.dedup();
    ends.truncate(2 * rng.usize(0..4));
    ends.as_chunks().0.iter().map(|&[lo, hi]| IsoRange { lo, hi }).collect()
}
