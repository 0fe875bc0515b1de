//! From slopes to normals, of eight pixels at once (model §8).

use super::nodes::OnPart;
use super::rays::Rays;
use super::sheets::{Eight, LANES};
use fearless_simd::Simd;
use slabsplat_backend::LayerPlan;
use slabsplat_backend::densities::FAINT_GRADIENT;
use slabsplat_core::SlabGrid;

/// Slopes on eight parts: to the right and upwards per world unit, along the ray per sheet.
pub(super) struct Slopes {
    /// Where the parts begin.
    starts: [Eight; 3],
    /// From the start to the end.
    changes: [Eight; 3],
    /// Four times how much more they are half way than in the mean of both.
    bulges: [Eight; 3],
}

/// Makes normals of slopes.
pub(super) struct Normals {
    rays: Rays,
    /// A gradient from which on surfaces are lit in full: scaled, per world unit.
    faint: f32,
    /// Sheets in a world unit.
    per_sheet: f32,
}

impl Slopes {
    #[inline(always)]
    pub(super) fn of<S: Simd>(slopes: &[OnPart<S>; 3]) -> Self {
        let zero = [[0.0; LANES]; 3];
        let mut of_parts = Self { starts: zero, changes: zero, bulges: zero };
        for (axis, slope) in slopes.iter().enumerate() {
            let [start, end] = slope.ends;
            of_parts.starts[axis] = start.into();
            of_parts.changes[axis] = (end - start).into();
            of_parts.bulges[axis] = (slope.bulge * 4.0).into();
        }
        of_parts
    }

    /// Those at a position of each part, 0 to 1.
    #[inline(always)]
    pub(super) fn at(&self, positions: &Eight) -> [Eight; 3] {
        let mut slopes = [[0.0; LANES]; 3];
        for (axis, slopes) in slopes.iter_mut().enumerate() {
            let (starts, changes) = (&self.starts[axis], &self.changes[axis]);
            for lane in 0..LANES {
                let t = positions[lane];
                let curve = t * (1.0 - t) * self.bulges[axis][lane];
                slopes[lane] = starts[lane] + t * changes[lane] + curve;
            }
        }
        slopes
    }
}

impl Normals {
    /// In sheets as thick as `slabs`, of values of which the finite ones have that scaled extent. Pixels are
    /// counted from the corner of a border of that many.
    pub(super) fn new(layer: &LayerPlan<'_>, slabs: &SlabGrid, extent: f64, border: usize) -> Self {
        let faint = FAINT_GRADIENT * extent / layer.volume.grid().unit();
        Self {
            rays: Rays::new(&layer.view, border),
            // Never 0, which a gradient of 0 would be divided by.
            faint: (faint as f32).max(f32::MIN_POSITIVE),
            per_sheet: (1.0 / slabs.thickness()) as f32,
        }
    }

    /// How the rays of eight pixels from that one on are slanted.
    #[inline(always)]
    pub(super) fn slants(&self, first_pixel: [usize; 2]) -> [Eight; 2] {
        self.rays.slants(first_pixel)
    }

    /// `−∇d/max(|∇d|, faint)`, to the right, upwards and forward.
    #[inline(always)]
    pub(super) fn of(&self, [right, up, along]: &[Eight; 3], slants: &[Eight; 2]) -> [Eight; 3] {
        let mut normals = [[0.0; LANES]; 3];
        for lane in 0..LANES {
            // From a sheet to the next, a pixel moves with its ray.
            let depth = along[lane] * self.per_sheet
                - slants[0][lane] * right[lane]
                - slants[1][lane] * up[lane];
            let squared = right[lane] * right[lane] + up[lane] * up[lane] + depth * depth;
            let factor = -1.0 / squared.sqrt().max(self.faint);
            normals[0][lane] = right[lane] * factor;
            normals[1][lane] = up[lane] * factor;
            normals[2][lane] = depth * factor;
        }
        normals
    }
}
