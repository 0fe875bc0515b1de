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

use super::choices::Part;
use super::colors::{Meaning, Values, Voxels};
use super::formats::{Input, Reader, VolumeListing};
use super::stored::StoredType;
use super::stream::{DataStream, first_bytes, plain_extension};
use super::window::not_in_boxes;
use super::{LoadedVolume, VolumeChoices, VolumeFormat};
use crate::IoError;
use crate::printable::shown_path;
use crate::store::Store;
use header::{Header, Version};

/// The format, of both versions.
pub(super) struct Nifti;

impl Reader for Nifti {
    fn listed(&self) -> &'static str {
        "NIfTI (.nii, .nii.gz, .hdr)"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["nii", "hdr", "img"]
    }

    fn is_begun_by(&self, start: &[u8]) -> bool {
        Header::parse(start).is_some()
    }

    fn header_of(&self, store: Store<'_>, path: &Path) -> Result<PathBuf, IoError> {
        if plain_extension(path) == "img" {
            return header_beside(store, path);
        }
        let what = "not a NIfTI file, or cut off: it does not begin with a whole header of NIfTI or Analyze 7.5";
        Err(IoError::malformed(path, what))
    }

    fn reads_boxes(&self) -> bool {
        true
    }

    fn read(&self, input: &Input<'_>) -> Result<LoadedVolume, IoError> {
        read(input)
    }

    fn list(&self, input: &Input<'_>) -> Result<VolumeListing, IoError> {
        let header = parse(input.store, input.path)?;
        Ok(VolumeListing {
            format: header.format(),
            dims: dims(&header, input.path)?,
            sample_type: stored(&header, input.path)?.each.widest(),
            choices: choices(&header, input)?,
        })
    }
}

/// Reads a volume by its header, which may hold the voxels too.
fn read(input: &Input<'_>) -> Result<LoadedVolume, IoError> {
    let &Input { store, path, .. } = input;
    let header = parse(store, path)?;
    let mut warnings = Vec::new();
    let dims = dims(&header, path)?;
    let choices = choices(&header, input)?;
    let grid = orientation::grid(&header, dims, &mut warnings)
        .map_err(|source| IoError::Grid { path: path.to_owned(), source })?;
    let (window, grid) = input.window(&grid)?;
    let stored = stored(&header, path)?;
    let scaling = scaling(&header, &mut warnings);
    let image_path = if header.is_single_file { path.to_owned() } else { image_of(store, path)? };

    let mut stream = DataStream::open_unpacked(store, &image_path)?;
    let n_bytes = (grid.uncropped().n_voxels() as u64).saturating_mul(stored.voxel_bytes() as u64);
    let [channel, time] = [&choices.channel, &choices.time];
    let Stored { each, n_channels } = stored;
    let (n_before, color) =
        if 1 < n_channels { (0, channel.chosen) } else { (channel.chosen as u64, 0) };
    let [n_channels, color] = if choices.is_color { [1, 0] } else { [n_channels, color] };
    let n_before = n_before.saturating_mul(time.n as u64);
    let n_before = n_before.saturating_add(time.chosen as u64);
    let n_before = n_before.saturating_mul(n_bytes);
    let meter = input.meter(n_before.saturating_add(n_bytes));
    let offset = data_offset(&header, path)?;
    if let Some(window) = window {
        if 1 < n_channels || choices.is_color {
            return Err(not_in_boxes(path, "a volume of colours"));
        }
        stream.jump(offset.saturating_add(n_before))?;
        let samples = window.read(&image_path, &mut stream, (each, 1), header.endian)?;
        let voxels = Voxels { grid, samples, scaling, choices };
        let loaded = voxels.load(input, header.format(), warnings)?;
        return Ok(loaded.standing(orientation::orientation(&header)));
    }
    stream.skip(offset)?;
    stream.metered(&meter);
    stream.skip(n_before)?;
    let mut buffer = input.buffer(each, header.endian);
    let n_samples = grid.n_voxels().saturating_mul(choices.n_read());
    stream.fill_channel(&mut buffer, n_samples, each.size_bytes(), [n_channels, color])?;
    if choices.is_single() && stream.has_more()? {
        warnings.push(format!("{} holds more data than were needed", shown_path(&image_path)));
    }
    let samples = buffer.finish(&mut warnings);
    let voxels = Voxels { grid, samples, scaling, choices };
    let loaded = voxels.load(input, header.format(), warnings)?;
    Ok(loaded.standing(orientation::orientation(&header)))
}

