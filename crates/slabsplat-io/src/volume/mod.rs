//! Reading volumes. The content decides the format, the name only where the content says nothing.
//!
//! What is read keeps its own sample type. Nothing is allocated on a header's word alone: a plain
//! file must be long enough first, a packed one could not unpack to more than its length allows,
//! and memory then grows with what really comes.
//!
//! Reading order: `formats` (what each format must say of itself, and how a file's is found), `foreign`
//! (formats that are none of them), `choices` (what is read of several volumes); `stream` (bytes from files),
//! `buffer` (bytes to samples); `header_fields`; `data_files`, `data`, `ascii` (samples in one file or many,
//! however they are written), `names`, `units`; `stored`, `placed` (samples in any order of axes),
//! `parallel`, `array_axes`, `colors`, `window` (boxes of voxels), `spill` and `scratch` (boxes of what is
//! packed), `zip`; then a format each, and `write`.

mod choices;
mod foreign;
mod formats;

mod buffer;
mod stream;

mod ascii;
mod data;
mod data_files;
mod header_fields;
mod names;
mod units;

mod array_axes;
mod colors;
mod parallel;
mod placed;
mod scratch;
mod spill;
mod stored;
mod window;
mod zip;

mod dicom;
mod hdf5;
mod images;
mod metaimage;
mod mrc;
mod nifti;
mod npy;
mod nrrd;
mod raw;
mod sidecar;
mod tiff;
mod vtk;
mod zarr;

mod raw_name;
mod write;

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

use slabsplat_core::glam::DMat3;
use slabsplat_core::{
    Acquisition, Grid, GridError, Orientation, Samples, Scaling, Volume, VolumeError,
};

pub use buffer::Endian;
pub use choices::{Choice, Part, VolumeChoices, VolumeOptions};
pub(crate) use colors::{ALPHA_IS_CONSTANT, is_constant};
pub use colors::{ColorUse, LoadedColors, OpacitySource};
pub use formats::{VolumeFormat, VolumeListing};
pub(crate) use raw::read_raw_from;
pub use raw::{RawDesc, read_raw};
pub(crate) use scratch::Scratch;
pub use scratch::{ScratchDesc, ScratchUse};
pub use write::{VolumeOutput, write_colored_volume, write_volume};
pub(crate) use zarr::ChunkCache;

use crate::IoError;
use crate::printable::shown;
use crate::progress::unless_stopped;
use crate::store::Store;
use formats::{Found, Input, Reader};

/// A volume, and what is worth knowing about where it came from.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct LoadedVolume {
    /// The volume, placed in RAS+ millimetres if the file says where it is; a copy shares it.
    pub volume: Arc<Volume>,
    /// What it was read from.
    pub format: VolumeFormat,
    /// What the file says of where its values come from, and of how the volume stands.
    pub acquisition: Acquisition,
    /// What the file left open or got wrong, and what was assumed; one line each.
    pub warnings: Vec<String>,
    /// What else there is in the file, and which part of it this is.
    pub choices: VolumeChoices,
    /// The colours of its voxels, if these are colours; the volume is then the scalar that was made of them.
    pub colors: Option<LoadedColors>,
}

/// Reads a volume in any format known: NRRD (`.nrrd`, `.nhdr`), NIfTI-1 and -2 (`.nii`, `.nii.gz`, either
/// file of a `.hdr`/`.img` pair), MetaImage (`.mha`, `.mhd`), MRC (`.mrc`, `.map`), DICOM (a folder of
/// slices, or a file), TIFF (a page a slice), a folder of images, NumPy (`.npy`, `.npz`), VTK (`.vti`,
/// `.vtk`), OME-Zarr (a folder or an archive), or raw described by a `.json` beside it (the path of either)
/// or by its own name. Of a file that holds several volumes, [`read_volume_with`] chooses; an array may be
/// named after the path, as `a.npz:name`.
///
/// # Errors
/// If the file cannot be read, is in no such format, is broken, or holds something other than scalar volumes.
pub fn read_volume(path: impl AsRef<Path>) -> Result<LoadedVolume, IoError> {
    read_volume_with(path, &VolumeOptions::default())
}

/// As [`read_volume`], with a choice of what is read.
///
/// # Errors
/// As there, and if the file does not hold what `options` ask for.
pub fn read_volume_with(
    path: impl AsRef<Path>,
    options: &VolumeOptions,
) -> Result<LoadedVolume, IoError> {
    read_from(Store::Disk, path.as_ref(), options)
}

