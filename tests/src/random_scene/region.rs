//! Regions at random: planes past the middle of a scene, some of them exactly across the view or along it,
//! and boxes.

use super::{between, random_direction};
use fastrand::Rng;
use slabsplat_core::glam::DVec3;
use slabsplat_core::{Plane, Region, ViewAxes};

/// A region that cuts something off, or all of it, of what lies within a sphere.
pub(super) fn random_region(rng: &mut Rng, axes: &ViewAxes, center: DVec3, radius: f64) -> Region {
    let region = if rng.u32(..4) == 0 {
        let half = DVec3::from_array([0; 3].map(|_| radius * between(rng, 0.2, 0.8)));
        let middle = center + 0.3 * radius * random_direction(rng);
        Region::in_box([middle - half, middle + half]).expect("it ends behind its start")
    } else {
        let n_planes = rng.usize(..=4);
        Region::new((0..n_planes).map(|_| random_plane(rng, axes, center, radius)).collect())
    };
    let region = if rng.u32(..3) == 0 { region.inverted() } else { region };
    if rng.u32(..3) == 0 { region.lit() } else { region }
}

fn random_plane(rng: &mut Rng, axes: &ViewAxes, center: DVec3, radius: f64) -> Plane {
    let normal = match rng.u32(..6) {
        0 => axes.forward,
        1 => -axes.forward,
        2 => {
            let (sin, cos) = between(rng, 0.0, 6.3).sin_cos();
            cos * axes.right + sin * axes.up
        }
        _ => random_direction(rng),
    };
    let through = center + radius * between(rng, 0.0, 0.5) * random_direction(rng);
    Plane::new(normal, normal.dot(through)).expect("the normal is not zero")
}
