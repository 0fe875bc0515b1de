//! Cameras for what is visible: from a side that people can name, filling the picture.
//!
//! Reading order: `facing` (where the front is), `visible` (what is there to be seen), `silhouette` (what of
//! it is seen from a direction), `fit` (how near the camera goes), `aim` (what people wish beside).

mod aim;
mod facing;
mod fit;
mod silhouette;
mod visible;

use rayon::prelude::*;
use silhouette::{Axes, Seen};
use slabsplat_core::glam::DVec3;
use slabsplat_core::{
    Camera, CameraError, Fit, Grid, ImageDesc, Layer, MeshLayer, Mode, Projection, Viewpoint,
};

pub use aim::{Aim, AimError};
pub use facing::Facing;
pub(crate) use fit::Window;
#[cfg(feature = "files")]
pub(crate) use visible::CellLayout;
pub(crate) use visible::Cells;

/// Vertical field of view of a perspective camera that nobody described.
pub(crate) const FOV_Y_RADIANS: f64 = 30.0 * std::f64::consts::PI / 180.0;

/// What pictures of some layers and meshes are to hold, and which way it stands.
#[derive(Clone, Debug)]
pub struct Framing {
    facing: Facing,
    visible: Vec<Cells>,
    whole: Vec<Cells>,
    window: Window,
}

impl Framing {
    /// Looks once at the voxels of all layers.
    ///
    /// Where nobody says which way up things are, the end at which more of them is cut off by the grid is
    /// taken for the lower one, as of a head that ends at its neck.
    pub fn new(layers: &[Layer], meshes: &[MeshLayer], mode: Mode, facing: Facing) -> Self {
        let visible = layers.iter().map(|layer| Cells::of_layer(layer, mode)).collect();
        let grids: Vec<Grid> = layers.iter().map(|layer| *layer.volume.grid()).collect();
        Self::of_cells(visible, &grids, meshes, facing)
    }

    /// The same of layers on those grids, of which is known what they show.
    pub(crate) fn of_cells(
        mut visible: Vec<Cells>,
        grids: &[Grid],
        meshes: &[MeshLayer],
        facing: Facing,
    ) -> Self {
        let boxes: Vec<[DVec3; 2]> = meshes.iter().filter_map(MeshLayer::bounds).collect();
        // Of a mesh without triangles nothing is seen from anywhere.
        let nowhere = [[DVec3::ZERO, DVec3::ONE]];
        let is_empty = grids.is_empty() && boxes.is_empty();
        let boxes = if is_empty { &nowhere[..] } else { &boxes };
        let of_boxes = || boxes.iter().map(|it| Cells::of_box(*it));
        let facing = match grids {
            [only] if facing.is_guessed() => stood_up(facing, only, &visible[0]),
            _ => facing,
        };
        visible.extend(of_boxes());
        let whole = grids.iter().map(Cells::of_grid).chain(of_boxes()).collect();
        Self { facing, visible, whole, window: Window::default() }
    }

    /// The same in a part of the picture, which leaves room for something else at its edges.
    #[cfg(all(feature = "annotations", feature = "files"))]
    pub(crate) fn within(self, window: Window) -> Self {
        Self { window, ..self }
    }

    /// The same with a box around the volumes, which is part of them where they are to be seen whole.
    #[cfg(all(feature = "annotations", feature = "files"))]
    pub(crate) fn and_box(mut self, ends: [DVec3; 2]) -> Self {
        self.whole.push(Cells::of_box(ends));
        self
    }

    /// Which way it stands.
    pub fn facing(&self) -> Facing {
        self.facing
    }

    /// A camera from a side, or from before it and a little above, whose picture is filled.
    ///
    /// # Errors
    /// If numbers do not suffice to tell where it is.
    pub fn camera(
        &self,
        viewpoint: Option<Viewpoint>,
        fit: Fit,
        projection: Projection,
        image: &ImageDesc,
    ) -> Result<Camera, CameraError> {
        let [to_eye, up] = viewpoint.map_or(self.facing.usual(), |it| self.facing.seen_from(it));
        let towards = Camera::new(to_eye, DVec3::ZERO, up, projection)?;
        self.refitted(&towards, fit, image)
    }

    /// The camera moved so that its picture is filled; it looks in the same direction.
    ///
    /// # Errors
    /// If numbers do not suffice to tell where it is.
    pub fn refitted(
        &self,
        camera: &Camera,
        fit: Fit,
        image: &ImageDesc,
    ) -> Result<Camera, CameraError> {
        let (axes, seen) = self.seen(camera, fit);
        fit::fitting(&seen, axes, camera.up(), camera.projection(), (image, self.window))
    }