pub(crate) fn read_from(
    store: Store<'_>,
    path: &Path,
    options: &VolumeOptions,
) -> Result<LoadedVolume, IoError> {
    let Found { reader, path, options } = formats::find(store, path, options)?;
    let input = Input { store, path: &path, options: &options, spill: None };
    read_by(reader, &input)
}

fn read_by(reader: &dyn Reader, input: &Input<'_>) -> Result<LoadedVolume, IoError> {
    let &Input { path, options, .. } = input;
    if !reader.reads_boxes() {
        let name = reader.listed().split(" (").next().unwrap_or_default();
        input.refuse_window(&format!("a volume in the format {name}"))?;
    }
    let mut loaded = unless_stopped(options.progress.as_ref(), reader.read(input))?;
    options.check(path, &loaded.choices)?;
    loaded.warnings.extend(loaded.choices.warnings(options));
    // They may cite the file, and one that lists a file again and again is warned of as often.
    let mut said = BTreeSet::new();
    loaded.warnings.retain(|warning| said.insert(warning.clone()));
    loaded.warnings.iter_mut().for_each(|warning| *warning = shown(warning));
    Ok(loaded)
}

/// What a file holds, as far as its header says: all of what [`read_volume_with`] would do but the samples.
///
/// # Errors
/// As [`read_volume_with`], as far as the header tells.
pub fn list_volume(
    path: impl AsRef<Path>,
    options: &VolumeOptions,
) -> Result<VolumeListing, IoError> {
    list_from(Store::Disk, path.as_ref(), options)
}

pub(crate) fn list_from(
    store: Store<'_>,
    path: &Path,
    options: &VolumeOptions,
) -> Result<VolumeListing, IoError> {
    let Found { reader, path, options } = formats::find(store, path, options)?;
    let listing = reader.list(&Input { store, path: &path, options: &options, spill: None })?;
    options.check(&path, &listing.choices)?;
    Ok(listing)
}

impl LoadedVolume {
    /// The same volume with voxels of another size, say where a file gives none or the wrong one.
    /// The directions of the axes stay; so does the place of the first voxel, but the middle of a
    /// built-in volume.
    ///
    /// # Errors
    /// If a spacing is zero or not finite.
    pub fn with_spacing(self, spacing: [f64; 3]) -> Result<Self, GridError> {
        let grid = respaced(self.volume.grid(), spacing, self.format == VolumeFormat::Builtin)?;
        Ok(self.on_grid(grid))
    }
}

impl LoadedVolume {
    /// The only volume of a file.
    pub(crate) fn new(volume: Arc<Volume>, format: VolumeFormat, warnings: Vec<String>) -> Self {
        let orientation = usual_orientation(format);
        let is_metric =
            is_usually_metric(format) && !warnings.iter().any(|what| what == units::NO_SIZE);
        let mut acquisition = Acquisition::default().orientation(orientation);
        acquisition.is_metric = is_metric;
        let choices = VolumeChoices::default();
        Self { volume, format, acquisition, warnings, choices, colors: None }
    }

    /// A volume that comes from no file: a simulation's, say.
    pub fn computed(volume: impl Into<Arc<Volume>>) -> Self {
        Self::new(volume.into(), VolumeFormat::Builtin, Vec::new())
    }

    /// The same that stands otherwise than is usual in its format.
    fn standing(self, orientation: Orientation) -> Self {
        Self { acquisition: self.acquisition.orientation(orientation), ..self }
    }

    /// The same where the file says of lengths what they are, or does not.
    fn measured(mut self, is_metric: bool) -> Self {
        self.acquisition.is_metric = is_metric;
        self
    }

    /// The same on another grid of as many voxels.
    fn on_grid(self, grid: Grid) -> Self {
        let volume = Arc::unwrap_or_clone(self.volume).with_grid(grid);
        let volume = volume.expect("the grid has as many voxels as before");
        Self { volume: volume.into(), ..self }
    }
}

