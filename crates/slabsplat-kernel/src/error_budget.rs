//! What a pixel may be off, and what may spend it: the one table of it.
//!
//! | spent by | at most | where | why so much |
//! | --- | --- | --- | --- |
//! | merged sections (model §7) | the tolerance | `split_levels.rs` | they save most |
//! | levels of detail (model §16) | twice of it, for the contrast of a brick's cells | `detail_levels.rs` | measured: a pixel tells a fifth of that at most, and stripes and ramps no more with four times as much as with half of it |
//! | the same | twice of it, for colours that differ from voxel to voxel without order | `detail_levels.rs` | in the image plane a pixel takes others of them, and tells half of that at most |
//! | the same, in light by the mean of normals, and by second moments too | two thirds of it; just over it | `detail_levels.rs` | both grow with the root of the extinction |
//! | the same in depth | two and a half times it, for cells as unlike within themselves as they are | `detail_levels.rs` | only stripes along the image plane that alternate from voxel to voxel come near it |
//! | separable footprints | an eighth of it, for a voxel | `slabsplat-cpu` | their errors have either sign, and one voxel hides others |
//! | separable footprints of densities | an eighth of it, of a voxel's weight | `slabsplat-cpu` | what is as dense everywhere looks just as it should |
//! | polynomials | a hundredth of it, for the most opaque voxel; a twentieth, for a pixel of any | `slabsplat-cpu` | they are fitted so well anyway |
//! | polynomials, exact pictures | 5·10⁻⁴ for a voxel: half of what a pixel may be | `slabsplat-cpu` | else the table is read |
//! | polynomials of low degree, exact pictures | 1.5·10⁻⁴ for a voxel | `slabsplat-cpu` | faint voxels alone may spend it |
//!
//! Each share is for one voxel or one face, and a pixel sees several; [numerics] has what they add up to: of
//! the tolerance of 0.05 that pictures have by default, 0.02 at most in random scenes, and 2 of 255 in scans.
//!
//! [numerics]: https://github.com/slabsplat/slabsplat/blob/main/docs/numerics.md

use slabsplat_core::{Compositing, Method, Normalization, RenderSettings};

/// What one picture may be off, and by whom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorBudget {
    tolerance: f64,
}

/// No pixel sees more layers of voxels than this merged across one face: a kernel has a support of
/// [`MAX_RADIUS`](crate::MAX_RADIUS) steps, and layers lie one step apart.
const LAYERS_PER_FACE: f64 = crate::MAX_RADIUS;

impl ErrorBudget {
    /// What a voxel's sections by polynomials of low degree may be off together, times its extinction, in any
    /// picture.
    pub const LOW_DEGREE: f64 = 1.5e-4;

    /// What a pixel may be off for one voxel's section by polynomials, in an exact picture: half of what it
    /// may be for all voxels ([model §9](slabsplat_core::model)). Sections of a Gaussian stay below a third
    /// of that, those of `crawfis-max`, which is in two pieces, just below it; normalised ones, products of
    /// others or a root of them, may be beyond.
    pub const EXACT_SECTION: f64 = 5e-4;

    /// A kernel whose sections are further from separable ones is not separable; a Gaussian that ends at R =
    /// 2 is off by 1.5·10⁻³.
    pub const SEPARABLE_KERNEL: f64 = 5e-3;

    /// The budget of pictures with these settings: none where the picture depends on the slab width by
    /// definition, and a tolerance has no effect.
    pub fn new(settings: &RenderSettings) -> Self {
        let is_additive = settings.method == Method::ImageAligned
            && settings.mode.compositing().is_some_and(Compositing::sums_extinction)
            && settings.normalization == Normalization::None;
        Self { tolerance: if is_additive { settings.tolerance } else { 0.0 } }
    }

    /// The budget of densities, whose sections are never normalised: what a section may be off there changes
    /// by how much a voxel counts in a mean of values, and not how much there is.
    pub fn of_densities(settings: &RenderSettings) -> Self {
        Self { tolerance: settings.tolerance }
    }

    /// What each of so many layers may spend, where all spend it of the same pixels.
    #[must_use]
    pub fn among(self, n_layers: usize) -> Self {
        Self { tolerance: self.tolerance / n_layers.max(1) as f64 }
    }

