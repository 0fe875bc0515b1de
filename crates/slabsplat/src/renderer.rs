//! A volume and what is kept of it between frames.

use slabsplat_backend::{Backend, BackendError, Caps, Frame, FrameId, PlanError, Planner};
use slabsplat_core::{IsoRange, Scene, Volume};
use slabsplat_traverse::{ListChange, RelevantList, ValueOrder};
use std::task::Poll;
use thiserror::Error;

/// Renders a volume, again and again.
pub struct Renderer {
    volume: Volume,
    order: ValueOrder,
    list: RelevantList,
    /// What `list` was last made for.
    ranges: Vec<IsoRange>,
    planner: Planner,
    backend: Box<dyn Backend>,
}

/// Why a frame could not be made.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum RenderError {
    /// The scene cannot be drawn.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The backend failed.
    #[error(transparent)]
    Backend(#[from] BackendError),
}

impl Renderer {
    /// Sorts the volume's voxels by value, which is done once.
    pub fn new(volume: Volume, backend: Box<dyn Backend>) -> Self {
        let order = ValueOrder::new(&volume);
        Self {
            volume,
            order,
            list: RelevantList::default(),
            ranges: Vec::new(),
            planner: Planner::default(),
            backend,
        }
    }

    /// The volume.
    pub fn volume(&self) -> &Volume {
        &self.volume
    }

    /// What renders it.
    pub fn caps(&self) -> &Caps {
        self.backend.caps()
    }

    /// Renders a frame and waits for it.
    ///
    /// # Errors
    /// If the scene cannot be drawn, or the backend fails.
    pub fn render(&mut self, scene: &Scene) -> Result<Frame, RenderError> {
        let frame = self.submit(scene)?;
        loop {
            match self.poll(frame)? {
                Poll::Ready(frame) => return Ok(frame),
                Poll::Pending => std::thread::yield_now(),
            }
        }
    }

    /// Begins a frame, to be taken by [`poll`](Self::poll).
    ///
    /// # Errors
    /// If the scene cannot be drawn, or the backend fails.
    pub fn submit(&mut self, scene: &Scene) -> Result<FrameId, RenderError> {
        self.update_list(scene);
        let plan = self.planner.plan(&self.volume, self.list.records(), scene)?;
        Ok(self.backend.submit(&plan)?)
    }

    /// Takes a frame if it is done, without waiting.
    ///
    /// # Errors
    /// If the frame failed, or there is no such frame.
    pub fn poll(&mut self, frame: FrameId) -> Result<Poll<Frame>, RenderError> {
        Ok(self.backend.poll_image(frame)?)
    }

    /// Makes the relevant voxels those of the scene's transfer function, by difference from what they
    /// were, and tells how many changed. Rendering does this by itself.
    pub fn update_list(&mut self, scene: &Scene) -> ListChange {
        let ranges = scene.transfer.iso_ranges();
        if ranges == self.ranges {
            return ListChange::default();
        }
        let change = self.list.update(&self.volume, &self.order, &ranges);
        self.ranges = ranges;
        change
    }
}
