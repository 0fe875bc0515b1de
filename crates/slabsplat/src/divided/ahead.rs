//! The voxels of a box, and those of the next one, which are read while a box is drawn.

use super::{DividedError, DividedScene, ShareCost};
use slabsplat_core::{PartBox, Volume};
use std::sync::Arc;
use std::thread::{Scope, ScopedJoinHandle};
use std::time::Instant;

/// What is read of a box and around it.
pub(super) struct BoxVoxels {
    /// Layer by layer.
    pub(super) volumes: Vec<Arc<Volume>>,
    /// Seconds that it took.
    pub(super) reading_secs: f64,
}

/// The voxels of a box that is likely to be drawn next.
pub(super) enum Ahead<'s> {
    /// They are being read.
    Read(ScopedJoinHandle<'s, Result<BoxVoxels, DividedError>>),
    /// There are no threads: they are read when they are needed.
    Later(&'s DividedScene, &'s PartBox),
}

impl DividedScene {
    /// Reads a box and what is around it.
    pub(super) fn read(&self, of: &PartBox) -> Result<BoxVoxels, DividedError> {
        // A page has no clock.
        let started = cfg!(not(target_arch = "wasm32")).then(Instant::now);
        let layers = self.sources.iter().zip(&self.grids).zip(&self.steps);
        let read = layers.map(|((source, grid), steps)| {
            Ok(source.read(self.boxes.voxels_near(of, grid, *steps))?.volume)
        });
        let volumes = read.collect::<Result<Vec<_>, DividedError>>()?;
        let reading_secs = started.map_or(0.0, |started| started.elapsed().as_secs_f64());
        Ok(BoxVoxels { volumes, reading_secs })
    }
}

impl ShareCost {
    /// Waits for voxels, and counts them.
    pub(super) fn wait_for(&mut self, ahead: Ahead<'_>) -> Result<BoxVoxels, DividedError> {
        let started = cfg!(not(target_arch = "wasm32")).then(Instant::now);
        let voxels = ahead.voxels()?;
        self.waiting_secs += started.map_or(0.0, |started| started.elapsed().as_secs_f64());
        self.reading_secs += voxels.reading_secs;
        for volume in &voxels.volumes {
            let n_voxels = volume.grid().n_voxels() as u64;
            self.n_voxels_read += n_voxels;
            self.n_bytes_read += n_voxels * volume.sample_type().size_bytes() as u64;
        }
        Ok(voxels)
    }
}

impl<'s> Ahead<'s> {
    /// Begins to read a box on a thread of its own.
    pub(super) fn begin(
        scene: &'s DividedScene,
        of: &'s PartBox,
        threads: &'s Scope<'s, '_>,
    ) -> Self {
        let read = move || scene.read(of);
        let thread = std::thread::Builder::new().name("read ahead".to_owned());
        thread.spawn_scoped(threads, read).map_or(Self::Later(scene, of), Self::Read)
    }

    /// Waits for them.
    pub(super) fn voxels(self) -> Result<BoxVoxels, DividedError> {
        match self {
            Self::Read(thread) => {
                thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
            }
            Self::Later(scene, of) => scene.read(of),
        }
    }
}
