//! A frame that another thread draws.

use crate::RenderError;
use slabsplat_backend::{BackendError, Frame};
use slabsplat_core::{Cancelled, FrameHandle};
use std::mem;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::pin::Pin;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll, Waker};

/// A frame that a [`RenderThread`](crate::RenderThread) was asked for. It can be looked at once in a while
/// ([`try_take`](Self::try_take)), waited for ([`wait`](Self::wait)), or awaited: it is a future that any
/// executor drives.
///
/// Who drops it wants the frame no more: it is cancelled. If its `RenderThread` is dropped, it is so too.
#[derive(Debug)]
#[must_use = "a frame is cancelled when this is dropped"]
pub struct PendingFrame {
    frame: FrameHandle,
    slot: Arc<Slot>,
}

/// Where the thread leaves what came of a frame.
#[derive(Debug, Default)]
pub(crate) struct Slot {
    state: Mutex<State>,
    is_done: Condvar,
}

#[derive(Debug)]
enum State {
    /// Whoever awaits it is to be woken.
    Pending(Option<Waker>),
    Done(Result<Frame, RenderError>),
    Taken,
}

impl Default for State {
    fn default() -> Self {
        Self::Pending(None)
    }
}

impl PendingFrame {
    pub(crate) fn new(frame: FrameHandle, slot: Arc<Slot>) -> Self {
        Self { frame, slot }
    }

    /// A handle by which others may watch the frame, and cancel it; whoever waits for it is told so when the
    /// thread comes to it, and within milliseconds if it is under way.
    pub fn handle(&self) -> &FrameHandle {
        &self.frame
    }

    /// How much of the frame is drawn, 0 … 1, as the share of its slabs; 0 while it waits for its turn.
    pub fn progress(&self) -> f32 {
        self.frame.progress()
    }

    /// Asks for the frame to be dropped, whether it has begun or not. Nobody waits for it any more.
    pub fn cancel(&self) {
        self.frame.cancel();
        self.slot.end_with(Err(Cancelled.into()));
    }

    /// Takes the frame if it is done, without waiting.
    ///
    /// # Errors
    /// If the frame failed or was cancelled, or was taken already.
    pub fn try_take(&mut self) -> Result<Poll<Frame>, RenderError> {
        self.taken(&mut self.slot.locked())
            .map_or(Ok(Poll::Pending), |taken| taken.map(Poll::Ready))
    }

    /// Takes the frame as soon as it is done, and sleeps until then.
    ///
    /// # Errors
    /// If the frame failed or was cancelled, or was taken already.
    pub fn wait(self) -> Result<Frame, RenderError> {
        let mut state = self.slot.locked();
        loop {
            if let Some(taken) = self.taken(&mut state) {
                return taken;
            }
            state = self.slot.is_done.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// What came of the frame, if it is done.
    fn taken(&self, state: &mut State) -> Option<Result<Frame, RenderError>> {
        match mem::replace(state, State::Taken) {
            State::Pending(_) | State::Done(Ok(_)) if self.frame.is_cancelled() => {
                Some(Err(Cancelled.into()))
            }
            State::Pending(waker) => {
                *state = State::Pending(waker);
                None
            }
            State::Done(result) => Some(result),
            State::Taken => Some(Err(BackendError::UnknownFrame.into())),
        }
    }
}

impl Future for PendingFrame {
    type Output = Result<Frame, RenderError>;

    fn poll(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Self::Output> {
        let mut state = self.slot.locked();
        if let Some(taken) = self.taken(&mut state) {
            return Poll::Ready(taken);
        }
        *state = State::Pending(Some(context.waker().clone()));
        Poll::Pending
    }
}

impl Drop for PendingFrame {
    fn drop(&mut self) {
        self.frame.cancel();
    }
}

impl Slot {
    fn locked(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Leaves what came of the frame, unless that is there already.
    pub(crate) fn end_with(&self, result: Result<Frame, RenderError>) {
        let mut state = self.locked();
        let State::Pending(waker) = &mut *state else { return };
        let waker = waker.take();
        *state = State::Done(result);
        drop(state);
        self.is_done.notify_all();
        if let Some(waker) = waker {
            // An executor that panics here must not take the thread with it, and all frames that wait.
            drop(catch_unwind(AssertUnwindSafe(|| waker.wake())));
        }
    }
}
