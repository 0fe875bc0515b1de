//! Which part of its frame a stage draws.

use slabsplat_core::FrameHandle;

/// A stage that takes a frame from one share of what is to be drawn to another.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Progress<'a> {
    pub(crate) frame: &'a FrameHandle,
    pub(crate) from: f32,
    pub(crate) to: f32,
}

impl<'a> Progress<'a> {
    /// Of a stage that draws all.
    pub(crate) fn of_all(frame: &'a FrameHandle) -> Self {
        Self { frame, from: 0.0, to: 1.0 }
    }

    /// One of so many equal parts.
    pub(crate) fn part(&self, part: usize, n_parts: usize) -> Self {
        self.between(part, part + 1, n_parts)
    }

    /// What follows `n_done` of so many equal parts, up to where `n_then` are done.
    pub(crate) fn between(&self, n_done: usize, n_then: usize, n_parts: usize) -> Self {
        let at = |n: usize| self.from + (self.to - self.from) * n as f32 / n_parts.max(1) as f32;
        Self { frame: self.frame, from: at(n_done), to: at(n_then) }
    }

    /// All of it is drawn.
    pub(crate) fn finish(&self) {
        self.frame.reach(self.to);
    }
}
