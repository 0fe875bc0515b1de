//! What draws one part of a scene after the other, on as many threads as the memory pays for.

use super::DividedError;
use crate::{RenderError, backend_named};
use rayon::{ThreadPool, ThreadPoolBuilder};
use slabsplat_backend::{Backend, BackendError, Frame, FramePlan, Planner};
use slabsplat_core::{FrameHandle, Image, Part, Scene};

/// The backend that keeps to a budget of memory.
pub(super) const CPU: &str = "cpu";

/// A backend and its plans.
pub(super) struct Painter<'a> {
    planner: Planner,
    backend_name: &'a str,
    backend: Option<Box<dyn Backend>>,
    /// If it has fewer threads than there are.
    pool: Option<ThreadPool>,
    /// The coarsest level of cells that it draws.
    coarsest: u32,
}

impl<'a> Painter<'a> {
    /// One by the backend of that name, on so many threads at most.
    pub(super) fn new(backend_name: &'a str, n_threads: usize) -> Self {
        let is_fewer = n_threads < rayon::current_num_threads();
        // Where no threads can be started, those that there are draw.
        let pool = is_fewer.then(|| ThreadPoolBuilder::new().num_threads(n_threads).build().ok());
        let pool = pool.flatten();
        Self { planner: Planner::default(), backend_name, backend: None, pool, coarsest: 0 }
    }

    /// The same that draws cells up to that level.
    pub(super) fn with_cells(self, coarsest: u32) -> Self {
        Self { coarsest, ..self }
    }

    /// Draws what there is of a scene in a part of the world, behind what is there.
    pub(super) fn draw(
        &mut self,
        scene: &Scene,
        part: &Part,
        in_front: &Image,
        frame: &FrameHandle,
    ) -> Result<Frame, DividedError> {
        let backend = match &mut self.backend {
            Some(backend) => backend,
            none => none.insert(backend_named(self.backend_name).map_err(RenderError::from)?),
        };
        let mut plan = self.planner.plan_part(scene, part, self.coarsest, frame)?;
        plan.in_front = Some(in_front);
        let drawn = match &self.pool {
            Some(pool) => pool.install(|| drawn(&mut **backend, &plan, frame)),
            None => drawn(&mut **backend, &plan, frame),
        };
        Ok(drawn.map_err(RenderError::from)?)
    }

    /// Forgets what the CPU caches of volumes that are not drawn again. What is on a device is replaced by
    /// what comes next, and takes long to open.
    pub(super) fn forget(&mut self) {
        self.backend.take_if(|_| self.backend_name == CPU);
    }
}

fn drawn(
    backend: &mut dyn Backend,
    plan: &FramePlan<'_>,
    frame: &FrameHandle,
) -> Result<Frame, BackendError> {
    backend.submit(plan, frame)?;
    backend.wait_image(frame)
}
