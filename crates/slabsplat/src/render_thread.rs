//! A renderer on a thread of its own, for programs that must not wait.
//!
//! The thread draws one frame after the other, in the order in which they were asked for. What it is asked
//! for is a [`Task`] in a queue; who asks has a [`PendingFrame`] of it, and both share a [`Slot`], in which
//! the thread leaves what came of it. No lock is held while anything is drawn, or foreign code is called.

use crate::pending_frame::Slot;
use crate::{NoBackend, PendingFrame, RenderError, Renderer};
use slabsplat_core::{Cancelled, FrameHandle, Scene};
use std::any::Any;
use std::collections::VecDeque;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};

/// Draws frames on a thread of its own: nothing that it is asked takes longer than a copy of a scene, which
/// shares volumes and meshes. It may be asked from any thread. Dropping it cancels all frames.
///
/// ```
/// use slabsplat::{Automatic, ImageDesc, RenderSettings, RenderThread, io};
/// use std::task::Poll;
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let automatic = Automatic::new(io::builtin_volume("sphere", Some(16))?);
/// let image = ImageDesc::new(32, 32);
/// let mut scene = automatic.scene(image, RenderSettings::default());
///
/// let renderer = RenderThread::open("cpu", |note| eprintln!("{note}"))?;
/// let mut pending = renderer.submit_newest(&scene);
/// let frame = loop {
///     if let Poll::Ready(frame) = pending.try_take()? {
///         break frame;
///     }
///     // A window would now show `pending.progress()`, handle its events, and call `pending.cancel()` if the
///     // user is tired of it.
///     std::thread::yield_now();
/// };
/// assert_eq!(frame.image.width(), 32);
///
/// scene.camera = scene.camera.orbited(0.1);
/// let frame = renderer.submit(&scene).wait()?;
/// assert!(0.9 < frame.image.pixel(16, 16)[3], "the middle of the ball is opaque");
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct RenderThread {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

/// What the thread and those who ask it share.
#[derive(Debug, Default)]
struct Shared {
    queue: Mutex<Queue>,
    has_changed: Condvar,
}

#[derive(Debug, Default)]
struct Queue {
    waiting: VecDeque<Task>,
    under_way: Option<FrameHandle>,
    /// What all frames come to once the thread shall end.
    ended_by: Option<RenderError>,
}

/// A frame to be drawn.
#[derive(Debug)]
struct Task {
    scene: Scene,
    frame: FrameHandle,
    slot: Arc<Slot>,
    turn: Turn,
}

/// What becomes of a frame that has not begun when a newer one is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Turn {
    /// It has its turn.
    Queued,
    /// One that is its own kind replaces it.
    Newest,
}

impl RenderThread {
    /// The renderer on a thread of its own.
    ///
    /// # Errors
    /// If the system starts no more threads.
    pub fn spawn(renderer: Renderer) -> io::Result<Self> {
        Self::spawn_with(move || Ok(renderer))
    }

    /// A renderer on the backend called `name`, as [`Renderer::open`] opens it. As drivers may take a second
    /// to start, that happens on the thread: if there is no such backend, all frames say so.
    ///
    /// # Errors
    /// If the system starts no more threads.
    pub fn open(
        name: impl Into<String>,
        tell: impl FnMut(&str) + Send + 'static,
    ) -> io::Result<Self> {
        let name = name.into();
        Self::spawn_with(move || Renderer::open(&name, tell))
    }

    /// The renderer that `make` makes on the thread.
    ///
    /// # Errors
    /// If the system starts no more threads.
    pub fn spawn_with(
        make: impl FnOnce() -> Result<Renderer, NoBackend> + Send + 'static,
    ) -> io::Result<Self> {
        let shared = Arc::new(Shared::default());
        let of_thread = shared.clone();
        let thread = thread::Builder::new().name("slabsplat".to_owned());
        let thread = thread.spawn(move || of_thread.draw_all(make))?;
        Ok(Self { shared, thread: Some(thread) })
    }

    /// Asks for a frame, after all that were asked for before, as for a film.
    pub fn submit(&self, scene: &Scene) -> PendingFrame {
        self.shared.add(scene, &FrameHandle::new(), Turn::Queued)
    }

    /// The same by a handle that is there before.
    #[cfg(feature = "wgpu")]
    pub(crate) fn submit_as(&self, scene: &Scene, frame: &FrameHandle) -> PendingFrame {
        self.shared.add(scene, frame, Turn::Queued)
    }

