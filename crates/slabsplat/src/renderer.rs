//! A backend, and what is cached between its frames.

use crate::{Choice, NoBackend, choose_backend, choose_backend_async};
use slabsplat_backend::{Backend, BackendError, Caps, Frame, PlanError, Planner};
use slabsplat_core::{Cancelled, FrameHandle, Scene};
use slabsplat_kernel::{Kernel, KernelError};
use std::fmt;
use std::sync::Arc;
use std::task::Poll;
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
    Plan(#[from] PlanError),
    /// The backend failed, or the frame was cancelled.
    #[error(transparent)]
    Backend(#[from] BackendError),
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

    /// The same, but for [`render`](Self::render): where its backend runs out of memory, is lost or cannot
    /// make a frame, `fallback` makes another, once, which draws that frame and all that follow. Frames that
    /// were submitted before and not taken are gone with the backend.
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

    /// Renders a frame and waits for it.
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
        if let Err(RenderError::Backend(error)) = &result
            && error.is_of_device()
            && let Some(fallback) = self.fallback.take()
        {
            self.backend = fallback(error);
            return self.render_once(scene, frame);
        }
        result
    }

    fn render_once(&mut self, scene: &Scene, frame: &FrameHandle) -> Result<Frame, RenderError> {
        self.submit_as(scene, frame)?;
        self.wait(frame)
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

    /// Takes a frame as soon as it is done, and sleeps until then.
    ///
    /// # Errors
    /// If the frame failed or was cancelled, or is none of this renderer's.
    pub fn wait(&mut self, frame: &FrameHandle) -> Result<Frame, RenderError> {
        Ok(self.backend.wait_image(frame)?)
    }
}

fn submit(
    planner: &mut Planner,
    backend: &mut dyn Backend,
    scene: &Scene,
    frame: &FrameHandle,
) -> Result<(), RenderError> {
    Ok(backend.submit(&planner.plan(scene)?, frame)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Automatic;
    use slabsplat_backend::{FrameCost, FrameStats};
    use slabsplat_core::{
        Grid, Image, ImageDesc, KernelName, Method, RenderSettings, Scaling, Volume,
    };
    use std::sync::Mutex;

    /// Draws pictures of one colour, until it fails with `error` where `fails_in` says.
    struct Fake {
        caps: Caps,
        color: f32,
        n_good: usize,
        fails_in: Call,
        error: BackendError,
        submitted: Vec<FrameHandle>,
    }

    #[derive(PartialEq)]
    enum Call {
        Submit,
        Poll,
    }

    impl Backend for Fake {
        fn caps(&self) -> &Caps {
            &self.caps
        }

        fn submit(
            &mut self,
            _: &slabsplat_backend::FramePlan<'_>,
            frame: &FrameHandle,
        ) -> Result<(), BackendError> {
            if self.n_good <= self.submitted.len() && self.fails_in == Call::Submit {
                return Err(self.error.clone());
            }
            self.submitted.push(frame.clone());
            Ok(())
        }

        fn poll_image(&mut self, frame: &FrameHandle) -> Result<Poll<Frame>, BackendError> {
            let nth = self.submitted.iter().position(|submitted| submitted == frame);
            if self.n_good <= nth.ok_or(BackendError::UnknownFrame)? {
                return Err(self.error.clone());
            }
            let image = Image::filled(2, 2, [self.color; 4]);
            let (stats, cost) = (FrameStats::default(), FrameCost::default());
            Ok(Poll::Ready(Frame::new(image, stats, cost)))
        }
    }

    fn fake(color: f32, n_good: usize, fails_in: Call, error: BackendError) -> Box<dyn Backend> {
        let caps = Caps::new("fake", "Fake 3000", Method::ALL);
        Box::new(Fake { caps, color, n_good, fails_in, error, submitted: Vec::new() })
    }

    fn lost() -> BackendError {
        BackendError::DeviceLost { device: "Fake 3000".to_owned(), reason: "it fell".to_owned() }
    }

    fn out_of_memory() -> BackendError {
        BackendError::OutOfMemory {
            what: "tiles",
            device: "Fake 3000".to_owned(),
            needed_bytes: 8,
            available_bytes: 4,
        }
    }

    fn unable() -> BackendError {
        BackendError::Unable {
            device: "Fake 3000".to_owned(),
            reason: "it knows no such method".to_owned(),
        }
    }

    fn scene() -> Scene {
        let grid = Grid::with_spacing([2; 3], [1.0; 3]).unwrap();
        let volume = Volume::new(grid, vec![1_u8; 8].into(), Scaling::IDENTITY).unwrap();
        let image = ImageDesc { width: 2, height: 2, background: [0.0; 4] };
        Automatic::new(volume).scene(image, RenderSettings::default())
    }

    /// Renders three frames, the second of which fails, and returns their colours and what was reported.
    fn colors(fails_in: Call, error: BackendError) -> ([f32; 3], Vec<String>) {
        let scene = scene();
        let reports = Arc::new(Mutex::new(Vec::new()));
        let reporter = reports.clone();
        let mut renderer =
            Renderer::new(fake(0.25, 1, fails_in, error)).with_fallback(move |error| {
                reporter.lock().unwrap().push(error.to_string());
                fake(0.75, 9, Call::Submit, lost())
            });
        let colors = [(); 3].map(|()| renderer.render(&scene).unwrap().image.pixel(0, 0)[0]);
        let reports = reports.lock().unwrap().clone();
        (colors, reports)
    }

    #[test]
    fn fallback_draws_the_frame_again_and_all_after() {
        for error in [lost(), out_of_memory(), unable()] {
            for fails_in in [Call::Submit, Call::Poll] {
                let (colors, reports) = colors(fails_in, error.clone());
                assert_eq!(colors, [0.25, 0.75, 0.75], "{error}");
                assert_eq!(reports, [error.to_string()], "reported once");
            }
        }
    }

    #[test]
    fn fallback_is_not_for_what_fails_everywhere() {
        let scene = scene();
        for error in [BackendError::UnknownFrame, BackendError::Cancelled(Cancelled)] {
            let backend = fake(0.25, 0, Call::Poll, error.clone());
            let mut renderer = Renderer::new(backend).with_fallback(|error| panic!("{error}"));
            assert_eq!(renderer.render(&scene), Err(RenderError::Backend(error)));
        }
        let backend = fake(0.25, 0, Call::Poll, lost());
        let mut renderer = Renderer::new(backend).with_fallback(|error| panic!("{error}"));
        let mut odd = scene.clone();
        odd.settings.kernel = KernelName("box".into());
        assert!(matches!(renderer.render(&odd), Err(RenderError::Plan(_))));
    }

    #[test]
    fn frames_are_their_renderers() {
        let scene = scene();
        let mut renderers =
            [0.25, 0.5].map(|color| Renderer::new(fake(color, 9, Call::Poll, lost())));
        let frames = renderers.each_mut().map(|renderer| renderer.submit(&scene).unwrap());
        for (renderer, other) in renderers.iter_mut().zip(frames.iter().rev()) {
            assert_eq!(renderer.poll(other), Err(RenderError::Backend(BackendError::UnknownFrame)));
        }
        for (renderer, own) in renderers.iter_mut().zip(&frames) {
            assert!(renderer.poll(own).unwrap().is_ready());
        }
    }

    #[test]
    fn frames_run_on_the_pool() {
        struct OnPool(Caps);
        impl Backend for OnPool {
            fn caps(&self) -> &Caps {
                &self.0
            }

            fn submit(
                &mut self,
                _: &slabsplat_backend::FramePlan<'_>,
                _: &FrameHandle,
            ) -> Result<(), BackendError> {
                assert_eq!(rayon::current_num_threads(), 3);
                assert!(rayon::current_thread_index().is_some());
                Err(unable())
            }

            fn poll_image(&mut self, _: &FrameHandle) -> Result<Poll<Frame>, BackendError> {
                Err(BackendError::UnknownFrame)
            }
        }
        let caps = Caps::new("fake", "Fake 3000", Method::ALL);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        let mut renderer = Renderer::new(Box::new(OnPool(caps))).with_pool(Arc::new(pool));
        assert_eq!(renderer.render(&scene()), Err(RenderError::Backend(unable())));
    }

    #[test]
    fn failure_without_fallback_is_an_error() {
        let scene = scene();
        let mut renderer = Renderer::new(fake(0.25, 0, Call::Submit, lost()));
        assert_eq!(renderer.render(&scene), Err(RenderError::Backend(lost())));
    }
}
