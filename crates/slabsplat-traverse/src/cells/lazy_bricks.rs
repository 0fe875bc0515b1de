//! Something of each brick, made when it is first asked for.

use std::sync::OnceLock;

/// Something of some bricks. Which have nothing yet takes hardly any memory.
#[derive(Debug)]
pub(super) struct LazyBricks<T>(Vec<OnceLock<Box<[OnceLock<T>]>>>);

/// Bricks whose slots are made together.
const AT_ONCE: usize = 64;

impl<T> LazyBricks<T> {
    /// Of so many bricks.
    pub(super) fn new(n_bricks: usize) -> Self {
        let n_chunks = n_bricks.div_ceil(AT_ONCE);
        Self((0..n_chunks).map(|_| OnceLock::new()).collect())
    }

    pub(super) fn get(&self, brick_idx: u32) -> Option<&T> {
        let idx = brick_idx as usize;
        self.0[idx / AT_ONCE].get()?[idx % AT_ONCE].get()
    }

    /// Retains what a brick has; if another thread was first, what that made.
    pub(super) fn retain(&self, brick_idx: u32, of_brick: T) -> &T {
        let idx = brick_idx as usize;
        let chunk =
            self.0[idx / AT_ONCE].get_or_init(|| (0..AT_ONCE).map(|_| OnceLock::new()).collect());
        chunk[idx % AT_ONCE].get_or_init(|| of_brick)
    }

    /// Forgets everything.
    pub(super) fn clear(&mut self) {
        self.0.iter_mut().for_each(|chunk| *chunk = OnceLock::new());
    }

    /// Bytes of a chunk that has been made, and of all that have not.
    pub(super) fn resident_bytes(&self) -> usize {
        let n_chunks = self.0.iter().filter(|chunk| chunk.get().is_some()).count();
        size_of_val(&*self.0) + n_chunks * AT_ONCE * size_of::<OnceLock<T>>()
    }
}
