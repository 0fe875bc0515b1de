//! What stands for a volume while the scene is opened: every so manieth of its voxels, or of those of a
//! coarser level, where the file has some.

use super::DividedError;
use super::survey::{Survey, joined};
use slabsplat_core::glam::{DAffine3, DVec3};
use slabsplat_core::{
    ColorSamples, Grid, LabelMap, Labels, Samples, Scaling, Volume, VoxelColors, with_samples,
};
use slabsplat_io::{IoError, LabelBoxes, LoadedVolume, VolumeBoxes};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Voxels of an overview, at most.
const MOST_VOXELS: usize = 1 << 21;

/// Voxels of a coarser level, at least, for an overview to be made of it: half as many along each axis as an
/// overview may have.
const LEAST_VOXELS: usize = MOST_VOXELS / 8;

/// A volume, as far as a scene has to know it before it is drawn.
pub(super) struct Overview {
    /// Voxels that are equally far apart along each axis, of a coarser level if there is one.
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
        let coarser = match source.coarser(LEAST_VOXELS) {
            Ok(coarser) => coarser,
            Err(error) => {
                survey.all(Err(error))?;
                return Err(DividedError::Differing);
            }
        };
        let read = coarser.as_ref().unwrap_or(source);
        let level = read.grid();
        let step = step_of(level.dims());
        let planes = own_planes(read, (first, n_shares), step);
        let (planes, colors) = match planes {
            Ok((planes, colors)) => (Ok(planes), colors),
            Err(error) => (Err(error), None),
        };
        let all = survey.all(planes)?;
        let dims = level.dims().map(|n| n.div_ceil(step));
        let samples = joined(all, (0..dims[2]).map(|_| dims[0] * dims[1]))?;
        let coarse = DAffine3::from_scale(DVec3::splat(step as f64));
        let path = || source.path().to_owned();
        let grid = Grid::new(dims, level.world_from_index() * coarse)
            .map_err(|source| IoError::Grid { path: path(), source })?;
        let volume = Volume::new(grid, samples, loaded.volume.scaling())
            .map_err(|source| IoError::Volume { path: path(), source })?;
        let mut loaded = loaded.clone();
        loaded.volume = Arc::new(volume);
        if let (Some(of_loaded), Some(colors)) = (&mut loaded.colors, colors) {
            let n_in_plane = 3 * dims[0] * dims[1];
            let colors = joined(survey.all(Ok(colors))?, (0..dims[2]).map(|_| n_in_plane))?;
            let colors = match colors {
                Samples::U8(colors) => ColorSamples::U8(colors.as_chunks().0.to_vec()),
                Samples::U16(colors) => ColorSamples::U16(colors.as_chunks().0.to_vec()),
                _ => return Err(DividedError::Differing),
            };
            let voxels = VoxelColors::new(dims, colors);
            of_loaded.voxels = Some(voxels.map_err(|_| DividedError::Differing)?);
        }
        Ok(Self { loaded, whole })
    }
}

/// The labels of an overview's voxels.
pub(super) fn labels_of(labels: &LabelBoxes, grid: &Grid) -> Result<Labels, IoError> {
    let [nx, ny, nz] = grid.dims();
    let (mut numbers, mut styles) = (Vec::with_capacity(grid.n_voxels()), BTreeMap::new());
    for k in 0..nz {
        let of_plane = labels.on(&grid.cropped(&[0..nx, 0..ny, k..k + 1]))?;
        let map = of_plane.map();
        numbers.extend(map.indices().iter().map(|idx| map.labels()[usize::from(*idx)] as f64));
        styles.clone_from(of_plane.styles());
    }
    let volume = Volume::new(*grid, Samples::F64(numbers), Scaling::IDENTITY);
    let volume = volume.expect("there is a label for each voxel");
    let map = LabelMap::new(&volume, grid).expect("they are labels");
    Ok(Labels::new(map, styles).expect("they were styles before"))
}

/// Of the planes of an overview every `n`th, from `first` on, plane by plane, and their colours, if they have
/// any.
fn own_planes(
    source: &VolumeBoxes,
    (first, n): (usize, usize),
    step: usize,
) -> Result<(Samples, Option<Samples>), IoError> {
    let [nx, ny, nz] = source.grid().dims();
    let voxel = source.first();
    let mut samples = every(voxel.volume.samples(), [0, 0], 1);
    let own = voxel.colors.as_ref().and_then(|colors| colors.voxels.as_ref());
    let mut all_colors = own.map(|colors| every_color(colors, [0, 0], 1));
    for k in (0..nz).step_by(step).skip(first).step_by(n) {
        let plane = source.read([0..nx, 0..ny, k..k + 1])?;
        samples.append(&every(plane.volume.samples(), [nx, ny], step));
        let own = plane.colors.and_then(|colors| colors.voxels);
        if let (Some(all), Some(colors)) = (&mut all_colors, own) {
            all.append(&every_color(&colors, [nx, ny], step));
        }
    }
    Ok((samples, all_colors))
}

/// The least step with which there are few enough.
fn step_of(dims: [usize; 3]) -> usize {
    let n_voxels = |step: usize| dims.iter().map(|n| n.div_ceil(step)).product::<usize>();
    (1..).find(|&step| n_voxels(step) <= MOST_VOXELS).expect("in the end there is one voxel")
}

/// Of a plane of samples those in every so manieth row and column.
fn every(plane: &Samples, n: [usize; 2], step: usize) -> Samples {
    with_samples!(plane, |s| indices(n, step).map(|idx| s[idx]).collect::<Vec<_>>().into())
}

/// The same of colours, as three samples each.
fn every_color(plane: &VoxelColors, n: [usize; 2], step: usize) -> Samples {
    match plane.samples() {
        ColorSamples::U8(colors) => {
            Samples::U8(indices(n, step).flat_map(|idx| colors[idx]).collect())
        }
        ColorSamples::U16(colors) => {
            Samples::U16(indices(n, step).flat_map(|idx| colors[idx]).collect())
        }
        _ => unreachable!("colours have 8 or 16 bits"),
    }
}

fn indices([nx, ny]: [usize; 2], step: usize) -> impl Iterator<Item = usize> {
    let rows = (0..ny).step_by(step);
    rows.flat_map(move |j| (0..nx).step_by(step).map(move |i| j * nx + i))
}