    /// What is to fill the picture of a camera, along its axes.
    fn seen(&self, camera: &Camera, fit: Fit) -> (Axes, Vec<Seen>) {
        let axes = camera.axes();
        let axes = [axes.right, axes.up, axes.forward];
        let of = |parts: &[Cells]| silhouette::seen(parts, axes);
        let mut seen = match fit {
            Fit::Visible => of(&self.visible),
            Fit::Volume => Vec::new(),
        };
        if seen.is_empty() {
            seen = of(&self.whole);
        }
        (axes, seen)
    }

    /// The camera aimed otherwise: turned, filled again where the aim or `refits` says so, magnified, moved.
    ///
    /// # Errors
    /// If numbers do not suffice to tell where it is.
    pub fn aimed(
        &self,
        camera: &Camera,
        aim: &Aim,
        refits: bool,
        image: &ImageDesc,
    ) -> Result<Camera, CameraError> {
        let mut camera = self.turned(camera, aim)?;
        let is_turned = aim.viewpoint.is_some() || aim.turns();
        let fit = aim.fit.or((refits && is_turned).then_some(Fit::Visible));
        if let Some(fit) = fit {
            camera = self.refitted(&camera, fit, image)?;
        }
        aim.moved(&camera, f64::from(image.width) / f64::from(image.height))
    }

    /// The camera aimed otherwise, and filled by what is seen from all of `views`: cameras that go around
    /// what it looks at, for the camera that is turned. Then it is magnified and moved.
    ///
    /// From each of them all is within the picture, and as large as from the others. It stands still in the
    /// middle, if they go around that: the target is in the middle of what they see.
    ///
    /// # Errors
    /// If numbers do not suffice to tell where it is.
    pub fn aimed_around(
        &self,
        camera: &Camera,
        aim: &Aim,
        views: impl FnOnce(&Camera) -> Vec<Camera>,
        image: &ImageDesc,
    ) -> Result<Camera, CameraError> {
        let camera = self.turned(camera, aim)?;
        let views = views(&camera);
        let views = views.par_iter().map(|view| self.seen(view, aim.fit.unwrap_or_default()));
        let views = [self.seen(&camera, aim.fit.unwrap_or_default())]
            .into_iter()
            .chain(views.collect::<Vec<_>>());
        let views: Vec<(Axes, Vec<Seen>)> = views.collect();
        let camera = fit::around(&camera, &views, (image, self.window))?;
        aim.moved(&camera, f64::from(image.width) / f64::from(image.height))
    }

    /// The camera from the side and by the turns that the aim says.
    fn turned(&self, camera: &Camera, aim: &Aim) -> Result<Camera, CameraError> {
        let mut camera = *camera;
        if let Some(viewpoint) = aim.viewpoint {
            let [to_eye, up] = self.facing.seen_from(viewpoint);
            let distance = camera.eye().distance(camera.target());
            let eye = camera.target() + to_eye * distance;
            camera = Camera::new(eye, camera.target(), up, camera.projection())?;
        }
        aim.turned(&camera)
    }
}

/// The projection of a camera that is all found.
pub(crate) fn usual_projection(is_perspective: bool) -> Projection {
    if is_perspective {
        Projection::Perspective { fov_y_radians: FOV_Y_RADIANS }
    } else {
        Projection::Orthographic { view_height: 1.0 }
    }
}

/// Turned upside down if more is cut off at its top than at its bottom.
fn stood_up(facing: Facing, grid: &Grid, visible: &Cells) -> Facing {
    let index_from_world = grid.index_from_world();
    let last = grid.dims()[2] as f64 - 1.0;
    // A layer of cells at either end of z.
    let thickness = (0.04 * last).max(1.0);
    let at_end = |is_upper: bool| {
        silhouette::weights(&visible.cells, |middle| {
            let z = index_from_world.transform_point3(middle).z;
            if is_upper { last - thickness < z } else { z < thickness }
        })
    };
    let steps = grid.world_from_index().matrix3.z_axis;
    let [lower, upper] = match 0.0 < steps.dot(facing.top()) {
        true => [at_end(false), at_end(true)],
        false => [at_end(true), at_end(false)],
    };
    let are_both_cut = BOTH_CUT * lower.max(upper) < lower.min(upper);
    let is_upside_down = match facing.is_head() && are_both_cut {
        true => upper < lower,
        false => TOP_HEAVY * lower < upper,
    };
    if is_upside_down { facing.upside_down() } else { facing }
}

/// How many times more must be cut off above than below.
const TOP_HEAVY: f64 = 2.0;

/// The least part of what is cut off at one end, of that at the other, from which on both count as cut.
const BOTH_CUT: f64 = 0.05;

#[cfg(test)]
mod tests;
