//! Which voxels around a part have a share in its picture (model §17).

use crate::PlanError;
use crate::seen_layer::SeenGrid;
use slabsplat_core::glam::{DMat3, DVec3};
use slabsplat_core::{Camera, Grid, ImageDesc, PartSupport, RenderSettings, View};
use slabsplat_kernel::{DetailLevels, ErrorBudget, Kernel, SplitLevels};

/// A scene that is drawn in parts, without its voxels.
#[derive(Clone, Copy, Debug)]
#[expect(clippy::exhaustive_structs, reason = "it is what decides how far voxels reach")]
pub struct SceneInParts<'a> {
    /// The grids of all layers, whole.
    pub grids: &'a [Grid],
    /// Who sees them.
    pub camera: &'a Camera,
    /// On which picture.
    pub image: &'a ImageDesc,
    /// How.
    pub settings: &'a RenderSettings,
}

impl SceneInParts<'_> {
    /// How many times as far sideways as its kernel a separable footprint may have a say, however little: it
    /// is a spline, of rows that are up to a quarter of the radius apart and reach three rows further.
    pub const WIDER_WHERE_SEPARABLE: f64 = 1.75;

    /// How many steps of `grid`, one of the scene's, along each axis a voxel may lie outside of a part that
    /// shows anything of it: the kernel's support, as wide as it is drawn where a pixel is largest, the slabs
    /// that it may be put off to, and one step more for gradients. Those further away change nothing. Cells
    /// reach no further from their middles.
    ///
    /// # Errors
    /// If the grid cannot be seen.
    pub(crate) fn support(
        &self,
        grid: &Grid,
        kernel: &dyn Kernel,
    ) -> Result<PartSupport, PlanError> {
        let Self { grids, camera, image, settings } = *self;
        let center = Grid::center_of_all(grids);
        let view = View::about(center, grid, camera, image)?;
        let levels = DetailLevels::new(kernel, ErrorBudget::new(settings).among(grids.len()));
        let radius = kernel.radius();
        let coarsest = SeenGrid::new(0, grid, view, radius).coarsest(grid, &levels);
        let steps = self.steps(grid, &view, radius);
        Ok(PartSupport::of_voxels(steps).with_cells(coarsest))
    }

    fn steps(&self, grid: &Grid, view: &View, radius: f64) -> [f64; 3] {
        let Self { grids, settings, .. } = *self;
        let from_index = view.from_index(grid);
        let m = from_index.matrix;
        let kernel = [0, 1, 2].map(|axis| radius * m.row(axis).length());
        let farthest = from_index.depth_range(grid)[1].max(view.near_depth()) + kernel[2];
        let stretch = view.stretch(view.pixels_per_world(farthest));
        let has_tolerance = 0.0 < settings.tolerance;
        let unit = grids.iter().map(Grid::unit).fold(f64::INFINITY, f64::min);
        let thickness = settings.slab_width * unit;
        // From where a ray is in the part to the middle of its slab, and to the other end of that slab or of
        // one that the voxel was put off to.
        let n_slabs = 1.0 + if has_tolerance { SplitLevels::MOST_SLABS_BEFORE as f64 } else { 0.0 };
        let slanted = 0.5 * view.steepest_ray() * thickness;
        let beside = DVec3::new(slanted, slanted, n_slabs * thickness);
        let sideways = Self::WIDER_WHERE_SEPARABLE * stretch;
        let rectangle = DVec3::from_array(kernel) * DVec3::new(sideways, sideways, 1.0);
        let index_from_view = m.inverse();
        let of_box = |half: DVec3| -> [f64; 3] {
            let rows = DMat3::transpose(&index_from_view);
            [rows.x_axis, rows.y_axis, rows.z_axis].map(|row| row.abs().dot(half))
        };
        // With a tolerance footprints are rectangles, without one they are ellipses.
        let stretched =
            index_from_view * DMat3::from_diagonal(DVec3::new(stretch, stretch, 1.0)) * m;
        let ellipsoid = [0, 1, 2].map(|axis| radius * stretched.row(axis).length());
        let footprint = if has_tolerance { of_box(rectangle) } else { ellipsoid };
        let beside = of_box(beside);
        [0, 1, 2].map(|axis| (footprint[axis] + beside[axis]).ceil() + OF_GRADIENTS)
    }
}

/// Steps that a gradient looks around a voxel.
const OF_GRADIENTS: f64 = 1.0;
