//! NIfTI-1 and NIfTI-2: one file (`.nii`), or a header and an image (`.hdr`, `.img`), each maybe
//! packed by gzip, in either byte order.
//!
//! Format: <https://nifti.nimh.nih.gov/pub/dist/src/niftilib/nifti1.h> and
//! <https://nifti.nimh.nih.gov/pub/dist/doc/nifti2.h>. The `nifti` crate is not used to read: it
//! knows no NIfTI-2, and takes memory for as many voxels as a header claims. The tests compare with
//! it.
//!
//! Reading order: `header` (bytes to fields), `orientation` (fields to the grid's place).

mod header;
mod orientation;

use std::path::{Path, PathBuf};

use slabsplat_core::{SampleType, Scaling};

use super::buffer::SampleBuffer;
use super::stream::{DataStream, first_bytes};
use super::{LoadedVolume, VolumeFormat, assemble};
use crate::IoError;
use crate::store::Store;
use header::{Header, Version};

/// Whether these are the first bytes of a NIfTI file.
pub(super) fn is_header(start: &[u8]) -> bool {
    Header::parse(start).is_some()
}

/// Reads a volume by its header, which may hold the voxels too.
pub(super) fn read(store: Store<'_>, path: &Path) -> Result<LoadedVolume, IoError> {
    let header = parse(store, path)?;
    let mut warnings = Vec::new();
    let dims = dims(&header, path, &mut warnings)?;
    let grid = orientation::grid(&header, dims, &mut warnings)
        .map_err(|source| IoError::Grid { path: path.to_owned(), source })?;
    let sample_type = sample_type(&header, path)?;
    let scaling = scaling(&header, &mut warnings);
    let image_path = if header.is_single_file { path.to_owned() } else { image_of(store, path)? };

    let mut stream = DataStream::open_unpacked(store, &image_path)?;
    stream.skip(data_offset(&header, path)?)?;
    let mut buffer = SampleBuffer::new(sample_type);
    stream.fill(&mut buffer, grid.n_voxels(), sample_type.size_bytes())?;
    if n_volumes(&header) == 1 && stream.has_more()? {
        warnings.push(format!("{} holds more data than were needed", image_path.display()));
    }
    let volume = assemble(path, grid, buffer.finish(header.endian), scaling)?;
    let format = match header.version {
        Version::One => VolumeFormat::Nifti1,
        Version::Two => VolumeFormat::Nifti2,
    };
    Ok(LoadedVolume { volume, format, warnings })
}

/// What a header says of the volume's size.
pub(super) fn dims_and_type(
    store: Store<'_>,
    path: &Path,
) -> Result<([usize; 3], SampleType), IoError> {
    let header = parse(store, path)?;
    Ok((dims(&header, path, &mut Vec::new())?, sample_type(&header, path)?))
}

fn parse(store: Store<'_>, path: &Path) -> Result<Header, IoError> {
    Header::parse(&first_bytes(store, path)?)
        .ok_or_else(|| IoError::malformed(path, "not a NIfTI header"))
}

/// The first file of a pair, by the second.
pub(super) fn header_beside(store: Store<'_>, path: &Path) -> Result<PathBuf, IoError> {
    counterpart(store, path, "hdr").ok_or_else(|| {
        let what = "an image without a header: the file of this name with .hdr is missing";
        IoError::malformed(path, what)
    })
}

fn image_of(store: Store<'_>, path: &Path) -> Result<PathBuf, IoError> {
    counterpart(store, path, "img").ok_or_else(|| {
        let what = "a header without an image: the file of this name with .img is missing";
        IoError::malformed(path, what)
    })
}

/// The other file of a pair, packed or not.
fn counterpart(store: Store<'_>, path: &Path, extension: &str) -> Option<PathBuf> {
    let is_packed = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("gz"));
    let stem = if is_packed { path.with_extension("") } else { path.to_owned() };
    let names = [extension.to_owned(), format!("{extension}.gz")];
    names.iter().map(|name| stem.with_extension(name)).find(|candidate| store.has(candidate))
}

/// The three first sizes; of a series, the first volume is taken.
fn dims(header: &Header, path: &Path, warnings: &mut Vec<String>) -> Result<[usize; 3], IoError> {
    let n_dims = header.dim[0];
    if !(1..=7).contains(&n_dims) {
        let what = format!("the file has {n_dims} axes, and a volume needs 3");
        return Err(IoError::malformed(path, what));
    }
    let sizes = &header.dim[1..=n_dims as usize];
    if let Some(bad) = sizes.iter().find(|size| **size < 1) {
        let what = format!("an axis cannot be {bad} voxels long: the sizes are {sizes:?}");
        return Err(IoError::malformed(path, what));
    }
    match n_volumes(header) {
        1 => {}
        n => warnings.push(format!("the file holds {n} volumes: the first was taken")),
    }
    let size = |axis: usize| sizes.get(axis).map_or(1, |&s| usize::try_from(s).unwrap_or(0));
    Ok([size(0), size(1), size(2)])
}

fn n_volumes(header: &Header) -> u64 {
    let n_dims = header.dim[0].clamp(0, 7) as usize;
    let beyond_space = header.dim[1..=n_dims].iter().skip(3);
    beyond_space.fold(1, |n: u64, &size| n.saturating_mul(size.unsigned_abs()))
}

/// The sample type by its code in nifti1.h.
fn sample_type(header: &Header, path: &Path) -> Result<SampleType, IoError> {
    let other = match header.datatype {
        2 => return Ok(SampleType::U8),
        4 => return Ok(SampleType::I16),
        8 => return Ok(SampleType::I32),
        16 => return Ok(SampleType::F32),
        64 => return Ok(SampleType::F64),
        256 => return Ok(SampleType::I8),
        512 => return Ok(SampleType::U16),
        768 => return Ok(SampleType::U32),
        1 => "single bits",
        128 | 2304 => "colours",
        32 | 1792 | 2048 => "complex numbers",
        1024 | 1280 => "64-bit integers",
        1536 => "128-bit floats",
        code => {
            return Err(IoError::malformed(path, format!("there is no data type of code {code}")));
        }
    };
    let what = format!(
        "voxels that are {other} cannot be read: convert them to integers of up to 32 bits, or to \
         32- or 64-bit floats"
    );
    Err(IoError::unsupported(path, what))
}

/// Slope and intercept; a slope of 0 says that there are none.
fn scaling(header: &Header, warnings: &mut Vec<String>) -> Scaling {
    let (slope, intercept) = (header.scl_slope, header.scl_inter);
    if slope == 0.0 {
        return Scaling::IDENTITY;
    }
    if !slope.is_normal() || !intercept.is_finite() {
        warnings.push(format!("slope {slope} and intercept {intercept} were taken as none"));
        return Scaling::IDENTITY;
    }
    Scaling { slope, intercept }
}

/// Where the voxels begin. In a single file that is behind the header, whatever it says.
fn data_offset(header: &Header, path: &Path) -> Result<u64, IoError> {
    let least = if header.is_single_file { header.version.n_header_bytes() + 4 } else { 0 };
    match header.vox_offset {
        offset if (0.0..1e15).contains(&offset) => Ok((offset as u64).max(least)),
        offset => {
            let what = format!("the voxels cannot begin at byte {offset}");
            Err(IoError::malformed(path, what))
        }
    }
}

#[cfg(test)]
mod tests;
