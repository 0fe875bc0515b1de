//! Boxes that were read for one frame and stay for the next, as far as there is room for them.
//!
//! Frames of a film read nearly the same boxes in nearly the same order. If those went first that were used
//! longest ago, each would go just before it is needed again; so what is there stays, for as long as each
//! frame uses it.

use super::ahead::LayerVoxels;
use std::ops::Range;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Voxels along x, y and z, of a layer.
type Key = (usize, [Range<usize>; 3]);

/// What is retained.
#[derive(Debug, Default)]
pub(super) struct RetainedBoxes(Mutex<Retained>);

#[derive(Debug, Default)]
struct Retained {
    room_bytes: u64,
    boxes: Vec<RetainedBox>,
    /// That were read, and that were there.
    counts: [u64; 2],
}

#[derive(Debug)]
struct RetainedBox {
    key: Key,
    voxels: LayerVoxels,
    is_used: bool,
}

impl RetainedBoxes {
    fn lock(&self) -> MutexGuard<'_, Retained> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Begins a frame, for which there is so much room: what the one before did not use goes.
    pub(super) fn begin_frame(&self, room_bytes: u64) {
        let mut retained = self.lock();
        retained.room_bytes = room_bytes;
        retained.boxes.retain(|of| of.is_used);
        retained.boxes.iter_mut().for_each(|of| of.is_used = false);
        while room_bytes < retained.n_bytes() {
            retained.boxes.pop();
        }
    }

    /// A box that is there, or that `read` reads.
    pub(super) fn get<E>(
        &self,
        key: &Key,
        read: impl FnOnce() -> Result<LayerVoxels, E>,
    ) -> Result<LayerVoxels, E> {
        {
            let mut retained = self.lock();
            if let Some(of) = retained.boxes.iter_mut().find(|of| of.key == *key) {
                of.is_used = true;
                let voxels = of.voxels.clone();
                retained.counts[1] += 1;
                return Ok(voxels);
            }
        }
        let voxels = read()?;
        let mut retained = self.lock();
        retained.counts[0] += 1;
        if retained.n_bytes() + voxels.n_bytes() <= retained.room_bytes {
            let (key, voxels) = (key.clone(), voxels.clone());
            retained.boxes.push(RetainedBox { key, voxels, is_used: true });
        }
        Ok(voxels)
    }

    /// How many boxes were read, and how many were there, of those that were asked for.
    pub(super) fn counts(&self) -> [u64; 2] {
        self.lock().counts
    }
}

impl Retained {
    fn n_bytes(&self) -> u64 {
        self.boxes.iter().map(|of| of.voxels.n_bytes()).sum()
    }
}
