//! Scenes of which no volume need fit the memory: drawn box by box, from the eye, as parts of the whole
//! (model §17).
//!
//! ```text
//! unpack each volume that cannot be read in boxes into a scratch file
//! what the scene file leaves open is found of the voxels of which it is found in memory
//! cut the largest volume into boxes, by a k-d tree, until one fits the memory with what it takes to draw it
//! for each box, from the eye:
//!     unless all pixels that it may touch are saturated:
//!         read its voxels, and those around it that have a share in its picture: while the one before is
//!             drawn, if that does not hide it
//!         draw it behind what is there
//! ```
//!
//! Several programs share a scene ([`SharedScene`]): the tree is cut between them first, by work, and each
//! draws its own boxes.
//!
//! Reading order: `opened_boxes`, `found_scene`, `survey`, `values` and `overview` (what is read before there
//! is a scene), `balance`, `shares`, `budget`, `retained`, `ahead`, `painter`, `drawing`, `refine`,
//! `moments`, `shared`.

mod ahead;
mod balance;
mod budget;
mod drawing;
mod found_scene;
mod moments;
mod opened_boxes;
mod overview;
mod painter;
mod refine;
mod retained;
mod shared;
mod shares;
mod survey;
mod values;

use crate::framing::Aim;
use crate::{OpenError, OpenScene, Picture, RenderError, finished, frame_scene};
use budget::{Budget, LayerInBoxes};
use found_scene::{Surveyed, Views, outlined};
use retained::RetainedBoxes;
use shares::Shares;
use slabsplat_backend::{Frame, PlanError, Planner, SceneInParts};
use slabsplat_core::{Camera, FrameHandle, Grid, PartBox, PartSupport, PartTree, View, Volume};
use slabsplat_io::{IoError, LabelBoxes, SceneFile, ScratchDesc, VolumeBoxes};
use std::sync::Arc;
use thiserror::Error;

pub use budget::NoRoom;
pub use refine::Refinement;
pub use shared::{Exchange, ShareCost, SharedDesc, SharedScene};

/// A scene that is drawn within a budget of memory, however large its volumes are.
///
/// The picture is that of the scene with all voxels in memory, up to rounding, and so is what the scene file
/// leaves open: transfer functions and the camera are found of the same voxels. Cells stand for voxels under
/// a tolerance as they do there.
///
/// ```no_run
/// use slabsplat::DividedScene;
///
/// let file = slabsplat::io::read_scene("large.toml")?;
/// let scene = DividedScene::open(&file, 2 << 30)?;
/// let picture = scene.picture(&Default::default())?;
/// assert_eq!(picture.frame.image.width(), scene.opened().scene.image.width);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct DividedScene {
    /// With overviews for volumes.
    opened: OpenScene,
    /// What annotations see for volumes.
    outlines: Vec<Arc<Volume>>,
    /// The volumes, whole.
    sources: Vec<VolumeBoxes>,
    /// Their labels, if they have any.
    labels: Vec<Option<LabelBoxes>>,
    grids: Vec<Grid>,
    boxes: PartTree,
    /// Those that are drawn here, of all shares.
    own: Option<shares::VoxelBox>,
    /// What around a box has a share in its picture, of each layer.
    supports: Vec<PartSupport>,
    memory_bytes: u64,
    /// As it was opened, for other scenes of the same volumes.
    desc: DividedDesc,
    retained: Arc<RetainedBoxes>,
    /// What boxes leave for some that are retained.
    room_bytes: u64,
    /// That draw.
    n_threads: usize,
    /// By name.
    backend: String,
    is_refined: bool,
}

/// What a scene may take that is drawn box by box.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct DividedDesc {
    /// Bytes of memory.
    pub memory_bytes: u64,
    /// Where volumes are unpacked that cannot be read box by box as they are.
    pub scratch: ScratchDesc,
    /// Whether it leaves room for what [`DividedScene::refined`] shows: 80 bytes a pixel, and what it takes
    /// to draw the overviews.
    pub is_refined: bool,
    /// How the camera is aimed that the scene file says, or that is found.
    pub aim: Aim,
}

impl DividedDesc {
    /// So many bytes of memory, and scratch in the system's folder for it.
    pub fn new(memory_bytes: u64) -> Self {
        Self {
            memory_bytes,
            scratch: ScratchDesc::default(),
            is_refined: false,
            aim: Aim::default(),
        }
    }

    /// The same with scratch there.
    #[must_use]
    pub fn scratch(self, scratch: ScratchDesc) -> Self {
        Self { scratch, ..self }
    }

