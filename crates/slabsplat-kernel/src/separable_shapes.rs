//! What separable sections look like in a view: their ellipses, and where they lie.
//!
//! In a view in which slab faces are parallel to the rays' normals in index space, too, every section of a
//! voxel has the shape of its whole footprint. On grids of unequal steps it has not: a *tilted* slab cuts out
//! of an ellipsoid what lies to one side before the voxel, and to the other side behind it, and is narrower
//! than all of it. A Gaussian is still one when it is cut at a single depth `Z`:
//!
//! ```text
//! r² = (p − m·Z)ᵀ C (p − m·Z) + (Z/λ)²        p: right and up in the image, λ: half_depth
//! F⁻¹ = C⁻¹ + λ²·m·mᵀ                          F: the form of the whole footprint, C: that of a cut
//! ```
//!
//! A section holds some depths. Its middle lies at `m` times their mean, and of the term with `m·mᵀ` it has
//! as much as the variance of these depths is of the whole kernel's. That differs from section to section,
//! but so little that the mean does for all: sections of all shapes of grids are then as near to exact ones
//! as those of cubic grids are. What `error` says is measured for the view that is asked for.

use crate::{FootprintShape, SectionTable, SeparableSections};
use slabsplat_core::glam::{DMat2, DVec2};

/// The shapes of separable sections in one view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeparableShapes {
    /// That of whole footprints; without tilt.
    pub whole: FootprintShape,
    /// That of what slabs cut; without tilt.
    pub cut: FootprintShape,
    /// How many times as high as a whole footprint of the same integral it is at its centre.
    pub cut_gain: f64,
    /// How far to the right and up a section's middle lies, in world units, if the mean of what it holds lies
    /// one index unit behind the voxel, across the slab.
    pub drift: [f64; 2],
    /// By how much any weight of any section is off at most.
    pub error: f64,
}

/// How many times as far off sections may be for having the shape of whole footprints.
const AS_GOOD: f64 = 1.1;

/// Slabs for which sections are compared, and points along each axis of the image.
const N_SLABS: usize = 9;
const N_POINTS: usize = 11;

impl SeparableShapes {
    /// Those of sections by slabs of `width` world units, of which `table` is the exact one.
    pub fn new(
        sections: &SeparableSections,
        table: &SectionTable,
        shape: &FootprintShape,
        width: f64,
    ) -> Self {
        let without_tilt = FootprintShape { tilt: [0.0; 2], ..*shape };
        if !shape.is_tilted(sections.radius()) {
            return Self {
                whole: without_tilt,
                cut: without_tilt,
                cut_gain: 1.0,
                drift: [0.0; 2],
                error: sections.error(),
            };
        }
        let FormAndTilt { form, tilt } = FormAndTilt::of(shape);
        let of_cut = form + DMat2::from_cols(tilt * tilt.x, tilt * tilt.y);
        let slope = -shape.index_per_depth * (of_cut.inverse() * tilt);
        let left = sections.variance_left(width / shape.half_depth);
        let drift = slope * shape.half_depth;
        let spread = DMat2::from_cols(drift * drift.x, drift * drift.y) * left;
        let form_of_sections = (of_cut.inverse() + spread).inverse();
        let mut shapes = Self {
            whole: without_tilt,
            cut: with_form(without_tilt, form_of_sections),
            cut_gain: (form_of_sections.determinant() / form.determinant()).sqrt(),
            drift: drift.to_array(),
            error: 0.0,
        };
        let error_of =
            |shapes: &Self| shapes.error_of(sections, table, shape, width).max(sections.error());
        shapes.error = error_of(&shapes);
        // Of slabs that are hardly tilted, whole footprints and what is cut are as good in one shape.
        let mut alike = Self { cut: without_tilt, cut_gain: 1.0, ..shapes };
        alike.error = error_of(&alike);
        if alike.error <= AS_GOOD * shapes.error { alike } else { shapes }
    }

    /// How far sections are from exact ones.
    fn error_of(
        &self,
        sections: &SeparableSections,
        table: &SectionTable,
        shape: &FootprintShape,
        width: f64,
    ) -> f64 {
        let radius = sections.radius();
        let thickness = 2.0 * radius * shape.half_depth + width;
        let position = |idx: usize| 2.0 * (idx as f64 + 0.5) / N_POINTS as f64 - 1.0;
        let mut worst = 0.0_f64;
        for slab in 0..N_SLABS {
            let back = thickness * ((slab as f64 + 0.5) / N_SLABS as f64 - 0.5) + 0.5 * width;
            let faces = [back - width, back];
            for (i, j) in (0..N_POINTS).flat_map(|i| (0..N_POINTS).map(move |j| (i, j))) {
                let [w, h] = shape.half_extent.map(|half| radius * half);
                let p = DVec2::new(w * position(i), h * position(j));
                let exact = exact_weight(table, shape, radius, p, faces);
                worst = worst.max((exact - self.weight(sections, p, faces)).abs());
            }
        }
        worst
    }

