//! What stands for a volume while the scene is opened: every so manieth of its voxels.

use super::DividedError;
use super::survey::{Survey, joined};
use slabsplat_core::glam::{DAffine3, DVec3};
use slabsplat_core::{Grid, Samples, Volume, with_samples};
use slabsplat_io::{IoError, LoadedVolume, VolumeBoxes};
use std::sync::Arc;

/// Voxels of an overview, at most.
const MOST_VOXELS: usize = 1 << 21;

/// A volume, as far as a scene has to know it before it is drawn.
pub(super) struct Overview {
    /// Its voxels that are `step` apart along each axis.
    pub(super) loaded: LoadedVolume,
    /// The grid of all.
    pub(super) whole: Grid,
}

impl Overview {
    /// Reads the overview of a volume: of its planes some, and of others the rest.
    pub(super) fn of(survey: Survey<'_, '_>) -> Result<Self, DividedError> {
        let source = survey.source;
        let (first, n_shares) = survey.share();
        let (loaded, whole) = (source.first(), source.grid());
        let step = step_of(whole.dims());
        let all = survey.all(own_planes(source, (first, n_shares), step))?;
        let dims = whole.dims().map(|n| n.div_ceil(step));
        let samples = joined(all, (0..dims[2]).map(|_| dims[0] * dims[1]))?;
        let coarse = DAffine3::from_scale(DVec3::splat(step as f64));
        let path = || source.path().to_owned();
        let grid = Grid::new(dims, whole.world_from_index() * coarse)
            .map_err(|source| IoError::Grid { path: path(), source })?;
        let volume = Volume::new(grid, samples, loaded.volume.scaling())
            .map_err(|source| IoError::Volume { path: path(), source })?;
        let mut loaded = loaded.clone();
        loaded.volume = Arc::new(volume);
        Ok(Self { loaded, whole })
    }
}

/// Of the planes of an overview every `n`th, from `first` on, plane by plane.
fn own_planes(
    source: &VolumeBoxes,
    (first, n): (usize, usize),
    step: usize,
) -> Result<Samples, IoError> {
    let [nx, ny, nz] = source.grid().dims();
    let mut samples = every(source.first().volume.samples(), [0, 0], 1);
    for k in (0..nz).step_by(step).skip(first).step_by(n) {
        let plane = source.read([0..nx, 0..ny, k..k + 1])?.volume;
        samples.append(&every(plane.samples(), [nx, ny], step));
    }
    Ok(samples)
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
