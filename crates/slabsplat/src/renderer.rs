//! A backend, and what is cached between its frames.

use crate::{Choice, NoBackend, choose_backend, choose_backend_async};
use slabsplat_backend::{Backend, BackendError, Caps, Frame, PlanError, Planner};
use slabsplat_core::{Cancelled, FinishError, FrameHandle, Scene};
use slabsplat_kernel::{Kernel, KernelError};
use std::fmt;
use std::future::poll_fn;
use std::sync::Arc;
use std::task::{Context, Poll};
use thiserror::Error;

/// Renders scenes, again and again. What was made of a volume, such as the list of its relevant voxels,
/// serves for the next frame that shows the same.
pub struct Renderer {
    planner: Planner,
    backend: Box<dyn Backend>,
    fallback: Option<Fallback>,
    #[cfg(not(target_arch = "wasm32"))]
    pool: Option<Arc<rayon::ThreadPool>>,
}

type Fallback = Box<dyn FnOnce(&BackendError) -> Box<dyn Backend> + Send>;

/// Why a frame could not be made.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum RenderError {
    /// The scene cannot be drawn.
    #[error(transparent)]
    Plan(PlanError),
    /// The backend failed, or the frame was cancelled.
    #[error(transparent)]
    Backend(#[from] BackendError),
    /// There is no room for all samples of a picture.
    #[error(transparent)]
    Finish(#[from] FinishError),
    /// The texture takes no such picture.
    #[cfg(feature = "wgpu")]
    #[error(transparent)]
    Target(#[from] slabsplat_wgpu::TargetError),
    /// There is no backend to draw it: a [`RenderThread`](crate::RenderThread) finds out when it has begun.
    #[error(transparent)]
    NoBackend(#[from] NoBackend),
    /// The thread that drew it panicked; nothing more will come of it.
    #[error("the renderer panicked: {message}")]
    Panicked {
        /// What the panic says.
        message: String,
    },
}

impl RenderError {
    /// Whether nothing is wrong but that someone cancelled the frame.
    pub fn is_cancelled(&self) -> bool {
        *self == Cancelled.into()
    }
}

impl From<PlanError> for RenderError {
    /// A cancelled frame is the same error, whoever was making it then.
    fn from(error: PlanError) -> Self {
        match error {
            PlanError::Cancelled(cancelled) => cancelled.into(),
            error => Self::Plan(error),
        }
    }
}

impl From<Cancelled> for RenderError {
    fn from(cancelled: Cancelled) -> Self {
        Self::Backend(cancelled.into())
    }
}

impl fmt::Debug for Renderer {
    /// What renders, and nothing of what it has cached.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Renderer").field("backend", self.caps()).finish_non_exhaustive()
    }
}

impl Renderer {
    /// A renderer on `backend`.
    pub fn new(backend: Box<dyn Backend>) -> Self {
        Self {
            planner: Planner::default(),
            backend,
            fallback: None,
            #[cfg(not(target_arch = "wasm32"))]
            pool: None,
        }
    }

    /// A renderer on the backend called `name`. With `auto`, the CPU continues where a graphics card fails;
    /// `tell` is given a sentence for people whenever one could not be used.
    ///
    /// # Errors
    /// If this build has no such backend, or this machine nothing that it runs on.
    pub fn open(name: &str, tell: impl FnMut(&str) + Send + 'static) -> Result<Self, NoBackend> {
        choose_backend(name).map(|choice| Self::of(choice, tell))
    }

    /// The same for where graphics cards are waited for: in a browser. Elsewhere it does not wait.
    ///
    /// # Errors
    /// If this build has no such backend, or this machine nothing that it runs on.
    pub async fn open_async(
        name: &str,
        tell: impl FnMut(&str) + Send + 'static,
    ) -> Result<Self, NoBackend> {
        choose_backend_async(name).await.map(|choice| Self::of(choice, tell))
    }

    fn of(choice: Choice, mut tell: impl FnMut(&str) + Send + 'static) -> Self {
        let Choice { backend, notes, fallback } = choice;
        notes.iter().for_each(|note| tell(note));
        let renderer = Self::new(backend);
        let Some(make) = fallback else { return renderer };
        renderer.with_fallback(move |error| {
            let backend = make();
            tell(&format!("{error}; going on with the backend \"{}\"", backend.caps().name));
            backend
        })
    }

    /// A renderer on a device of wgpu's that the caller has, whose pictures are read back; a
    /// [`TextureRenderer`](crate::TextureRenderer) leaves them there.
    ///
    /// The device stays the caller's. Handlers of errors, and of the loss of the device, are neither set nor
    /// replaced: what goes wrong here is caught by error scopes, and is an error here. The caller continues
    /// to use the device, on this thread or others; callbacks of the caller's may be called by a poll from
    /// here, as by any.
    ///
    /// # Errors
    /// If the shaders do not run on it, with all that it lacks:
    /// [`device_descriptor`](crate::device_descriptor) asks for it.
    #[cfg(feature = "wgpu")]
    pub fn on_wgpu(
        device: &slabsplat_wgpu::wgpu::Device,
        queue: &slabsplat_wgpu::wgpu::Queue,
    ) -> Result<Self, NoBackend> {
        let opened = slabsplat_wgpu::on(device.clone(), queue.clone());
        let device =
            opened.map_err(|none| NoBackend::Unavailable { name: "wgpu", reason: none.reason })?;
        Ok(Self::new(Box::new(slabsplat_gpu::GpuBackend::new("wgpu", device))))
    }

    /// The same, but for [`render`](Self::render) and [`render_async`](Self::render_async): where its backend
    /// runs out of memory, is lost or cannot make a frame, `fallback` makes another, once, which draws that
    /// frame and all that follow. Frames that were submitted before and not taken are gone with the backend.
    pub fn with_fallback(
        self,
        fallback: impl FnOnce(&BackendError) -> Box<dyn Backend> + Send + 'static,
    ) -> Self {
        Self { fallback: Some(Box::new(fallback)), ..self }
    }

    /// Adds a kernel, which the settings of scenes may name from now on. It stays with a fallback.
    ///
    /// # Errors
    /// As [`Kernels::add`](slabsplat_kernel::Kernels::add).
    pub fn add_kernel(&mut self, kernel: Arc<dyn Kernel>) -> Result<(), KernelError> {
        self.planner.add_kernel(kernel)
    }

    /// The same on threads of the caller's: what a frame takes on the CPU runs there, and not on rayon's
    /// global pool. A GPU needs it for little.
    #[must_use]
    #[cfg(not(target_arch = "wasm32"))]
    pub fn with_pool(self, pool: Arc<rayon::ThreadPool>) -> Self {
        Self { pool: Some(pool), ..self }
    }

    /// What renders.
    pub fn caps(&self) -> &Caps {
        self.backend.caps()
    }

    /// Renders a frame and waits for it. In a browser only the CPU can: [`render_async`](Self::render_async).
    ///
    /// # Errors
    /// If the scene cannot be drawn, or the backend fails and there is no fallback.
    pub fn render(&mut self, scene: &Scene) -> Result<Frame, RenderError> {
        self.render_as(scene, &FrameHandle::new())
    }

    /// The same by a handle, a clone of which watches the frame or cancels it from another thread. A program
    /// that must not wait at all has a [`RenderThread`](crate::RenderThread).
    ///
    /// # Errors
    /// If the frame is cancelled, too.
    pub fn render_as(&mut self, scene: &Scene, frame: &FrameHandle) -> Result<Frame, RenderError> {
        let result = self.render_once(scene, frame);
        if self.falls_back(&result) { self.render_once(scene, frame) } else { result }
    }

    fn render_once(&mut self, scene: &Scene, frame: &FrameHandle) -> Result<Frame, RenderError> {
        self.submit_as(scene, frame)?;
        self.wait(frame)
    }

    /// Renders a frame and lets others work while a GPU draws it: a future that any executor drives, in a
    /// browser too, where nothing else waits for a GPU. The CPU draws its frames when they are submitted, and
    /// so within the first poll.
    ///
    /// A browser wakes the future when the GPU is done. Elsewhere nobody would, so that polls take up to five
    /// milliseconds; programs with threads have a [`RenderThread`](crate::RenderThread), whose frames are
    /// futures as well.
    ///
    /// ```
    /// use slabsplat::{Frame, RenderError, Renderer, Scene};
    ///
    /// async fn turn(renderer: &mut Renderer, mut scene: Scene) -> Result<Frame, RenderError> {
    ///     scene.camera = scene.camera.orbited(0.1);
    ///     renderer.render_async(&scene).await
    /// }
    /// ```
    ///
    /// # Errors
    /// If the scene cannot be drawn, or the backend fails and there is no fallback.
    pub async fn render_async(&mut self, scene: &Scene) -> Result<Frame, RenderError> {
        let result = self.render_once_async(scene).await;
        if self.falls_back(&result) { self.render_once_async(scene).await } else { result }
    }

    async fn render_once_async(&mut self, scene: &Scene) -> Result<Frame, RenderError> {
        let frame = self.submit(scene)?;
        self.wait_async(&frame).await
    }

    /// Whether there is another backend from now on, since this one failed.
    fn falls_back(&mut self, result: &Result<Frame, RenderError>) -> bool {
        if let Err(RenderError::Backend(error)) = result
            && error.is_of_device()
            && let Some(fallback) = self.fallback.take()
        {
            self.backend = fallback(error);
            return true;
        }
        false
    }

    /// Begins a frame, to be taken by [`poll`](Self::poll) or [`wait`](Self::wait). A GPU draws it meanwhile;
    /// the CPU has drawn it when this returns. It is dropped with its last handle.
    ///
    /// # Errors
    /// If the scene cannot be drawn, or the backend fails.
    pub fn submit(&mut self, scene: &Scene) -> Result<FrameHandle, RenderError> {
        let frame = FrameHandle::new();
        self.submit_as(scene, &frame)?;
        Ok(frame)
    }

    /// The same by a handle that is there before. A handle names one frame: it is not used for another.
    ///
    /// # Errors
    /// If the scene cannot be drawn, the backend fails, or the frame is cancelled.
    pub fn submit_as(&mut self, scene: &Scene, frame: &FrameHandle) -> Result<(), RenderError> {
        frame.check()?;
        let Self { planner, backend, .. } = self;
        #[cfg(not(target_arch = "wasm32"))]
        if let Some(pool) = &self.pool {
            return pool.install(|| submit(planner, &mut **backend, scene, frame));
        }
        submit(planner, &mut **backend, scene, frame)
    }

    /// Takes a frame if it is done, without waiting.
    ///
    /// # Errors
    /// If the frame failed or was cancelled, or is none of this renderer's.
    pub fn poll(&mut self, frame: &FrameHandle) -> Result<Poll<Frame>, RenderError> {
        Ok(self.backend.poll_image(frame)?)
    }

    /// Takes a frame as soon as it is done, and sleeps until then. In a browser nobody may, and a frame is
    /// polled or awaited ([`wait_async`](Self::wait_async)).
    ///
    /// # Errors
    /// If the frame failed or was cancelled, or is none of this renderer's; in a browser, if it is not done.
    pub fn wait(&mut self, frame: &FrameHandle) -> Result<Frame, RenderError> {
        Ok(self.backend.wait_image(frame)?)
    }

    /// Takes a frame as soon as it is done, as [`render_async`](Self::render_async) does. If the future is
    /// dropped, the frame continues, and may be awaited again.
    ///
    /// # Errors
    /// If the frame failed or was cancelled, or is none of this renderer's.
    pub async fn wait_async(&mut self, frame: &FrameHandle) -> Result<Frame, RenderError> {
        let poll = |context: &mut Context<'_>| match self.poll(frame) {
            Ok(Poll::Pending) => {
                self.backend.wake_when_done(frame, context.waker());
                Poll::Pending
            }
            Ok(Poll::Ready(frame)) => Poll::Ready(Ok(frame)),
            Err(error) => Poll::Ready(Err(error)),
        };
        poll_fn(poll).await
    }
}

fn submit(
    planner: &mut Planner,
    backend: &mut dyn Backend,
    scene: &Scene,
    frame: &FrameHandle,
) -> Result<(), RenderError> {
    planner.plan_cells(backend.caps().draws_cells);
    Ok(backend.submit(&planner.plan_for_frame(scene, frame)?, frame)?)
}

#[cfg(test)]
mod tests;
