//! How much work the slabs of a frame make, bounded before it begins.
//!
//! In proportion to voxels and pixels anything is drawn, however large. What slabs add to that has a limit:
//! a few thousand voxels whose steps are very unequal, or very thin slabs, would take minutes or hours. The
//! bounds do not depend on the view, as a camera that turns must not meet an error on its way.

use slabsplat_core::glam::DVec3;
use slabsplat_core::{Grid, Method};

use crate::{DensitySplats, PlanError};

/// The slabs of a frame, and what they cut.
pub(crate) struct SlabWork<'a, G> {
    /// Of all layers.
    pub(crate) grids: G,
    /// [`Method::ImageAligned`] or [`Method::PostClassified`].
    pub(crate) method: Method,
    /// Of the kernel, in index units.
    pub(crate) radius: f64,
    /// The setting, in the shortest voxel steps of all layers.
    pub(crate) slab_width: f64,
    /// Of the picture.
    pub(crate) n_pixels: usize,
    /// Whether [`Method::EverySample`] shows the same scene. Only the error asks.
    pub(crate) is_drawn_by_every_sample: &'a dyn Fn() -> bool,
}

/// Any number of voxels may have kernels up to so many slabs deep, which of image-aligned slabs is steps 64
/// times as long as others. A cubic grid's are four.
const SLABS_OF_ANY_KERNEL: f64 = 256.0;

/// Sections of deeper kernels, all together. Of long and thin kernels one takes some 0.5 µs, so that these
/// are some fifteen seconds of a processor at most.
const MAX_SECTIONS: f64 = 33_554_432.0;

/// How many times as long as a section of colours one of densities took then: 3 µs.
const DENSITY_SECTIONS_PER_COLOR: f64 = 6.0;

/// There may be so many slabs for each voxel along the three axes, whatever the picture's size.
const SLABS_OF_ANY_STEP: f64 = 64.0;

/// Pixels of all sheets together where there are more slabs. One takes some nanoseconds.
const MAX_SHEET_PIXELS: f64 = 8_589_934_592.0;

/// How many times as long as a pixel of colours one of densities takes, of which a slab has two sheets of six
/// that are needed for each.
const DENSITIES_PER_COLOR: f64 = 8.0;

impl<'a, G: Iterator<Item = &'a Grid> + Clone> SlabWork<'_, G> {
    /// # Errors
    /// If slabs make more work than that; the error says which width makes little enough.
    pub(crate) fn check(&self) -> Result<(), PlanError> {
        self.check_sections()?;
        self.check_sheets()
    }

    /// Bounds the sections of all kernels that are deep.
    fn check_sections(&self) -> Result<(), PlanError> {
        let deep = self.grids.clone().filter(|grid| SLABS_OF_ANY_KERNEL < self.n_slabs(grid));
        let n_sections: f64 = deep.clone().map(|grid| self.n_sections(grid)).sum();
        let cost = if self.is_of_densities() { DENSITY_SECTIONS_PER_COLOR } else { 1.0 };
        if n_sections * cost <= MAX_SECTIONS {
            return Ok(());
        }
        let deepest = deep.clone().map(|grid| self.n_slabs(grid)).fold(0.0, f64::max);
        let excess = (n_sections * cost / MAX_SECTIONS).min(deepest / SLABS_OF_ANY_KERNEL);
        let worst = deep.max_by(|a, b| self.n_sections(a).total_cmp(&self.n_sections(b)));
        Err(self.too_much("sections of kernels", n_sections, excess, worst))
    }

    /// Bounds the pixels of all sheets, of which one takes time even where it holds little.
    fn check_sheets(&self) -> Result<(), PlanError> {
        let n_slabs = self.depth() / self.thickness();
        let n_steps = self.grids.clone().map(|grid| grid.dims().iter().sum::<usize>()).max();
        let n_free = SLABS_OF_ANY_STEP * n_steps.unwrap_or(0) as f64;
        let cost = if self.is_of_densities() { DENSITIES_PER_COLOR } else { 1.0 };
        let n_pixels = n_slabs * self.n_pixels as f64;
        let excess = (n_pixels * cost / MAX_SHEET_PIXELS).min(n_slabs / n_free);
        if excess <= 1.0 {
            return Ok(());
        }
        let longest = self.grids.clone().max_by(|a, b| longest(a).total_cmp(&longest(b)));
        Err(self.too_much("pixels of sheets", n_pixels, excess, longest))
    }

    fn too_much(&self, of: &'static str, n: f64, excess: f64, grid: Option<&Grid>) -> PlanError {
        let [x, y, z] = grid.map_or([0.0; 3], Grid::spacing);
        PlanError::TooMuchWork {
            n,
            of,
            spacing: format!("{x} x {y} x {z}"),
            cause: grid.map_or_else(String::new, |grid| self.cause(grid)),
            wide_enough: rounded_up(self.slab_width * excess),
            is_drawn_by_every_sample: (self.is_drawn_by_every_sample)(),
        }
    }

    /// What makes kernels of a layer deep, or slabs many: what of three has the most part in it.
    fn cause(&self, grid: &Grid) -> String {
        let unequal = longest(grid) / grid.unit();
        let others = grid.unit() / self.unit();
        let thin = self.slab_width.recip();
        if others.max(thin) <= unequal {
            format!("its longest voxel step is {unequal:.0} times its shortest")
        } else if thin <= others {
            format!("its voxel steps are {others:.0} times those of another layer")
        } else {
            format!("slabs are {} voxel steps wide", self.slab_width)
        }
    }

    /// How many sections all kernels of a layer have, at most.
    fn n_sections(&self, grid: &Grid) -> f64 {
        let sheets = if self.is_of_densities() { DensitySplats::SHEETS_PER_SLAB } else { 1.0 };
        sheets * grid.n_voxels() as f64 * self.n_slabs(grid)
    }

    /// How many slabs a kernel of the layer is deep, seen along its longest step.
    fn n_slabs(&self, grid: &Grid) -> f64 {
        2.0 * self.radius * longest(grid) / self.thickness()
    }

    /// From one side of all kernels to the other, wherever they are seen from.
    fn depth(&self) -> f64 {
        let corners = self.grids.clone().flat_map(Grid::corners_in_world);
        let nothing = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        let [min, max] = corners.fold(nothing, |[min, max], at| [min.min(at), max.max(at)]);
        let longest = self.grids.clone().map(longest).fold(0.0, f64::max);
        (max - min).length() + 2.0 * self.radius * longest
    }

    fn thickness(&self) -> f64 {
        self.slab_width * self.unit()
    }

    /// The shortest voxel step of any layer.
    fn unit(&self) -> f64 {
        self.grids.clone().map(Grid::unit).fold(f64::INFINITY, f64::min)
    }

    fn is_of_densities(&self) -> bool {
        self.method == Method::PostClassified
    }
}