    /// Asks for a frame instead of any that was asked for by this very method and has not begun: that
    /// one is cancelled. So a program that asks for a frame whenever its user moves the mouse never falls
    /// behind by more than the frame that is under way, which is drawn to its end unless somebody cancels it.
    pub fn submit_newest(&self, scene: &Scene) -> PendingFrame {
        self.shared.add(scene, &FrameHandle::new(), Turn::Newest)
    }
}

impl Drop for RenderThread {
    /// Cancels all frames, and waits until the thread has noticed.
    fn drop(&mut self) {
        self.shared.close(&Cancelled.into());
        if let Some(thread) = self.thread.take()
            // Foreign code that the thread calls when a frame is done may be what drops this.
            && thread.thread().id() != thread::current().id()
        {
            // It never panics, but for what a renderer does when it is dropped.
            drop(thread.join());
        }
    }
}

impl Shared {
    fn locked(&self) -> MutexGuard<'_, Queue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn add(&self, scene: &Scene, frame: &FrameHandle, turn: Turn) -> PendingFrame {
        let (frame, slot) = (frame.clone(), Arc::new(Slot::default()));
        let pending = PendingFrame::new(frame.clone(), slot.clone());
        let task = Task { scene: scene.clone(), frame, slot, turn };
        let is_over = |waiting: &Task| {
            waiting.frame.is_cancelled() || (turn, waiting.turn) == (Turn::Newest, Turn::Newest)
        };
        let mut queue = self.locked();
        let (over, waiting) = queue.waiting.drain(..).partition::<VecDeque<_>, _>(is_over);
        queue.waiting = waiting;
        let refused = match queue.ended_by.clone() {
            Some(error) => Some((task, error)),
            None => {
                queue.waiting.push_back(task);
                None
            }
        };
        drop(queue);
        self.has_changed.notify_one();
        let over = over.into_iter().map(|task| (task, Cancelled.into()));
        over.chain(refused).for_each(|(task, error)| task.end_with(error));
        pending
    }

    /// Ends all frames that wait and those that are still to come, and cancels the one under way.
    fn close(&self, why: &RenderError) {
        let mut queue = self.locked();
        queue.ended_by.get_or_insert_with(|| why.clone());
        if let Some(frame) = &queue.under_way {
            frame.cancel();
        }
        let waiting = std::mem::take(&mut queue.waiting);
        drop(queue);
        self.has_changed.notify_one();
        waiting.into_iter().for_each(|task| task.end_with(why.clone()));
    }

    /// What the thread does: draws frame after frame, until it shall end or the renderer is broken.
    fn draw_all(&self, make: impl FnOnce() -> Result<Renderer, NoBackend>) {
        let mut renderer = match caught(|| Ok(make()?)) {
            Ok(renderer) => renderer,
            Err(error) => return self.close(&error),
        };
        while let Some(Task { scene, frame, slot, .. }) = self.next() {
            let result = caught(|| renderer.render_as(&scene, &frame));
            self.locked().under_way = None;
            if let Err(broken @ RenderError::Panicked { .. }) = &result {
                self.close(broken);
            }
            slot.end_with(result);
        }
    }

    /// The next frame, as soon as there is one; `None` if there will be none.
    fn next(&self) -> Option<Task> {
        let mut queue = self.locked();
        while queue.waiting.is_empty() && queue.ended_by.is_none() {
            queue = self.has_changed.wait(queue).unwrap_or_else(PoisonError::into_inner);
        }
        let task = queue.waiting.pop_front()?;
        queue.under_way = Some(task.frame.clone());
        Some(task)
    }
}

impl Task {
    fn end_with(self, error: RenderError) {
        self.slot.end_with(Err(error));
    }
}

/// What `work` returns, or that it panicked.
fn caught<T>(work: impl FnOnce() -> Result<T, RenderError>) -> Result<T, RenderError> {
    // Nothing is used again that a panic may have left half done.
    let panicked = |payload: Box<dyn Any + Send>| {
        Err(RenderError::Panicked { message: message_of(&*payload).to_owned() })
    };
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(panicked)
}

fn message_of(payload: &(dyn Any + Send)) -> &str {
    let as_str = payload.downcast_ref::<&str>().copied();
    let as_string = || payload.downcast_ref::<String>().map(String::as_str);
    as_str.or_else(as_string).unwrap_or("without a message")
}

#[cfg(test)]
mod tests;
