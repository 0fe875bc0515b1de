//! Pictures of a simulation while it runs: each rank has a box of its voxels in memory, and hands it over.
//!
//! ```text
//! once: all tell each other their boxes, and make a k-d tree of them
//! for each picture: each rank is sent the voxels around its box that it needs and has not (ghosts),
//!     draws its box before nothing; all lay their pictures over each other, and rank 0 has the result
//! ```
//!
//! Reading order: this file, `boxes` (a tree of boxes that are there), `field` (arrays of the simulation),
//! `ghosts`, `scene_text`; `c`.

mod boxes;
mod field;
mod ghosts;
mod scene_text;

#[cfg(feature = "mpi")]
pub mod c;

pub use boxes::{BoxError, VoxelBox};
pub use field::{Field, FieldError, Values};
pub use scene_text::SceneText;

use crate::collective::{agree, all_gather};
use crate::communicator::while_beating;
use crate::{Communicator, MpiError, composite};
use slabsplat::backend::{PlanError, SceneInParts};
use slabsplat::{
    FrameHandle, Grid, Image, PartTree, Picture, Planner, RenderError, Scene, Volume,
    backend_named, finished, frame_scene, over,
};
use std::sync::Arc;
use thiserror::Error;

/// A simulation's grid, of which each rank has a box.
///
/// ```
/// use slabsplat_mpi::{Communicator, Field, InSitu, ThreadRank, Values};
/// use slabsplat::{Camera, Grid, ImageDesc, Layer, Projection, Scene, TransferFunction, Volume};
/// use slabsplat::glam::DVec3;
/// use std::sync::Arc;
///
/// let grid = Grid::with_spacing([8, 8, 8], [1.0; 3])?;
/// let pictures = ThreadRank::run(2, std::time::Duration::from_secs(9), |comm| {
///     // Each has a half, without ghosts.
///     let own = [0..8, 0..8, 4 * comm.rank()..4 * comm.rank() + 4];
///     let temperature = vec![1.0_f32; 8 * 8 * 4];
///     let in_situ = InSitu::new(comm, grid, &own)?;
///     let field = Field::packed(Values::F32(&temperature), own)?;
///     let look = |volumes: Vec<Arc<Volume>>| {
///         let transfer = TransferFunction::new([(0.0, 0.0), (1.0, 0.5)], [(0.0, [1.0, 0.3, 0.1])])?;
///         let middle = DVec3::splat(3.5);
///         let camera = Camera::new(
///             middle + DVec3::X * 30.0,
///             middle,
///             DVec3::Z,
///             Projection::Orthographic { view_height: 10.0 },
///         )?;
///         let layer = Layer::new(volumes[0].clone(), transfer);
///         Ok(Scene::new(layer, camera).image(ImageDesc::new(32, 32)))
///     };
///     in_situ.picture(comm, &[field], look)
/// });
/// let picture = pictures[0].as_ref().unwrap().as_ref().expect("rank 0 has it");
/// assert!(0.5 < picture.frame.image.pixel(16, 16)[3]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct InSitu {
    grid: Grid,
    /// Of all ranks; empty ones have no voxels.
    boxes: Vec<VoxelBox>,
    tree: PartTree,
    backend: String,
}

