//! The CPU backend: always there, and the one that the others are compared with.
//!
//! # How a frame is made
//!
//! 1. Find the relevant voxels, if they are not those of the last plan (`slabsplat-traverse`).
//! 2. Rasterise opaque meshes, if there are any: their samples wait in the tiles until slabs come to them.
//! 3. Go through the volume in ranges of depth. *Take in* the bricks of a range, but for those that saturated
//!    parts of the image occlude: *project* and *shade* their voxels and *toss* them onto square tiles of the
//!    image, in parallel.
//! 4. For every tile, in parallel: sort its voxels by slab, and then, slab by slab from the eye, *splat* the
//!    sections into a sheet of the tile's size and *composite* it.
//!
//! A sheet that covers a tile stays in the first-level cache, so the full-screen sheets of the paper and
//! their traffic vanish. Blocks of pixels that are saturated take no more, and a tile of them stops. Tiles
//! share nothing: there are no atomics, and each pixel's sum has one order, whatever the number of threads.
//!
//! A frame that is cancelled is left at the next slab of a tile, or the next task of what comes before.
//! Stages look whenever they have worked for a millisecond or so; what is cached across frames is replaced
//! once it is whole, and all else a frame makes anew.
//!
//! The inner loops are written once, over vectors of `fearless_simd`, and compiled for every set of
//! instructions that there may be; one of these is chosen when the backend is made.
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
//! | `stopwatch`, `progress` | how long stages take, how much is drawn, and whether anyone still wants it |
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
mod progress;
mod sections;
mod separable;
mod stopwatch;
mod voxels;

use fearless_simd::Level;
use slabsplat_backend::{Backend, BackendError, Caps, Frame, FramePlan};
use slabsplat_core::{FrameHandle, Method};
use std::task::Poll;

/// Renders on rayon's current thread pool. A frame is done when [`submit`](Backend::submit) returns.
#[derive(Debug)]
pub struct CpuBackend {
    caps: Caps,
    level: Level,
    buffers: frame::Buffers,
    done: Vec<(FrameHandle, Frame)>,
}

impl CpuBackend {
    /// A backend with nothing in it; buffers grow with the first frame.
    pub fn new() -> Self {
        Self {
            caps: Caps::new(
                "cpu",
                format!("{} CPU threads", rayon::current_num_threads()),
                Method::ALL,
            )
            .with_cells()
            .with_parts(),
            level: Level::new(),
            buffers: frame::Buffers::default(),
            done: Vec::new(),
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

    fn submit(&mut self, plan: &FramePlan<'_>, frame: &FrameHandle) -> Result<(), BackendError> {
        self.done.retain(|(done, _)| !done.is_abandoned());
        let drawn = frame::render(plan, frame, self.level, &mut self.buffers)?;
        self.done.push((frame.clone(), drawn));
        Ok(())
    }

    fn poll_image(&mut self, frame: &FrameHandle) -> Result<Poll<Frame>, BackendError> {
        let idx = self.done.iter().position(|(done, _)| done == frame);
        let (_, drawn) = self.done.swap_remove(idx.ok_or(BackendError::UnknownFrame)?);
        frame.check()?;
        Ok(Poll::Ready(drawn))
    }
}

#[cfg(test)]
mod tests;
