//! The voxels of a box, and those of the next one, which are read while a box is drawn.

use super::{DividedError, DividedScene, ShareCost};
use slabsplat_core::{Labels, PartBox, Volume, VoxelColors};
use std::ops::Range;
use std::sync::Arc;
use std::thread::{Scope, ScopedJoinHandle};
use std::time::Instant;

/// What is read of a box and around it.
pub(super) struct BoxVoxels {
    /// Layer by layer.
    pub(super) layers: Vec<LayerVoxels>,
    /// Seconds that it took.
    pub(super) reading_secs: f64,
}

/// What is read of a layer in a box.
#[derive(Clone, Debug)]
pub(super) struct LayerVoxels {
    pub(super) volume: Arc<Volume>,
    pub(super) colors: Option<VoxelColors>,
    pub(super) labels: Option<Labels>,
}

impl LayerVoxels {
    /// Bytes that they take.
    pub(super) fn n_bytes(&self) -> u64 {
        let volume = &self.volume;
        let of_colors = self.colors.as_ref().map_or(0, |colors| colors.samples().size_bytes());
        let of_labels = self.labels.as_ref().map_or(0, |_| size_of::<u16>());
        let n_voxels = volume.grid().n_voxels();
        (n_voxels * (volume.sample_type().size_bytes() + of_labels) + of_colors) as u64
    }
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
        let layers = self.grids.iter().zip(&self.supports).enumerate();
        let read = layers.map(|(layer_idx, (grid, support))| {
            let key = (layer_idx, self.boxes.voxels_near(of, grid, support));
            self.retained.get(&key, || self.layer_voxels(layer_idx, &key.1))
        });
        let layers = read.collect::<Result<Vec<_>, DividedError>>()?;
        let reading_secs = started.map_or(0.0, |started| started.elapsed().as_secs_f64());
        Ok(BoxVoxels { layers, reading_secs })
    }

    fn layer_voxels(
        &self,
        layer_idx: usize,
        voxels: &[Range<usize>; 3],
    ) -> Result<LayerVoxels, DividedError> {
        let read = self.sources[layer_idx].read(voxels.clone())?;
        let colors = read.colors.and_then(|colors| colors.voxels);
        let volume = Arc::unwrap_or_clone(read.volume);
        let grid = volume.grid().with_cells_of_whole();
        let volume = Arc::new(volume.with_grid(grid).expect("it has as many voxels as before"));
        let labels = self.labels[layer_idx].as_ref();
        let labels = labels.map(|labels| labels.on(&grid)).transpose()?;
        Ok(LayerVoxels { volume, colors, labels })
    }
}

impl ShareCost {
    /// Waits for voxels, and counts them.
    pub(super) fn wait_for(&mut self, ahead: Ahead<'_>) -> Result<BoxVoxels, DividedError> {
        let started = cfg!(not(target_arch = "wasm32")).then(Instant::now);
        let voxels = ahead.voxels()?;
        self.waiting_secs += started.map_or(0.0, |started| started.elapsed().as_secs_f64());
        self.reading_secs += voxels.reading_secs;
        for layer in &voxels.layers {
            self.n_voxels_read += layer.volume.grid().n_voxels() as u64;
            self.n_bytes_read += layer.n_bytes();
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