    /// Extinction that a layer of voxels may have merged across a face.
    pub fn per_face(self) -> f64 {
        self.tolerance / LAYERS_PER_FACE
    }

    /// Extinction of all layers of voxels, from a face to the middle of the slab, that may be drawn whole in
    /// that slab; of cells, that of the voxels for which they stand.
    pub fn per_thick_slab(self) -> f64 {
        self.tolerance
    }

    /// What a pixel may tell of that cells lie otherwise in depth than their voxels, by how much cells side
    /// by side differ.
    pub fn cells(self) -> f64 {
        2.0 * self.tolerance
    }

    /// The standard deviation of colours that differ from voxel to voxel without any order, times the root of
    /// the extinction: the part of a pixel's noise that depends on which voxels it sees, of some `10/μ`. What
    /// cells change of that is a fifth, in the mean of squares, and the worst of thousands of pixels is off
    /// by four and a half times as much.
    pub fn noise_of_cells(self) -> f64 {
        2.0 * self.tolerance
    }

    /// The same of colours that differ from cell to cell: a fifth of the tolerance if voxels are black and
    /// white, of which cells of eight differ by a quarter.
    pub fn steps_of_cells(self) -> f64 {
        self.tolerance / 20.0
    }

    /// By how much colours may differ from one layer of cells to the next however opaque they are: what a
    /// pixel tells of where in its cell a border lies is a fourth of it at most.
    pub fn contrast_of_cells(self) -> f64 {
        4.0 * self.tolerance
    }

    /// What cells may tell in depth, of how unlike their voxels are.
    pub fn spread_of_cells(self) -> f64 {
        2.5 * self.tolerance
    }

    /// The extinction of cells up to which these may be lit by mean normals, and up to which by second
    /// moments, too, if light makes no more of normals than 1.
    ///
    /// What light makes of eight random normals is off by 0.075 in the mean of squares as told by their mean,
    /// by 0.027 with second moments. A pixel sees the mean of some `2.2/μ` cells: five across, as many in
    /// depth as it takes to hide what is behind. The worst of thousands of pixels is off by four and a half
    /// times the root of the mean of squares: by `0.22·√μ` and `0.08·√μ`. The first may be two thirds of the
    /// tolerance, the second, which opaque scans stay far below, somewhat more than it.
    pub fn light_of_cells(self) -> [f64; 2] {
        [3.0, 14.0].map(|per_tolerance| (per_tolerance * self.tolerance).powi(2))
    }

    /// Whether nothing may be off at all.
    pub fn is_exact(self) -> bool {
        self.tolerance <= 0.0
    }

    /// What a voxel's separable section may be off.
    pub fn separable(self) -> f64 {
        self.tolerance / 8.0
    }

    /// What the weight of the most opaque voxel's section by a polynomial may be off.
    pub fn polynomial(self) -> f64 {
        self.tolerance / 100.0
    }

    /// What a pixel may be off for one voxel's section by a polynomial, whatever its extinction.
    pub fn polynomial_pixel(self) -> f64 {
        self.tolerance / 20.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::Mode;

    #[test]
    fn budget_is_for_additive_pictures() {
        let settings = RenderSettings::default().tolerance(0.04);
        let budget = ErrorBudget::new(&settings);
        assert_eq!((budget.per_face(), budget.per_thick_slab()), (0.02, 0.04));
        assert_eq!((budget.separable(), budget.cells()), (0.005, 0.08));
        assert_eq!((budget.polynomial(), budget.polynomial_pixel()), (0.0004, 0.002));
        assert_eq!(budget.among(2).per_thick_slab(), 0.02);
        let separate = settings.clone().mode(Mode::Separate);
        assert_eq!(ErrorBudget::of_densities(&separate), budget, "they are means");
        for settings in [
            settings.clone().method(Method::AxisAligned),
            settings.clone().mode(Mode::Separate),
            settings.normalization(Normalization::Paper),
        ] {
            assert_eq!(ErrorBudget::new(&settings), ErrorBudget { tolerance: 0.0 }, "{settings:?}");
        }
    }
}
