//! A camera before grids: view space, pixels, and how large things are at a depth.

use crate::{Camera, Grid, ImageDesc, Projection, ViewAxes, ViewRay};
use glam::{DMat3, DVec3};
use thiserror::Error;

/// View space and its pixels.
///
/// Points in view space are (right, up, depth) in world units: right and up from the optical axis,
/// depth along it *from the centre of what is seen*, so that turning the camera about that leaves the slabs
/// where they are ([model §3](crate::model)).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    axes: ViewAxes,
    eye: DVec3,
    center: DVec3,
    center_depth: f64,
    unit: f64,
    cells: Option<Cells>,
    projection: Projection,
    image_size: [u32; 2],
}

/// How footprints of cells differ from those of voxels.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cells {
    /// Voxels along a side.
    side: f64,
    /// What a cell adds to the variance of its voxels' footprints, over that of its own kernel.
    spread: f64,
}

/// Why there is no view.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[error(
    "a voxel step would be {pixels:.3e} pixels long, and can be {} to {}: check view_height, fov_y and eye",
    STEP_PIXELS.start(), STEP_PIXELS.end()
)]
#[non_exhaustive]
pub struct ViewError {
    /// Pixels that a step of the grid would be long, where it is seen largest or smallest.
    pub pixels: f64,
}

/// How large voxel steps may be seen, of whatever axis: squares of these fit 32-bit floats, and a picture
/// within a millionth of a voxel has one colour.
const STEP_PIXELS: std::ops::RangeInclusive<f64> = 1e-9..=1e12;

impl View {
    /// The view of `grid` through `camera` on an image.
    ///
    /// # Errors
    /// If a voxel step would be less than 10⁻⁹ or more than 10¹² pixels long, where it is drawn.
    pub fn new(grid: &Grid, camera: &Camera, image: &ImageDesc) -> Result<Self, ViewError> {
        Self::about(grid.center_in_world(), grid, camera, image)
    }

