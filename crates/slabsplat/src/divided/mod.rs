//! Scenes of which no volume need fit the memory: drawn box by box, from the eye, as parts of the whole
//! (model §17).
//!
//! ```text
//! unpack each volume that cannot be read in boxes into a scratch file
//! what the scene file leaves open is found of overviews, every so manieth voxel of each volume
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
//! Reading order: `overview`, `balance`, `shares`, `budget`, `ahead`, `painter`, `drawing`, `refine`,
//! `shared`.

mod ahead;
mod balance;
mod budget;
mod drawing;
mod overview;
mod painter;
mod refine;
mod shared;
mod shares;

use crate::framing::Aim;
use crate::{OpenError, OpenScene, Picture, RenderError, finished, frame_scene};
use budget::Budget;
use overview::Overview;
use painter::CPU;
use shares::Shares;
use slabsplat_backend::{PlanError, Planner, SceneInParts, check_parts};
use slabsplat_core::{FrameHandle, Grid, PartBox, PartTree};
use slabsplat_io::{IoError, SceneFile, ScratchDesc, VolumeBoxes};
use thiserror::Error;

pub use budget::NoRoom;
pub use refine::Refinement;
pub use shared::{Exchange, ShareCost, SharedScene};

/// A scene that is drawn within a budget of memory, however large its volumes are.
///
/// The picture is that of the scene with all voxels in memory, up to rounding, if the scene file says its
/// transfer functions and its camera; what it leaves open is found of an overview of each volume, of two
/// million voxels at most. Cells that stand for voxels under a tolerance are not drawn.
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
    /// The volumes, whole.
    sources: Vec<VolumeBoxes>,
    grids: Vec<Grid>,
    boxes: PartTree,
    /// Those that are drawn here, of all shares.
    own: Option<shares::VoxelBox>,
    /// How many voxels around a box have a share in its picture, of each layer.
    steps: Vec<[f64; 3]>,
    memory_bytes: u64,
    /// That draw.
    n_threads: usize,
    /// By name.
    backend: String,
    is_refined: bool,
}

/// The part of all memory that unpacked chunks may take while overviews are read, and nothing is drawn.
const OF_OVERVIEW: u64 = 4;

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
}

impl DividedDesc {
    /// So many bytes of memory, and scratch in the system's folder for it.
    pub fn new(memory_bytes: u64) -> Self {
        Self { memory_bytes, scratch: ScratchDesc::default(), is_refined: false }
    }

