//! The pixels of a section whose slab's faces cut its ellipsoid at a slant: those of a band of the footprint.
//!
//! ```text
//! at depth t, from −1 at the ellipsoid's nearest point to 1 at its farthest, a plane has of it an ellipse
//!     around t·farthest, half as wide as half_across·√(1 − t²)
//! its right end is t·farthest + half_across·√(1 − t²), largest at t = farthest/half_extent
//! ```
//!
//! A needle that is r times as long as wide meets r slabs. Each has a piece of it as long as it is wide; the
//! box of the whole footprint would be r times as long, and at a slant to the image r times as high, too.

use crate::footprints::raster::PixelShape;
use crate::pixels::rectangle::MARGIN;
use fearless_simd::{Simd, f32x8, prelude::*};

/// The depths between which slabs cut eight voxels.
#[derive(Clone, Copy)]
pub(super) struct Bands<S: Simd> {
    /// From −1, the nearest point, to 1, the farthest.
    depths: [f32x8<S>; 2],
    /// Of the kernel, in index units.
    radius: f32,
}

/// What `1 − t²` may have lost by rounding.
const ROUNDING: f32 = 1e-6;

impl<S: Simd> Bands<S> {
    /// Between faces that cut the rays through voxels so many index units behind them.
    #[inline(always)]
    pub(super) fn of(simd: S, faces: [f32x8<S>; 2], half_depth_in_index: f32, radius: f32) -> Self {
        let one = f32x8::splat(simd, 1.0);
        let [near, far] = faces;
        let depths_per_index = half_depth_in_index.recip();
        let near = (near * depths_per_index).max(-one).min(one);
        let far = (far * depths_per_index).max(-one).min(one);
        Self { depths: [near, far], radius }
    }

    /// The least and the largest coordinate that sections have, from their centres, in pixels.
    #[inline(always)]
    pub(super) fn ends(&self, simd: S, shape: &PixelShape, axis: usize) -> [f32x8<S>; 2] {
        [self.end(simd, shape, axis, -1.0), self.end(simd, shape, axis, 1.0)]
    }

    /// The end on the side of `sign`.
    #[inline(always)]
    fn end(&self, simd: S, shape: &PixelShape, axis: usize, sign: f32) -> f32x8<S> {
        let [half_extent, farthest, half_across] =
            [shape.half_extent[axis], shape.farthest[axis], shape.half_across[axis]];
        let [near, far] = self.depths;
        let widest = f32x8::splat(simd, sign * farthest / half_extent);
        let depth = widest.max(near).min(far);
        let across = (f32x8::splat(simd, 1.0 + ROUNDING) - depth * depth).sqrt();
        (depth * farthest + across * (sign * half_across)) * self.radius + sign * MARGIN
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::levels;
    use fearless_simd::{Level, dispatch};
    use slabsplat_core::glam::DVec3;
    use slabsplat_seeds::for_each_seed;

    const RADIUS: f64 = 2.0;

    /// Every point of a ball between two planes is within, and one is at each end.
    #[test]
    fn bands_of_every_level_hold_what_is_between_their_faces() {
        for_each_seed(1, |mut rng| {
            for (_, level) in levels() {
                for _ in 0..100 {
                    check(&mut rng, level);
                }
            }
        });
    }

    fn check(rng: &mut fastrand::Rng, level: Level) {
        let normal = vector(rng).normalize();
        let axis = 40.0 * vector(rng);
        let mut depths = [2.0 * rng.f64() - 1.0, 2.0 * rng.f64() - 1.0];
        depths.sort_by(f64::total_cmp);
        let farthest = axis.dot(normal);
        let across = axis - farthest * normal;
        let shape = PixelShape {
            half_extent: [axis.length() as f32; 2],
            farthest: [farthest as f32; 2],
            half_across: [across.length() as f32; 2],
            ..PixelShape::default()
        };
        // Rays may be at any angle to slabs.
        let half_depth = (RADIUS * (1.0 + 9.0 * rng.f64())) as f32;
        let ends = dispatch!(level, simd => {
            let face = |depth: f64| f32x8::splat(simd, depth as f32 * half_depth);
            let bands = Bands::of(simd, depths.map(face), half_depth, RADIUS as f32);
            bands.ends(simd, &shape, 1).map(<[f32; 8]>::from)
        });
        let [low, high] = ends.map(|end| f64::from(end[0]));
        for _ in 0..1000 {
            let point = RADIUS * vector(rng);
            let depth = point.dot(normal) / RADIUS;
            if point.length() <= RADIUS && depths[0] <= depth && depth <= depths[1] {
                let at = point.dot(axis);
                assert!(low <= at && at <= high, "{at} is not from {low} to {high}");
            }
        }
        for (sign, end) in [(-1.0, low), (1.0, high)] {
            let depth = (sign * farthest / axis.length()).clamp(depths[0], depths[1]);
            let across = sign * (1.0 - depth * depth).sqrt() * across.normalize();
            let at = RADIUS * (depth * normal + across).dot(axis);
            assert!((at - end).abs() < 0.1, "{at} should be near {end}");
        }
    }

    fn vector(rng: &mut fastrand::Rng) -> DVec3 {
        DVec3::from_array([0; 3].map(|_| 2.0 * rng.f64() - 1.0))
    }
}
