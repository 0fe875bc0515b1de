//! Frames of a backend that draws when it is told to.

use super::*;
use crate::{Automatic, Backend, BackendError, Caps, Frame, FramePlan, RenderSettings};
use slabsplat_backend::{FrameCost, FrameStats};
use slabsplat_core::{Grid, Image, ImageDesc, Method, Scaling, Volume};
use std::pin::pin;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::task::{Context, Poll, Wake, Waker};
use std::thread::Thread;

/// What the backend is told to do with a frame.
enum Order {
    Draw,
    Fail,
    Panic,
}

/// Says which frame it begins, by its width, and waits for an order or for the frame to be cancelled.
struct Ordered {
    caps: Caps,
    begun: Sender<u32>,
    orders: Receiver<Order>,
    done: Option<(FrameHandle, Frame)>,
}

const UNABLE: &str = "it was told so";

impl Backend for Ordered {
    fn caps(&self) -> &Caps {
        &self.caps
    }

    fn submit(&mut self, plan: &FramePlan<'_>, frame: &FrameHandle) -> Result<(), BackendError> {
        let _ = self.begun.send(plan.image.width);
        loop {
            frame.check()?;
            match self.orders.try_recv() {
                Ok(Order::Draw) => break,
                Ok(Order::Fail) => {
                    let (device, reason) = (self.caps.device.clone(), UNABLE.to_owned());
                    return Err(BackendError::Unable { device, reason });
                }
                Ok(Order::Panic) => panic!("told to panic over {}", plan.image.width),
                Err(TryRecvError::Empty | TryRecvError::Disconnected) => thread::yield_now(),
            }
        }
        frame.reach(1.0);
        let image = Image::filled(plan.image.width, 1, [0.0; 4]);
        let drawn = Frame::new(image, FrameStats::default(), FrameCost::default());
        self.done = Some((frame.clone(), drawn));
        Ok(())
    }

    fn poll_image(&mut self, frame: &FrameHandle) -> Result<Poll<Frame>, BackendError> {
        let taken = self.done.take_if(|(done, _)| done == frame);
        taken.map(|(_, drawn)| Poll::Ready(drawn)).ok_or(BackendError::UnknownFrame)
    }
}

/// A thread with such a backend, what it began, and who gives the orders.
struct Workshop {
    thread: RenderThread,
    begun: Receiver<u32>,
    orders: Sender<Order>,
}

fn workshop() -> Workshop {
    let ((told, begun), (orders, obeyed)) = (channel(), channel());
    let caps = Caps::new("ordered", "nothing", Method::ALL);
    let backend = Ordered { caps, begun: told, orders: obeyed, done: None };
    let thread = RenderThread::spawn(Renderer::new(Box::new(backend))).unwrap();
    Workshop { thread, begun, orders }
}

fn scene(width: u32) -> Scene {
    let grid = Grid::with_spacing([2; 3], [1.0; 3]).unwrap();
    let volume = Volume::new(grid, vec![1_u8; 8].into(), Scaling::IDENTITY).unwrap();
    let image = ImageDesc::new(width, 1);
    Automatic::new(volume).scene(image, RenderSettings::default())
}

fn cancelled<T>() -> Result<T, RenderError> {
    Err(Cancelled.into())
}

fn width(result: Result<Frame, RenderError>) -> Result<u32, RenderError> {
    result.map(|frame| frame.image.width())
}

#[test]
fn frames_have_their_turns() {
    let Workshop { thread, begun, orders } = workshop();
    let frames = [1, 2, 3].map(|width| thread.submit(&scene(width)));
    for (frame, expected) in frames.into_iter().zip(1..) {
        assert_eq!(begun.recv(), Ok(expected));
        assert!(frame.progress() < 1.0);
        orders.send(Order::Draw).unwrap();
        assert_eq!(width(frame.wait()), Ok(expected));
    }
}