    /// The same of one of several grids, whose depths all count from `center`.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn about(
        center: DVec3,
        grid: &Grid,
        camera: &Camera,
        image: &ImageDesc,
    ) -> Result<Self, ViewError> {
        let axes = camera.axes();
        let view = Self {
            axes,
            eye: camera.eye(),
            center,
            center_depth: (center - camera.eye()).dot(axes.forward),
            unit: grid.unit(),
            cells: None,
            projection: camera.projection(),
            image_size: [image.width, image.height],
        };
        let [front, back] = view.from_index(grid).depth_range(grid);
        let near = view.near_depth();
        for depth in [front.max(near), back.max(near)] {
            let steps = grid.spacing().map(|step| view.pixels_per_world(depth) * step);
            if let Some(pixels) = steps.into_iter().find(|step| !STEP_PIXELS.contains(step)) {
                return Err(ViewError { pixels });
            }
        }
        Ok(view)
    }

    /// Right, up and forward in world space.
    pub fn axes(&self) -> &ViewAxes {
        &self.axes
    }

    /// Width and height of the image in pixels.
    pub fn image_size(&self) -> [u32; 2] {
        self.image_size
    }

    /// Whether rays leave the eye; otherwise they are parallel.
    pub fn is_perspective(&self) -> bool {
        matches!(self.projection, Projection::Perspective { .. })
    }

    /// The point at view space `(0, 0, 0)` and the matrix that takes index space to view space.
    pub fn from_index(&self, grid: &Grid) -> ViewFromIndex {
        let ViewAxes { right, up, forward } = self.axes;
        let view_from_world = DMat3::from_cols(right, up, forward).transpose();
        let whole = grid.uncropped();
        let first = DVec3::from_array(grid.first_voxel().map(|c| c as f64));
        let center_in_index = whole.center_in_index() - first;
        let center_in_view = view_from_world * (whole.center_in_world() - self.eye);
        let center_depth = (whole.center_in_world() - self.center).dot(forward);
        ViewFromIndex {
            matrix: view_from_world * grid.world_from_index().matrix3,
            center_in_index,
            center_in_view: center_in_view.with_z(center_depth),
        }
    }

    /// The depth of the eye from the centre.
    pub fn eye_depth(&self) -> f64 {
        -self.center_depth
    }

    /// Least depth at which anything of the grid is drawn, from the centre: the eye's plane in an
    /// orthographic view, one `unit` before the eye in a perspective one.
    pub fn near_depth(&self) -> f64 {
        let before_eye = if self.is_perspective() { self.unit } else { 0.0 };
        before_eye - self.center_depth
    }

    /// Whether the sections of a slab between two depths from the centre are drawn: in a perspective
    /// view if its middle, where they are projected, is not before the near depth; in an orthographic
    /// one if any of it lies behind the eye's plane.
    #[inline]
    pub fn draws_slab(&self, [front, back]: [f64; 2]) -> bool {
        if self.is_perspective() {
            self.near_depth() <= 0.5 * (front + back)
        } else {
            self.near_depth() < back
        }
    }

    /// Pixels per world unit at a depth from the centre; the depth must not lie before
    /// [`near_depth`](Self::near_depth).
    pub fn pixels_per_world(&self, depth: f64) -> f64 {
        let height = f64::from(self.image_size[1]);
        match self.projection {
            Projection::Orthographic { view_height } => height / view_height,
            Projection::Perspective { fov_y_radians } => {
                height / (2.0 * (0.5 * fov_y_radians).tan() * (depth + self.center_depth))
            }
        }
    }

    /// How far the ray of the image's corner, which no other ray exceeds, moves sideways per step in depth.
    pub fn steepest_ray(&self) -> f64 {
        let [width, height] = self.image_size.map(f64::from);
        match self.projection {
            Projection::Orthographic { .. } => 0.0,
            Projection::Perspective { fov_y_radians } => {
                (0.5 * fov_y_radians).tan() * (width / height).hypot(1.0)
            }
        }
    }

    /// The ray through a point of the image, in pixels from its upper left corner.
    #[inline]
    pub fn ray(&self, [x, y]: [f64; 2]) -> ViewRay {
        let [width, height] = self.image_size.map(f64::from);
        let from_axis = DVec3::new(x - 0.5 * width, 0.5 * height - y, 0.0);
        match self.projection {
            Projection::Orthographic { view_height } => {
                ViewRay { start: from_axis * (view_height / height), step: DVec3::Z }
            }
            Projection::Perspective { fov_y_radians } => {
                let slant = from_axis * (2.0 * (0.5 * fov_y_radians).tan() / height);
                ViewRay { start: slant * self.center_depth, step: slant + DVec3::Z }
            }
        }
    }

    /// Where view space has its origin: on the optical axis, as deep as the centre of what is seen.
    pub fn origin_in_world(&self) -> DVec3 {
        self.eye + self.axes.forward * self.center_depth
    }

    /// A point of view space in the world.
    pub fn world_from_view(&self, point: DVec3) -> DVec3 {
        let ViewAxes { right, up, forward } = self.axes;
        self.origin_in_world() + DMat3::from_cols(right, up, forward) * point
    }

    /// No footprint of cells is narrower. A layer that would need it is not drawn by cells; but a slab may
    /// be a little nearer to the eye than any voxel.
    pub const LEAST_STRETCH_OF_CELLS: f64 = 0.5;

    /// By how much footprints are widened where a pixel covers more than a voxel step
    /// ([model §5](crate::model)).
    pub fn stretch(&self, pixels_per_world: f64) -> f64 {
        let of_voxels = (1.0 / (pixels_per_world * self.unit)).max(1.0);
        self.cells.map_or(of_voxels, |Cells { side, spread }| {
            ((of_voxels / side).powi(2) - spread).max(Self::LEAST_STRETCH_OF_CELLS.powi(2)).sqrt()
        })
    }

    /// What a cell adds to the variance of its voxels' footprints, over that of its own kernel, if this is a
    /// view of cells; [`stretch`](Self::stretch) takes that off.
    pub fn spread_of_cells(&self) -> Option<f64> {
        self.cells.map(|cells| cells.spread)
    }

    /// The same view of cells, each of `2^level` voxels along every axis, by kernels whose variance along an
    /// axis is that, in cells. Their footprints are stretched so that a cell's is as wide as those of its
    /// voxels together ([model §16](crate::model)).
    #[must_use]
    pub fn of_cells(self, level: u32, kernel_variance: f64) -> Self {
        let side = f64::from(1_u32 << level);
        let spread = (1.0 - 1.0 / (side * side)) / (12.0 * kernel_variance);
        Self { cells: Some(Cells { side, spread }), ..self }
    }
}

/// Takes index space to view space; exact for voxels near the centre of the grid, or of the one that it was
/// cropped of, so that voxels of both have one position.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(clippy::exhaustive_structs, reason = "it is an affine map")]
pub struct ViewFromIndex {
    /// Takes steps in index space to steps in view space.
    pub matrix: DMat3,
    /// That centre in index space.
    pub center_in_index: DVec3,
    /// And in view space.
    pub center_in_view: DVec3,
}

impl ViewFromIndex {
    /// A point of index space in view space.
    #[inline]
    pub fn transform(&self, in_index: DVec3) -> DVec3 {
        self.matrix * (in_index - self.center_in_index) + self.center_in_view
    }