impl Header {
    fn format(&self) -> VolumeFormat {
        match self.version {
            Version::Zero => VolumeFormat::Analyze,
            Version::One => VolumeFormat::Nifti1,
            Version::Two => VolumeFormat::Nifti2,
        }
    }
}

fn parse(store: Store<'_>, path: &Path) -> Result<Header, IoError> {
    Header::parse(&first_bytes(store, path)?)
        .ok_or_else(|| IoError::malformed(path, "not a NIfTI header"))
}

/// The first file of a pair, by the second.
fn header_beside(store: Store<'_>, path: &Path) -> Result<PathBuf, IoError> {
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

/// The three first sizes.
fn dims(header: &Header, path: &Path) -> Result<[usize; 3], IoError> {
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
    let size = |axis: usize| sizes.get(axis).map_or(1, |&s| usize::try_from(s).unwrap_or(0));
    Ok([size(0), size(1), size(2)])
}

/// Times along the fourth axis, and channels along what comes after it.
fn choices(header: &Header, input: &Input<'_>) -> Result<VolumeChoices, IoError> {
    let n_dims = header.dim[0].clamp(0, 7) as usize;
    let sizes = header.dim[1..=n_dims].iter().map(|&size| usize::try_from(size).unwrap_or(0));
    let beyond_space: Vec<usize> = sizes.skip(3).collect();
    let n_times = beyond_space.first().copied().unwrap_or(1);
    let n_channels = beyond_space.iter().skip(1).fold(1, |n: usize, &size| n.saturating_mul(size));
    let Stored { each, n_channels: n_in_voxel } = stored(header, input.path)?;
    if 1 < n_in_voxel && 1 < n_channels {
        let what = "colours of several channels cannot be read: save one channel alone";
        return Err(IoError::unsupported(input.path, what));
    }
    let time = input.choose(Part::Time, n_times)?;
    if n_in_voxel == 1 {
        let channel = input.choose(Part::Channel, n_channels)?;
        return Ok(VolumeChoices { time, channel, ..VolumeChoices::default() });
    }
    let values = Values { n: n_in_voxel, stored: each, meaning: Meaning::Color };
    Ok(VolumeChoices { time, ..input.choose_values(&values)? })
}

/// What a voxel is in the file: values one after the other, of which one is read.
#[derive(Clone, Copy)]
struct Stored {
    each: StoredType,
    n_channels: usize,
}

impl Stored {
    fn voxel_bytes(self) -> usize {
        self.each.size_bytes() * self.n_channels
    }
}

/// What voxels are, by the code in nifti1.h.
fn stored(header: &Header, path: &Path) -> Result<Stored, IoError> {
    if (3000..3100).contains(&header.intent_code) {
        let what = "a CIFTI file, whose values lie on surfaces: wb_command -cifti-separate takes out its volume";
        return Err(IoError::unsupported(path, what));
    }
    let of = |sample_type| Ok(Stored { each: StoredType::Sample(sample_type), n_channels: 1 });
    let colors = |n_channels| Ok(Stored { each: StoredType::U8_SAMPLE, n_channels });
    let other = match header.datatype {
        2 => return of(SampleType::U8),
        4 => return of(SampleType::I16),
        8 => return of(SampleType::I32),
        16 => return of(SampleType::F32),
        64 => return of(SampleType::F64),
        256 => return of(SampleType::I8),
        512 => return of(SampleType::U16),
        768 => return of(SampleType::U32),
        128 => return colors(3),
        2304 => return colors(4),
        1024 => return Ok(Stored { each: StoredType::I64, n_channels: 1 }),
        1280 => return Ok(Stored { each: StoredType::U64, n_channels: 1 }),
        1 => "single bits",
        32 | 1792 | 2048 => "complex numbers, of which no one value can be drawn,",
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