    /// The same with scratch there.
    #[must_use]
    pub fn scratch(self, scratch: ScratchDesc) -> Self {
        Self { scratch, ..self }
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
    /// What is in memory whole could be more than there is.
    #[error("a volume is not drawn box by box with {0}: leave them out, or leave out the memory")]
    Whole(&'static str),
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
        let desc = DividedDesc::new(memory_bytes);
        Self::open_framed(file, &desc, |opened, file| opened.frame(file, &Aim::default()))
    }

    /// The same with a camera that `frame` finds, as [`OpenScene::frame`] does.
    ///
    /// # Errors
    /// As [`open`](Self::open), and `frame`.
    pub fn open_framed(
        file: &SceneFile,
        desc: &DividedDesc,
        frame: impl FnOnce(&mut OpenScene, &SceneFile) -> Result<(), OpenError>,
    ) -> Result<Self, DividedError> {
        let alone = &mut shared::Alone;
        let (opened, sources, grids) = Self::overviews(file, desc, alone, frame)?;
        let drawn = frame_scene(&opened.scene).map_err(RenderError::from)?;
        let budget = Budget::new(&opened.scene, &drawn.image, desc)?;
        drop(drawn);
        let (mut divided, _) = Self::divided(opened, sources, grids, (&budget, Shares::whole()))?;
        divided.draw_by(file);
        Ok(divided)
    }

    /// The scene with overviews, of which each share reads some planes, where its volumes are, and their
    /// grids.
    fn overviews(
        file: &SceneFile,
        desc: &DividedDesc,
        others: &mut dyn Exchange,
        frame: impl FnOnce(&mut OpenScene, &SceneFile) -> Result<(), OpenError>,
    ) -> Result<(OpenScene, Vec<VolumeBoxes>, Vec<Grid>), DividedError> {
        if file.layers.iter().any(|layer| layer.labels.is_some()) {
            return Err(DividedError::Whole("labels"));
        }
        let layers = file.layers.clone();
        let (mut file, mut grids, mut loaded) = (file.clone(), Vec::new(), Vec::new());
        let mut sources: Vec<VolumeBoxes> = Vec::new();
        for layer in &mut file.layers {
            let before = layers.iter().zip(&sources).find(|(of, _)| layer.shares_volume(of));
            let source = match before {
                Some((_, source)) => Ok(source.clone()),
                None => layer.open_boxes(&desc.scratch),
            };
            if let Ok(source) = &source {
                // Planes of an overview meet the same chunks.
                source.retain_chunks(desc.memory_bytes / OF_OVERVIEW);
            }
            let (source, overview) = Overview::of(source, others)?;
            source.retain_chunks(0);
            overview.stand_in(layer);
            grids.push(overview.whole);
            loaded.push(overview.loaded);
            sources.push(source);
        }
        let mut opened = OpenScene::unframed(loaded, &file)?;
        check_parts(&opened.scene)?;
        frame(&mut opened, &file)?;
        for ((layer, of_file), grid) in opened.scene.layers.iter_mut().zip(&layers).zip(&grids) {
            layer.region = of_file.region.on(grid).map_err(OpenError::from)?;
        }
        Ok((opened, sources, grids))
    }

    fn divided(
        opened: OpenScene,
        sources: Vec<VolumeBoxes>,
        grids: Vec<Grid>,
        (budget, mut shares): (&Budget, Shares),
    ) -> Result<(Self, Shares), DividedError> {
        let drawn = frame_scene(&opened.scene).map_err(RenderError::from)?;
        let in_parts = SceneInParts {
            grids: &grids,
            camera: &drawn.camera,
            image: &drawn.image,
            settings: &drawn.settings,
        };
        let planner = Planner::default();
        let steps = grids.iter().map(|grid| planner.support_of_parts(&in_parts, grid));
        let steps = steps.collect::<Result<Vec<_>, _>>()?;
        let types = drawn.layers.iter().map(|layer| layer.volume.sample_type());
        let has_chunks = sources.iter().any(VolumeBoxes::is_in_chunks);
        let (boxes, of_chunks) = budget.boxes(&grids, &steps, types, (&mut shares, has_chunks))?;
        drop(drawn);
        let n_sources = sources.len().max(1) as u64;
        sources.iter().for_each(|source| source.retain_chunks(of_chunks / n_sources));
        let (memory_bytes, n_threads) = (budget.memory_bytes(), budget.n_threads());
        let own = shares.own_box();
        let (backend, is_refined) = (CPU.to_owned(), budget.is_refined());
        let divided = Self {
            opened,
            sources,
            grids,
            boxes,
            own,
            steps,
            memory_bytes,
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

    /// Has it drawn by the backend that a scene file names.
    fn draw_by(&mut self, file: &SceneFile) {
        let named = if file.backend == "auto" { CPU } else { &file.backend };
        named.clone_into(&mut self.backend);
    }

    /// The name of the backend that draws it: the one of the scene file, and the CPU if that is `auto`. What
    /// others have on their device is beside the memory that it was opened for.
    pub fn backend(&self) -> &str {
        &self.backend
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
        file.layers.iter_mut().for_each(|layer| layer.hash = None);
        Ok(file)
    }

    /// Draws the scene and finishes it, as [`Renderer::picture_as`](crate::Renderer::picture_as) does.
    ///
    /// # Errors
    /// If its [backend](Self::backend) is not there or cannot draw it, a volume cannot be read any more, or
    /// the frame is cancelled.
    pub fn picture(&self, frame: &FrameHandle) -> Result<Picture, DividedError> {
        let drawn = self.frame(frame, &mut |_, _| {})?;
        Ok(finished(drawn, &self.opened.scene, self.opened.acquisition))
    }
}