    /// The least and the largest depth of any voxel of `grid`.
    pub fn depth_range(&self, grid: &Grid) -> [f64; 2] {
        let half = grid.center_in_index();
        let depth_per_step = self.matrix.row(2).abs();
        let (middle, reach) = (self.transform(half).z, depth_per_step.dot(half));
        [middle - reach, middle + reach]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view(projection: Projection) -> (Grid, View) {
        let grid = Grid::with_spacing([3, 3, 5], [1.0, 1.0, 2.0]).unwrap();
        let target = grid.center_in_world();
        let camera = Camera::new(target + DVec3::Z * 20.0, target, DVec3::Y, projection).unwrap();
        let image = ImageDesc::new(40, 20);
        (grid, View::new(&grid, &camera, &image).unwrap())
    }

    #[test]
    fn view_refuses_what_no_number_holds() {
        let grid = Grid::with_spacing([3, 3, 5], [1.0, 1.0, 2.0]).unwrap();
        let refused = |projection, distance: f64| {
            let eye = grid.center_in_world() + DVec3::Z * distance;
            let camera = Camera::new(eye, grid.center_in_world(), DVec3::Y, projection).unwrap();
            let image = ImageDesc::new(40, 20);
            View::new(&grid, &camera, &image).err().map(|error| error.pixels)
        };
        let orthographic = |view_height| Projection::Orthographic { view_height };
        let perspective = |fov_y_radians| Projection::Perspective { fov_y_radians };
        for (projection, distance) in [
            (orthographic(1e-7), 9.0),
            (orthographic(1e9), 9.0),
            (perspective(1e-6), 1e6),
            (perspective(0.5), 1e9),
            (perspective(3.1), 0.1),
        ] {
            assert_eq!(refused(projection, distance), None, "{projection:?} {distance}");
        }
        for (projection, distance) in [
            (orthographic(1e-37), 9.0),
            (orthographic(1e300), 9.0),
            (perspective(1e-12), 9.0),
            (perspective(0.5), 1e100),
        ] {
            assert!(refused(projection, distance).is_some(), "{projection:?} {distance}");
        }
        assert_eq!(refused(orthographic(1e-12), 9.0), Some(2e13));
    }

    #[test]
    fn view_depth_is_from_grid_center() {
        let (grid, view) = view(Projection::Orthographic { view_height: 10.0 });
        let from_index = view.from_index(&grid);
        let corner = from_index.transform(DVec3::ZERO);
        assert!(corner.abs_diff_eq(DVec3::new(-1.0, -1.0, 4.0), 1e-12), "{corner}");
        assert_eq!(from_index.depth_range(&grid), [-4.0, 4.0]);
        assert_eq!(view.near_depth(), -20.0);
        assert!(view.draws_slab([-500.0, -19.9]) && !view.draws_slab([-21.0, -20.0]));
        assert_eq!(view.pixels_per_world(0.0), 2.0);
        assert_eq!(view.image_size(), [40, 20]);
    }

    #[test]
    fn view_of_coarse_voxels_from_aside() {
        let grid = Grid::with_spacing([3, 3, 3], [2.0; 3]).unwrap();
        let eye = grid.center_in_world() + DVec3::new(1.0, 0.5, 20.0);
        let projection = Projection::Orthographic { view_height: 10.0 };
        let camera = Camera::new(eye, eye - DVec3::Z, DVec3::Y, projection).unwrap();
        let view = View::new(&grid, &camera, &ImageDesc::default()).unwrap();
        let middle = view.from_index(&grid).transform(DVec3::ONE);
        assert!(middle.abs_diff_eq(DVec3::new(-1.0, -0.5, 0.0), 1e-12), "{middle}");
        assert_eq!(view.stretch(0.125), 4.0, "a step is a quarter of a pixel");
    }

    #[test]
    fn view_perspective_shrinks_with_depth() {
        let fov_y_radians = std::f64::consts::FRAC_PI_2;
        let (_, view) = view(Projection::Perspective { fov_y_radians });
        assert!((view.pixels_per_world(0.0) - 0.5).abs() < 1e-12);
        assert!((view.pixels_per_world(20.0) - 0.25).abs() < 1e-12);
        assert_eq!(view.near_depth(), -19.0);
        assert!(view.draws_slab([-20.0, -18.0]) && !view.draws_slab([-20.1, -18.1]));
        assert_eq!(view.stretch(0.25), 4.0);
        assert_eq!(view.stretch(3.0), 1.0);
        assert!((view.steepest_ray() - 5.0_f64.sqrt()).abs() < 1e-12);
    }
}