    /// The same with the camera aimed so.
    #[must_use]
    pub fn aim(self, aim: Aim) -> Self {
        Self { aim, ..self }
    }

    /// The same with room for pictures that are shown meanwhile.
    #[must_use]
    pub fn refined(self) -> Self {
        Self { is_refined: true, ..self }
    }
}

/// Why a scene cannot be drawn within its memory.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum DividedError {
    /// It cannot be opened.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// A volume cannot be read, or not box by box.
    #[error(transparent)]
    Io(#[from] IoError),
    /// It cannot be drawn, or not in parts.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// Not even the smallest boxes have room.
    #[error(transparent)]
    NoRoom(#[from] NoRoom),
    /// There may be no room for more pictures than one.
    #[error(
        "the scene was not opened to show pictures while it is drawn: DividedDesc::refined does that"
    )]
    NotRefined,
    /// Another share of the scene failed.
    #[error(transparent)]
    Elsewhere(Box<dyn std::error::Error + Send + Sync>),
    /// What shares read of a volume does not fit together.
    #[error("not all read the same volume: it has another size or type for some of them")]
    Differing,
}

impl From<PlanError> for DividedError {
    fn from(error: PlanError) -> Self {
        Self::Render(error.into())
    }
}

impl DividedScene {
    /// Opens the scene of `file` for so many bytes of memory.
    ///
    /// Volumes that cannot be read box by box, as those that gzip has packed, are unpacked into a scratch
    /// file first ([`DividedDesc::scratch`]), which is gone with the scene.
    ///
    /// # Errors
    /// If it cannot be opened, read or drawn box by box, or not within so little memory; if there is no room
    /// for scratch.
    pub fn open(file: &SceneFile, memory_bytes: u64) -> Result<Self, DividedError> {
        Self::open_as(file, &DividedDesc::new(memory_bytes))
    }