#[test]
fn newest_replaces_what_has_not_begun() {
    let Workshop { thread, begun, orders } = workshop();
    let under_way = thread.submit_newest(&scene(1));
    assert_eq!(begun.recv(), Ok(1));
    let queued = thread.submit(&scene(2));
    let old = thread.submit_newest(&scene(3));
    let older = thread.submit_newest(&scene(4));
    assert_eq!(width(old.wait()), cancelled(), "at once: nothing was drawn since");
    let newest = thread.submit_newest(&scene(5));
    assert_eq!(width(older.wait()), cancelled());
    for (frame, expected) in [(under_way, 1), (queued, 2), (newest, 5)] {
        orders.send(Order::Draw).unwrap();
        assert_eq!(width(frame.wait()), Ok(expected));
    }
    assert_eq!(begun.try_iter().collect::<Vec<_>>(), [2, 5]);
}

#[test]
fn cancelled_frames_make_way() {
    let Workshop { thread, begun, orders } = workshop();
    let [mut first, mut second, dropped, last] =
        [1, 2, 3, 4].map(|width| thread.submit(&scene(width)));
    assert_eq!(begun.recv(), Ok(1));
    assert!(first.try_take().unwrap().is_pending());
    // The one under way last: with it gone, the thread takes up whatever still waits.
    drop(dropped);
    second.handle().clone().cancel();
    first.cancel();
    for frame in [&mut first, &mut second] {
        assert_eq!(frame.try_take(), cancelled());
        assert_eq!(frame.try_take(), Err(BackendError::UnknownFrame.into()), "it is gone");
    }
    assert_eq!(begun.recv(), Ok(4), "nobody wants the two before it");
    orders.send(Order::Draw).unwrap();
    assert_eq!(width(last.wait()), Ok(4));
}

#[test]
fn frame_under_way_is_cancelled_for_who_waits() {
    let Workshop { thread, begun, .. } = workshop();
    let frame = thread.submit(&scene(1));
    let handle = frame.handle().clone();
    assert_eq!(begun.recv(), Ok(1));
    thread::scope(|scope| {
        let waiting = scope.spawn(|| frame.wait());
        handle.cancel();
        assert_eq!(waiting.join().unwrap(), cancelled());
    });
}

#[test]
fn drop_cancels_all_frames() {
    let Workshop { thread, begun, .. } = workshop();
    let [under_way, mut queued] = [1, 2].map(|width| thread.submit(&scene(width)));
    let newest = thread.submit_newest(&scene(3));
    assert_eq!(begun.recv(), Ok(1));
    drop(thread);
    assert_eq!(queued.try_take(), cancelled());
    assert_eq!((under_way.wait(), newest.wait()), (cancelled(), cancelled()));
    assert!(begun.recv().is_err(), "the backend is gone, and began no other");
}

#[test]
fn failures_are_the_frames_own() {
    let Workshop { thread, orders, .. } = workshop();
    orders.send(Order::Fail).unwrap();
    let failed = thread.submit(&scene(1)).wait();
    assert!(
        matches!(&failed, Err(RenderError::Backend(BackendError::Unable { .. }))),
        "{failed:?}"
    );
    orders.send(Order::Draw).unwrap();
    assert_eq!(width(thread.submit(&scene(2)).wait()), Ok(2));
    let bad = Scene::of_meshes(Vec::new(), scene(1).camera);
    assert!(matches!(thread.submit(&bad).wait(), Err(RenderError::Plan(_))));
}

#[test]
fn panic_is_an_error_of_all_frames() {
    let Workshop { thread, begun, orders } = workshop();
    let [under_way, queued] = [1, 2].map(|width| thread.submit(&scene(width)));
    assert_eq!(begun.recv(), Ok(1));
    orders.send(Order::Panic).unwrap();
    let expected = RenderError::Panicked { message: "told to panic over 1".to_owned() };
    for result in [under_way.wait(), queued.wait(), thread.submit_newest(&scene(3)).wait()] {
        assert_eq!(result, Err(expected.clone()));
    }
}