    /// The weight of the section between two faces, in world units behind the voxel, at `p` to the right and
    /// up of it.
    pub fn weight(&self, sections: &SeparableSections, p: DVec2, faces: [f64; 2]) -> f64 {
        let across_slab = faces.map(|face| face / self.whole.half_depth);
        let [factor, moment] = sections.factor_and_moment(across_slab);
        if factor <= 0.0 {
            return 0.0;
        }
        let p = p - DVec2::from_array(self.drift) * (moment / factor);
        let FootprintShape { across, shear, along, .. } = self.cut;
        let u = across.sqrt() * (p.x + shear * p.y) / sections.radius();
        let v = along.sqrt() * p.y / sections.radius();
        self.cut_gain * factor * sections.profile_at(u) * sections.profile_at(v)
    }
}

/// The weight of a section, read from its table.
fn exact_weight(
    table: &SectionTable,
    shape: &FootprintShape,
    radius: f64,
    p: DVec2,
    faces: [f64; 2],
) -> f64 {
    let FormAndTilt { form, tilt } = FormAndTilt::of(shape);
    let rho = p.dot(form * p).sqrt();
    if radius <= rho {
        return 0.0;
    }
    let [front, back] = faces.map(|face| (face * shape.index_per_depth + tilt.dot(p)) as f32);
    table.sample(rho as f32, front, back).into()
}

struct FormAndTilt {
    /// `ρ² = pᵀ F p`.
    form: DMat2,
    tilt: DVec2,
}

impl FormAndTilt {
    fn of(shape: &FootprintShape) -> Self {
        let FootprintShape { across, shear, along, tilt, .. } = *shape;
        let mixed = across * shear;
        let form = DMat2::from_cols_array(&[across, mixed, mixed, along + mixed * shear]);
        Self { form, tilt: tilt.into() }
    }
}

/// The shape with another form.
fn with_form(shape: FootprintShape, form: DMat2) -> FootprintShape {
    let [a, b, _, d] = form.to_cols_array();
    let inverse = form.inverse();
    FootprintShape {
        across: a,
        shear: b / a,
        along: d - b * b / a,
        half_extent: [inverse.x_axis.x, inverse.y_axis.y].map(f64::sqrt),
        ..shape
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{SectionDesc, TableDesc, kernel_named};
    use slabsplat_core::glam::DVec3;
    use slabsplat_core::{Camera, Grid, Lookup, Normalization, Projection};
    use slabsplat_seeds::for_each_seed;

    /// Sections of `gaussian` on a grid of those steps, seen from there.
    fn seen(spacing: [f64; 3], [eye, up]: [DVec3; 2]) -> (SeparableSections, SeparableShapes) {
        let grid = Grid::with_spacing([2; 3], spacing).unwrap();
        let projection = Projection::Orthographic { view_height: 1.0 };
        let camera = Camera::new(eye, DVec3::ZERO, up, projection).unwrap();
        let shape = FootprintShape::new(&grid, &camera.axes());
        let kernel = kernel_named("gaussian").unwrap();
        let (kappa, normalization) = (shape.kappa, Normalization::None);
        let table = |width: f64| {
            let desc =
                SectionDesc { kernel: &*kernel, width, kappa, normalization, base_width: 0.5 };
            let table = TableDesc { sections: 128, radial_samples: 128, lookup: Lookup::Linear };
            SectionTable::new(&desc, table)
        };
        let slabs = table(1.0);
        let sections = SeparableSections::new(&slabs, &table(4.0 / kappa));
        let shapes = SeparableShapes::new(&sections, &slabs, &shape, 1.0);
        (sections, shapes)
    }

    /// Whatever the steps of a grid are, and wherever it is seen from.
    #[test]
    fn separable_shapes_are_nearly_the_sections() {
        for_each_seed(1, |mut rng| {
            let mut worst = 0.0_f64;
            for _ in 0..60 {
                let spacing = [1.0, 1.0 + 2.0 * rng.f64(), 1.0 + 2.0 * rng.f64()];
                let mut random = || DVec3::from_array([0; 3].map(|_| rng.f64() - 0.5));
                let (sections, shapes) = seen(spacing, [random(), random()]);
                let error = sections.error();
                println!("{spacing:.2?}: {:.2e} {error:.2e} {:.2}", shapes.error, shapes.cut_gain);
                worst = worst.max(shapes.error / error);
            }
            println!("{worst}");
            assert!(worst < 1.2, "{worst}");
        });
    }

    #[test]
    fn slabs_that_are_hardly_tilted_have_one_shape() {
        let view = [DVec3::new(2.8, 1.8, 1.4), DVec3::Z];
        let (_, hardly) = seen([1.0, 1.0, 1.02], view);
        assert!(hardly.cut == hardly.whole && hardly.cut_gain == 1.0, "{hardly:?}");
        assert!(hardly.drift != [0.0; 2], "their middles lie beside the voxel");
        let (_, tilted) = seen([1.0, 1.0, 1.5], view);
        assert!(tilted.cut != tilted.whole && 1.0 < tilted.cut_gain, "{tilted:?}");
    }
}