/// The longest voxel step.
fn longest(grid: &Grid) -> f64 {
    grid.spacing().into_iter().fold(0.0, f64::max)
}

/// To three digits, as what is written must be enough, too.
fn rounded_up(width: f64) -> f64 {
    let scale = 10.0_f64.powf(2.0 - width.log10().floor());
    (width * scale).ceil() / scale
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(dims: [usize; 3], spacing: [f64; 3]) -> Grid {
        Grid::with_spacing(dims, spacing).unwrap()
    }

    fn error(grids: &[Grid], method: Method, slab_width: f64, side: usize) -> Option<PlanError> {
        let n_pixels = side * side;
        let work = SlabWork {
            grids: grids.iter(),
            method,
            radius: 2.0,
            slab_width,
            n_pixels,
            is_drawn_by_every_sample: &|| false,
        };
        work.check().err()
    }

    const METHODS: [Method; 2] = [Method::ImageAligned, Method::PostClassified];

    #[test]
    fn work_of_sensible_scenes_has_room() {
        let check = |grids: &[Grid], slab_width: f64, side: usize| {
            for method in METHODS {
                assert_eq!(error(grids, method, slab_width, side), None, "{method} {grids:?}");
            }
        };
        let thousand = grid([1000; 3], [1.0; 3]);
        check(std::slice::from_ref(&thousand), 1.0, 4096);
        check(std::slice::from_ref(&thousand), 0.1, 4096);
        check(&[grid([512, 512, 30], [0.2, 0.2, 10.0])], 1.0, 2048);
        check(&[grid([2048, 2048, 100], [4.0, 4.0, 40.0])], 0.5, 4096);
        check(&[thousand, grid([64; 3], [16.0; 3])], 1.0, 4096);
        check(&[grid([20; 3], [1.0; 3])], 1.0 / 16.0, 4096);
        check(&[grid([1; 3], [1.0; 3])], 1.0, 8192);
        // Needles: few, and a thousand times as long as wide.
        check(&[grid([3; 3], [1.0, 1.0, 1000.0])], 1.0, 24);
        check(&[grid([3; 3], [1.0, 1.0, 1000.0])], 1.0, 256);
    }

    /// Each is refused, with the cause that it has, up to the width that the error names.
    #[test]
    fn work_without_sense_is_refused() {
        let check = |grids: &[Grid], slab_width: f64, side: usize, expected: &str| {
            for method in METHODS {
                let refused = error(grids, method, slab_width, side);
                let Some(PlanError::TooMuchWork { cause, wide_enough, .. }) = &refused else {
                    panic!("{method} {grids:?}: {refused:?}");
                };
                assert!(cause.contains(expected), "{cause}");
                // What was too much of one kind may still be of the other.
                let mut width = *wide_enough;
                while let Some(PlanError::TooMuchWork { wide_enough, .. }) =
                    error(grids, method, width, side)
                {
                    assert!(width < wide_enough, "{method} {grids:?}: {width}, {wide_enough}");
                    width = wide_enough;
                }
                let narrower = 0.9 * wide_enough;
                assert!(error(grids, method, narrower, side).is_some(), "{method} {grids:?}");
            }
        };
        let unequal = "longest voxel step is 1600 times its shortest";
        check(&[grid([16, 16, 30], [1.0, 1.0, 1600.0])], 1.0, 512, unequal);
        check(&[grid([16, 16, 30], [1600.0, 1600.0, 1.0])], 1.0, 512, unequal);
        check(&[grid([64; 3], [1.0, 1.0, 100.0])], 1.0, 300, "100 times");
        check(&[grid([20; 3], [1.0; 3])], 0.0005, 300, "slabs are 0.0005 voxel steps wide");
        check(&[grid([2; 3], [1.0; 3])], 0.001, 4096, "slabs are 0.001 voxel steps wide");
        let layers = [grid([24; 3], [1.0; 3]), grid([2; 3], [1e-3; 3])];
        check(&layers, 1.0, 512, "1000 times those of another layer");
        let far = DVec3::new(1e6, 0.0, 0.0);
        let moved = slabsplat_core::glam::DAffine3::from_translation(far);
        let apart = [grid([2; 3], [1.0; 3]), Grid::new([2; 3], moved).unwrap()];
        check(&apart, 1.0, 512, "longest voxel step");
    }
}
