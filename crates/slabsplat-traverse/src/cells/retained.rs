//! How much is retained of bricks.
//!
//! A brick of cells takes as much as one of voxels, and is made of eight of these and more, classified: so
//! cells go first, and voxels have what these left in the frame before.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// A budget of bytes, and what is spent of it.
#[derive(Debug)]
pub(super) struct Retained {
    budget: usize,
    /// What voxels may take of it.
    for_voxels: usize,
    /// Of voxels and cells.
    bytes: AtomicUsize,
    of_voxels: AtomicUsize,
    /// Of cells that this frame made and had no room for.
    of_missed_cells: AtomicUsize,
    is_spent: AtomicBool,
}

impl Retained {
    /// Nothing, of so many bytes.
    pub(super) fn new(budget: usize) -> Self {
        Self {
            budget,
            for_voxels: budget,
            bytes: AtomicUsize::new(0),
            of_voxels: AtomicUsize::new(0),
            of_missed_cells: AtomicUsize::new(0),
            is_spent: AtomicBool::new(false),
        }
    }

    /// Whether there is room for so many bytes of voxels, which are then spent.
    pub(super) fn spends_on_voxels(&self, bytes: usize) -> bool {
        let before = self.of_voxels.fetch_add(bytes, Ordering::Relaxed);
        let has_room = before + bytes <= self.for_voxels && self.spends(bytes);
        if !has_room {
            self.of_voxels.fetch_sub(bytes, Ordering::Relaxed);
            self.is_spent.store(true, Ordering::Relaxed);
        }
        has_room
    }

    /// The same of cells.
    pub(super) fn spends_on_cells(&self, bytes: usize) -> bool {
        let has_room = self.spends(bytes);
        if !has_room {
            self.of_missed_cells.fetch_add(bytes, Ordering::Relaxed);
            self.is_spent.store(true, Ordering::Relaxed);
        }
        has_room
    }

    fn spends(&self, bytes: usize) -> bool {
        let before = self.bytes.fetch_add(bytes, Ordering::Relaxed);
        let has_room = before + bytes <= self.budget;
        if !has_room {
            self.bytes.fetch_sub(bytes, Ordering::Relaxed);
        }
        has_room
    }

    /// Whether a frame asked for more than there was room for, since it was last asked.
    pub(super) fn was_spent(&mut self) -> bool {
        std::mem::take(self.is_spent.get_mut())
    }

    /// So many bytes of voxels are no longer there.
    pub(super) fn forget_voxels(&mut self, bytes: usize) {
        *self.of_voxels.get_mut() -= bytes;
        *self.bytes.get_mut() -= bytes;
    }

    /// The same of cells.
    pub(super) fn forget_cells(&mut self, bytes: usize) {
        *self.bytes.get_mut() -= bytes;
    }

    /// Sets apart room for the cells for which the last frame had none. Returns whether voxels take some of
    /// it.
    pub(super) fn make_room_for_cells(&mut self) -> bool {
        let of_voxels = *self.of_voxels.get_mut();
        let of_cells = *self.bytes.get_mut() - of_voxels;
        let missed = std::mem::take(self.of_missed_cells.get_mut());
        self.for_voxels = self.budget.saturating_sub(of_cells + missed);
        self.for_voxels < of_voxels
    }

    /// Bytes that are spent.
    pub(super) fn bytes(&self) -> usize {
        self.bytes.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn retained_cells_go_before_voxels() {
        let mut retained = Retained::new(100);
        assert!(retained.spends_on_voxels(60) && retained.spends_on_cells(30));
        assert!(!retained.was_spent() && !retained.spends_on_cells(30) && retained.was_spent());
        assert!(retained.make_room_for_cells(), "60 bytes of cells leave no room for 60");
        retained.forget_voxels(60);
        assert!(retained.spends_on_cells(30) && retained.bytes() == 60);
        assert!(!retained.spends_on_voxels(41) && retained.spends_on_voxels(40));
        assert!(retained.was_spent() && retained.bytes() == 100);
        assert!(!retained.make_room_for_cells(), "cells had all that they asked for");
    }

    #[test]
    fn retained_voxels_have_what_cells_leave() {
        let mut retained = Retained::new(100);
        assert!(retained.spends_on_cells(50) && !retained.spends_on_cells(60));
        assert!(!retained.make_room_for_cells());
        assert!(!retained.spends_on_voxels(1), "it is for the cells that were missed");
        retained.forget_cells(30);
        assert!(!retained.make_room_for_cells(), "nobody missed any since");
        assert!(retained.spends_on_voxels(80) && !retained.spends_on_voxels(1));
        assert_eq!(retained.bytes(), 100);
    }
}
