//! Writing volumes. What is written appears under its name only when it is complete, and is never in memory a
//! second time.
//!
//! Samples keep their type, and go out with the least significant byte first. The place of the voxels goes as
//! far as the format has room for it, and so do slope and intercept; what is lost is a warning.
//!
//! Reading order: `samples` (what is written for a voxel), then a format each.

mod samples;

mod metaimage;
mod nifti;
mod npy;
mod nrrd;
mod raw;
mod zarr;

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use slabsplat_core::glam::{DMat3, DVec3};
use slabsplat_core::{Grid, SampleType, Volume};

use super::colors::{LoadedColors, OpacitySource};
use super::stream::plain_extension;
use crate::IoError;
use crate::picture::atomic;
use samples::{Colored, ToWrite, WrittenSamples};

/// A format that volumes are written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum VolumeOutput {
    /// NRRD in one file, packed by gzip: `.nrrd`.
    Nrrd,
    /// NIfTI in one file: `.nii`.
    Nifti,
    /// NIfTI in one file, packed by gzip: `.nii.gz`.
    NiftiGz,
    /// MetaImage in one file: `.mha`.
    MetaImage,
    /// An array of NumPy with the axes z, y, x: `.npy`.
    Npy,
    /// Samples alone, with a `.json` beside them that describes them: `.raw`.
    Raw,
    /// OME-Zarr 0.4, a folder: `.zarr`.
    Zarr,
}

impl VolumeOutput {
    /// The format that the name's extension says.
    ///
    /// # Errors
    /// If it says none that is written.
    pub fn of(path: impl AsRef<Path>) -> Result<Self, IoError> {
        let path = path.as_ref();
        let is_gz = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("gz"));
        match (plain_extension(path).as_str(), is_gz) {
            ("nrrd", false) => Ok(Self::Nrrd),
            ("nii", false) => Ok(Self::Nifti),
            ("nii", true) => Ok(Self::NiftiGz),
            ("mha", false) => Ok(Self::MetaImage),
            ("npy", false) => Ok(Self::Npy),
            ("raw", false) => Ok(Self::Raw),
            ("zarr", false) => Ok(Self::Zarr),
            _ => Err(IoError::UnknownOutput { path: path.to_owned() }),
        }
    }
}

/// Writes a volume in the format that the name's extension says; what stood there before is replaced. Returns
/// what the format has no room for, one line each.
///
/// ```
/// use slabsplat_io::{builtin_volume, read_volume, write_volume};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let dir = tempfile::tempdir()?;
/// let path = dir.path().join("cube.nrrd");
/// let cube = builtin_volume("cube", Some(12))?;
/// assert!(write_volume(&path, &cube)?.is_empty());
/// assert_eq!(read_volume(&path)?.volume.grid(), cube.grid());
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// If the extension is another, the format cannot hold the volume, or the file cannot be written.
pub fn write_volume(path: impl AsRef<Path>, volume: &Volume) -> Result<Vec<String>, IoError> {
    write(path.as_ref(), &ToWrite { volume, colors: None })
}

/// Writes a volume whose voxels have colours: red, green and blue of each, and the volume's value as alpha if
/// it is that. Where the format has no room for colours, the volume is written as [`write_volume`] does, and
/// a warning says so.
///
/// # Errors
/// As [`write_volume`].
pub fn write_colored_volume(
    path: impl AsRef<Path>,
    volume: &Volume,
    colors: &LoadedColors,
) -> Result<Vec<String>, IoError> {
    let path = path.as_ref();
    let Some(voxels) = &colors.voxels else { return write_volume(path, volume) };
    let has_room = match VolumeOutput::of(path)? {
        VolumeOutput::Nrrd | VolumeOutput::MetaImage | VolumeOutput::Npy => true,
        VolumeOutput::Nifti | VolumeOutput::NiftiGz => volume.sample_type() == SampleType::U8,
        VolumeOutput::Raw | VolumeOutput::Zarr => false,
    };
    let is_alpha = colors.opacity_from == OpacitySource::Alpha;
    if !has_room {
        let bits = 8 * volume.sample_type().size_bytes();
        let what = format!(
            "the format has no colours of {bits} bits: {} alone was written",
            colors.opacity_from
        );
        let mut warnings = write_volume(path, volume)?;
        warnings.push(what);
        return Ok(warnings);
    }
    let colored = Colored { voxels, is_alpha };
    let mut warnings = write(path, &ToWrite { volume, colors: Some(colored) })?;
    if colors.has_alpha && !is_alpha {
        warnings.push("alpha was not written: opacity was made of luminance".to_owned());
    }
    Ok(warnings)
}

fn write(path: &Path, to_write: &ToWrite<'_>) -> Result<Vec<String>, IoError> {
    match VolumeOutput::of(path)? {
        VolumeOutput::Nrrd => nrrd::write(path, to_write),
        VolumeOutput::Nifti => nifti::write(path, to_write, false),
        VolumeOutput::NiftiGz => nifti::write(path, to_write, true),
        VolumeOutput::MetaImage => metaimage::write(path, to_write),
        VolumeOutput::Npy => npy::write(path, to_write),
        VolumeOutput::Raw => raw::write(path, to_write.volume),
        VolumeOutput::Zarr => zarr::write(path, to_write.volume),
    }
}

/// A header, and the samples after it, maybe packed by gzip.
fn write_file(
    path: &Path,
    header: &[u8],
    samples: &WrittenSamples<'_>,
    packing: Packing,
) -> Result<(), IoError> {
    atomic::write(path, |file| match packing {
        Packing::None => {
            file.write_all(header)?;
            samples.write(file)
        }
        Packing::Samples => {
            file.write_all(header)?;
            pack(file, |packed| samples.write(packed))
        }
        Packing::All => pack(file, |packed| {
            packed.write_all(header)?;
            samples.write(packed)
        }),
    })
}

/// What of a file gzip packs.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Packing {
    None,
    Samples,
    All,
}

fn pack(
    file: &mut BufWriter<&mut File>,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    let mut encoder = flate2::write::GzEncoder::new(file, flate2::Compression::default());
    write(&mut encoder)?;
    encoder.finish().map(drop)
}

/// Steps along the axes and the first voxel's place, in the coordinates of a format: RAS+, or LPS+ where x
/// and y are turned round.
fn steps_and_origin(grid: &Grid, is_lps: bool) -> ([DVec3; 3], DVec3) {
    let signs = if is_lps { DVec3::new(-1.0, -1.0, 1.0) } else { DVec3::ONE };
    let to_world = grid.world_from_index();
    let DMat3 { x_axis, y_axis, z_axis } = to_world.matrix3;
    // The sum has no zeros with a sign.
    let turned = |at: DVec3| at * signs + 0.0;
    ([x_axis, y_axis, z_axis].map(turned), turned(to_world.translation))
}

/// Numbers with blanks between, each with as many digits as say it exactly.
fn numbers(numbers: impl IntoIterator<Item = f64>) -> String {
    let words: Vec<String> = numbers.into_iter().map(|number| number.to_string()).collect();
    words.join(" ")
}

/// Whether the axes of a grid are those of the world, so that spacing and origin say all.
fn is_upright(grid: &Grid) -> bool {
    let m = grid.world_from_index().matrix3;
    m == DMat3::from_diagonal(DVec3::new(m.x_axis.x, m.y_axis.y, m.z_axis.z))
}

#[cfg(test)]
mod tests;
