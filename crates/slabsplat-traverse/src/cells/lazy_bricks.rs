//! Something of each brick, made when it is first asked for.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering};

/// Something of some bricks, with the last frame that asked for it. Bricks of which nothing was asked take
/// hardly any memory.
#[derive(Debug)]
pub(super) struct LazyBricks<T>(Vec<OnceLock<Box<[Slot<T>]>>>);

#[derive(Debug)]
struct Slot<T> {
    of_brick: OnceLock<T>,
    last_frame: AtomicU32,
}

/// Bricks whose slots are made together.
const AT_ONCE: usize = 64;

impl<T> LazyBricks<T> {
    /// Of so many bricks.
    pub(super) fn new(n_bricks: usize) -> Self {
        let n_chunks = n_bricks.div_ceil(AT_ONCE);
        Self((0..n_chunks).map(|_| OnceLock::new()).collect())
    }

    /// What there is of a brick.
    pub(super) fn get(&self, brick_idx: u32, frame: u32) -> Option<&T> {
        let idx = brick_idx as usize;
        let slot = &self.0[idx / AT_ONCE].get()?[idx % AT_ONCE];
        slot.last_frame.store(frame, Ordering::Relaxed);
        slot.of_brick.get()
    }

    /// Retains what a brick has; if another thread was first, what that made.
    pub(super) fn retain(&self, brick_idx: u32, frame: u32, of_brick: T) -> &T {
        let idx = brick_idx as usize;
        let chunk =
            self.0[idx / AT_ONCE].get_or_init(|| (0..AT_ONCE).map(|_| Slot::default()).collect());
        let slot = &chunk[idx % AT_ONCE];
        slot.last_frame.store(frame, Ordering::Relaxed);
        slot.of_brick.get_or_init(|| of_brick)
    }

    /// Forgets what no frame from that on has asked for, and returns the sum of what `bytes_of` says of it.
    pub(super) fn forget_before(&mut self, frame: u32, bytes_of: impl Fn(&T) -> usize) -> usize {
        let mut n_bytes = 0;
        for slot in self.0.iter_mut().filter_map(OnceLock::get_mut).flatten() {
            if *slot.last_frame.get_mut() < frame {
                n_bytes += slot.of_brick.take().map_or(0, |of_brick| bytes_of(&of_brick));
            }
        }
        n_bytes
    }

    /// Bytes of slots, beside what these hold.
    pub(super) fn resident_bytes(&self) -> usize {
        let n_chunks = self.0.iter().filter(|chunk| chunk.get().is_some()).count();
        size_of_val(&*self.0) + n_chunks * AT_ONCE * size_of::<Slot<T>>()
    }
}

impl<T> Default for Slot<T> {
    fn default() -> Self {
        Self { of_brick: OnceLock::new(), last_frame: AtomicU32::new(0) }
    }
}
