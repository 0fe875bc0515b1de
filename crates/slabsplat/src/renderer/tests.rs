//! Renderers on backends that fail, or take their time.

use super::*;
use crate::Automatic;
use slabsplat_backend::{FrameCost, FrameStats};
use slabsplat_core::{Grid, Image, ImageDesc, KernelName, Method, RenderSettings, Scaling, Volume};
use std::pin::pin;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Wake, Waker};

/// Draws pictures of one colour, until it fails with `error` where `fails_in` says.
struct Fake {
    caps: Caps,
    color: f32,
    n_good: usize,
    fails_in: Call,
    error: BackendError,
    submitted: Vec<FrameHandle>,
    /// How often a frame is still pending when it is asked for.
    n_pending: usize,
}

#[derive(Clone, Copy, PartialEq)]
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
        if let Some(fewer) = self.n_pending.checked_sub(1) {
            self.n_pending = fewer;
            return Ok(Poll::Pending);
        }
        let image = Image::filled(2, 2, [self.color; 4]);
        let (stats, cost) = (FrameStats::default(), FrameCost::default());
        Ok(Poll::Ready(Frame::new(image, stats, cost)))
    }
}

fn fake(color: f32, n_good: usize, fails_in: Call, error: BackendError) -> Box<dyn Backend> {
    let caps = Caps::new("fake", "Fake 3000", Method::ALL);
    Box::new(Fake { caps, color, n_good, fails_in, error, submitted: Vec::new(), n_pending: 0 })
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
    let image = ImageDesc::new(2, 2);
    Automatic::new(volume).scene(image, RenderSettings::default())
}

/// Renders three frames, the second of which fails, and returns their colours and what was reported.
fn colors(
    fails_in: Call,
    error: BackendError,
    mut render: impl FnMut(&mut Renderer, &Scene) -> Result<Frame, RenderError>,
) -> ([f32; 3], Vec<String>) {
    let scene = scene();
    let reports = Arc::new(Mutex::new(Vec::new()));
    let reporter = reports.clone();
    let mut renderer = Renderer::new(fake(0.25, 1, fails_in, error)).with_fallback(move |error| {
        reporter.lock().unwrap().push(error.to_string());
        fake(0.75, 9, Call::Submit, lost())
    });
    let colors = [(); 3].map(|()| render(&mut renderer, &scene).unwrap().image.pixel(0, 0)[0]);
    let reports = reports.lock().unwrap().clone();
    (colors, reports)
}

/// What an executor does: it polls whenever it is woken. Also how often it did.
fn executed<T>(future: impl Future<Output = T>) -> (T, usize) {
    struct Woken(AtomicBool);
    impl Wake for Woken {
        fn wake(self: Arc<Self>) {
            self.0.store(true, Ordering::Relaxed);
        }
    }
    let mut future = pin!(future);
    let woken = Arc::new(Woken(AtomicBool::new(true)));
    let waker = woken.clone().into();
    let mut n_polls = 0;
    // Nothing but the poll could wake it here.
    while woken.0.swap(false, Ordering::Relaxed) {
        n_polls += 1;
        if let Poll::Ready(value) = future.as_mut().poll(&mut Context::from_waker(&waker)) {
            return (value, n_polls);
        }
    }
    panic!("it sleeps for ever")
}

#[test]
fn fallback_draws_the_frame_again_and_all_after() {
    for error in [lost(), out_of_memory(), unable()] {
        for fails_in in [Call::Submit, Call::Poll] {
            let waited = colors(fails_in, error.clone(), Renderer::render);
            let awaited = colors(fails_in, error.clone(), |renderer, scene| {
                executed(renderer.render_async(scene)).0
            });
            for (colors, reports) in [waited, awaited] {
                assert_eq!(colors, [0.25, 0.75, 0.75], "{error}");
                assert_eq!(reports, [error.to_string()], "reported once");
            }
        }
    }
}

fn slow(n_pending: usize) -> Renderer {
    let caps = Caps::new("slow", "Fake 3000", Method::ALL);
    let (submitted, fails_in) = (Vec::new(), Call::Submit);
    let slow = Fake { caps, color: 0.5, n_good: 9, fails_in, error: lost(), submitted, n_pending };
    Renderer::new(Box::new(slow))
}

#[test]
fn awaited_frame_is_polled_until_it_is_done() {
    let (frame, n_polls) = executed(slow(3).render_async(&scene()));
    assert_eq!(frame.unwrap().image.pixel(0, 0), [0.5; 4]);
    assert_eq!(n_polls, 4);
    let bad = Scene::of_meshes(Vec::new(), scene().camera);
    assert!(matches!(executed(slow(0).render_async(&bad)).0, Err(RenderError::Plan(_))));
}

#[test]
fn awaited_frame_may_be_awaited_again() {
    let (mut renderer, scene) = (slow(1), scene());
    let frame = renderer.submit(&scene).unwrap();
    {
        let mut dropped = pin!(renderer.wait_async(&frame));
        assert!(dropped.as_mut().poll(&mut Context::from_waker(Waker::noop())).is_pending());
    }
    assert!(executed(renderer.wait_async(&frame)).0.is_ok());
    let never = executed(renderer.wait_async(&FrameHandle::new())).0;
    assert_eq!(never, Err(RenderError::Backend(BackendError::UnknownFrame)));
}

/// Executors with threads move what they drive.
#[test]
fn awaited_frame_goes_to_other_threads() {
    let (mut renderer, scene) = (slow(2), scene());
    let color = std::thread::scope(|scope| {
        let future = async { renderer.render_async(&scene).await.map(|frame| frame.image) };
        let drawn = scope.spawn(move || executed(future).0);
        drawn.join().unwrap().unwrap().pixel(1, 1)
    });
    assert_eq!(color, [0.5; 4]);
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
    let mut renderers = [0.25, 0.5].map(|color| Renderer::new(fake(color, 9, Call::Poll, lost())));
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