/// Why a rank cannot draw what it has.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum InSituError {
    /// The ranks cannot go on together.
    #[error(transparent)]
    Mpi(#[from] MpiError),
    /// The boxes are not all of the grid.
    #[error(transparent)]
    Boxes(#[from] BoxError),
    /// An array is not what it should be.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// The scene cannot be made.
    #[error("the scene cannot be made: {0}")]
    Scene(#[source] Box<dyn std::error::Error + Send + Sync>),
    /// It cannot be drawn, or not in parts.
    #[error(transparent)]
    Render(#[from] RenderError),
}

impl From<PlanError> for InSituError {
    fn from(error: PlanError) -> Self {
        Self::Render(error.into())
    }
}

/// Why a scene could not be made.
type AnyError = Box<dyn std::error::Error + Send + Sync>;

impl InSitu {
    /// A simulation's grid, of which this rank has the voxels `own`; a rank without any has an empty box.
    /// Boxes are those of a k-d tree, as of any regular division, and are all of the grid together.
    ///
    /// # Errors
    /// If they are not, on all ranks.
    pub fn new(comm: &dyn Communicator, grid: Grid, own: &VoxelBox) -> Result<Self, InSituError> {
        let bytes = boxes::to_bytes(own, &grid);
        let all = all_gather(comm, agree(comm, Ok::<_, MpiError>(bytes))?)?;
        let boxes = boxes::from_bytes(&all, &grid);
        let boxes = agree(comm, boxes)?;
        let tree = agree(comm, boxes::tree(&grid, &boxes))?;
        Ok(Self { grid, boxes, tree, backend: "cpu".to_owned() })
    }

    /// Has this rank draw by the backend of that name, a GPU's for instance, instead of on the CPU. Ranks may
    /// differ: pictures of several backends are one up to rounding.
    #[must_use]
    pub fn drawn_by(mut self, backend: impl Into<String>) -> Self {
        self.backend = backend.into();
        self
    }

    /// The grid of all.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The boxes of all ranks.
    pub fn boxes(&self) -> &[VoxelBox] {
        &self.boxes
    }

    /// Draws the simulation as it is. `look` makes a scene of a volume for each of the fields, in their
    /// order: what a rank has of it, with ghosts, so that it may use no more of a volume than its type. All
    /// ranks have to make the same scene of it. The picture is on rank 0; others get nothing.
    ///
    /// # Errors
    /// If any rank cannot, on all.
    pub fn picture(
        &self,
        comm: &dyn Communicator,
        fields: &[Field<'_>],
        look: impl FnOnce(Vec<Arc<Volume>>) -> Result<Scene, AnyError>,
    ) -> Result<Option<Picture>, InSituError> {
        let own = comm.rank();
        let fields = agree(comm, self.checked(own, fields))?;
        // How far around its box a rank needs voxels depends on the scene, and that not on the voxels.
        let sketch = self.sketch(fields);
        let scene =
            agree(comm, sketch.and_then(|volumes| look(volumes).map_err(InSituError::Scene)))?;
        let near = agree(comm, self.near(&scene))?;
        let volumes = fields.iter().map(|field| self.with_ghosts(comm, field, &near));
        let volumes = volumes.collect::<Result<Vec<_>, _>>()?;
        let drawn = while_beating(comm, || self.drawn(own, &scene, volumes))?;
        let drawn = agree(comm, drawn)?;
        let Some(mut image) = composite(comm, &drawn, &self.order(&scene))? else {
            return Ok(None);
        };
        let behind =
            frame_scene(&scene).map_err(RenderError::from)?.image.premultiplied_background();
        image.pixels_mut().iter_mut().for_each(|pixel| *pixel = over(*pixel, behind));
        let frame = slabsplat::Frame::new(image, Default::default(), Default::default());
        Ok(Some(finished(frame, &scene, Default::default())))
    }

    /// Arrays that have what they should.
    fn checked<'a, 'b>(
        &self,
        own: usize,
        fields: &'a [Field<'b>],
    ) -> Result<&'a [Field<'b>], InSituError> {
        fields.iter().try_for_each(|field| field.check_holds(&self.boxes[own], &self.grid))?;
        Ok(fields)
    }

    /// A volume of one voxel for each field.
    fn sketch(&self, fields: &[Field<'_>]) -> Result<Vec<Arc<Volume>>, InSituError> {
        let grid = self.grid.cropped(&[0..1, 0..1, 0..1]);
        let volumes = fields.iter().map(|field| field.blank(grid).map(Arc::new));
        Ok(volumes.collect::<Result<Vec<_>, _>>()?)
    }

    /// The voxels that each rank needs.
    fn near(&self, scene: &Scene) -> Result<Vec<Option<VoxelBox>>, InSituError> {
        let drawn = frame_scene(scene).map_err(RenderError::from)?;
        let grids = vec![self.grid; scene.layers.len()];
        let in_parts = SceneInParts {
            grids: &grids,
            camera: &drawn.camera,
            image: &drawn.image,
            settings: &drawn.settings,
        };
        let support = Planner::default().support_of_parts(&in_parts, &self.grid)?.with_cells(0);
        let leaves = self.tree.seen_by(&scene.camera);
        let near = self.boxes.iter().map(|of| {
            let leaf = leaves.iter().find(|leaf| leaf.voxels == *of)?;
            Some(self.tree.voxels_near(leaf, &self.grid, &support))
        });
        Ok(near.collect())
    }

    fn with_ghosts(
        &self,
        comm: &dyn Communicator,
        field: &Field<'_>,
        near: &[Option<VoxelBox>],
    ) -> Result<Option<Arc<Volume>>, InSituError> {
        let volume = ghosts::exchange(comm, field, (&self.boxes, near), &self.grid)?;
        Ok(volume.map(Arc::new))
    }

    /// What a rank shows, before nothing.
    fn drawn(
        &self,
        own: usize,
        scene: &Scene,
        volumes: Vec<Option<Arc<Volume>>>,
    ) -> Result<Image, InSituError> {
        let drawn = frame_scene(scene).map_err(RenderError::from)?;
        let mut scene = drawn.into_owned();
        scene.image.background = [0.0; 4];
        let leaves = self.tree.seen_by(&scene.camera);
        let leaf = leaves.iter().find(|leaf| leaf.voxels == self.boxes[own]);
        let volumes: Option<Vec<_>> = volumes.into_iter().collect();
        let Some((leaf, volumes)) = leaf.zip(volumes) else {
            return Ok(Image::filled(scene.image.width, scene.image.height, [0.0; 4]));
        };
        scene.layers.iter_mut().zip(volumes).for_each(|(layer, volume)| layer.volume = volume);
        let mut backend = backend_named(&self.backend).map_err(RenderError::from)?;
        let (mut planner, frame) = (Planner::default(), FrameHandle::new());
        let plan = planner.plan_part(&scene, &leaf.part, 0, &frame)?;
        backend.submit(&plan, &frame).map_err(RenderError::from)?;
        Ok(backend.wait_image(&frame).map_err(RenderError::from)?.image)
    }

    /// The ranks that have a box, the nearest first.
    fn order(&self, scene: &Scene) -> Vec<usize> {
        let leaves = self.tree.seen_by(&scene.camera);
        let rank_of = |voxels: &VoxelBox| self.boxes.iter().position(|of| of == voxels);
        leaves.iter().filter_map(|leaf| rank_of(&leaf.voxels)).collect()
    }
}
