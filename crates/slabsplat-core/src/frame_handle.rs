//! The name of a frame, by which it is watched and cancelled while others make it.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use thiserror::Error;

/// Names one frame. Who asks for a frame makes a handle, and gives it to whoever makes the frame; by a clone
/// of it, on any thread, the frame is watched and cancelled.
///
/// Two handles are equal if one is a clone of the other. So a frame can be taken by those alone who have a
/// handle of it, from the one to which it was given, and not by a number that somebody guessed.
///
/// ```
/// use slabsplat_core::FrameHandle;
///
/// let frame = FrameHandle::new();
/// let of_button = frame.clone();
/// assert!(of_button == frame && FrameHandle::new() != frame);
///
/// of_button.cancel();
/// assert!(frame.is_cancelled());
/// ```
#[derive(Clone, Debug, Default)]
pub struct FrameHandle(Arc<State>);

#[derive(Debug, Default)]
struct State {
    is_cancelled: AtomicBool,
    /// The bits of the share that is done: those of floats from 0 on rise as the floats do.
    progress: AtomicU32,
    /// The frame that it is a part of, and from which share to which.
    whole: Option<(FrameHandle, Range<f32>)>,
}

/// The frame was cancelled before it was done.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[error("the frame was cancelled")]
#[expect(clippy::exhaustive_structs, reason = "there is nothing more to say of it")]
pub struct Cancelled;

/// Why what a frame needs was not made.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[expect(clippy::exhaustive_enums, reason = "whoever answers for a frame says each to the caller")]
pub enum StageError {
    /// Nobody wants the frame any more.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// The system has no room for it.
    #[error("the frame needs {needed_bytes} bytes for {what}, and the system has no room for them")]
    OutOfMemory {
        /// What the memory is for.
        what: &'static str,
        /// Bytes needed.
        needed_bytes: u64,
    },
}

impl FrameHandle {
    /// A handle of a frame that was not begun.
    pub fn new() -> Self {
        Self::default()
    }

    /// Names a part of the frame, which is made as a frame is: it is cancelled with the frame, and as it is
    /// made the frame proceeds from the first of these shares to the last.
    ///
    /// ```
    /// use slabsplat_core::FrameHandle;
    ///
    /// let frame = FrameHandle::new();
    /// let second_half = frame.part(0.5..1.0);
    /// second_half.reach(0.5);
    /// assert_eq!(frame.progress(), 0.75);
    ///
    /// frame.cancel();
    /// assert!(second_half.is_cancelled());
    /// ```
    #[must_use]
    pub fn part(&self, shares: Range<f32>) -> Self {
        let whole = Some((self.clone(), shares));
        Self(Arc::new(State { whole, ..State::default() }))
    }

    /// Asks for the frame to be dropped, as soon as whoever makes it looks: on the CPU within milliseconds,
    /// on a GPU when what was sent to it is done. It is then never delivered.
    pub fn cancel(&self) {
        self.0.is_cancelled.store(true, Ordering::Release);
    }

    /// Whether anyone has asked for that.
    #[inline]
    pub fn is_cancelled(&self) -> bool {
        self.0.is_cancelled.load(Ordering::Relaxed)
            || self.0.whole.as_ref().is_some_and(|(whole, _)| whole.is_cancelled())
    }

    /// How much of the frame is drawn, 0 … 1, as the share of its slabs; it never falls. A GPU does not say
    /// so before all is.
    pub fn progress(&self) -> f32 {
        f32::from_bits(self.0.progress.load(Ordering::Relaxed))
    }

    /// For who makes the frame: continues unless it was cancelled.
    ///
    /// # Errors
    /// If it was.
    #[inline]
    pub fn check(&self) -> Result<(), Cancelled> {
        if self.is_cancelled() { Err(Cancelled) } else { Ok(()) }
    }

    /// For who makes the frame: so much is drawn, if that is more than before.
    pub fn reach(&self, share: f32) {
        if 0.0 < share {
            self.0.progress.fetch_max(share.min(1.0).to_bits(), Ordering::Relaxed);
            if let Some((whole, shares)) = &self.0.whole {
                whole.reach(shares.start + share.min(1.0) * (shares.end - shares.start));
            }
        }
    }

    /// Whether there is no other handle of the frame, so that nobody can take it any more.
    pub fn is_abandoned(&self) -> bool {
        self.n_handles() == 1
    }

    /// How many handles of the frame there are, with this one.
    pub fn n_handles(&self) -> usize {
        Arc::strong_count(&self.0)
    }
}

impl PartialEq for FrameHandle {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl Eq for FrameHandle {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frame_handle_names_one_frame() {
        let [a, b] = [FrameHandle::new(), FrameHandle::new()];
        let again = a.clone();
        assert!(a == again && a != b);
        assert_eq!((a.n_handles(), b.n_handles()), (2, 1));
        assert!(!a.is_abandoned() && b.is_abandoned());
        drop(again);
        assert!(a.is_abandoned());
    }

    #[test]
    fn frame_handle_is_cancelled_for_all_who_have_it() {
        let [a, b] = [FrameHandle::new(), FrameHandle::new()];
        assert_eq!(a.check(), Ok(()));
        a.clone().cancel();
        assert_eq!((a.check(), b.check()), (Err(Cancelled), Ok(())));
    }

    #[test]
    fn frame_handle_of_a_part_is_its_own() {
        let frame = FrameHandle::new();
        let [near, far] = [0.0..0.5, 0.5..1.0].map(|shares| frame.part(shares));
        near.cancel();
        assert!(near.is_cancelled() && !frame.is_cancelled() && !far.is_cancelled());
        far.part(0.0..0.5).reach(7.0);
        near.reach(0.25);
        assert_eq!([near.progress(), far.progress(), frame.progress()], [0.25, 0.5, 0.75]);
        frame.cancel();
        assert_eq!(far.part(0.0..1.0).check(), Err(Cancelled));
        assert!(far != frame && far.n_handles() == 1);
    }

    #[test]
    fn frame_handle_progress_never_falls() {
        let frame = FrameHandle::new();
        let reached = [-1.0, 0.25, 0.125, f32::NAN, 0.5, 7.0, 0.75].map(|share| {
            frame.reach(share);
            frame.progress()
        });
        assert_eq!(reached, [0.0, 0.25, 0.25, 0.25, 0.5, 1.0, 1.0]);
    }
}
