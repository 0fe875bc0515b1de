//! What stands for a volume while the scene is opened: every so manieth of its voxels.

use super::{DividedError, Exchange};
use slabsplat_core::glam::{DAffine3, DVec3};
use slabsplat_core::{Grid, Samples, Volume, with_samples};
use slabsplat_io::{IoError, LayerFile, LoadedVolume, VolumeBoxes};
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
    /// Reads the overview of a volume, if it could be opened: of its planes some, and of `others` the rest.
    pub(super) fn of(
        source: Result<VolumeBoxes, IoError>,
        others: &mut dyn Exchange,
    ) -> Result<(VolumeBoxes, Self), DividedError> {
        let [first, n_shares] = [others.share_idx(), others.n_shares()];
        let read = source.and_then(|source| {
            let (own, samples) = OwnPlanes::read(&source, first, n_shares)?;
            Ok((source, own, samples))
        });
        let (source, own, samples) = match read {
            Ok(read) => read,
            Err(error) => {
                others.all(Err(error))?;
                return Err(DividedError::Differing);
            }
        };
        let all = others.all(Ok(samples))?;
        let OwnPlanes { mut loaded, whole, step } = own;
        let dims = whole.dims().map(|n| n.div_ceil(step));
        let samples = Self::joined(&all, dims[2], dims[0] * dims[1])?;
        drop(all);
        let coarse = DAffine3::from_scale(DVec3::splat(step as f64));
        let path = || source.path().to_owned();
        let grid = Grid::new(dims, whole.world_from_index() * coarse)
            .map_err(|source| IoError::Grid { path: path(), source })?;
        let volume = Volume::new(grid, samples, loaded.volume.scaling())
            .map_err(|source| IoError::Volume { path: path(), source })?;
        loaded.volume = Arc::new(volume);
        Ok((source, Self { loaded, step, whole }))
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

/// Some planes of a volume, and what they are of.
struct OwnPlanes {
    /// One voxel.
    loaded: LoadedVolume,
    whole: Grid,
    step: usize,
}

impl OwnPlanes {
    /// Of the planes of an overview every `n`th, from `first` on, plane by plane.
    fn read(source: &VolumeBoxes, first: usize, n: usize) -> Result<(Self, Samples), IoError> {
        let (loaded, whole) = (source.first().clone(), source.grid());
        let [nx, ny, nz] = whole.dims();
        let step = step_of(whole.dims());
        let mut samples = every(loaded.volume.samples(), [0, 0], 1);
        for k in (0..nz).step_by(step).skip(first).step_by(n) {
            let plane = source.read([0..nx, 0..ny, k..k + 1])?.volume;
            samples.append(&every(plane.samples(), [nx, ny], step));
        }
        Ok((Self { loaded, whole, step }, samples))
    }
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