#[test]
fn backend_that_is_not_there_is_an_error_of_all_frames() {
    let thread = RenderThread::open("cray", |_| ()).unwrap();
    for _ in 0..2 {
        let failed = thread.submit(&scene(1)).wait();
        assert!(matches!(failed, Err(RenderError::NoBackend(NoBackend::Unknown { .. }))));
    }
    let thread = RenderThread::spawn_with(|| panic!("no")).unwrap();
    let failed = thread.submit(&scene(1)).wait();
    assert_eq!(failed, Err(RenderError::Panicked { message: "no".to_owned() }));
}

/// Wakes a thread, and counts how often.
struct Alarm {
    sleeper: Thread,
    n_calls: AtomicUsize,
}

impl Wake for Alarm {
    fn wake(self: Arc<Self>) {
        self.n_calls.fetch_add(1, Ordering::SeqCst);
        self.sleeper.unpark();
    }
}

fn alarm() -> (Arc<Alarm>, Waker) {
    let alarm = Arc::new(Alarm { sleeper: thread::current(), n_calls: AtomicUsize::new(0) });
    (alarm.clone(), alarm.into())
}

#[test]
fn frame_is_a_future() {
    let Workshop { thread, begun, orders } = workshop();
    let mut frame = pin!(async { thread.submit(&scene(7)).await.map(|f| f.image.width()) });
    let [(old, old_waker), (alarm, waker)] = [alarm(), alarm()];
    assert!(frame.as_mut().poll(&mut Context::from_waker(&old_waker)).is_pending());
    assert_eq!(begun.recv(), Ok(7));
    assert!(frame.as_mut().poll(&mut Context::from_waker(&waker)).is_pending());
    orders.send(Order::Draw).unwrap();
    let result = loop {
        if let Poll::Ready(result) = frame.as_mut().poll(&mut Context::from_waker(&waker)) {
            break result;
        }
        thread::park();
    };
    assert_eq!(result, Ok(7));
    assert_eq!(old.n_calls.load(Ordering::SeqCst), 0, "the last waker is the one that counts");
    assert!(alarm.n_calls.load(Ordering::SeqCst) <= 1);
}

#[test]
fn future_wakes_when_its_frame_is_cancelled() {
    let Workshop { thread, begun, .. } = workshop();
    let under_way = thread.submit(&scene(1));
    assert_eq!(begun.recv(), Ok(1));
    let mut replaced = thread.submit_newest(&scene(2));
    let (alarm, waker) = alarm();
    let mut context = Context::from_waker(&waker);
    assert!(pin!(&mut replaced).poll(&mut context).is_pending());
    let mut newest = thread.submit_newest(&scene(3));
    assert_eq!(alarm.n_calls.load(Ordering::SeqCst), 1);
    assert_eq!(pin!(&mut replaced).poll(&mut context), Poll::Ready(cancelled()));
    assert!(pin!(&mut newest).poll(&mut context).is_pending());
    drop(thread);
    assert_eq!(alarm.n_calls.load(Ordering::SeqCst), 2);
    assert_eq!(pin!(&mut newest).poll(&mut context), Poll::Ready(cancelled()));
    assert_eq!(width(under_way.wait()), cancelled());
}

/// An executor may do anything when it is woken, even to drop the thread, or to panic.
#[test]
fn waker_may_be_anything() {
    struct Dropping(Mutex<Option<RenderThread>>);
    impl Wake for Dropping {
        fn wake(self: Arc<Self>) {
            drop(self.0.lock().unwrap().take());
            panic!("an executor that fails");
        }
    }
    let Workshop { thread, begun, orders } = workshop();
    let [mut frame, queued] = [1, 2].map(|width| thread.submit(&scene(width)));
    let waker = Waker::from(Arc::new(Dropping(Mutex::new(Some(thread)))));
    assert!(pin!(&mut frame).poll(&mut Context::from_waker(&waker)).is_pending());
    assert_eq!(begun.recv(), Ok(1));
    orders.send(Order::Draw).unwrap();
    assert_eq!(width(frame.wait()), Ok(1));
    assert_eq!(width(queued.wait()), cancelled());
}
