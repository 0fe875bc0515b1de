//! Reading volumes. The content decides the format, the name only where the content says nothing.
//!
//! What is read keeps its own sample type. Nothing is allocated on a header's word alone: a plain
//! file must be long enough first, a packed one could not unpack to more than its length allows,
//! and memory then grows with what really comes.
//!
//! Reading order: `stream` (bytes from files), `buffer` (bytes to samples); `header_fields`; `data_files`,
//! `data`, `ascii` (samples in one file or many, however they are written), `names`; then a format each.

mod buffer;
mod stream;

mod ascii;
mod data;
mod data_files;
mod header_fields;
mod names;

mod metaimage;
mod nifti;
mod nrrd;
mod raw;
mod sidecar;
mod tiff;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use slabsplat_core::glam::DMat3;
use slabsplat_core::{Grid, GridError, Samples, Scaling, Volume, VolumeError};

pub use buffer::Endian;
pub(crate) use raw::read_raw_from;
pub use raw::{RawDesc, read_raw};

use crate::IoError;
use crate::store::Store;

/// A volume, and what is worth knowing about where it came from.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct LoadedVolume {
    /// The volume, placed in RAS+ millimetres if the file says where it is; a copy shares it.
    pub volume: Arc<Volume>,
    /// What it was read from.
    pub format: VolumeFormat,
    /// What the file left open or got wrong, and what was assumed; one line each.
    pub warnings: Vec<String>,
}

/// What a volume was read from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum VolumeFormat {
    /// NRRD, with its data attached or in files of their own.
    Nrrd,
    /// NIfTI-1, one file or a pair.
    Nifti1,
    /// NIfTI-2, one file or a pair.
    Nifti2,
    /// MetaImage, with its data attached or in files of their own.
    MetaImage,
    /// Pages of a TIFF.
    Tiff,
    /// Samples without a header.
    Raw,
    /// No file: see [`builtin_volume`](crate::builtin_volume).
    Builtin,
}

impl VolumeFormat {
    /// The format's name as it is written in prose.
    pub fn name(self) -> &'static str {
        match self {
            Self::Nrrd => "NRRD",
            Self::Nifti1 => "NIfTI-1",
            Self::Nifti2 => "NIfTI-2",
            Self::MetaImage => "MetaImage",
            Self::Tiff => "TIFF",
            Self::Raw => "raw",
            Self::Builtin => "built-in",
        }
    }
}

/// Reads a volume in any format known: NRRD (`.nrrd`, `.nhdr`), NIfTI-1 and -2 (`.nii`, `.nii.gz`, either
/// file of a `.hdr`/`.img` pair), MetaImage (`.mha`, `.mhd`), TIFF (a page a slice), or raw described by a
/// `.json` beside it (the path of either).
///
/// # Errors
/// If the file cannot be read, is in no such format, is broken, or holds something other than one
/// scalar volume.
pub fn read_volume(path: impl AsRef<Path>) -> Result<LoadedVolume, IoError> {
    read_from(Store::Disk, path.as_ref())
}

pub(crate) fn read_from(store: Store<'_>, path: &Path) -> Result<LoadedVolume, IoError> {
    match header_of(store, path)? {
        HeaderFile::Nrrd(header) => nrrd::read(store, &header),
        HeaderFile::Nifti(header) => nifti::read(store, &header),
        HeaderFile::MetaImage(header) => metaimage::read(store, &header),
        HeaderFile::Sidecar(header) => sidecar::read(store, &header),
        HeaderFile::Tiff(path) => tiff::read(store, &path),
    }
}

/// Bytes that the samples of a volume will take in memory, on the word of its header, which nothing has
/// backed yet.
///
/// # Errors
/// As [`read_volume`], as far as the header tells.
pub fn volume_bytes(path: impl AsRef<Path>) -> Result<u64, IoError> {
    let store = Store::Disk;
    let (dims, sample_type) = match header_of(store, path.as_ref())? {
        HeaderFile::Nrrd(header) => nrrd::dims_and_type(store, &header),
        HeaderFile::Nifti(header) => nifti::dims_and_type(store, &header),
        HeaderFile::MetaImage(header) => metaimage::dims_and_type(store, &header),
        HeaderFile::Sidecar(header) => sidecar::dims_and_type(store, &header),
        HeaderFile::Tiff(path) => tiff::dims_and_type(store, &path),
    }?;
    let n_voxels = dims.into_iter().fold(1, |n: u64, size| n.saturating_mul(size as u64));
    Ok(n_voxels.saturating_mul(sample_type.size_bytes() as u64))
}

/// The file that says what a volume is like.
enum HeaderFile {
    Nrrd(PathBuf),
    Nifti(PathBuf),
    MetaImage(PathBuf),
    Sidecar(PathBuf),
    Tiff(PathBuf),
}

/// By the content of a file, or by its name where that says nothing.
fn header_of(store: Store<'_>, path: &Path) -> Result<HeaderFile, IoError> {
    let start = stream::first_bytes(store, path)?;
    if nrrd::is_nrrd(&start) {
        return Ok(HeaderFile::Nrrd(path.to_owned()));
    }
    if tiff::is_tiff(&start) {
        return Ok(HeaderFile::Tiff(path.to_owned()));
    }
    if metaimage::is_header(&start) {
        return Ok(HeaderFile::MetaImage(path.to_owned()));
    }
    if nifti::is_header(&start) {
        return Ok(HeaderFile::Nifti(path.to_owned()));
    }
    match stream::plain_extension(path).as_str() {
        "json" => Ok(HeaderFile::Sidecar(path.to_owned())),
        "nrrd" | "nhdr" => {
            Err(IoError::malformed(path, "not an NRRD file: it does not begin with NRRD000"))
        }
        "mha" | "mhd" => {
            Err(IoError::malformed(path, "not a MetaImage file: it does not begin with its fields"))
        }
        "tif" | "tiff" => {
            Err(IoError::malformed(path, "not a TIFF file: it does not begin as one"))
        }
        "nii" | "hdr" => Err(IoError::malformed(
            path,
            "not a NIfTI file, or cut off: it does not begin with a whole NIfTI header (Analyze 7.5 is not \
             read)",
        )),
        "img" => nifti::header_beside(store, path).map(HeaderFile::Nifti),
        _ if store.has(&path.with_extension("json")) => {
            Ok(HeaderFile::Sidecar(path.with_extension("json")))
        }
        _ => Err(IoError::UnknownFormat { path: path.to_owned() }),
    }
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
    /// The same on another grid of as many voxels.
    fn on_grid(self, grid: Grid) -> Self {
        let volume = Arc::unwrap_or_clone(self.volume).with_grid(grid);
        let volume = volume.expect("the grid has as many voxels as before");
        Self { volume: volume.into(), ..self }
    }
}

fn respaced(grid: &Grid, spacing: [f64; 3], keeps_center: bool) -> Result<Grid, GridError> {
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
    Grid::new(grid.dims(), world_from_index)
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
        let loaded = LoadedVolume { volume, format: VolumeFormat::Builtin, warnings: vec![] };
        let loaded = loaded.with_spacing([1.0, 1.0, 2.0]).unwrap();
        assert!(loaded.volume.grid().center_in_world().length() < 1e-12);
        assert_eq!(loaded.volume.grid().spacing(), [1.0, 1.0, 2.0]);
    }
}