    /// The same as `desc` says.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn open_as(file: &SceneFile, desc: &DividedDesc) -> Result<Self, DividedError> {
        Self::open_for(file, desc, None)
    }

    /// The same for a camera that goes around, as [`OpenScene::frame_around`].
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn open_around(
        file: &SceneFile,
        desc: &DividedDesc,
        views: &dyn Fn(&Camera) -> Vec<Camera>,
    ) -> Result<Self, DividedError> {
        Self::open_for(file, desc, Some(views))
    }

    fn open_for(
        file: &SceneFile,
        desc: &DividedDesc,
        views: Option<Views<'_>>,
    ) -> Result<Self, DividedError> {
        let surveyed = Self::surveyed(file, desc, &mut shared::Alone, views)?;
        let scene = &surveyed.opened.scene;
        let drawn = frame_scene(scene).map_err(RenderError::from)?;
        let budget = Budget::new(scene, &drawn.image, (desc, &surveyed.backend))?;
        drop(drawn);
        let shares = Shares::whole();
        let (divided, _) = Self::divided(surveyed, desc, (budget, shares))?;
        Ok(divided)
    }

    fn divided(
        surveyed: Surveyed,
        desc: &DividedDesc,
        (mut budget, mut shares): (Budget, Shares),
    ) -> Result<(Self, Shares), DividedError> {
        let Surveyed { opened, sources, labels, grids, outlines, backend } = surveyed;
        let drawn = frame_scene(&opened.scene).map_err(RenderError::from)?;
        let in_parts = SceneInParts {
            grids: &grids,
            camera: &drawn.camera,
            image: &drawn.image,
            settings: &drawn.settings,
        };
        let planner = Planner::default();
        let supports = grids.iter().map(|grid| planner.support_of_parts(&in_parts, grid));
        let supports = supports.collect::<Result<Vec<_>, _>>()?;
        let of_labels = labels.iter().zip(&grids);
        let of_labels = of_labels
            .map(|(labels, grid)| labels.as_ref().map_or(0, |labels| labels.voxel_bytes(grid)));
        let voxel_bytes = drawn.layers.iter().map(budget::voxel_bytes);
        let voxel_bytes = voxel_bytes.zip(of_labels).map(|(own, of_labels)| own + of_labels);
        let center = Grid::center_of_all(&grids);
        let layers = grids.iter().zip(&supports).zip(voxel_bytes);
        let layers = layers.map(|((grid, &support), voxel_bytes)| {
            let view = View::about(center, grid, &drawn.camera, &drawn.image)?;
            let n_on_tile = budget::n_on_tile(grid, &view, &support);
            Ok(LayerInBoxes { grid, support, voxel_bytes, n_on_tile })
        });
        let layers = layers.collect::<Result<Vec<_>, PlanError>>()?;
        let has_chunks = sources.iter().any(VolumeBoxes::is_in_chunks);
        let (tree, left_bytes) = budget.boxes(&layers, (&mut shares, has_chunks))?;
        drop(drawn);
        let n_sources = sources.len().max(1) as u64;
        sources.iter().for_each(|source| source.retain_chunks(left_bytes / n_sources));
        let room_bytes = if has_chunks { 0 } else { left_bytes };
        let (memory_bytes, n_threads) = (budget.memory_bytes(), budget.n_threads());
        let own = shares.own_box();
        let is_refined = budget.is_refined();
        let divided = Self {
            opened,
            outlines,
            sources,
            labels,
            grids,
            boxes: tree,
            own,
            supports,
            memory_bytes,
            desc: desc.clone(),
            retained: Arc::default(),
            room_bytes,
            n_threads,
            backend,
            is_refined,
        };
        Ok((divided, shares))
    }

    /// The scene as it was opened, whose volumes are overviews: their grids have longer steps.
    pub fn opened(&self) -> &OpenScene {
        &self.opened
    }

    /// The same for who changes how it is finished. Volumes, camera, picture and settings have to stay.
    pub fn opened_mut(&mut self) -> &mut OpenScene {
        &mut self.opened
    }

    /// The volumes, layer by layer: where they are, and what they take on a disk.
    pub fn sources(&self) -> &[VolumeBoxes] {
        &self.sources
    }

    /// The grids of the volumes, layer by layer.
    pub fn grids(&self) -> &[Grid] {
        &self.grids
    }

    /// The memory that it was opened for.
    pub fn memory_bytes(&self) -> u64 {
        self.memory_bytes
    }

    /// How many threads draw it, of those that there are: as many as the memory pays for.
    pub fn n_threads(&self) -> usize {
        self.n_threads
    }

    /// The name of the backend that draws it: the one of the scene file, and the CPU if that is `auto`. What
    /// others have on their device is beside the memory that it was opened for.
    pub fn backend(&self) -> &str {
        &self.backend
    }

    /// The coarsest level of cells by which it may be drawn ([model §16](slabsplat_core::model)), 0 … 3, as
    /// in core.
    pub fn coarsest_cells(&self) -> u32 {
        self.supports.iter().map(|support| support.coarsest).max().unwrap_or(0)
    }

    /// How many boxes there are.
    pub fn n_boxes(&self) -> usize {
        self.own_boxes().len()
    }

    /// The boxes that are drawn here, the nearest first.
    fn own_boxes(&self) -> Vec<&PartBox> {
        let mut boxes = self.boxes.seen_by(&self.opened.scene.camera);
        boxes.retain(|of| self.own.as_ref().is_some_and(|own| shares::holds(own, &of.voxels)));
        boxes
    }

    /// The scene as a scene file that leaves nothing open, not even what draws it, as
    /// [`OpenScene::to_file`], without hashes of volumes.
    ///
    /// # Errors
    /// As there.
    pub fn to_file(&self) -> Result<SceneFile, IoError> {
        let mut file = self.opened.to_file()?;
        self.backend.clone_into(&mut file.backend);
        for (idx, layer) in file.layers.iter_mut().enumerate() {
            layer.hash = None;
            if let Some(labels) = &mut layer.labels {
                labels.hash = None;
            }
            // What counts voxels counts those of the whole volume.
            let (said, drawn) = (&self.opened.sources.layers[idx], &self.opened.scene.layers[idx]);
            if said.region.on(&self.grids[idx]).is_ok_and(|region| region == drawn.region) {
                layer.region = said.region.clone();
            }
        }
        Ok(file)
    }

    /// Draws the scene and finishes it, as [`Renderer::picture_as`](crate::Renderer::picture_as) does.
    ///
    /// # Errors
    /// If its [backend](Self::backend) is not there or cannot draw it, a volume cannot be read any more, or
    /// the frame is cancelled.
    pub fn picture(&self, frame: &FrameHandle) -> Result<Picture, DividedError> {
        let drawn = self.frame(frame, &mut |_, _| {})?;
        Ok(self.finished(drawn))
    }

    /// Makes a frame into a picture.
    fn finished(&self, frame: Frame) -> Picture {
        let scene = outlined(&self.opened.scene, &self.outlines);
        finished(frame, &scene, self.opened.acquisition)
    }
}
