//! The gradient of the density at a pixel of a sheet, from the pixels beside it and the sheets before and
//! behind.

use super::sheet::Sum;
use slabsplat_core::glam::DVec3;

/// What a gradient is taken from: the pixel's own sum, and pairs of neighbours' sums, the one with the larger
/// coordinate first.
#[derive(Clone, Copy, Debug)]
pub(super) struct Neighborhood {
    pub(super) here: Sum,
    pub(super) right_left: [Sum; 2],
    pub(super) up_down: [Sum; 2],
    pub(super) behind_before: [Sum; 2],
}

/// How far neighbours are apart.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spacing {
    /// World units from a pixel to the next.
    pub(super) pixel: f64,
    /// World units from a slab to the next, along the viewing direction.
    pub(super) slab: f64,
    /// World units to the right and upwards that the pixel's ray moves over one world unit of depth.
    pub(super) lean: [f64; 2],
    /// A gradient from which on surfaces are lit in full.
    pub(super) faint: f64,
}

impl Neighborhood {
    /// `−∇d/max(|∇d|, faint)` in view space.
    #[inline]
    pub(super) fn normal(&self, density: f64, spacing: &Spacing) -> DVec3 {
        let along = |pair: [Sum; 2]| difference(f64::from(self.here.length), density, pair);
        let right = along(self.right_left) / spacing.pixel;
        let up = along(self.up_down) / spacing.pixel;
        let along_ray = along(self.behind_before) / spacing.slab;
        let [lean_right, lean_up] = spacing.lean;
        // From a slab to the next, a pixel moves with its ray.
        let depth = along_ray - lean_right * right - lean_up * up;
        let gradient = DVec3::new(right, up, depth);
        -gradient / gradient.length().max(spacing.faint)
    }
}

/// The change of the density from a neighbour to this place and from here to the other one, weighted by how
/// much of each there is: a central difference within the grid, a one-sided one at its border, and next to
/// nothing where there is next to nothing on both sides.
#[inline]
fn difference(length: f64, density: f64, pair: [Sum; 2]) -> f64 {
    let [after, before] = pair.map(|sum| {
        let sum_length = f64::from(sum.length);
        (f64::from(sum.weighted) - sum_length * density, sum_length)
    });
    (after.0 - before.0) / (after.1 + before.1).max(length)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sum(length: f32, density: f32) -> Sum {
        Sum { length, weighted: length * density }
    }

    #[test]
    fn gradient_of_linear_density() {
        let check = |pair: [Sum; 2], expected: f64| {
            let actual = difference(1.0, 0.5, pair);
            assert!((actual - expected).abs() < 1e-6, "{pair:?}: {actual}");
        };
        check([sum(1.0, 0.75), sum(1.0, 0.25)], 0.25);
        check([sum(0.9, 0.75), sum(1.1, 0.25)], 0.25);
        check([sum(1.0, 0.75), Sum::default()], 0.25);
        check([Sum::default(), sum(1.0, 0.25)], 0.25);
        check([sum(0.1, 0.75), Sum::default()], 0.025);
        check([Sum::default(); 2], 0.0);
    }

    /// On a slanted ray the neighbouring slabs' pixels lie aside.
    #[test]
    fn gradient_along_a_slanted_ray() {
        let gradient = DVec3::new(0.1, -0.2, 0.3);
        let spacing = Spacing { pixel: 0.5, slab: 2.0, lean: [0.3, -0.4], faint: 1e-3 };
        let at = |x: f64, y: f64, z: f64| sum(1.0, gradient.dot(DVec3::new(x, y, z)) as f32);
        let ray = |z: f64| at(0.3 * z, -0.4 * z, z);
        let neighborhood = Neighborhood {
            here: at(0.0, 0.0, 0.0),
            right_left: [at(0.5, 0.0, 0.0), at(-0.5, 0.0, 0.0)],
            up_down: [at(0.0, 0.5, 0.0), at(0.0, -0.5, 0.0)],
            behind_before: [ray(2.0), ray(-2.0)],
        };
        let normal = neighborhood.normal(0.0, &spacing);
        assert!(normal.abs_diff_eq(-gradient.normalize(), 1e-6), "{normal}");
        let faint =
            neighborhood.normal(0.0, &Spacing { faint: 2.0 * gradient.length(), ..spacing });
        assert!((faint.length() - 0.5).abs() < 1e-6, "{faint}");
    }
}
