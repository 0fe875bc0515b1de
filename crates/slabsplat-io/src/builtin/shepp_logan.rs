//! The head phantom of Shepp and Logan in three dimensions, with Toft's contrast.
//!
//! L. Shepp, B. Logan, "The Fourier Reconstruction of a Head Section", IEEE Transactions on Nuclear
//! Science 21 (1974), gives the ten ellipses; P. Toft, "The Radon Transform" (thesis, Technical
//! University of Denmark, 1996, table B.3), the values that let the eye tell the tissues apart;
//! M. Schabel, "3D Shepp-Logan phantom" (MATLAB Central 9416, 2006), the third axes. Schabel also
//! turns the ventricles by an angle ψ = 10°, which at θ = 0 only makes them lopsided in the plane;
//! it is left out here, so that they are tilted by ∓18° as in the original.

use slabsplat_core::Samples;
use slabsplat_core::glam::{DMat3, DVec3};

use super::{sampled, to_byte};

/// Value added, half axes, centre, and turn about z in degrees; the head fills −1 … 1.
#[rustfmt::skip]
const ELLIPSOIDS: [(f64, [f64; 3], [f64; 3], f64); 10] = [
    ( 1.0, [0.6900, 0.920, 0.810], [ 0.00,  0.0000,  0.00],   0.0), // skull
    (-0.8, [0.6624, 0.874, 0.780], [ 0.00, -0.0184,  0.00],   0.0), // brain
    (-0.2, [0.1100, 0.310, 0.220], [ 0.22,  0.0000,  0.00], -18.0), // right ventricle
    (-0.2, [0.1600, 0.410, 0.280], [-0.22,  0.0000,  0.00],  18.0), // left ventricle
    ( 0.1, [0.2100, 0.250, 0.410], [ 0.00,  0.3500, -0.15],   0.0),
    ( 0.1, [0.0460, 0.046, 0.050], [ 0.00,  0.1000,  0.25],   0.0),
    ( 0.1, [0.0460, 0.046, 0.050], [ 0.00, -0.1000,  0.25],   0.0),
    ( 0.1, [0.0460, 0.023, 0.050], [-0.08, -0.6050,  0.00],   0.0),
    ( 0.1, [0.0230, 0.023, 0.020], [ 0.00, -0.6060,  0.00],   0.0),
    ( 0.1, [0.0230, 0.046, 0.020], [ 0.06, -0.6050,  0.00],   0.0),
];

struct Ellipsoid {
    value: f64,
    center: DVec3,
    /// Takes the ellipsoid, centred, to the unit ball.
    ball_from_head: DMat3,
    smallest_axis: f64,
}

/// Edges are one voxel wide: a voxel that is cut takes the share of it that lies inside.
pub(super) fn samples(size: usize) -> Samples {
    let voxel = 2.0 / size as f64;
    let ellipsoids = ELLIPSOIDS.map(ellipsoid);
    let value_at = |p| ellipsoids.iter().map(|e| e.value * e.share_of_voxel(p, voxel)).sum();
    Samples::U8(sampled(size, |place| to_byte(value_at(place * voxel))))
}

fn ellipsoid((value, half_axes, center, degrees): (f64, [f64; 3], [f64; 3], f64)) -> Ellipsoid {
    let half_axes = DVec3::from_array(half_axes);
    let upright = DMat3::from_rotation_z(-degrees.to_radians());
    Ellipsoid {
        value,
        center: DVec3::from_array(center),
        ball_from_head: DMat3::from_diagonal(half_axes.recip()) * upright,
        smallest_axis: half_axes.min_element(),
    }
}

impl Ellipsoid {
    /// How much of a voxel around `point` is inside, from the distance to the surface.
    fn share_of_voxel(&self, point: DVec3, voxel: f64) -> f64 {
        let in_ball = self.ball_from_head * (point - self.center);
        let radius = in_ball.length();
        // A surface that is a voxel away in the narrowest direction is farther in all others.
        if voxel / self.smallest_axis <= (radius - 1.0).abs() {
            return if radius < 1.0 { 1.0 } else { 0.0 };
        }
        let gradient = (self.ball_from_head.transpose() * in_ball).length() / radius.max(1e-9);
        (0.5 - (radius - 1.0) / gradient.max(1e-9) / voxel).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use crate::builtin_volume;
    use slabsplat_core::glam::DVec3;

    #[test]
    fn shepp_logan_tissues() {
        let volume = builtin_volume("shepp-logan", None).unwrap();
        let grid = volume.grid();
        let value_at = |x: f64, y: f64, z: f64| {
            let index = grid.index_from_world().transform_point3(DVec3::new(x, y, z) * 48.0);
            volume.value(grid.voxel_idx(index.round().to_array().map(|c| c as usize)))
        };
        let check = |at: [f64; 3], expected: f64| {
            let actual = value_at(at[0], at[1], at[2]);
            assert!((actual - expected * 255.0).abs() < 1.0, "{actual} at {at:?}");
        };
        check([0.0, 0.895, 0.0], 1.0); // skull
        check([0.0, -0.3, 0.0], 0.2); // brain
        check([0.22, 0.0, 0.0], 0.0); // ventricles
        check([-0.22, 0.0, 0.0], 0.0);
        check([0.0, 0.35, -0.15], 0.3);
        check([0.95, 0.95, 0.95], 0.0); // air
    }

    #[test]
    fn shepp_logan_edges_are_graded() {
        let volume = builtin_volume("shepp-logan", None).unwrap();
        let is_between = |v: f64| ![0.0, 51.0, 77.0, 255.0].contains(&v);
        let n_between = (0..volume.grid().n_voxels()).filter(|&v| is_between(volume.value(v)));
        assert!(10_000 < n_between.count(), "edges should be anti-aliased");
    }
}
