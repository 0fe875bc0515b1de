//! Scenes of which each of several programs draws a share: a box of the volumes, of which it alone reads the
//! voxels.

use super::balance::WorkCells;
use super::budget::Budget;
use super::shares::Shares;
use super::{DividedDesc, DividedError, DividedScene, Surveyed};
use crate::{Aim, Picture, RenderError, frame_scene};
use slabsplat_backend::{Frame, FrameCost, FrameStats};
use slabsplat_core::{FrameHandle, Image, Samples, over};
use slabsplat_io::{IoError, SceneFile, ScratchDesc};

/// What joins those who each draw a share of a scene. All call the same, in one order.
pub trait Exchange {
    /// How many there are.
    fn n_shares(&self) -> usize;

    /// Which of them this is, from 0.
    fn share_idx(&self) -> usize;

    /// The first of those that run on this one's computer: what has to be unpacked that one unpacks, and the
    /// others there read it.
    fn first_here(&self) -> usize;

    /// Does what may take long, while the others hear that this one is at work.
    ///
    /// # Errors
    /// If the others cannot be told, as [`DividedError::Elsewhere`]; the work is done all the same.
    fn at_work(&mut self, work: &mut (dyn FnMut() + Send)) -> Result<(), DividedError>;

    /// Hands in samples, or why there are none, and returns those of all, in order.
    ///
    /// # Errors
    /// If any of them failed, on all, as [`DividedError::Elsewhere`] or as the error that was handed in.
    fn all(&mut self, own: Result<Samples, IoError>) -> Result<Vec<Samples>, DividedError>;
}

/// What a share of a scene may take, and where.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct SharedDesc {
    /// Bytes of memory; `None` is 1.3 times its part of what all volumes take, but 64 MiB at least, or what
    /// the smallest boxes need, and what it takes beside voxels.
    pub memory_bytes: Option<u64>,
    /// Where volumes are unpacked that cannot be read box by box as they are: by one share of each computer,
    /// for all that are there.
    pub scratch: ScratchDesc,
    /// How the camera is aimed that the scene file says, or that is found.
    pub aim: Aim,
}

impl SharedDesc {
    /// The same with so many bytes of memory.
    #[must_use]
    pub fn memory_bytes(self, memory_bytes: Option<u64>) -> Self {
        Self { memory_bytes, ..self }
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
}

/// A share of a scene that several programs draw.
///
/// All of them open the same scene. The largest volume is cut into as many boxes by a k-d tree, such that
/// each has as many relevant voxels, as far as an overview tells, of which each reads some planes. A share is
/// then drawn like a [`DividedScene`], within its memory.
#[derive(Debug)]
pub struct SharedScene {
    pub(super) divided: DividedScene,
    shares: Shares,
}

/// What a share took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ShareCost {
    /// Boxes that were drawn, and that were not, as what is before them is opaque.
    pub n_boxes: [usize; 2],
    /// Voxels that were read, those around boxes included.
    pub n_voxels_read: u64,
    /// Bytes of their samples.
    pub n_bytes_read: u64,
    /// Seconds that reading took, on a thread beside drawing.
    pub reading_secs: f64,
    /// Seconds of these in which nothing was drawn, as the voxels were not there yet.
    pub waiting_secs: f64,
}

impl SharedScene {
    /// Opens the scene of `file` as `desc` says.
    ///
    /// # Errors
    /// As [`DividedScene::open`], and if another share fails while planes are exchanged.
    pub fn open(
        file: &SceneFile,
        desc: &SharedDesc,
        others: &mut dyn Exchange,
    ) -> Result<Self, DividedError> {
        let SharedDesc { memory_bytes, scratch, aim } = desc.clone();
        let desc = DividedDesc::new(memory_bytes.unwrap_or(LEAST_BYTES));
        let desc = desc.scratch(scratch).aim(aim);
        let (n_shares, share_idx) = (others.n_shares(), others.share_idx());
        let surveyed = DividedScene::surveyed(file, &desc, others, None)?;
        let Surveyed { opened, grids, backend, .. } = &surveyed;
        let drawn = frame_scene(&opened.scene).map_err(RenderError::from)?;
        let budget = match memory_bytes {
            Some(_) => Budget::new(&opened.scene, &drawn.image, (&desc, backend))?,
            None => Budget::of_share(&opened.scene, &drawn.image, (grids, n_shares), backend),
        };
        drop(drawn);
        let cells = WorkCells::of(&opened.scene, grids);
        let shares = Shares::new(n_shares, share_idx, cells);
        let (divided, shares) = DividedScene::divided(surveyed, &desc, (budget, shares))?;
        Ok(Self { divided, shares })
    }

    /// The scene as it was opened, as [`DividedScene::opened`].
    pub fn scene(&self) -> &DividedScene {
        &self.divided
    }

    /// The shares that have a box, the nearest first.
    pub fn order(&self) -> Vec<usize> {
        let mut order: Vec<usize> = Vec::new();
        for of in self.divided.boxes.seen_by(&self.divided.opened.scene.camera) {
            if let Some(share) = self.shares.holding(&of.voxels)
                && order.last() != Some(&share)
            {
                order.push(share);
            }
        }
        order
    }

    /// Voxels of a share's box, along each axis; nothing if there are more shares than boxes.
    pub fn box_of(&self, share_idx: usize) -> Option<[std::ops::Range<usize>; 3]> {
        self.shares.boxes[share_idx].clone()
    }

    /// Draws the share before nothing.
    ///
    /// # Errors
    /// If a volume cannot be read any more, or the frame is cancelled.
    pub fn frame(&self, frame: &FrameHandle) -> Result<(Frame, ShareCost), DividedError> {
        self.divided.boxes_drawn(frame, &mut |_, _| {})
    }

    /// Makes the picture of all shares' frames, laid over each other in [order](Self::order), of which
    /// `stats` is what all drew.
    ///
    /// # Errors
    /// None that [`open`](Self::open) would not have had.
    ///
    /// # Panics
    /// If the image is of another size.
    pub fn finished(&self, mut image: Image, stats: FrameStats) -> Result<Picture, DividedError> {
        let drawn = frame_scene(&self.divided.opened.scene).map_err(RenderError::from)?;
        let behind = drawn.image.premultiplied_background();
        drop(drawn);
        image.pixels_mut().iter_mut().for_each(|pixel| *pixel = over(*pixel, behind));
        Ok(self.divided.finished(Frame::new(image, stats, FrameCost::default())))
    }
}

/// What a share has at least, before it is known how large its box is.
const LEAST_BYTES: u64 = 128 << 20;

/// Nobody else.
pub(super) struct Alone;

impl Exchange for Alone {
    fn n_shares(&self) -> usize {
        1
    }

    fn share_idx(&self) -> usize {
        0
    }

    fn first_here(&self) -> usize {
        0
    }

    fn at_work(&mut self, work: &mut (dyn FnMut() + Send)) -> Result<(), DividedError> {
        work();
        Ok(())
    }

    fn all(&mut self, own: Result<Samples, IoError>) -> Result<Vec<Samples>, DividedError> {
        Ok(vec![own?])
    }
}
