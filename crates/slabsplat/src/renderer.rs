//! A volume and what is kept of it between frames.

use slabsplat_backend::{Backend, BackendError, Caps, Frame, FrameId, PlanError, Planner};
use slabsplat_core::{Scene, Volume};
use std::sync::Arc;
use std::task::Poll;
use thiserror::Error;

/// Renders a volume, again and again.
pub struct Renderer {
    volume: Arc<Volume>,
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
    /// A renderer of `volume`. What is done once a volume, such as sorting its voxels by value, is
    /// done with the first frame.
    pub fn new(volume: impl Into<Arc<Volume>>, backend: Box<dyn Backend>) -> Self {
        Self { volume: volume.into(), planner: Planner::default(), backend }
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
        let plan = self.planner.plan(&self.volume, scene)?;
        Ok(self.backend.submit(&plan)?)
    }

    /// Takes a frame if it is done, without waiting.
    ///
    /// # Errors
    /// If the frame failed, or there is no such frame.
    pub fn poll(&mut self, frame: FrameId) -> Result<Poll<Frame>, RenderError> {
        Ok(self.backend.poll_image(frame)?)
    }
}
