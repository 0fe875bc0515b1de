//! Where there are no threads, as in browsers, the device draws or nobody does.

use super::TextureRenderer;
use crate::RenderError;
use slabsplat_backend::{BackendError, Caps, Frame};
use slabsplat_core::{FrameHandle, Scene};
use slabsplat_kernel::Kernel;
use std::convert::Infallible;
use std::sync::Arc;
use std::task::Poll;

/// There is none.
pub(super) struct OnCpu(Infallible);

/// There is none.
pub(super) struct Uploaded(Infallible);

impl TextureRenderer {
    pub(super) fn falls_back(&mut self, _: &BackendError) -> bool {
        false
    }
}

impl OnCpu {
    pub(super) fn caps(&self) -> &Caps {
        match self.0 {}
    }

    pub(super) fn add_kernel(&mut self, _: Arc<dyn Kernel>) {
        match self.0 {}
    }

    pub(super) fn begin(&mut self, _: &Scene, _: &FrameHandle) -> Result<Uploaded, RenderError> {
        match self.0 {}
    }
}

impl Uploaded {
    pub(super) fn try_take(&mut self) -> Result<Poll<Frame>, RenderError> {
        match self.0 {}
    }

    pub(super) fn wait(&mut self) -> Result<Frame, RenderError> {
        match self.0 {}
    }
}
