//! What stands for a volume while the scene is opened: every so manieth of its voxels.

use slabsplat_core::glam::{DAffine3, DVec3};
use slabsplat_core::{Grid, Samples, Volume, with_samples};
use slabsplat_io::{IoError, LayerFile, LoadedVolume};
use std::ops::Range;
use std::sync::Arc;

/// Voxels of an overview, at most.
const MOST_VOXELS: usize = 1 << 21;

/// A volume, as far as a scene has to know it before it is drawn.
pub(super) struct Overview {
    /// Its voxels that are `step` apart along each axis.
    pub(super) loaded: LoadedVolume,
    pub(super) step: usize,
    /// The grid of all.
    pub(super) whole: Grid,
}

impl Overview {
    /// Reads the overview of a layer's volume, plane by plane.
    pub(super) fn of(layer: &LayerFile) -> Result<Self, IoError> {
        let mut loaded = read(layer, [0..1, 0..1, 0..1])?;
        let whole = loaded.volume.grid().uncropped();
        let [nx, ny, nz] = whole.dims();
        let step = step_of(whole.dims());
        let mut samples: Option<Samples> = None;
        for k in (0..nz).step_by(step) {
            let plane = read(layer, [0..nx, 0..ny, k..k + 1])?.volume;
            let plane = every(plane.samples(), [nx, ny], step);
            match &mut samples {
                None => samples = Some(plane),
                Some(samples) => samples.append(&plane),
            }
        }
        let coarse = DAffine3::from_scale(DVec3::splat(step as f64));
        let dims = whole.dims().map(|n| n.div_ceil(step));
        let path = || layer.volume.to_string().into();
        let grid = Grid::new(dims, whole.world_from_index() * coarse)
            .map_err(|source| IoError::Grid { path: path(), source })?;
        let samples = samples.expect("a grid has a plane");
        let volume = Volume::new(grid, samples, loaded.volume.scaling())
            .map_err(|source| IoError::Volume { path: path(), source })?;
        loaded.volume = Arc::new(volume);
        Ok(Self { loaded, step, whole })
    }

    /// Makes a layer's file one of the overview: what is per length in it counts voxel steps, and what it
    /// says of the volume's content is not of this.
    pub(super) fn stand_in(&self, layer: &mut LayerFile) {
        layer.hash = None;
        if let Some(distance) = &mut layer.fit.unit_distance {
            *distance *= self.step as f64;
        }
    }
}

/// Reads some voxels of a layer's volume.
pub(super) fn read(layer: &LayerFile, voxels: [Range<usize>; 3]) -> Result<LoadedVolume, IoError> {
    let mut layer = layer.clone();
    layer.options = layer.options.voxels(voxels);
    layer.load_volume()
}

/// The least step with which there are few enough.
fn step_of(dims: [usize; 3]) -> usize {
    let n_voxels = |step: usize| dims.iter().map(|n| n.div_ceil(step)).product::<usize>();
    (1..).find(|&step| n_voxels(step) <= MOST_VOXELS).expect("in the end there is one voxel")
}

/// Of a plane of samples those in every so manieth row and column.
fn every(plane: &Samples, [nx, ny]: [usize; 2], step: usize) -> Samples {
    let rows = (0..ny).step_by(step);
    let indices = rows.flat_map(|j| (0..nx).step_by(step).map(move |i| j * nx + i));
    with_samples!(plane, |s| indices.map(|idx| s[idx]).collect::<Vec<_>>().into())
}
