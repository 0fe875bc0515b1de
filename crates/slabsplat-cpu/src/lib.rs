//! The CPU backend: always there, and the one that the others are compared with.
//!
//! # How a frame is made
//!
//! 1. Find the relevant voxels, if they are not those of the last plan (`slabsplat-traverse`).
//! 2. Rasterise opaque meshes, if there are any: their samples wait in the tiles until slabs come to them.
//! 3. Go through the volume in ranges of depth. *Take in* the bricks of a range, but for what saturated parts
//!    of the image hide: *project* and *shade* their voxels and *toss* them onto square tiles of the image,
//!    in parallel.
//! 4. For every tile, in parallel: sort its voxels by slab, and then, slab by slab from the eye, *splat* the
//!    sections into a sheet of the tile's size and *composite* it.
//!
//! A sheet that covers a tile stays in the first-level cache, so the full-screen sheets of the paper and
//! their traffic vanish. Blocks of pixels that are saturated take no more, and a tile of them stops. Tiles
//! share nothing: there are no atomics, and each pixel's sum has one order, whatever the number of threads.
//!
//! The inner loops are written once, over vectors of `fearless_simd`, and compiled for every set of
//! instructions that there may be; which one runs is found out when the backend is made.
//!
//! # Floors
//!
//! Modules only use modules below them, and `cargo xtask lint` checks it:
//!
//! | floor | holds |
//! | --- | --- |
//! | `frame` | dispatch to a method, and what every frame has |
//! | `meshes` | where rays end at opaque meshes (`slabsplat-mesh`) |
//! | `methods` | the four methods: image-aligned, axis-aligned, every-sample, densities |
//! | `separable` | sections by separable footprints, a short cut of image-aligned |
//! | `sections` | sections of eight voxels at a time, and their splatting |
//! | `footprints` | where a footprint lies, how it weighs pixels, the inner loop |
//! | `voxels` | the list, a voxel, and voxels by the sheet they go to first |
//! | `pixels` | tiles, sheets, compositing |
//! | `stopwatch` | how long stages take |
//!
//! ```
//! use slabsplat_backend::Backend;
//! use slabsplat_cpu::CpuBackend;
//!
//! assert_eq!(CpuBackend::new().caps().name, "cpu");
//! ```

mod footprints;
mod frame;
mod meshes;
mod methods;
mod pixels;
mod sections;
mod separable;
mod stopwatch;
mod voxels;

use fearless_simd::Level;
use slabsplat_backend::{Backend, BackendError, Caps, Frame, FrameId, FramePlan};
use slabsplat_core::Method;
use std::collections::VecDeque;
use std::task::Poll;

/// Renders on rayon's current thread pool. A frame is done when [`submit`](Backend::submit) returns.
#[derive(Debug)]
pub struct CpuBackend {
    caps: Caps,
    level: Level,
    buffers: frame::Buffers,
    n_submitted: u64,
    done: VecDeque<(FrameId, Frame)>,
}

impl CpuBackend {
    /// A backend with nothing in it; buffers grow with the first frame.
    pub fn new() -> Self {
        Self {
            caps: Caps::new(
                "cpu",
                format!("{} CPU threads", rayon::current_num_threads()),
                Method::ALL,
            ),
            level: Level::new(),
            buffers: frame::Buffers::default(),
            n_submitted: 0,
            done: VecDeque::new(),
        }
    }
}

impl Default for CpuBackend {
    fn default() -> Self {
        Self::new()
    }
}

impl Backend for CpuBackend {
    fn caps(&self) -> &Caps {
        &self.caps
    }

    fn submit(&mut self, plan: &FramePlan<'_>) -> Result<FrameId, BackendError> {
        let frame = FrameId(self.n_submitted);
        self.n_submitted += 1;
        self.done.push_back((frame, frame::render(plan, self.level, &mut self.buffers)));
        Ok(frame)
    }

    fn poll_image(&mut self, frame: FrameId) -> Result<Poll<Frame>, BackendError> {
        let place = self.done.iter().position(|(done, _)| *done == frame);
        let taken = place.and_then(|place| self.done.remove(place));
        taken.map(|(_, frame)| Poll::Ready(frame)).ok_or(BackendError::UnknownFrame(frame))
    }
}

#[cfg(test)]
mod tests;
