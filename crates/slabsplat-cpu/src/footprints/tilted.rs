//! The weights of a section whose slab's faces cut the rays of its footprint at different offsets, on a row
//! of pixels.
//!
//! ```text
//! x      = across·(dx + shear·dy)² + along·dy² − 1              (2·(ρ/R)² − 1, at most 1)
//! end    = R·√((1 − x)/2)                                      where the ray leaves the ball
//! A(s)   = s·p(2·(s/R)² − 1),  s = face + tilt·(dx, dy), clamped to ±end
//! weight = g(x)·(A(back) − A(front))
//! ```
//!
//! Outside of the ball both faces are clamped to one depth, and the weight is 0.

use super::raster::PixelShape;
use super::weights::{CENTERS, Lanes, Weigh, eleven, nine};
use fearless_simd::Simd;
use slabsplat_kernel::TiltedSections;

/// A section of a kernel that is a product of a function across the ray and one along it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tilted<'a> {
    pub(crate) sections: &'a TiltedSections,
    /// The kernel's radius in index units.
    pub(crate) radius: f32,
    /// Index units from the voxel to the slab's faces, on the ray through the footprint's centre.
    pub(crate) faces: [f32; 2],
}

impl<S: Simd> Weigh<S> for Tilted<'_> {
    /// Pixels right of the centre.
    #[inline(always)]
    fn columns<V: Lanes<S>>(&self, simd: S, _: &PixelShape, left: f32) -> V {
        V::from_slice(simd, &CENTERS[..V::LEN]) + left
    }

    #[inline(always)]
    fn row<V: Lanes<S>>(&self, simd: S, shape: &PixelShape, columns: V, dy: f32) -> V {
        let one = V::splat(simd, 1.0);
        let u = columns + shape.shear * dy;
        let from_row = V::splat(simd, shape.along * dy * dy - 1.0);
        let x = (u * shape.across).mul_add(u, from_row).min(one);
        let end = ((one - x) * (0.5 * self.radius * self.radius)).sqrt();
        let later =
            columns.mul_add(V::splat(simd, shape.tilt[0]), V::splat(simd, shape.tilt[1] * dy));
        let [front, back] = self.faces;
        let front = (later + front).max(-end).min(end);
        let back = (later + back).max(-end).min(end);
        eleven(simd, self.sections.across(), x) * (self.up_to(simd, back) - self.up_to(simd, front))
    }
}

impl Tilted<'_> {
    /// What a ray through the voxel has of its kernel up to `s` index units behind it.
    #[inline(always)]
    fn up_to<S: Simd, V: Lanes<S>>(&self, simd: S, s: V) -> V {
        let form = 2.0 / (self.radius * self.radius);
        let x = (s * form).mul_add(s, V::splat(simd, -1.0));
        s * nine(simd, self.sections.along(), x)
    }
}