/// How volumes of a format stand, where the file does not say otherwise.
fn usual_orientation(format: VolumeFormat) -> Orientation {
    match format {
        VolumeFormat::Dicom
        | VolumeFormat::Analyze
        | VolumeFormat::Nifti1
        | VolumeFormat::Nifti2
        | VolumeFormat::MetaImage => Orientation::Anatomical,
        VolumeFormat::Images | VolumeFormat::Tiff | VolumeFormat::Zarr => Orientation::Pictures,
        VolumeFormat::Nrrd
        | VolumeFormat::Mrc
        | VolumeFormat::Npy
        | VolumeFormat::Vtk
        | VolumeFormat::Hdf5
        | VolumeFormat::Raw
        | VolumeFormat::Builtin => Orientation::Unknown,
    }
}

/// Whether files of a format say lengths in units that are known; they become millimetres.
fn is_usually_metric(format: VolumeFormat) -> bool {
    match format {
        VolumeFormat::Dicom
        | VolumeFormat::Analyze
        | VolumeFormat::Nifti1
        | VolumeFormat::Nifti2
        | VolumeFormat::Mrc
        | VolumeFormat::Tiff
        | VolumeFormat::Zarr => true,
        VolumeFormat::Nrrd
        | VolumeFormat::MetaImage
        | VolumeFormat::Images
        | VolumeFormat::Npy
        | VolumeFormat::Vtk
        | VolumeFormat::Hdf5
        | VolumeFormat::Raw
        | VolumeFormat::Builtin => false,
    }
}

fn respaced(grid: &Grid, spacing: [f64; 3], keeps_center: bool) -> Result<Grid, GridError> {
    let whole = grid.uncropped();
    if whole != *grid {
        let ends = grid.first_voxel().into_iter().zip(grid.dims());
        let voxels: Vec<_> = ends.map(|(first, n)| first..first + n).collect();
        let voxels = voxels.try_into().expect("a grid has three axes");
        return Ok(respaced(&whole, spacing, keeps_center)?.cropped(&voxels));
    }
    let mut world_from_index = grid.world_from_index();
    let center_in_world = grid.center_in_world();
    let m = world_from_index.matrix3;
    world_from_index.matrix3 = DMat3::from_cols(
        m.x_axis.normalize() * spacing[0],
        m.y_axis.normalize() * spacing[1],
        m.z_axis.normalize() * spacing[2],
    );
    if keeps_center {
        world_from_index.translation =
            center_in_world - world_from_index.matrix3 * grid.center_in_index();
    }
    Grid::new_large(grid.dims(), world_from_index)
}

/// Puts the parts of a volume together; errors name the file.
fn assemble(
    path: &Path,
    grid: Grid,
    samples: Samples,
    scaling: Scaling,
) -> Result<Arc<Volume>, IoError> {
    Volume::new(grid, samples, scaling)
        .map(Arc::new)
        .map_err(|source: VolumeError| IoError::Volume { path: path.to_owned(), source })
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::glam::{DAffine3, DVec3};

    #[test]
    fn respaced_keeps_directions_and_origin() {
        let turned = DMat3::from_cols(DVec3::Y * 2.0, -DVec3::X, DVec3::new(0.0, 3.0, 3.0));
        let origin = DVec3::new(5.0, 6.0, 7.0);
        let grid = Grid::new([3, 4, 5], DAffine3::from_mat3_translation(turned, origin)).unwrap();
        let respaced = respaced(&grid, [1.0, 1.5, 4.0], false).unwrap();
        let m = respaced.world_from_index();
        assert_eq!(m.translation, origin);
        assert!(m.matrix3.x_axis.abs_diff_eq(DVec3::Y, 1e-12));
        assert!(m.matrix3.y_axis.abs_diff_eq(DVec3::X * -1.5, 1e-12));
        assert!((m.matrix3.z_axis.length() - 4.0).abs() < 1e-12);
        assert!(super::respaced(&grid, [0.0, 1.0, 1.0], false).is_err());
    }

    #[test]
    fn respaced_builtin_stays_centered() {
        let volume = crate::builtin_volume("cube", None).unwrap();
        let volume = Arc::new(volume);
        let loaded = LoadedVolume::new(volume, VolumeFormat::Builtin, vec![]);
        let loaded = loaded.with_spacing([1.0, 1.0, 2.0]).unwrap();
        assert!(loaded.volume.grid().center_in_world().length() < 1e-12);
        assert_eq!(loaded.volume.grid().spacing(), [1.0, 1.0, 2.0]);
    }
}
